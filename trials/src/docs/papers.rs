//! Blocks of reproduced papers: number of claims by verdict, and the values found.

use std::fmt::Write as _;

use stosszahl_results::{Table, TableEstimate};

use super::data::{DataMaker, DataTable, Made, count};
use super::results::{FinishedRun, MeasuredNumber, ResultRow};
use super::tables::table as markdown;
use crate::TrialError;

/// Makes the block of all papers: number of claims by verdict, and the claims that differ.
pub(super) fn papers_block(results: &FinishedRun) -> Result<Made, TrialError> {
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
        markdown(
            &["paper", "claims", "agree", "differ", "undecided", "void"],
            &counts
        ),
        markdown(
            &["paper", "figure", "claim", "where", "paper says", "found"],
            &differences
        )
    )
    .into())
}

/// Maker of the block of the claims of Kawasaki (1985).
pub(super) const KAWASAKI: DataMaker = DataMaker::Data {
    table: |results| claims(results, "kawasaki-1985"),
    data: DataTable {
        columns,
        summary: |table, link| summary(table, link, &KAWASAKI_PARTS),
    },
};

/// Maker of the block of the claims of Bodrova & Osinsky (2024).
pub(super) const BODROVA: DataMaker = DataMaker::Data {
    table: |results| claims(results, "bodrova-2024"),
    data: DataTable {
        columns,
        summary: |table, link| summary(table, link, &BODROVA_PARTS),
    },
};

/// Part of a paper: its words, and the figures that belong to it.
type PaperPart = (&'static str, &'static [&'static str]);

const KAWASAKI_PARTS: [PaperPart; 3] = [
    (
        "columns under gravity, Figs. 3.1 to 3.4",
        &["3.1", "3.2", "3.3", "3.4"],
    ),
    ("rough grains that cool, Figs. 3.5 and 3.6", &["3.5", "3.6"]),
    (
        "channels, Figs. 5.2 to 5.6",
        &["5.2", "5.3", "5.4", "5.5", "5.6"],
    ),
];

const BODROVA_PARTS: [PaperPart; 8] = [
    ("1: equal sizes, unlike masses", &["1"]),
    ("2: few heavy particles, from the cooling state", &["2"]),
    ("3: three species", &["3"]),
    ("4: very many sizes", &["4"]),
    ("5: tracers", &["5"]),
    ("6: temperatures of a hundred sizes", &["6"]),
    ("7 and 8: viscoelastic particles", &["7", "8"]),
    ("I: number of collisions, energy", &["Table I"]),
];

fn columns() -> Table {
    stosszahl_results::table! {
        "claims", "What a paper claims, and what was found.";
        key "figure", "", "Figure or table of the paper";
        key "claim", "", "The claim in words";
        key "place", "", "Where the number stands: point, table, column and row";
        note "relation", "", "What the paper says of the number: equal, above, below; or what it should say: corrected";
        estimate "paper", "of the column", "The number of the paper, its bound, or its correction";
        estimate "found", "of the column", "The number that was found";
        note "margin", "of the column", "Largest deviation that counts as agreement";
        note "verdict", "", "agree, differ, undecided or void";
    }
}

/// Creates the table of all claims of one paper.
fn claims(results: &FinishedRun, paper: &str) -> Result<Table, TrialError> {
    let mut table = columns();
    for claim in results.rows(paper, "claims", &[])? {
        let estimate = |column: &str| TableEstimate {
            value: claim.maybe(column),
            standard_error: claim.maybe(&format!("{column}_se")),
            ..TableEstimate::default()
        };
        table.add((
            (claim.words("figure")?, claim.words("claim")?),
            (claim.words("place")?, claim.words("relation")?),
            (estimate("paper"), estimate("found")),
            claim.maybe("margin"),
            claim.words("verdict")?,
        ));
    }
    Ok(table)
}

/// Formats the number of claims of each part by verdict, and all claims that differ.
fn summary(table: &Table, link: &str, parts: &[PaperPart]) -> Result<String, TrialError> {
    let mut left: Vec<ResultRow<'_>> = ResultRow::all_rows(table).collect();
    let all = left.len();
    let (mut counts, mut differences) = (Vec::new(), String::new());
    for (words, figures) in parts {
        let mut own = Vec::new();
        for claim in std::mem::take(&mut left) {
            let is_own = figures.contains(&claim.words("figure")?);
            if is_own { &mut own } else { &mut left }.push(claim);
        }
        counts.push(counted(words, &own)?);
        for claim in own {
            if claim.words("verdict")? == "differ" {
                let [figure, claim, _, paper, found] = row(&claim)?;
                let _ = writeln!(
                    differences,
                    "- {figure}: {claim}. The paper has {paper}, found is {found}."
                );
            }
        }
    }
    if let Some(claim) = left.first() {
        let figure = claim.words("figure")?;
        return Err(TrialError::failed(format!("figure {figure} is in no part")));
    }
    let header = ["part", "claims", "agree", "differ", "undecided", "void"];
    Ok(format!(
        "{}\n[All {all} claims]({link}). What differs, by figure:\n\n{differences}",
        markdown(&header, &counts),
    ))
}

/// Counts claims by verdict, as cells of a table.
fn counted(name: &str, claims: &[ResultRow<'_>]) -> Result<Vec<String>, TrialError> {
    let mut cells = vec![name.to_owned(), claims.len().to_string()];
    for verdict in ["agree", "differ", "undecided", "void"] {
        cells.push(count(claims, "verdict", verdict)?.to_string());
    }
    Ok(cells)
}

/// Formats a claim as a row: figure, claim, place, value of the paper and value found.
fn row(claim: &ResultRow<'_>) -> Result<[String; 5], TrialError> {
    let number = |column: &str| {
        let value = claim.maybe(column)?;
        let error = claim
            .maybe(&format!("{column}_se"))
            .filter(|error| *error > 0.0);
        Some(error.map_or_else(
            || short(value),
            |error| MeasuredNumber { value, error }.text(),
        ))
    };
    let paper = number("paper").unwrap_or_default();
    let paper = match claim.words("relation")? {
        "above" => format!("> {paper}"),
        "below" => format!("< {paper}"),
        "corrected" => format!("{paper} (corrected)"),
        _ => paper,
    };
    Ok([
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
