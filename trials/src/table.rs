//! Claims about accuracy as table rows: expected value, found value with its error, and verdict.

use std::fmt::Write as _;

use stosszahl_analysis::statistics::Estimate;
use stosszahl_results as results;

use crate::TrialError;

/// Verdict of the validation on a claim about accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowVerdict {
    /// Verdict that the claim holds: the value is within the tolerance, with a standard error of at
    /// most half the tolerance.
    Pass,
    /// Verdict that the claim does not hold: the value is beyond the tolerance.
    Fail,
    /// Verdict that the standard error is too wide to tell if the claim holds.
    Unresolved,
    /// Verdict that nothing is claimed: the value is only measured.
    Measured,
}

impl RowVerdict {
    /// Returns the verdict on a claim as a word for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::Unresolved => "unresolved",
            Self::Measured => "measured",
        }
    }
}

/// Claim about a measured quantity: expected and found value, error, tolerance and verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialTableRow {
    /// Part of the validation, scheme, setting and gas that the claim is about.
    pub place: RowPlace,
    /// Name of the measured quantity, with its unit.
    pub quantity: String,
    /// Expected value of the quantity, from theory or from another engine.
    pub expected: f64,
    /// Measured value of the quantity that the claim is about.
    pub found: f64,
    /// Standard error of the measured value, including that of the expected value if it was
    /// measured too.
    pub standard_error: f64,
    /// Largest deviation from the expected value that passes; `None` if nothing is claimed.
    pub tolerance: Option<f64>,
    /// Verdict on the claim about the measured value.
    pub verdict: RowVerdict,
}

/// Part of the validation, scheme, resolution and gas that rows of claims have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct RowPlace {
    /// Name of the part of the validation, such as `elastic` or `cooling`.
    pub part: &'static str,
    /// Name of the Monte Carlo scheme or of the exact dynamics.
    pub scheme: String,
    /// Resolution of the scheme, as text.
    pub setting: String,
    /// Packing fraction of the gas that the claims are about.
    pub packing: f64,
    /// CPU time of the runs behind the rows, which may share them \[s\].
    pub seconds: f64,
    /// True if the row belongs to the default scheme, whose claims must hold.
    pub default: bool,
}

impl RowPlace {
    /// Creates the common part of rows whose claims must hold: part, scheme, setting, packing
    /// fraction and CPU time \[s\].
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

    /// Sets whether the claims of these rows must hold, as those of the default scheme.
    #[must_use]
    pub fn only_default(self, default: bool) -> Self {
        Self { default, ..self }
    }

    fn names(&self) -> (&str, &str, &str, f64) {
        (self.part, &self.scheme, &self.setting, self.packing)
    }

    /// Creates a row for a quantity without a statistical error.
    pub fn exact(
        &self,
        quantity: impl Into<String>,
        expected: f64,
        found: f64,
        tolerance: f64,
    ) -> TrialTableRow {
        self.row(quantity, expected, estimate(found, 0.0), Some(tolerance))
    }

    /// Creates a row for a quantity with a statistical error. The tolerance is absolute; `None`
    /// means that nothing is claimed.
    pub fn row(
        &self,
        quantity: impl Into<String>,
        expected: f64,
        found: Estimate,
        tolerance: Option<f64>,
    ) -> TrialTableRow {
        let error = found.standard_error.unwrap_or(f64::NAN);
        TrialTableRow {
            place: self.clone(),
            quantity: quantity.into(),
            expected,
            found: found.value,
            standard_error: error,
            tolerance,
            verdict: verdict(expected, found.value, error, tolerance),
        }
    }
}

/// Number of standard errors beyond the tolerance at which a value counts as wrong. A value exactly
/// at its tolerance then fails with probability 0.1 %.
const SURE: f64 = 3.09;

fn verdict(expected: f64, found: f64, error: f64, tolerance: Option<f64>) -> RowVerdict {
    let Some(tolerance) = tolerance else {
        return RowVerdict::Measured;
    };
    let deviation = (found - expected).abs();
    // Written so that a value or an error that is no number fails.
    if deviation <= tolerance && error <= 0.5 * tolerance {
        RowVerdict::Pass
    } else if deviation <= tolerance + SURE * error && error > 0.5 * tolerance {
        RowVerdict::Unresolved
    } else {
        RowVerdict::Fail
    }
}

/// Formats tolerance, expected value, found value and its error, with four decimals, or in powers
/// of ten for tiny tolerances.
pub(crate) fn numbers(tolerance: Option<f64>, values: [f64; 3]) -> [String; 4] {
    let small = tolerance.is_some_and(|tolerance| tolerance < 1e-6);
    let show = |value: f64| {
        if small {
            format!("{value:.1e}")
        } else {
            results::unsigned_zero(format!("{value:.4}"))
        }
    };
    let within = tolerance.map_or_else(|| "-".to_owned(), show);
    let [expected, found, error] = values.map(show);
    [within, expected, found, error]
}

impl TrialTableRow {
    fn numbers(&self) -> [String; 4] {
        let values = [self.expected, self.found, self.standard_error];
        numbers(self.tolerance, values)
    }

    /// Formats a claim as a line of the terminal: verdict, setting, quantity, expected and found
    /// value.
    pub fn line(&self) -> String {
        let [within, expected, found, error] = self.numbers();
        let within = self
            .tolerance
            .map_or_else(String::new, |_| format!(" within {within}"));
        let (verdict, quantity) = (self.verdict.name(), &self.quantity);
        let (part, scheme, setting, packing) = self.place.names();
        format!(
            "{verdict:10} {part:11} {scheme:24} {setting:12} phi {packing:.2}  {quantity:34} expected {expected}{within}, \
             found {found} ± {error}"
        )
    }

