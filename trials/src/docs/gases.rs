//! Blocks of gases with positions: transport, pairs near contact, and exact disks against the
//! contact-point scheme.

use super::data::Made;
use super::results::{Key, Results};
use super::tables::{of_window, table};
use crate::TrialError;

/// Scheme that has Enskog's rate and pressure.
const CONTACT_POINT: &str = "dsmc-contact-point";

/// Makes the block of transport coefficients over Enskog's, by packing.
pub(super) fn transport(results: &Results) -> Result<Made, TrialError> {
    let coefficients = [
        "self_diffusion",
        "shear_viscosity",
        "bulk_viscosity",
        "heat_conductivity",
    ];
    let mut rows = Vec::new();
    for point in results.points() {
        let row = results.row(point, "transport", &[("engine", Key::Is("ed"))])?;
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
    Ok(table(&header, &rows).into())
}

/// Makes the block of slopes of P(b/d): of pairs near contact as they are and shuffled, and of slow
/// and fast pairs at contact.
pub(super) fn pairs(results: &Results) -> Result<Made, TrialError> {
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
            let keys = [engine, start, end, ("quantity", Key::Is(quantity))];
            cells.push(results.row("", "chaos", &keys)?.measured("value")?.text());
        }
        rows.push(cells);
    }
    let header = ["window, t/t0", "0 to 1", "1 to 10", "10 to 40", "40 to 100"];
    Ok(table(&header, &rows).into())
}

/// Makes a table of the factors of the cooling rates of engines in windows of time.
pub(super) fn factors(
    results: &Results,
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
    Ok(table(&header, &rows))
}

/// Makes the block of energies of exact disks over those of the contact-point scheme from dilute to
/// dense, and the rate of the scheme.
pub(super) fn ladder(results: &Results) -> Result<Made, TrialError> {
    let simulators = "engine.dsmc-contact-point.simulators_per_particle";
    let times = [1.077, 10.77, 23.21, 50.0];
    let mut rows = Vec::new();
    for point in results.points() {
        let mut cells = vec![
            results.setting(point, "box.packing_fraction")?.to_string(),
            results.setting(point, simulators)?.to_string(),
        ];
        for time in times {
            let keys = [
                ("engine_a", Key::Is("ed")),
                ("engine_b", Key::Is(CONTACT_POINT)),
                ("time", Key::At(time)),
            ];
            let row = results.row(point, "comparison", &keys)?;
            cells.push(row.measured("energy_ratio_a_over_b")?.digits(4));
        }
        for engine in [CONTACT_POINT, "ed"] {
            let row = results.row(point, "dissipation", &of_window(engine, [0.0, 1.0]))?;
            cells.push(row.measured("rate_ratio")?.digits(4));
        }
        rows.push(cells);
    }
    let header = [
        "packing",
        "simulators per disk",
        "t/t0 = 1.077",
        "10.77",
        "23.21",
        "50",
        "rate of the scheme, t/t0 < 1",
        "rate of exact disks",
    ];
    Ok(table(&header, &rows).into())
}
