//! Blocks of reproduced papers: number of claims by verdict, and the values found.

use super::entries::{Made, table};
use super::results::{Measured, Results, Row};
use crate::TrialError;

/// Makes the block of all papers: number of claims by verdict, and the claims that differ.
pub(super) fn all(results: &Results) -> Result<Made, TrialError> {
    let (mut counts, mut differences) = (Vec::new(), Vec::new());
    for paper in results.points() {
        let claims = results.rows(paper, "claims", &[])?;
        counts.push(counted(&format!("`{paper}`"), &claims)?);
        for claim in &claims {
            if claim.words("verdict")? == "differ" {
                let mut cells = vec![format!("`{paper}`")];
                cells.extend(row(claim)?);
                differences.push(cells);
            }
        }
    }
    Ok(format!(
        "{}\nWhat differs:\n\n{}",
        table(
            &["paper", "claims", "agree", "differ", "undecided", "void"],
            &counts
        ),
        table(
            &["paper", "figure", "claim", "where", "paper says", "found"],
            &differences
        )
    )
    .into())
}

/// Makes the table of all claims of one paper.
fn claims(results: &Results, paper: &str) -> Result<Made, TrialError> {
    let mut rows = Vec::new();
    for claim in results.rows(paper, "claims", &[])? {
        let mut cells = row(&claim)?;
        cells.push(claim.words("verdict")?.to_owned());
        rows.push(cells);
    }
    let header = ["figure", "claim", "where", "paper says", "found", "verdict"];
    Ok(table(&header, &rows).into())
}

/// Makes the block of the claims of Kawasaki (1985).
pub(super) fn kawasaki(results: &Results) -> Result<Made, TrialError> {
    claims(results, "kawasaki-1985")
}

/// Makes the block of the claims of Bodrova & Osinsky (2024).
pub(super) fn bodrova(results: &Results) -> Result<Made, TrialError> {
    claims(results, "bodrova-2024")
}

/// Counts claims by verdict, as cells of a table.
fn counted(name: &str, claims: &[Row<'_>]) -> Result<Vec<String>, TrialError> {
    let mut cells = vec![name.to_owned(), claims.len().to_string()];
    for verdict in ["agree", "differ", "undecided", "void"] {
        let mut count = 0;
        for claim in claims {
            count += usize::from(claim.words("verdict")? == verdict);
        }
        cells.push(count.to_string());
    }
    Ok(cells)
}

/// Formats a claim as a row: figure, claim, place, value of the paper and value found.
fn row(claim: &Row<'_>) -> Result<Vec<String>, TrialError> {
    let number = |column: &str| {
        let value = claim.maybe(column)?;
        let error = claim
            .maybe(&format!("{column}_se"))
            .filter(|error| *error > 0.0);
        Some(error.map_or_else(|| short(value), |error| Measured { value, error }.text()))
    };
    let paper = number("paper").unwrap_or_default();
    let paper = match claim.words("relation")? {
        "above" => format!("> {paper}"),
        "below" => format!("< {paper}"),
        "corrected" => format!("{paper} (corrected)"),
        _ => paper,
    };
    Ok(vec![
        claim.words("figure")?.to_owned(),
        claim.words("claim")?.to_owned(),
        format!("`{}`", claim.words("place")?),
        paper,
        number("found").unwrap_or_else(|| "–".to_owned()),
    ])
}

/// Formats a number without an error, in four digits.
fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let places = (3.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
