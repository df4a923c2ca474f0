//! Markdown tables of documentation blocks, and lookups of numbers that several blocks show.

use std::fmt::Write as _;

use stosszahl_results::{FinishedPoints, NumberNotFound, RowKey, Table, TableEstimate};

use super::results::{At, Is, OF_EXACT, number_text};
use crate::TrialError;

/// Cells of one row of a Markdown table.
pub(super) type RowCells = Result<Vec<String>, TrialError>;

/// Formats a Markdown table; column names in `header` are separated by ` | `.
pub(super) fn markdown_table(
    header: &str,
    rows: impl IntoIterator<Item = RowCells>,
) -> Result<String, TrialError> {
    let columns = header.split(" | ").count();
    let mut text = format!("| {header} |\n|{}\n", "---|".repeat(columns));
    for row in rows {
        // Escape of a bar, which would end the cell.
        let cells: Vec<String> = row?.iter().map(|cell| cell.replace('|', "\\|")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    Ok(text)
}

/// Formats the cells of a Markdown row: texts first, then measured numbers with errors.
pub(super) fn measured_cells<const N: usize>(
    words: [String; N],
    numbers: impl IntoIterator<Item = Result<TableEstimate, NumberNotFound>>,
) -> RowCells {
    let mut cells = Vec::from(words);
    for number in numbers {
        cells.push(number_text(number?));
    }
    Ok(cells)
}

/// Counts the table rows with a given verdict.
pub(super) fn count_verdicts(table: &Table, verdict: &str) -> usize {
    let is_it = |row: &stosszahl_results::TableRow<'_>| row.words("verdict") == Ok(verdict);
    table.all_rows().filter(is_it).count()
}

/// Returns the energy of exact disks over that of another engine, at a sample time of a point.
pub(super) fn energy_ratio(
    results: &FinishedPoints,
    point: &str,
    other: &str,
    time: f64,
) -> Result<TableEstimate, NumberNotFound> {
    let keys = [
        ("engine_a", Is("ed")),
        ("engine_b", Is(other)),
        ("time", At(time)),
    ];
    let row = results.row(point, "comparison", &keys)?;
    row.measured("energy_ratio_a_over_b")
}

/// Returns K/K(0) of exact disks at a sample time, and its ratio to Haff's law.
pub(super) fn exact_energy(
    results: &FinishedPoints,
    time: f64,
) -> Result<[TableEstimate; 2], NumberNotFound> {
    let row = results.row("", "energy", &[OF_EXACT, ("time", At(time))])?;
    let ratio = row.measured("energy_ratio")?;
    Ok([ratio, ratio.times(1.0 / row.number("energy_ratio_theory")?)])
}

/// Formats a Markdown table of the energies of exact disks at sample times, with their ratios to
/// other engines, each given by name and title.
pub(super) fn against(
    results: &FinishedPoints,
    times: &[f64],
    others: &[(&str, &str)],
) -> Result<String, TrialError> {
    let row = |&time: &f64| {
        let own = exact_energy(results, time)?.map(Ok);
        let ratios = others
            .iter()
            .map(|other| energy_ratio(results, "", other.0, time));
        measured_cells([time.to_string()], own.into_iter().chain(ratios))
    };
    let words = others.iter().map(|(_, words)| format!(" | ED / {words}"));
    let words: String = words.collect();
    markdown_table(
        &format!("time t/t0 | ED: K/K(0) | ED over Haff{words}"),
        times.iter().map(row),
    )
}

/// Returns the row keys that select an engine and a time window.
pub(super) fn of_window(engine: &str, [start, end]: [f64; 2]) -> [RowKey<'_>; 3] {
    [
        ("engine", Is(engine)),
        ("window_start", At(start)),
        ("window_end", At(end)),
    ]
}
