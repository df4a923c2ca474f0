//! Documentation blocks of cooling runs: energies of exact disks against the contact-point scheme,
//! and factors of the cooling rates. The long tables are files.

use std::fmt::Write as _;

use stosszahl_results::{FinishedPoints, Table, TableRow, table};

use super::data::{DataMaker, DataTable};
use super::results::{At, Is, number_text};
use super::tables::{energy_ratio, exact_energy, of_window};
use crate::TrialError;

/// Generator of the block for 10 000 exact disks against the contact-point scheme with 64
/// simulators per disk.
pub(super) const BROKEN_CHAOS: DataMaker = DataMaker::Data {
    table: |results| {
        let times = [0.2, 0.4309, 0.9283, 2.0, 4.309, 9.283, 20.0];
        course(results, &times, &[[0.0, 1.0], [1.0, 5.0], [5.0, 20.0]])
    },
    data: DATA,
};

/// Generator of the block for the gas of Luding, Müller & McNamara (1998), against the
/// contact-point scheme with four simulators per disk.
pub(super) const UNBIASED: DataMaker = DataMaker::Data {
    table: |results| {
        let times = [0.1, 1.0, 2.154, 10.0, 21.54, 46.42, 100.0, 215.4, 400.0];
        course(results, &times, &[[0.0, 1.0], [100.0, 400.0]])
    },
    data: DATA,
};

const DATA: DataTable = DataTable { columns, summary };

/// Name of the contact-point engine, the Monte Carlo scheme with Enskog's collision rate and
/// pressure.
pub(super) const CONTACT_POINT: &str = "dsmc-contact-point";
/// Names of the compared engines, each with its title in the text.
const ENGINES: [(&str, &str); 2] = [("ed", "exact disks"), (CONTACT_POINT, "contact point")];
/// Columns of the factors of the cooling rate over molecular chaos, and of the cooling rate itself.
pub(super) const FACTORS: [&str; 5] = [
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

/// Creates the table of energies at sample times, and of cooling-rate factors in time windows.
fn course(
    results: &FinishedPoints,
    times: &[f64],
    windows: &[[f64; 2]],
) -> Result<Table, TrialError> {
    let mut table = columns();
    let instant = None::<f64>;
    for &time in times {
        let [ratio, haff] = exact_energy(results, time)?;
        let other = energy_ratio(results, "", CONTACT_POINT, time)?;
        table.add((("energy_ratio", "ed"), (time, instant), ratio));
        table.add((("energy_over_haff", "ed"), (time, instant), haff));
        table.add((
            ("energy_ratio_a_over_b", CONTACT_POINT),
            (time, instant),
            other,
        ));
    }
    for &window in windows {
        for (engine, _) in ENGINES {
            let keys = of_window(engine, window);
            let row = results.row("", "dissipation", &keys)?;
            for factor in FACTORS {
                table.add(((factor, engine), window, row.measured(factor)?));
            }
            let row = results.row("", "impact_parameter_summary", &keys)?;
            table.add((("slope", engine), window, row.measured("slope")?));
        }
    }
    Ok(table)
}

/// Formats the energy ratio of exact disks over the scheme at its maximum and at the end. Cooling
/// rates and slopes of P(b/d) follow for each window.
fn summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let rows_of =
        |quantity, engine| table.find_rows(&[("quantity", Is(quantity)), ("engine", Is(engine))]);
    let quotients = rows_of("energy_ratio_a_over_b", CONTACT_POINT)?;
    let value = |row: &&TableRow<'_>| row.number("value").unwrap_or(f64::NEG_INFINITY);
    let mut largest = &quotients[0];
    for row in &quotients {
        if value(&row) > value(&largest) {
            largest = row;
        }
    }
    let at = |row: &TableRow<'_>| -> Result<String, TrialError> {
        let (found, time) = (row.measured("value")?, row.number("start")?);
        Ok(format!("{} at t/t0 = {time}", number_text(found)))
    };
    let haff = rows_of("energy_over_haff", "ed")?;
    let mut text = format!(
        "- Energy of exact disks over that of contact point: {}, largest {}. Over Haff's law it is {}.\n",
        at(&quotients[quotients.len() - 1])?,
        at(largest)?,
        at(&haff[haff.len() - 1])?,
    );
    for window in rows_of("dissipation_ratio", "ed")? {
        let [start, end] = [window.number("start")?, window.number("end")?];
        let mut parts = Vec::new();
        for (engine, words) in ENGINES {
            let own = |quantity| -> Result<String, TrialError> {
                let rows = table.find_rows(&[
                    ("quantity", Is(quantity)),
                    ("engine", Is(engine)),
                    ("start", At(start)),
                    ("end", At(end)),
                ])?;
                Ok(number_text(rows[0].measured("value")?))
            };
            let (cooling, slope) = (own("dissipation_ratio")?, own("slope")?);
            parts.push(format!("{words} {cooling} and {slope}"));
        }
        let parts = parts.join(", ");
        let _ = writeln!(
            text,
            "- Cooling rate over chaos and slope of P(b/d), t/t0 from {start} to {end}: {parts}."
        );
    }
    let all = table.rows.len();
    Ok(format!(
        "{text}\n[All {all} numbers]({link}), with the factors of the cooling rates."
    ))
}
