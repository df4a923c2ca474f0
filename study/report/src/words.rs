//! Number formats of report pages: values, errors, powers of ten, settings.

use serde_json::Value;
use stosszahl_results::with_decimals;

/// Formats a number with about `digits` significant digits; a dash if it is not finite.
pub fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let size = value.abs();
    let sign = if value < 0.0 { "−" } else { "" };
    // The formatter rounds first, so that 0.99999 gets the exponent of the shown number.
    let text = format!("{size:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return format!("{sign}{}", without_zeros(&format!("{size:.decimals$}")));
    }
    match without_zeros(mantissa) {
        "1" => format!("{sign}{}", power(exponent)),
        mantissa => format!("{sign}{mantissa}·{}", power(exponent)),
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

/// Formats a value with its standard error, both to the second significant digit of the error.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error.filter(|error| error.is_finite() && *error > 0.0) {
        _ if !value.is_finite() => "–".to_owned(),
        None => number(value, 5),
        Some(error) => {
            let decimals = (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize;
            if decimals > 7 || value.abs() >= 1e6 || error >= 1e6 {
                return format!("{} ± {}", number(value, 5), number(error, 2));
            }
            with_decimals(value, error, decimals).replace('-', "−")
        }
    }
}

/// Formats ten to the power of a whole number, with superscripts.
pub fn power(exponent: i32) -> String {
    let raised = exponent.to_string();
    let raised = raised.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    });
    "10".chars().chain(raised).collect()
}

/// Picks at most `most` items of a list, evenly spread, including the first and the last.
pub(crate) fn spread<T: Clone>(items: &[T], most: usize) -> Vec<T> {
    match (items.len(), most) {
        (_, 0) => Vec::new(),
        (count, most) if count <= most => items.to_vec(),
        (count, 1) => vec![items[count - 1].clone()],
        (count, most) => (0..most)
            .map(|i| items[(i * (count - 1) + (most - 1) / 2) / (most - 1)].clone())
            .collect(),
    }
}

/// Formats the value of a swept key; a dash if there is none.
pub(crate) fn setting(value: Option<&Value>) -> String {
    match value {
        None => "–".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(Value::Number(value)) => value
            .as_f64()
            .map_or(value.to_string(), |value| number(value, 5)),
        Some(other) => other.to_string(),
    }
}
