//! Blocks of the verdicts of a run, or of each point of a sweep, in the words of the program.

use std::fmt::Write as _;

use stosszahl_results::{Table, TableEstimate, table};

use super::data::{DataMaker, DataTable, count};
use super::results::{FinishedRun, ResultRow};
use crate::TrialError;

/// Maker of the block of all verdicts of a case.
pub(super) const VERDICTS: DataMaker = DataMaker::Data {
    table: verdicts,
    data: DataTable { columns, summary },
};

fn columns() -> Table {
    table! {
        "verdicts", "Verdicts of a case, in the words of the program.";
        key "point", "", "Point of the sweep; empty without a sweep";
        note "verdict", "", "agree, differ, undecided, void, warning or note";
        key "topic", "", "Topic of the verdict";
        note "sentence", "", "The verdict in words";
        estimate "difference", "1", "Difference chosen before the run, relative or in the unit of its quantity; empty where nothing is compared";
        note "degrees_of_freedom", "1", "Degrees of freedom of the standard error";
        note "margin", "1", "Largest difference that counts as agreement";
        note "level", "1", "Probability that the interval misses the true difference";
    }
}

fn verdicts(results: &FinishedRun) -> Result<Table, TrialError> {
    let mut table = columns();
    for point in results.points() {
        for verdict in results.verdicts(point)? {
            let number = verdict.number.as_ref();
            let difference = number.map_or_else(TableEstimate::default, |number| {
                TableEstimate::with_error(number.difference, number.standard_error)
            });
            let degrees = number.and_then(|number| number.degrees_of_freedom);
            table.add((
                (point, verdict.kind.name()),
                (&*verdict.topic, &*verdict.sentence),
                difference,
                degrees.map(|degrees| degrees as f64),
                number.map(|number| number.margin),
                number.map(|number| number.level),
            ));
        }
    }
    Ok(table)
}

/// Formats the number of verdicts of each kind, and the sentence of each that finds no agreement.
fn summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let rows: Vec<ResultRow<'_>> = ResultRow::all_rows(table).collect();
    let mut counts = Vec::new();
    for kind in ["agree", "differ", "undecided", "void", "warning", "note"] {
        let found = count(&rows, "verdict", kind)?;
        if found > 0 {
            counts.push(format!("{found} {kind}"));
        }
    }
    let mut text = format!("{} ([all sentences]({link})).\n", counts.join(", "));
    for row in &rows {
        let (kind, point) = (row.words("verdict")?, row.words("point")?);
        if kind != "agree" {
            let place = if point.is_empty() {
                String::new()
            } else {
                format!("{}: ", point.replace('_', " "))
            };
            let (topic, sentence) = (row.words("topic")?, row.words("sentence")?);
            let _ = write!(text, "\n- *{kind}*, {place}{topic}: {sentence}");
        }
    }
    Ok(text)
}
