//! Tables of Markdown that several blocks have.

use std::fmt::Write as _;

use super::data::Made;
use super::results::{FinishedRun, KeyCondition};
use crate::TrialError;

/// Formats a table of Markdown.
pub(super) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!(
        "| {} |\n|{}\n",
        header.join(" | "),
        "---|".repeat(header.len())
    );
    for row in rows {
        // Escape of a bar, which would end the cell.
        let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "\\|")).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

/// Makes a table of the energy of exact disks, and its ratio to the energy of other engines, given
/// as name and words.
pub(super) fn against(
    results: &FinishedRun,
    times: &[f64],
    others: &[(&str, &str)],
) -> Result<Made, TrialError> {
    let row = |&time: &f64| -> Result<Vec<String>, TrialError> {
        let keys = [
            ("engine", KeyCondition::Is("ed")),
            ("time", KeyCondition::At(time)),
        ];
        let exact = results.row("", "energy", &keys)?;
        let ratio = exact.measured("energy_ratio")?;
        let haff = ratio.divided_by(exact.number("energy_ratio_theory")?);
        let mut cells = vec![format!("{time}"), ratio.text(), haff.text()];
        for &(other, _) in others {
            let keys = [
                ("engine_a", KeyCondition::Is("ed")),
                ("engine_b", KeyCondition::Is(other)),
                ("time", KeyCondition::At(time)),
            ];
            let quotient = results
                .row("", "comparison", &keys)?
                .measured("energy_ratio_a_over_b")?;
            cells.push(quotient.text());
        }
        Ok(cells)
    };
    let rows: Vec<Vec<String>> = times.iter().map(row).collect::<Result<_, _>>()?;
    let words: Vec<String> = others
        .iter()
        .map(|(_, words)| format!("ED / {words}"))
        .collect();
    let mut header = vec!["time t/t0", "ED: K/K(0)", "ED over Haff"];
    header.extend(words.iter().map(String::as_str));
    Ok(table(&header, &rows).into())
}

/// Returns the conditions that select the row of an engine and a time window.
pub(super) fn of_window(
    engine: &str,
    [start, end]: [f64; 2],
) -> [(&'static str, KeyCondition<'_>); 3] {
    [
        ("engine", KeyCondition::Is(engine)),
        ("window_start", KeyCondition::At(start)),
        ("window_end", KeyCondition::At(end)),
    ]
}
