//! Documentation block of the claims about accuracy, generated from the table of all claims.

use stosszahl_results::{Table, TableRow};

use super::tables::markdown_table;
use crate::TrialError;
use crate::table::numbers;

/// Formats how many claims of each part have each verdict, and the claim of each part nearest to
/// its tolerance.
pub(super) fn summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let mut parts: Vec<(&str, Vec<TableRow<'_>>)> = Vec::new();
    for row in table.all_rows() {
        let part = row.words("part")?;
        match parts.iter_mut().find(|known| known.0 == part) {
            Some((_, rows)) => rows.push(row),
            None => parts.push((part, vec![row])),
        }
    }
    let mut all = [0; 4];
    let lines = parts.into_iter().map(|(part, rows)| {
        let mut cells = vec![part.to_owned()];
        for (verdict, all) in ["pass", "fail", "unresolved", "measured"]
            .iter()
            .zip(&mut all)
        {
            let own = rows
                .iter()
                .filter(|row| row.words("verdict") == Ok(verdict));
            let found = own.count();
            *all += found;
            cells.push(found.to_string());
        }
        cells.push(closest(&rows)?);
        Ok(cells)
    });
    let header = "part | pass | fail | unresolved | measured | claim closest to its tolerance";
    let text = markdown_table(header, lines)?;
    let [pass, fail, unresolved, measured] = all;
    Ok(format!(
        "{text}\n{} claims: {pass} pass, {fail} fail, {unresolved} unresolved; {measured} rows are measured and claim nothing. \
         [All {} rows]({link}).",
        pass + fail + unresolved,
        table.rows.len(),
    ))
}

/// Formats the claim whose deviation is the largest fraction of its tolerance.
fn closest(rows: &[TableRow<'_>]) -> Result<String, TrialError> {
    let (mut text, mut largest) = ("–".to_owned(), 0.0);
    for row in rows {
        let Ok(tolerance) = row.number("tolerance") else {
            continue;
        };
        let [expected, found] = [row.number("expected")?, row.number("found")?];
        let share = (found - expected).abs() / tolerance;
        if share > largest {
            largest = share;
            let error = row.number("found_se").unwrap_or(f64::NAN);
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
