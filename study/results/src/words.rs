//! Formatting of numbers with their errors in tables and verdicts.

/// Removes the sign of a number rounded to zero: "-0.000" becomes "0.000".
pub fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| "0.".contains(c)) => zero.to_owned(),
        _ => text,
    }
}

/// Formats a value and its error with the given number of decimals.
pub fn with_decimals(value: f64, error: f64, decimals: usize) -> String {
    let value = unsigned_zero(format!("{value:.decimals$}"));
    format!("{value} ± {error:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::unsigned_zero;

    #[test]
    fn zero_has_no_sign() {
        for (value, text) in [(-1e-5, "0.000"), (1e-5, "0.000"), (-0.0013, "-0.001")] {
            assert_eq!(unsigned_zero(format!("{value:.3}")), text);
        }
    }
}
