//! Rows of claims: a claim, what was expected, what was found, and the verdict.

use std::fmt::Write as _;

use serde::Serialize;
use stosszahl_analysis::statistics::Estimate;

use crate::Trouble;

/// What a row says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Claimed, and within the tolerance, with an error bar of at most half of it.
    Pass,
    /// Claimed, and not within the tolerance.
    Fail,
    /// Claimed, but the error bar is too wide to tell.
    Unresolved,
    /// Not claimed.
    Measured,
}

impl Verdict {
    /// As in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::Unresolved => "unresolved",
            Self::Measured => "measured",
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Part of the validation.
    pub part: &'static str,
    /// Scheme, or what it is compared with.
    pub scheme: String,
    /// Resolution.
    pub setting: String,
    /// Packing fraction.
    pub packing: f64,
    /// What was measured, with its unit.
    pub quantity: String,
    /// What theory or the other engine says.
    pub expected: f64,
    /// What was found.
    pub found: f64,
    /// Standard error of what was found (and of what was expected, where that was measured too).
    pub standard_error: f64,
    /// How far from the expected it may be; none if nothing is claimed.
    pub tolerance: Option<f64>,
    /// Verdict.
    pub verdict: Verdict,
    /// CPU time of the runs behind this line, which may share them \[s\].
    pub seconds: f64,
    /// Whether it belongs to the default scheme.
    pub default: bool,
}

/// Where a row stands.
#[derive(Clone, Debug)]
pub struct Place {
    /// Part of the validation.
    pub part: &'static str,
    /// Scheme.
    pub scheme: String,
    /// Resolution.
    pub setting: String,
    /// Packing fraction.
    pub packing: f64,
    /// CPU time \[s\].
    pub seconds: f64,
    /// Whether it is the default scheme.
    pub default: bool,
}

impl Place {
    /// The place of claims that must hold.
    pub fn new(
        part: &'static str,
        scheme: impl Into<String>,
        setting: impl Into<String>,
        packing: f64,
        seconds: f64,
    ) -> Self {
        Self {
            part,
            scheme: scheme.into(),
            setting: setting.into(),
            packing,
            seconds,
            default: true,
        }
    }

    /// The same for what need not hold unless it is the default.
    #[must_use]
    pub fn of(self, default: bool) -> Self {
        Self { default, ..self }
    }

    /// A line about a quantity without a statistical error.
    pub fn exact(
        &self,
        quantity: impl Into<String>,
        expected: f64,
        found: f64,
        tolerance: f64,
    ) -> Row {
        self.row(quantity, expected, estimate(found, 0.0), Some(tolerance))
    }

    /// A line about a quantity; `tolerance` is absolute, and none if nothing is claimed.
    pub fn row(
        &self,
        quantity: impl Into<String>,
        expected: f64,
        found: Estimate,
        tolerance: Option<f64>,
    ) -> Row {
        let error = found.standard_error.unwrap_or(f64::NAN);
        Row {
            part: self.part,
            scheme: self.scheme.clone(),
            setting: self.setting.clone(),
            packing: self.packing,
            quantity: quantity.into(),
            expected,
            found: found.value,
            standard_error: error,
            tolerance,
            verdict: verdict(expected, found.value, error, tolerance),
            seconds: self.seconds,
            default: self.default,
        }
    }
}

/// Standard errors by which a value beyond its tolerance must be beyond it to be called wrong (false alarm 0.1 % each
/// where it is exactly at its tolerance).
const SURE: f64 = 3.09;

fn verdict(expected: f64, found: f64, error: f64, tolerance: Option<f64>) -> Verdict {
    let Some(tolerance) = tolerance else {
        return Verdict::Measured;
    };
    let deviation = (found - expected).abs();
    // Written so that a value or an error that is no number fails.
    if deviation <= tolerance && error <= 0.5 * tolerance {
        Verdict::Pass
    } else if deviation <= tolerance + SURE * error {
        if error <= 0.5 * tolerance {
            Verdict::Fail
        } else {
            Verdict::Unresolved
        }
    } else {
        Verdict::Fail
    }
}

impl Row {
    /// One line of text for the terminal.
    pub fn line(&self) -> String {
        let show = |value| shown(value, self.tolerance);
        let within = self
            .tolerance
            .map_or_else(String::new, |t| format!(" within {}", show(t)));
        format!(
            "{:10} {:11} {:24} {:12} phi {:.2}  {:34} expected {}{within}, found {} ± {}",
            self.verdict.name(),
            self.part,
            self.scheme,
            self.setting,
            self.packing,
            self.quantity,
            show(self.expected),
            show(self.found),
            show(self.standard_error),
        )
    }

