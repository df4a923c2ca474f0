//! Documentation blocks of the verdicts of a case, with the program's own sentences.

use std::fmt::Write as _;

use stosszahl_results::{FinishedPoints, Table, TableEstimate, table};

use super::data::{DataMaker, DataTable};
use super::tables::count_verdicts;
use crate::TrialError;

/// Generator of the block of all verdicts of a case, or of each point of its sweep.
pub(super) const VERDICTS: DataMaker = DataMaker::Data {
    table: |results| Ok(verdicts(results)),
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

fn verdicts(results: &FinishedPoints) -> Table {
    let mut table = columns();
    for (point, stored) in &results.0 {
        for verdict in &stored.manifest.verdicts {
            let number = verdict.number.as_ref();
            let difference = number.map_or_else(TableEstimate::default, |number| {
                TableEstimate::with_error(number.difference, number.standard_error)
            });
            let degrees = number.and_then(|number| number.degrees_of_freedom);
            table.add((
                (&*point.name, verdict.kind.name()),
                (&*verdict.topic, &*verdict.sentence),
                difference,
                degrees.map(|degrees| degrees as f64),
                number.map(|number| number.margin),
                number.map(|number| number.level),
            ));
        }
    }
    table
}

/// Formats how many verdicts there are of each kind, and the sentences of those other than *agree*.
fn summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let kinds = ["agree", "differ", "undecided", "void", "warning", "note"];
    let counts = kinds
        .map(|kind| (count_verdicts(table, kind), kind))
        .into_iter();
    let counts = counts.filter(|(found, _)| *found > 0);
    let counts: Vec<String> = counts
        .map(|(found, kind)| format!("{found} {kind}"))
        .collect();
    let mut text = format!("{} ([all sentences]({link})).\n", counts.join(", "));
    for row in table.all_rows() {
        let (kind, point) = (row.words("verdict")?, row.words("point")?);
        if kind != "agree" {
            let place = match point {
                "" => String::new(),
                point => format!("{}: ", point.replace('_', " ")),
            };
            let (topic, sentence) = (row.words("topic")?, row.words("sentence")?);
            let _ = write!(text, "\n- *{kind}*, {place}{topic}: {sentence}");
        }
    }
    Ok(text)
}
