//! Short decimal text of numbers for error messages.

/// Formats a number as it would be typed, or with seven digits where that is longer than twelve
/// characters.
///
/// ```
/// use stosszahl_model::format_short;
///
/// assert_eq!(format_short(-0.25), "-0.25");
/// assert_eq!(format_short(1.0000001), "1.0000001");
/// assert_eq!(format_short(1.0 / 3.0), "0.3333333");
/// assert_eq!(format_short(1e300), "1e300");
/// assert_eq!(format_short(f64::MAX), "1.797693e308");
/// assert_eq!(format_short(f64::NAN), "NaN");
/// ```
pub fn format_short(value: f64) -> String {
    /// Largest length of a number that is shown with all digits \[characters\].
    const LONGEST: usize = 12;
    let [plain, exponent] = [format!("{value}"), format!("{value:e}")];
    if plain.len() <= LONGEST {
        plain
    } else if exponent.len() <= LONGEST {
        exponent
    } else if (1e-3..1e6).contains(&value.abs()) {
        let before = value.abs().log10().floor().max(0.0) as usize + 1;
        format!("{value:.*}", 8 - before.min(7))
    } else {
        format!("{value:.6e}")
    }
}
