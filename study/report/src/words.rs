//! Number formats of report pages: values, errors, powers of ten, settings.

use serde_json::Value;
use stosszahl_results::{format_significant, format_with_error};

/// Formats a number with `digits` significant digits; a dash if it is not finite.
pub fn number(value: f64, digits: usize) -> String {
    if value.is_finite() {
        typeset(&format_significant(value, digits))
    } else {
        "–".to_owned()
    }
}

/// Formats a value with its standard error, both to the second significant digit of the error; the
/// value alone if it is exact.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error.filter(|error| error.is_finite() && *error > 0.0) {
        Some(error) if value.is_finite() => {
            let text = format_with_error(value, error);
            let parts: Vec<String> = text.split(" ± ").map(typeset).collect();
            parts.join(" ± ")
        }
        _ => number(value, 5),
    }
}

/// Sets a number in plain text with a minus sign and a power of ten.
fn typeset(text: &str) -> String {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, ""));
    let mantissa = mantissa.replace('-', "−");
    match exponent.parse().map(power) {
        Err(_) => mantissa,
        Ok(power) if mantissa.trim_start_matches('−') == "1" => mantissa.replace('1', &power),
        Ok(power) => format!("{mantissa}·{power}"),
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
