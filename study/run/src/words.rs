//! Formatting of numbers, fractions and durations with few digits.

/// Formats a number with few significant digits.
pub fn short(value: f64) -> String {
    if (1e-3..1e6).contains(&value.abs()) || value == 0.0 {
        let rounded = format!("{value:.4}");
        let plain = rounded.trim_end_matches('0').trim_end_matches('.');
        plain.to_owned()
    } else {
        format!("{value:.3e}")
    }
}

/// Formats a fraction as a percentage.
pub(crate) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let digits = match value.abs() {
        10.0.. => 0,
        1.0.. => 1,
        _ => 2,
    };
    format!("{value:.digits$} %")
}

/// Formats a duration \[s\] in seconds, minutes or hours.
pub(crate) fn time(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{:.0} ms", 1e3 * seconds)
    } else if seconds < 120.0 {
        format!("{seconds:.1} s")
    } else if seconds < 7200.0 {
        format!("{:.1} min", seconds / 60.0)
    } else {
        format!("{:.1} h", seconds / 3600.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_few_digits() {
        let shares = [0.0123, 0.123, 0.00456, -0.02].map(percent);
        assert_eq!(shares, ["1.2 %", "12 %", "0.46 %", "-2.0 %"]);
        let numbers = [0.25, 1234.5678, -3.0, 2e300, 0.0].map(short);
        assert_eq!(numbers, ["0.25", "1234.5678", "-3", "2.000e300", "0"]);
        let times = [0.05, 3.0, 600.0, 9000.0].map(time);
        assert_eq!(times, ["50 ms", "3.0 s", "10.0 min", "2.5 h"]);
    }
}
