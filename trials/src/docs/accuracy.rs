//! Text of the block of claims about accuracy, from the table of all claims.

use std::fmt::Write as _;

use stosszahl_results::Table;

use super::data::count;
use super::results::ResultRow;
use super::tables::table as markdown;
use crate::TrialError;
use crate::table::numbers;

/// Formats the number of claims by part and verdict, and the claim of each part that is closest to
/// its tolerance.
pub(super) fn summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let rows: Vec<ResultRow<'_>> = ResultRow::all_rows(table).collect();
    let mut parts: Vec<&str> = Vec::new();
    for row in &rows {
        let part = row.words("part")?;
        if !parts.contains(&part) {
            parts.push(part);
        }
    }
    let (mut lines, mut all) = (Vec::new(), [0; 4]);
    for part in parts {
        let mut own = Vec::new();
        for row in &rows {
            if row.words("part")? == part {
                own.push(*row);
            }
        }
        let mut cells = vec![part.to_owned()];
        for (verdict, all) in ["pass", "fail", "unresolved", "measured"]
            .iter()
            .zip(&mut all)
        {
            let found = count(&own, "verdict", verdict)?;
            *all += found;
            cells.push(found.to_string());
        }
        cells.push(closest(&own)?);
        lines.push(cells);
    }
    let header = [
        "part",
        "pass",
        "fail",
        "unresolved",
        "measured",
        "claim closest to its tolerance",
    ];
    let mut text = markdown(&header, &lines);
    let [pass, fail, unresolved, measured] = all;
    let _ = write!(
        text,
        "\n{} claims: {pass} pass, {fail} fail, {unresolved} unresolved; {measured} rows are measured and claim nothing. \
         [All {} rows]({link}).",
        pass + fail + unresolved,
        rows.len(),
    );
    Ok(text)
}

/// Formats the claim whose deviation is the largest share of its tolerance.
fn closest(rows: &[ResultRow<'_>]) -> Result<String, TrialError> {
    let (mut text, mut largest) = ("–".to_owned(), 0.0);
    for row in rows {
        let Some(tolerance) = row.maybe("tolerance") else {
            continue;
        };
        let [expected, found] = [row.number("expected")?, row.number("found")?];
        let share = (found - expected).abs() / tolerance;
        if share > largest {
            largest = share;
            let error = row.maybe("found_se").unwrap_or(f64::NAN);
            let [within, expected, found, error] =
                numbers(Some(tolerance), [expected, found, error]);
            text = format!(
                "{}, {} {} at packing {}: {found} ± {error}, expected {expected} within {within}",
                row.words("quantity")?,
                row.words("scheme")?,
                row.words("setting")?,
                (1e4 * row.number("packing")?).round() / 1e4,
            );
        }
    }
    Ok(text)
}
