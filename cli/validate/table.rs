//! Rows of the validation: a claim, what was expected, what was found, and the verdict.

use std::fmt::Write as _;

use serde::Serialize;
use stosszahl_analysis::statistics::Estimate;

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
    /// Whether more gases would hardly change the verdict.
    pub fn is_decided(&self) -> bool {
        let Some(tolerance) = self.tolerance else {
            return true;
        };
        let beyond = (self.found - self.expected).abs() - tolerance;
        self.verdict == Verdict::Pass || beyond > SURE * self.standard_error
    }
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

/// One line of text for the terminal.
pub fn line(row: &Row) -> String {
    let tolerance = row.tolerance.map_or_else(String::new, |tolerance| {
        format!(" within {}", shown(tolerance, row.tolerance))
    });
    format!(
        "{:10} {:11} {:24} {:12} phi {:.2}  {:34} expected {}{tolerance}, found {} ± {}",
        row.verdict.name(),
        row.part,
        row.scheme,
        row.setting,
        row.packing,
        row.quantity,
        shown(row.expected, row.tolerance),
        shown(row.found, row.tolerance),
        shown(row.standard_error, row.tolerance),
    )
}

/// The table in Markdown.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| part | scheme | setting | packing | quantity | expected | within | found | verdict | CPU s |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let tolerance = row.tolerance.map_or_else(
            || "-".to_owned(),
            |tolerance| shown(tolerance, row.tolerance),
        );
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {tolerance} | {} ± {} | {} | {:.1} |",
            row.part,
            row.scheme,
            row.setting,
            row.packing,
            row.quantity,
            shown(row.expected, row.tolerance),
            shown(row.found, row.tolerance),
            shown(row.standard_error, row.tolerance),
            row.verdict.name(),
            row.seconds,
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
    writer
        .into_inner()
        .map_err(|error| error.into_error().into())
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
        let estimate = |value, error| Estimate {
            value,
            standard_error: Some(error),
            replicas: 4,
        };
        let ratio = against(estimate(2.0, 0.06), estimate(4.0, 0.16));
        assert!((ratio.value - 0.5).abs() < 1e-15);
        assert!((ratio.standard_error.unwrap_or(0.0) - 0.025).abs() < 1e-15);
        assert_eq!(over(estimate(2.0, 0.5), 4.0).standard_error, Some(0.125));
    }

    #[test]
    fn tables_have_a_line_for_each_row() {
        let place = Place {
            part: "elastic",
            scheme: "a".to_owned(),
            setting: "single".to_owned(),
            packing: 0.25,
            seconds: 1.0,
            default: true,
        };
        let found = Estimate::over_replicas(&[1.0, 1.002]);
        let rows = [place.row("rate", 1.0, found.expect("two values"), Some(0.01))];
        assert_eq!(rows[0].verdict, Verdict::Pass);
        assert_eq!(markdown(&rows).lines().count(), 3);
        let text = String::from_utf8(csv(&rows).expect("a table")).expect("text");
        assert!(text.starts_with("part,scheme") && text.contains("elastic,a,single,0.25"));
    }
}
