//! Documentation blocks of reproduced papers: claims counted by verdict, and the values found.

use stosszahl_results::{
    FinishedPoints, Table, TableCell, TableEstimate, TableRow, format_significant,
};

use super::data::{DataMaker, DataTable, Made};
use super::results::number_text;
use super::tables::{count_verdicts, markdown_table};
use crate::TrialError;

/// Generates the block of all reproduced papers: claims counted by verdict, and the claims that
/// differ.
pub(super) fn papers_block(results: &FinishedPoints) -> Result<Made, TrialError> {
    let (mut counts, mut differences) = (Vec::new(), Vec::new());
    for (paper, stored) in &results.0 {
        let (name, claims) = (format!("`{}`", paper.name), stored.table("claims")?);
        for claim in claims.all_rows() {
            if claim.words("verdict")? == "differ" {
                let cells = [name.clone()].into_iter().chain(row(&claim)?);
                differences.push(Ok(cells.collect()));
            }
        }
        counts.push(Ok(counted(name, claims)));
    }
    Ok(format!(
        "{}\nWhat differs:\n\n{}",
        markdown_table("paper | claims | agree | differ | undecided | void", counts)?,
        markdown_table(
            "paper | figure | claim | where | paper says | found",
            differences
        )?
    )
    .into())
}

/// Generator of the block of claims of Kawasaki (1985).
pub(super) const KAWASAKI: DataMaker = DataMaker::Data {
    table: |results| claims(results, "kawasaki-1985"),
    data: DataTable {
        columns,
        summary: |table, link| summary(table, link, &KAWASAKI_PARTS),
    },
};

/// Generator of the block of claims of Bodrova & Osinsky (2024).
pub(super) const BODROVA: DataMaker = DataMaker::Data {
    table: |results| claims(results, "bodrova-2024"),
    data: DataTable {
        columns,
        summary: |table, link| summary(table, link, &BODROVA_PARTS),
    },
};

/// Part of a paper in a documentation block: its title, and the names of its figures.
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

/// Creates the table of all claims of one paper, with selected columns of its `claims.csv`.
fn claims(results: &FinishedPoints, paper: &str) -> Result<Table, TrialError> {
    let (all, mut table) = (results.point(paper)?.1.table("claims")?, columns());
    let places: Option<Vec<usize>> = (table.columns.iter())
        .map(|column| all.find_column(&column.name))
        .collect();
    let places = places.ok_or_else(|| TrialError::failed(format!("{paper}: other columns")))?;
    let own = |row: &Vec<TableCell>| places.iter().map(|&place| row[place].clone()).collect();
    table.rows = all.rows.iter().map(own).collect();
    Ok(table)
}

/// Formats how many claims of each part of a paper have each verdict, and all claims that differ.
fn summary(table: &Table, link: &str, parts: &[PaperPart]) -> Result<String, TrialError> {
    let part_of = |row: &TableRow<'_>| {
        let figure = row.words("figure")?;
        let found = parts.iter().position(|(_, own)| own.contains(&figure));
        found.ok_or_else(|| TrialError::failed(format!("figure {figure} is in no part")))
    };
    let mut own = vec![columns(); parts.len()];
    for row in table.all_rows() {
        own[part_of(&row)?].rows.push(row.cells().to_vec());
    }
    let named = parts.iter().zip(&own);
    let counts = named.map(|((words, _), own)| Ok(counted((*words).to_owned(), own)));
    let counts = markdown_table("part | claims | agree | differ | undecided | void", counts)?;
    let mut differences = Vec::new();
    for claim in own.iter().flat_map(Table::all_rows) {
        if claim.words("verdict")? == "differ" {
            let [figure, claim, _, paper, found] = row(&claim)?;
            differences.push(format!(
                "- {figure}: {claim}. The paper has {paper}, found is {found}.\n"
            ));
        }
    }
    let (all, differences) = (table.rows.len(), differences.concat());
    Ok(format!(
        "{counts}\n[All {all} claims]({link}). What differs, by figure:\n\n{differences}"
    ))
}

/// Counts claims by verdict, and formats the counts as cells of a row.
fn counted(name: String, claims: &Table) -> Vec<String> {
    let counts =
        ["agree", "differ", "undecided", "void"].map(|verdict| count_verdicts(claims, verdict));
    let counts = [claims.rows.len()].into_iter().chain(counts);
    [name]
        .into_iter()
        .chain(counts.map(|n| n.to_string()))
        .collect()
}

/// Formats a claim as table cells: figure, claim, location, the paper's value and the value found.
fn row(claim: &TableRow<'_>) -> Result<[String; 5], TrialError> {
    let number = |column: &str| {
        let value = claim.number(column).ok()?;
        let error = claim.number(&format!("{column}_se")).ok();
        Some(match error.filter(|error| *error > 0.0) {
            None => format_significant(value, 4),
            error => number_text(TableEstimate::with_error(value, error)),
        })
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
