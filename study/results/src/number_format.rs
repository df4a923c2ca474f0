//! Formatting of numbers with few digits: alone, with a standard error, in per cent, as a duration.

/// Formats a number with `digits` significant digits in plain text. Outside 1e-3..1e6 it has an
/// exponent; trailing zeros are removed.
///
/// ```
/// use stosszahl_results::format_significant;
///
/// assert_eq!(format_significant(0.012_345_6, 3), "0.0123");
/// assert_eq!(format_significant(-0.5, 4), "-0.5");
/// // Digits before the point stay.
/// assert_eq!(format_significant(123_456.7, 4), "123457");
/// assert_eq!(format_significant(2.5e-7, 4), "2.5e-7");
/// assert_eq!(format_significant(999_999.9, 4), "1e6");
/// assert_eq!(format_significant(f64::NAN, 4), "NaN");
/// ```
pub fn format_significant(value: f64, digits: usize) -> String {
    let digits = digits.max(1);
    // The formatter rounds first, so that 0.99999 gets the exponent of the shown number.
    let text = format!("{value:.*e}", digits - 1);
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text;
    };
    match exponent.parse::<i32>() {
        Ok(exponent) if value == 0.0 || (-3..6).contains(&exponent) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            unsigned_zero(without_zeros(&format!("{value:.decimals$}")).to_owned())
        }
        _ => format!("{}e{exponent}", without_zeros(mantissa)),
    }
}

/// Formats a number of a sentence, with five significant digits.
///
/// ```
/// use stosszahl_results::format_number;
///
/// let numbers = [0.25, 1234.5678, 0.042_966_4, 240.0, -3.0, 2e300].map(format_number);
/// assert_eq!(numbers, ["0.25", "1234.6", "0.042966", "240", "-3", "2e300"]);
/// ```
pub fn format_number(value: f64) -> String {
    format_significant(value, 5)
}

/// Formats a rough number, such as an estimated cost, with two significant digits; below 1e4 all
/// whole digits stay.
///
/// ```
/// use stosszahl_results::format_rough;
///
/// assert_eq!([3.21, 1234.5, 98_765.0].map(format_rough), ["3.2", "1234", "9.9e4"]);
/// ```
pub fn format_rough(value: f64) -> String {
    if value.abs() < 1e4 {
        format_significant(value, 2)
    } else {
        format!("{value:.1e}")
    }
}

/// Formats a value with its standard error, both to the second significant digit of the error.
///
/// ```
/// use stosszahl_results::format_with_error;
///
/// assert_eq!(format_with_error(0.9324, 0.0123), "0.932 ± 0.012");
/// assert_eq!(format_with_error(-0.0004, 0.0123), "0.000 ± 0.012");
/// assert_eq!(format_with_error(0.932_412_341, 5e-7), "0.93241234 ± 5e-7");
/// assert_eq!(format_with_error(2.515e7, 1.23e5), "2.515e7 ± 120000");
/// assert_eq!(format_with_error(0.3, 0.0), "0.3 ± 0");
/// ```
pub fn format_with_error(value: f64, error: f64) -> String {
    let decimals = (1.0 - error.log10().floor()).max(0.0);
    if decimals > 7.0 || value.abs().max(error) >= 1e6 {
        // As many digits of the value as reach the second of the error.
        let digits = (value / error).abs().log10().floor() + 2.0;
        let digits = if digits.is_finite() { digits } else { 5.0 };
        let error = format_significant(two_digits(error), 2);
        format!(
            "{} ± {error}",
            format_significant(value, digits.clamp(5.0, 17.0) as usize)
        )
    } else {
        with_decimals(value, error, decimals as usize)
    }
}

/// Rounds a number to two significant digits.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// Formats a value and its error with the given number of decimals.
pub fn with_decimals(value: f64, error: f64, decimals: usize) -> String {
    let value = unsigned_zero(format!("{value:.decimals$}"));
    format!("{value} ± {error:.decimals$}")
}

/// Formats a fraction in per cent, with two significant digits.
///
/// ```
/// use stosszahl_results::format_percent;
///
/// let shares = [0.0123, 0.123, 0.00456, -0.02, 1.234].map(format_percent);
/// assert_eq!(shares, ["1.2 %", "12 %", "0.46 %", "-2 %", "123 %"]);
/// ```
pub fn format_percent(fraction: f64) -> String {
    format!("{} %", format_significant(100.0 * fraction, 2))
}

/// Formats a duration \[s\] in milliseconds, seconds, minutes, hours or days.
///
/// ```
/// use stosszahl_results::format_duration;
///
/// let times = [0.05, 3.0, 600.0, 9000.0, 864e3].map(format_duration);
/// assert_eq!(times, ["50 ms", "3.0 s", "10.0 min", "2.5 h", "10.0 days"]);
/// ```
pub fn format_duration(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{:.0} ms", 1e3 * seconds)
    } else if seconds < 120.0 {
        format!("{seconds:.1} s")
    } else if seconds < 7200.0 {
        format!("{:.1} min", seconds / 60.0)
    } else if seconds < 172_800.0 {
        format!("{:.1} h", seconds / 3600.0)
    } else {
        format!("{:.1} days", seconds / 86_400.0)
    }
}

/// Removes the sign of a number rounded to zero: "-0.000" becomes "0.000".
///
/// ```
/// use stosszahl_results::unsigned_zero;
///
/// let rounded = [-1e-5, 1e-5, -0.0013].map(|value| unsigned_zero(format!("{value:.3}")));
/// assert_eq!(rounded, ["0.000", "0.000", "-0.001"]);
/// ```
pub fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| "0.".contains(c)) => zero.to_owned(),
        _ => text,
    }
}

/// Removes trailing zeros after a decimal point.
fn without_zeros(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}
