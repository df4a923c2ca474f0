//! Formatting of numbers for verdict sentences: values with the digits of their errors,
//! percentages, margins.

use stosszahl_analysis::compare::Interval;
use stosszahl_results::{TableEstimate, format_number, format_percent, format_with_error};

/// Text shown for a number that is not finite.
const UNKNOWN: &str = "unknown";
/// Magnitude from which numbers are shown with an exponent.
const LARGE: f64 = 1e6;

/// Returns an error, or 0 if it is below a millionth of the value: equal replicas differ by
/// rounding.
fn significant_error(value: f64, error: f64) -> f64 {
    if error > 1e-6 * value.abs() {
        error
    } else {
        0.0
    }
}

/// Formats a number with its error, to the digits that the error justifies.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error.filter(|error| error.is_finite()) {
        _ if !value.is_finite() => UNKNOWN.to_owned(),
        Some(error) => format_with_error(value, significant_error(value, error)),
        None => format!("{} (error unknown)", format_number(value)),
    }
}

/// Formats an estimate with its error, both divided by a unit.
pub fn in_units(found: &TableEstimate, unit: f64) -> String {
    let error = found.standard_error.map(|error| (error / unit).abs());
    with_error(found.value.unwrap_or(f64::NAN) / unit, error)
}

/// Formats an estimate divided by a unit, with half its 95 % confidence interval, Student's if the
/// error comes from few parts of the runs.
pub fn with_interval(found: &TableEstimate, unit: f64) -> String {
    let half = super::interval_of(found, 0.05).ends;
    let half = half.map(|[low, high]| (0.5 * (high - low) / unit).abs());
    with_error(found.value.unwrap_or(f64::NAN) / unit, half)
}

/// Formats the quotient of two estimates with its error.
pub fn format_quotient(a: &TableEstimate, b: &TableEstimate) -> String {
    let [x, y] = [a, b].map(|one| one.value.unwrap_or(f64::NAN));
    let errors = a.standard_error.zip(b.standard_error);
    let error = errors.map(|(a, b)| (x / y).abs() * (a / x).hypot(b / y));
    with_error(x / y, error)
}

/// Formats a relative deviation in per cent, with its error.
pub fn format_deviation(deviation: f64, error: Option<f64>) -> String {
    let deviation = 100.0 * deviation;
    match error.map(|error| 100.0 * error) {
        _ if !deviation.is_finite() => UNKNOWN.to_owned(),
        Some(error) if error.is_finite() && deviation.abs().max(error) >= LARGE => {
            format!("{deviation:+.1e} ± {error:.1e} %")
        }
        Some(error) if error.is_finite() => {
            let digits = match significant_error(deviation, error) {
                0.0 => 3,
                error => (-error.log10().floor()).clamp(0.0, 11.0) as usize,
            };
            format!("{deviation:+.digits$} ± {error:.digits$} %")
        }
        _ if deviation.abs() >= LARGE => format!("{deviation:+.1e} % (error unknown)"),
        _ => format!("{deviation:+.2} % (error unknown)"),
    }
}

/// Rounds a positive number to two significant digits, up or down.
fn two_digits(value: f64, up: bool) -> f64 {
    let scale = 10_f64.powf((1.0 - value.log10().floor()).clamp(-300.0, 8.0));
    if up {
        (value * scale - 1e-9).ceil() / scale
    } else {
        (value * scale + 1e-9).floor() / scale
    }
}

/// Formats an upper bound, given as a share, in per cent, rounded up.
pub fn format_margin(share: f64) -> String {
    let percent = 100.0 * share;
    if percent.is_nan() || percent >= LARGE {
        return UNKNOWN.to_owned();
    }
    format_percent(0.01 * two_digits(percent, true))
}

/// Unit in which a verdict states a difference: per cent of the quantity, or the unit of the
/// quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DifferenceUnit {
    /// Difference as a share of the quantity, shown in per cent.
    Relative,
    /// Difference in the unit of the quantity; the number is the largest magnitude that the
    /// quantity can have.
    Own(f64),
}

impl DifferenceUnit {
    /// Formats a difference with its standard error and degrees of freedom.
    pub fn interval(self, one: &Interval) -> String {
        let value = match self {
            Self::Relative => format_deviation(one.value, one.standard_error),
            Self::Own(_) => with_error(one.value, one.standard_error),
        };
        match one
            .degrees_of_freedom
            .filter(|_| one.standard_error.is_some())
        {
            Some(1) => format!("{value} (1 degree of freedom)"),
            Some(freedom) => format!("{value} ({freedom} degrees of freedom)"),
            None => value,
        }
    }

    /// Formats a bound on the magnitude of a difference with two digits, rounded up or down.
    pub(super) fn bound(self, value: f64, up: bool) -> String {
        match self {
            Self::Relative if up => format_margin(value),
            Self::Relative => format_percent(0.01 * two_digits(100.0 * value, false)),
            Self::Own(_) => format_number(two_digits(value, up)),
        }
    }

    /// Returns the largest possible magnitude of a difference, as a bound that is not below it is
    /// no information: 1 for a relative difference, else the largest magnitude of the quantity.
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::Relative => 1.0,
            Self::Own(largest) => largest,
        }
    }
}
