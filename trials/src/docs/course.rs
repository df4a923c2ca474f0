//! Blocks of the energies of exact disks against the contact-point scheme, with the factors of
//! their cooling rates: long tables, which are files.

use std::fmt::Write as _;

use stosszahl_results::{Table, TableEstimate, table};

use super::data::{DataMaker, DataTable};
use super::results::{FinishedRun, KeyCondition, MeasuredNumber, ResultRow};
use super::tables::of_window;
use crate::TrialError;

/// Maker of the block of 10 000 exact disks and of 64 simulators for each.
pub(super) const BROKEN_CHAOS: DataMaker = DataMaker::Data {
    table: |results| {
        let times = [0.2, 0.4309, 0.9283, 2.0, 4.309, 9.283, 20.0];
        course(results, &times, &[[0.0, 1.0], [1.0, 5.0], [5.0, 20.0]])
    },
    data: DATA,
};

/// Maker of the block of the case of 1998 and of four simulators for each disk.
pub(super) const UNBIASED: DataMaker = DataMaker::Data {
    table: |results| {
        let times = [0.1, 1.0, 2.154, 10.0, 21.54, 46.42, 100.0, 215.4, 400.0];
        course(results, &times, &[[0.0, 1.0], [100.0, 400.0]])
    },
    data: DATA,
};

const DATA: DataTable = DataTable { columns, summary };

/// Names of the engines, each with its title in the text.
const ENGINES: [(&str, &str); 2] = [
    ("ed", "exact disks"),
    ("dsmc-contact-point", "contact point"),
];
/// Columns of the factors of a cooling rate, and of the cooling rate itself.
const FACTORS: [&str; 5] = [
    "rate_ratio",
    "speed_ratio",
    "impact_ratio",
    "correlation_ratio",
    "dissipation_ratio",
];

fn columns() -> Table {
    table! {
        "course", "Energies of exact disks and of the contact-point scheme, and the factors of their cooling rates.";
        key "quantity", "", "energy_ratio: K/K(0); energy_over_haff: the same over Haff's law; energy_ratio_a_over_b: of exact disks over the engine; rate_ratio to dissipation_ratio: factors of the cooling rate and the rate, over those of chaos; slope: of P(b/d)";
        key "engine", "", "Engine";
        key "start", "t0", "Time, or start of the window";
        key "end", "t0", "End of the window; empty for a time";
        estimate "value", "1", "Value of the quantity";
    }
}

/// Creates the table of energies at times, and of factors in windows.
fn course(results: &FinishedRun, times: &[f64], windows: &[[f64; 2]]) -> Result<Table, TrialError> {
    let mut table = columns();
    let mut add =
        |quantity: &str, engine: &str, start: f64, end: Option<f64>, found: MeasuredNumber| {
            let value = TableEstimate::with_error(found.value, Some(found.error));
            table.add(((quantity, engine), (start, end), value));
        };
    let [(exact, _), (scheme, _)] = ENGINES;
    for &time in times {
        let keys = [
            ("engine", KeyCondition::Is(exact)),
            ("time", KeyCondition::At(time)),
        ];
        let row = results.row("", "energy", &keys)?;
        let ratio = row.measured("energy_ratio")?;
        add("energy_ratio", exact, time, None, ratio);
        let haff = ratio.divided_by(row.number("energy_ratio_theory")?);
        add("energy_over_haff", exact, time, None, haff);
        let keys = [
            ("engine_a", KeyCondition::Is(exact)),
            ("engine_b", KeyCondition::Is(scheme)),
            ("time", KeyCondition::At(time)),
        ];
        let quotient = results.row("", "comparison", &keys)?;
        let quotient = quotient.measured("energy_ratio_a_over_b")?;
        add("energy_ratio_a_over_b", scheme, time, None, quotient);
    }
    for &window in windows {
        for (engine, _) in ENGINES {
            let (keys, [start, end]) = (of_window(engine, window), window);
            let row = results.row("", "dissipation", &keys)?;
            for factor in FACTORS {
                add(factor, engine, start, Some(end), row.measured(factor)?);
            }
            let row = results.row("", "impact_parameter_summary", &keys)?;
            add("slope", engine, start, Some(end), row.measured("slope")?);
        }
    }
    Ok(table)
}

/// Returns the rows of a quantity of an engine.
fn rows_of<'a>(
    table: &'a Table,
    quantity: &str,
    engine: &str,
) -> Result<Vec<ResultRow<'a>>, TrialError> {
    let mut found = Vec::new();
    for row in ResultRow::all_rows(table) {
        if row.words("quantity")? == quantity && row.words("engine")? == engine {
            found.push(row);
        }
    }
    if found.is_empty() {
        return Err(TrialError::failed(format!("no {quantity} of {engine}")));
    }
    Ok(found)
}

/// Formats the quotient of energies where it is largest and at the end, and the cooling rates and
/// slopes of each window.
fn summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let [(exact, _), (scheme, _)] = ENGINES;
    let quotients = rows_of(table, "energy_ratio_a_over_b", scheme)?;
    let (mut largest, mut value) = (quotients[0], f64::NEG_INFINITY);
    for row in &quotients {
        let found = row.number("value")?;
        if found > value {
            (largest, value) = (*row, found);
        }
    }
    let at = |row: &ResultRow<'_>| -> Result<String, TrialError> {
        let (found, time) = (row.measured("value")?, row.number("start")?);
        Ok(format!("{} at t/t0 = {time}", found.text()))
    };
    let last = quotients[quotients.len() - 1];
    let haff = rows_of(table, "energy_over_haff", exact)?;
    let mut text = format!(
        "- Energy of exact disks over that of contact point: {}, largest {}. Over Haff's law it is {}.\n",
        at(&last)?,
        at(&largest)?,
        at(&haff[haff.len() - 1])?,
    );
    let windows = rows_of(table, "dissipation_ratio", exact)?;
    for (place, window) in windows.iter().enumerate() {
        let (start, end) = (window.number("start")?, window.number("end")?);
        let mut parts = Vec::new();
        for (engine, words) in ENGINES {
            let own = |quantity: &str| -> Result<String, TrialError> {
                let rows = rows_of(table, quantity, engine)?;
                let row = rows.get(place).ok_or_else(|| {
                    TrialError::failed(format!("no {quantity} of {engine} from {start} to {end}"))
                })?;
                Ok(row.measured("value")?.text())
            };
            let (cooling, slope) = (own("dissipation_ratio")?, own("slope")?);
            parts.push(format!("{words} {cooling} and {slope}"));
        }
        let _ = writeln!(
            text,
            "- Cooling rate over chaos and slope of P(b/d), t/t0 from {start} to {end}: {}.",
            parts.join(", "),
        );
    }
    let _ = write!(
        text,
        "\n[All {} numbers]({link}), with the factors of the cooling rates.",
        table.rows.len()
    );
    Ok(text)
}