    /// Whether more gases would hardly change the verdict.
    pub fn is_decided(&self) -> bool {
        let Some(tolerance) = self.tolerance else {
            return true;
        };
        let beyond = (self.found - self.expected).abs() - tolerance;
        self.verdict == Verdict::Pass || beyond > SURE * self.standard_error
    }
}

/// A value and its standard error.
pub fn estimate(value: f64, standard_error: f64) -> Estimate {
    Estimate {
        value,
        standard_error: Some(standard_error),
        replicas: 1,
    }
}

/// The mean of something over replicas, with its standard error.
///
/// # Errors
/// [`Trouble::NoReplicas`] if there is nothing to average.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Result<Estimate, Trouble> {
    let values: Vec<f64> = values.into_iter().collect();
    Estimate::over_replicas(&values).ok_or(Trouble::NoReplicas)
}

/// An estimate that is a difference or ratio to another measured one: its relative error with that of the other.
pub fn against(found: Estimate, other: Estimate) -> Estimate {
    let relative = |e: Estimate| e.standard_error.map(|error| error / e.value);
    let error = relative(found)
        .zip(relative(other))
        .map(|(a, b)| a.hypot(b));
    let value = found.value / other.value;
    Estimate {
        value,
        standard_error: error.map(|error| error * value.abs()),
        replicas: found.replicas.min(other.replicas),
    }
}

/// The same in units of something known.
pub fn over(found: Estimate, unit: f64) -> Estimate {
    Estimate {
        value: found.value / unit,
        standard_error: found.standard_error.map(|error| error / unit.abs()),
        ..found
    }
}

/// A number beside its tolerance: in powers of ten where that is below what four decimals show.
fn shown(value: f64, tolerance: Option<f64>) -> String {
    if tolerance.is_some_and(|tolerance| tolerance < 1e-6) {
        format!("{value:.1e}")
    } else {
        format!("{value:.4}")
    }
}

/// The table in Markdown.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| part | scheme | setting | packing | quantity | expected | within | found | verdict | CPU s |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let show = |value| shown(value, row.tolerance);
        let Row {
            part,
            scheme,
            setting,
            packing,
            quantity,
            seconds,
            ..
        } = row;
        let within = row.tolerance.map_or_else(|| "-".to_owned(), show);
        let [expected, found, error] = [row.expected, row.found, row.standard_error].map(show);
        let verdict = row.verdict.name();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {part} | {scheme} | {setting} | {packing} | {quantity} | {expected} | {within} | {found} ± {error} | \
             {verdict} | {seconds:.1} |"
        );
    }
    text
}

/// The table as comma-separated values.
///
/// # Errors
/// None in practice: rows always serialise.
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let done = writer.into_inner();
    done.map_err(|error| error.into_error().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_need_narrow_errors() {
        assert_eq!(verdict(1.0, 1.009, 0.004, Some(0.01)), Verdict::Pass);
        assert_eq!(verdict(1.0, 1.009, 0.006, Some(0.01)), Verdict::Unresolved);
        assert_eq!(verdict(1.0, 1.011, 0.004, Some(0.01)), Verdict::Fail);
        assert_eq!(verdict(1.0, 1.05, 0.006, Some(0.01)), Verdict::Fail);
        assert_eq!(verdict(1.0, 1.05, 0.006, None), Verdict::Measured);
        for [found, error] in [[f64::NAN, 0.001], [1.0, f64::NAN]] {
            assert_eq!(verdict(1.0, found, error, Some(0.01)), Verdict::Fail);
        }
    }

    #[test]
    fn ratios_add_relative_errors() {
        let ratio = against(estimate(2.0, 0.06), estimate(4.0, 0.16));
        assert!((ratio.value - 0.5).abs() < 1e-15);
        assert!((ratio.standard_error.unwrap_or(0.0) - 0.025).abs() < 1e-15);
        assert_eq!(over(estimate(2.0, 0.5), 4.0).standard_error, Some(0.125));
    }

    #[test]
    fn tables_have_a_line_for_each_row() {
        let place = Place::new("elastic", "a", "single", 0.25, 1.0);
        let found = Estimate::over_replicas(&[1.0, 1.002]);
        let rows = [place.row("rate", 1.0, found.expect("two values"), Some(0.01))];
        assert_eq!(rows[0].verdict, Verdict::Pass);
        assert_eq!(markdown(&rows).lines().count(), 3);
        let text = String::from_utf8(csv(&rows).expect("a table")).expect("text");
        assert!(text.starts_with("part,scheme") && text.contains("elastic,a,single,0.25"));
    }
}
