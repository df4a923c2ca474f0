//! Documentation blocks of gases with positions: transport coefficients, pair correlations near
//! contact, and energies across densities.

use stosszahl_results::{
    FinishedPoints, NumberNotFound, Table, TableEstimate, table, with_decimals,
};

use super::course::CONTACT_POINT;
use super::data::{DataMaker, DataTable, Made};
use super::results::{At, Is, OF_EXACT, value_and_error};
use super::tables::{energy_ratio, markdown_table, measured_cells, of_window};
use crate::TrialError;

/// Generates the block of transport coefficients over Enskog's, for each packing fraction.
pub(super) fn transport(results: &FinishedPoints) -> Result<Made, TrialError> {
    let coefficients = [
        "self_diffusion_over_enskog",
        "shear_viscosity_over_enskog",
        "bulk_viscosity_over_enskog",
        "heat_conductivity_over_enskog",
    ];
    let rows = results.names().map(|point| {
        let row = results.row(point, "transport", &[OF_EXACT])?;
        let packing = results.setting(point, "box.packing_fraction")?;
        measured_cells(
            [packing.to_string()],
            coefficients.map(|name| row.measured(name)),
        )
    });
    let header = "packing | self-diffusion | shear viscosity | bulk viscosity | heat conductivity";
    Ok(markdown_table(header, rows)?.into())
}

/// Generates the block of slopes of P(b/d): of pairs near contact, of shuffled ones, and of slow
/// and fast pairs at contact.
pub(super) fn pairs(results: &FinishedPoints) -> Result<Made, TrialError> {
    let windows = [[0.0, 1.0], [1.0, 10.0], [10.0, 40.0], [40.0, 100.0]];
    let quantities = [
        ("slope_near", "slope, pairs as they are"),
        ("slope_shuffled", "slope, shuffled"),
        ("slope_slow", "slope at contact, slow pairs"),
        ("slope_fast", "slope at contact, fast pairs"),
    ];
    let rows = quantities.map(|(quantity, words)| {
        let slope = |window| {
            let [engine, start, end] = of_window("ed", window);
            let keys = [engine, start, end, ("quantity", Is(quantity))];
            results.row("", "chaos", &keys)?.measured("value")
        };
        measured_cells([words.to_owned()], windows.map(slope))
    });
    let header = "window, t/t0 | 0 to 1 | 1 to 10 | 10 to 40 | 40 to 100";
    Ok(markdown_table(header, rows)?.into())
}

/// Generator of the block of the case `density-ladder`: energy ratios and collision rates of exact
/// disks and the contact-point scheme, by packing fraction.
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

fn ladder(results: &FinishedPoints) -> Result<Table, TrialError> {
    let simulators = "engine.dsmc-contact-point.simulators_per_particle";
    let mut table = ladder_columns();
    for point in results.names() {
        let ratio = |time| energy_ratio(results, point, CONTACT_POINT, time);
        let rate = |engine| -> Result<TableEstimate, NumberNotFound> {
            let row = results.row(point, "dissipation", &of_window(engine, [0.0, 1.0]))?;
            row.measured("rate_ratio")
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

/// Formats the table of energy ratios by packing fraction, for four simulators per disk.
fn ladder_summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let columns = [
        "energy_ratio_1",
        "energy_ratio_11",
        "energy_ratio_23",
        "energy_ratio_50",
        "scheme_rate",
    ];
    let rows = table.find_rows(&[("simulators", At(4.0))])?;
    let rows = rows.into_iter().map(|row| {
        let mut cells = vec![row.number("packing_fraction")?.to_string()];
        for column in columns {
            let [value, error] = value_and_error(row.measured(column)?);
            cells.push(with_decimals(value, error, 4));
        }
        Ok(cells)
    });
    let header = "packing | t/t0 = 1.1 | 10.8 | 23 | 50 | rate of the scheme, t/t0 < 1";
    let rows = markdown_table(header, rows)?;
    Ok(format!(
        "Four simulators for each disk; [all numbers]({link}), also of one:\n\n{rows}"
    ))
}
