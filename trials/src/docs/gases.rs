//! Blocks of gases with positions: transport, pairs near contact, and exact disks against the
//! contact-point scheme.

use stosszahl_results::{Table, TableEstimate, table};

use super::data::{DataMaker, DataTable, Made};
use super::map::estimate;
use super::results::{FinishedRun, KeyCondition, ResultRow};
use super::tables::{of_window, table as markdown};
use crate::TrialError;

/// Scheme that has Enskog's rate and pressure.
const CONTACT_POINT: &str = "dsmc-contact-point";

/// Makes the block of transport coefficients over Enskog's, by packing.
pub(super) fn transport(results: &FinishedRun) -> Result<Made, TrialError> {
    let coefficients = [
        "self_diffusion",
        "shear_viscosity",
        "bulk_viscosity",
        "heat_conductivity",
    ];
    let mut rows = Vec::new();
    for point in results.points() {
        let row = results.row(point, "transport", &[("engine", KeyCondition::Is("ed"))])?;
        let packing = results.setting(point, "box.packing_fraction")?;
        let mut cells = vec![packing.to_string()];
        for name in coefficients {
            cells.push(row.measured(&format!("{name}_over_enskog"))?.text());
        }
        rows.push(cells);
    }
    let header = [
        "packing",
        "self-diffusion",
        "shear viscosity",
        "bulk viscosity",
        "heat conductivity",
    ];
    Ok(markdown(&header, &rows).into())
}

/// Makes the block of slopes of P(b/d): of pairs near contact as they are and shuffled, and of slow
/// and fast pairs at contact.
pub(super) fn pairs(results: &FinishedRun) -> Result<Made, TrialError> {
    let windows = [[0.0, 1.0], [1.0, 10.0], [10.0, 40.0], [40.0, 100.0]];
    let quantities = [
        ("slope_near", "slope, pairs as they are"),
        ("slope_shuffled", "slope, shuffled"),
        ("slope_slow", "slope at contact, slow pairs"),
        ("slope_fast", "slope at contact, fast pairs"),
    ];
    let mut rows = Vec::new();
    for (quantity, words) in quantities {
        let mut cells = vec![words.to_owned()];
        for window in windows {
            let [engine, start, end] = of_window("ed", window);
            let keys = [engine, start, end, ("quantity", KeyCondition::Is(quantity))];
            cells.push(results.row("", "chaos", &keys)?.measured("value")?.text());
        }
        rows.push(cells);
    }
    let header = ["window, t/t0", "0 to 1", "1 to 10", "10 to 40", "40 to 100"];
    Ok(markdown(&header, &rows).into())
}

/// Makes a table of the factors of the cooling rates of engines in windows of time.
pub(super) fn factors(
    results: &FinishedRun,
    windows: &[[f64; 2]],
    engines: &[(&str, &str)],
) -> Result<String, TrialError> {
    let mut rows = Vec::new();
    for window in windows {
        for &(engine, words) in engines {
            let keys = of_window(engine, *window);
            let row = results.row("", "dissipation", &keys)?;
            let mut cells = vec![format!("{} to {}", window[0], window[1]), words.to_owned()];
            for factor in ["rate", "speed", "impact", "correlation", "dissipation"] {
                cells.push(row.measured(&format!("{factor}_ratio"))?.text());
            }
            rows.push(cells);
        }
    }
    let header = [
        "t/t0",
        "engine",
        "collision rate",
        "squared speed of pairs",
        "impact parameters",
        "correlation",
        "cooling rate",
    ];
    Ok(markdown(&header, &rows))
}

/// Maker of the block of the case `density-ladder`: energy ratios and collision rates by packing.
pub(super) const LADDER: DataMaker = DataMaker::Data {
    table: ladder,
    data: DataTable {
        columns: ladder_columns,
        summary: ladder_summary,
    },
};

fn ladder_columns() -> Table {
    table! {
        "density-ladder", "Energies of exact disks over those of the contact-point scheme, from dilute to dense.";
        key "packing_fraction", "1", "Packing fraction";
        key "simulators", "1", "Simulators of the scheme for each disk";
        estimate "energy_ratio_1", "1", "Energy of exact disks over that of the scheme at t/t0 = 1.077";
        estimate "energy_ratio_11", "1", "Energy ratio at t/t0 = 10.77";
        estimate "energy_ratio_23", "1", "Energy ratio at t/t0 = 23.21";
        estimate "energy_ratio_50", "1", "Energy ratio at t/t0 = 50";
        estimate "scheme_rate", "1", "Collision rate of the scheme over Enskog's, t/t0 < 1";
        estimate "exact_rate", "1", "Collision rate of exact disks over Enskog's, t/t0 < 1";
    }
}

fn ladder(results: &FinishedRun) -> Result<Table, TrialError> {
    let simulators = "engine.dsmc-contact-point.simulators_per_particle";
    let mut table = ladder_columns();
    for point in results.points() {
        let ratio = |time: f64| -> Result<TableEstimate, TrialError> {
            let keys = [
                ("engine_a", KeyCondition::Is("ed")),
                ("engine_b", KeyCondition::Is(CONTACT_POINT)),
                ("time", KeyCondition::At(time)),
            ];
            let row = results.row(point, "comparison", &keys)?;
            Ok(estimate(row.measured("energy_ratio_a_over_b")?))
        };
        let rate = |engine: &str| -> Result<TableEstimate, TrialError> {
            let row = results.row(point, "dissipation", &of_window(engine, [0.0, 1.0]))?;
            Ok(estimate(row.measured("rate_ratio")?))
        };
        table.add((
            results.setting(point, "box.packing_fraction")?,
            results.setting(point, simulators)?,
            [ratio(1.077)?, ratio(10.77)?, ratio(23.21)?, ratio(50.0)?],
            [rate(CONTACT_POINT)?, rate("ed")?],
        ));
    }
    Ok(table)
}

/// Formats the rows of four simulators for each disk.
fn ladder_summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let mut rows = Vec::new();
    for row in ResultRow::all_rows(table) {
        if (row.number("simulators")? - 4.0).abs() > 0.5 {
            continue;
        }
        let mut cells = vec![row.number("packing_fraction")?.to_string()];
        for column in [
            "energy_ratio_1",
            "energy_ratio_11",
            "energy_ratio_23",
            "energy_ratio_50",
            "scheme_rate",
        ] {
            cells.push(row.measured(column)?.digits(4));
        }
        rows.push(cells);
    }
    let header = [
        "packing",
        "t/t0 = 1.1",
        "10.8",
        "23",
        "50",
        "rate of the scheme, t/t0 < 1",
    ];
    Ok(format!(
        "Four simulators for each disk; [all numbers]({link}), also of one:\n\n{}",
        markdown(&header, &rows)
    ))
}
