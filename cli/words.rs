//! Shares and durations, as they are written on the command line and as they are told.

/// A share: `1%` or `0.01`; above zero and below one.
pub(crate) fn share(text: &str) -> Option<f64> {
    let text = text.trim();
    let value = match text.strip_suffix('%') {
        Some(percent) => percent.trim_end().parse::<f64>().ok()? / 100.0,
        None => text.parse().ok()?,
    };
    (value > 0.0 && value < 1.0).then_some(value)
}

/// A duration: `90s`, `10m`, `1.5h`, or seconds \[s\]; above zero and at most a year.
pub(crate) fn duration(text: &str) -> Option<f64> {
    const YEAR: f64 = 365.25 * 86_400.0;
    let text = text.trim();
    let units = [("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let unit = units.iter().find(|(letter, _)| text.ends_with(letter));
    let value = match unit {
        Some((letter, seconds)) => {
            text.strip_suffix(letter)?.trim_end().parse::<f64>().ok()? * seconds
        }
        None => text.parse().ok()?,
    };
    (value > 0.0 && value <= YEAR).then_some(value)
}

/// A share in per cent with two digits.
pub(crate) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let digits = if value.abs() >= 10.0 {
        0
    } else if value.abs() >= 1.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$} %")
}

/// Seconds, minutes or hours with two digits.
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
    fn shares_are_read() {
        assert_eq!(share("1%"), Some(0.01));
        assert_eq!(share("0.5 %"), Some(0.005));
        assert_eq!(share("0.02"), Some(0.02));
        for bad in ["", "%", "0", "-1%", "100%", "2", "nan", "inf", "one"] {
            assert_eq!(share(bad), None, "{bad}");
        }
    }

    #[test]
    fn durations_are_read() {
        assert_eq!(duration("90s"), Some(90.0));
        assert_eq!(duration("10m"), Some(600.0));
        assert_eq!(duration("1.5h"), Some(5400.0));
        assert_eq!(duration("12"), Some(12.0));
        for bad in ["", "m", "0s", "-3m", "1e9h", "nan", "inf", "ten"] {
            assert_eq!(duration(bad), None, "{bad}");
        }
    }

    #[test]
    fn numbers_are_told_with_two_digits() {
        assert_eq!(percent(0.0123), "1.2 %");
        assert_eq!(percent(0.123), "12 %");
        assert_eq!(percent(0.00456), "0.46 %");
        assert_eq!(
            [0.05, 3.0, 600.0, 9000.0].map(time),
            ["50 ms", "3.0 s", "10.0 min", "2.5 h"]
        );
    }
}