    /// Returns true if more replicas would hardly change the verdict.
    pub fn is_decided(&self) -> bool {
        let Some(tolerance) = self.tolerance else {
            return true;
        };
        let beyond = (self.found - self.expected).abs() - tolerance;
        self.verdict == RowVerdict::Pass || beyond > SURE * self.standard_error
    }
}

/// Creates an `Estimate` from a value and its standard error.
pub fn estimate(value: f64, standard_error: f64) -> Estimate {
    Estimate {
        value,
        standard_error: Some(standard_error),
        replicas: 1,
    }
}

/// Averages values over replicas, with the standard error of their mean.
///
/// # Errors
///
/// [`TrialError`] if there are no values.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Result<Estimate, TrialError> {
    let values: Vec<f64> = values.into_iter().collect();
    Estimate::over_replicas(&values).ok_or_else(|| TrialError::failed("no replicas"))
}

/// Divides two estimates with independent errors; their relative errors add in squares.
pub fn against(found: Estimate, other: Estimate) -> Estimate {
    let errors = found.standard_error.zip(other.standard_error);
    let value = found.value / other.value;
    let error = |(a, b): (f64, f64)| (a / found.value).hypot(b / other.value) * value.abs();
    Estimate {
        value,
        standard_error: errors.map(error),
        replicas: found.replicas.min(other.replicas),
    }
}

/// Divides an estimate and its standard error by an exact number.
pub fn divided_by(found: Estimate, unit: f64) -> Estimate {
    Estimate {
        value: found.value / unit,
        standard_error: found.standard_error.map(|error| error / unit.abs()),
        ..found
    }
}

/// Formats rows of claims as a Markdown table.
pub fn markdown(rows: &[TrialTableRow]) -> String {
    let mut text = String::from(
        "| part | scheme | setting | packing | quantity | expected | within | found | verdict | CPU s |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let [within, expected, found, error] = row.numbers();
        let (verdict, quantity) = (row.verdict.name(), &row.quantity);
        let (part, scheme, setting, packing) = row.place.names();
        let seconds = row.place.seconds;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {part} | {scheme} | {setting} | {packing} | {quantity} | {expected} | {within} | {found} ± {error} | \
             {verdict} | {seconds:.1} |"
        );
    }
    text
}

/// Creates the result table of claims, with columns and without rows.
pub(crate) fn columns() -> results::Table {
    results::table! {
        "validation", "Claims about accuracy: what was expected, what was found, and the verdict.";
        key "part", "", "Part of the validation";
        key "scheme", "", "Name of the scheme";
        key "setting", "", "Resolution of the scheme";
        key "packing", "1", "Packing fraction of the gas";
        key "quantity", "", "Measured quantity, with its unit";
        note "expected", "of the quantity", "Expected value, from theory or the other engine";
        estimate "found", "of the quantity", "Value found";
        note "tolerance", "of the quantity", "Largest deviation that is claimed; empty if nothing is claimed";
        note "verdict", "", "pass, fail, unresolved or measured";
        note "seconds", "s", "Computing time of the runs behind the row, which rows may share";
        note "default", "", "true if the row belongs to the default scheme";
    }
}

/// Creates the result table of claims from its rows.
pub(crate) fn table(rows: &[TrialTableRow]) -> results::Table {
    let mut table = columns();
    for row in rows {
        let (part, scheme, setting, packing) = row.place.names();
        let error = row.standard_error;
        let found = results::TableEstimate::with_error(
            row.found,
            Some(error).filter(|one| one.is_finite()),
        );
        table.add((
            (part, scheme, setting),
            (packing, &*row.quantity),
            (row.expected, found, row.tolerance),
            (&*row.verdict.name().to_lowercase(), row.place.seconds),
            if row.place.default { "true" } else { "false" },
        ));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_need_narrow_errors() {
        assert_eq!(verdict(1.0, 1.009, 0.004, Some(0.01)), RowVerdict::Pass);
        assert_eq!(
            verdict(1.0, 1.009, 0.006, Some(0.01)),
            RowVerdict::Unresolved
        );
        assert_eq!(verdict(1.0, 1.011, 0.004, Some(0.01)), RowVerdict::Fail);
        assert_eq!(verdict(1.0, 1.05, 0.006, Some(0.01)), RowVerdict::Fail);
        assert_eq!(verdict(1.0, 1.05, 0.006, None), RowVerdict::Measured);
        for [found, error] in [[f64::NAN, 0.001], [1.0, f64::NAN]] {
            assert_eq!(verdict(1.0, found, error, Some(0.01)), RowVerdict::Fail);
        }
    }

    #[test]
    fn ratios_add_relative_errors() {
        let ratio = against(estimate(2.0, 0.06), estimate(4.0, 0.16));
        assert!((ratio.value - 0.5).abs() < 1e-15);
        assert!((ratio.standard_error.unwrap_or(0.0) - 0.025).abs() < 1e-15);
        assert_eq!(
            divided_by(estimate(2.0, 0.5), 4.0).standard_error,
            Some(0.125)
        );
    }

    #[test]
    fn tables_have_a_line_for_each_row() {
        let place = RowPlace::new("elastic", "a", "single", 0.25, 1.0);
        let found = Estimate::over_replicas(&[1.0, 1.002]);
        let rows = [place.row("rate", 1.0, found.expect("two values"), Some(0.01))];
        assert_eq!(rows[0].verdict, RowVerdict::Pass);
        assert_eq!(markdown(&rows).lines().count(), 3);
        let text = table(&rows).to_csv().expect("a table");
        let text = String::from_utf8(text).expect("text");
        assert!(text.starts_with("part,scheme") && text.contains("elastic,a,single,0.25"));
        assert!(text.contains(",0.01,pass,1.0,true"), "{text}");
    }
}
