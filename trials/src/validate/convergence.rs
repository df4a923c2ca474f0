//! Convergence test of Monte Carlo schemes: limits of vanishing simulator weight, cell size and
//! time step, and the order of the errors.
//!
//! The gas has 48 disks at packing 0.25 in a box of 12.3 d, where no shear mode grows. Measured are
//! the elastic collision rate over Enskog's, the energy of the cooling gas with r = 0.8 at `t_0`
//! over Haff's law, and its a2 at `3 t_0`. Weights vary in cells of two diameters. Cells and steps
//! vary with many simulators per disk, so that a small cell still holds many.
//!
//! The rate of N simulators with zero total momentum is divided by `sqrt(1 - 1/N)`. Of N (N - 1)
//! pairs each is faster by sqrt(N/(N - 1)) than a pair of free simulators.

use stosszahl_analysis::fit::{self, FitPoint};
use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_dsmc::Parameters;
use stosszahl_model::equation_of_state;
use stosszahl_theory::cooling;

use super::gas::{advance, energy, monte_carlo, start};
use super::over_seeds;
use super::schemes::{Method, SchemeQuantity, SchemeSetting};
use super::small_gas::{DISKS, EQUILIBRATE, PACKING, RESTITUTION, cumulant, haff_time};
use crate::table::{RowPlace, estimate, mean};
use crate::{Done, Effort, TrialError, TrialLog};

/// Simulators per disk while cell size and time step vary.
const MANY: u32 = 64;
/// Durations of relaxation and of measurement in the elastic gas \[mean free times\].
const ELASTIC: [f64; 2] = [10.0, 50.0];

/// Variation of one numerical parameter: its name, the theoretical order of its error, and its
/// values h with the scheme's parameters.
type Sweep = (&'static str, f64, Vec<(f64, Parameters)>);

fn sweeps(method: &Method) -> [Sweep; 3] {
    let base = method.parameters_at(SchemeSetting::Single);
    let side = (DISKS as f64 * std::f64::consts::FRAC_PI_4 / PACKING).sqrt();
    let simulators = |simulators_per_particle| Parameters {
        simulators_per_particle,
        ..base
    };
    let many = simulators(MANY);
    let weights = [1, 2, 4, 8, 16].map(|count| (f64::from(count).recip(), simulators(count)));
    let cells = [3.0, 4.0, 6.0, 8.0, 12.0].map(|count| {
        let cell_size = Some(side / count);
        (side / count, Parameters { cell_size, ..many })
    });
    let steps = [1.0, 2.0, 4.0, 8.0].map(|steps_per_cell_crossing: f64| {
        let parameters = Parameters {
            steps_per_cell_crossing,
            ..many
        };
        (steps_per_cell_crossing.recip(), parameters)
    });
    [
        ("weight", 1.0, weights.to_vec()),
        ("cell", 2.0, cells.to_vec()),
        ("step", 2.0, steps.to_vec()),
    ]
}

/// Names of the measured quantities of the convergence test.
const QUANTITIES: [&str; 3] = ["collision rate/Enskog", "K/Haff at t0", "a2 at 3 t0"];
/// Tolerances of the extrapolated limits, by quantity, for schemes that claim them.
const TOLERANCES: [f64; 3] = [0.005, 0.01, 0.002];

/// Measures the elastic collision rate and the cooling energy of one gas over theory, and its
/// fourth cumulant a2.
fn measure(parameters: Parameters, seed: u64) -> Result<[f64; 3], TrialError> {
    let start = start(DISKS, PACKING, seed, EQUILIBRATE)?;
    let chi = equation_of_state::contact_value(PACKING);
    let enskog = equation_of_state::collision_rate(PACKING, chi, 0.0);
    let mut gas = monte_carlo(&start, 1.0, parameters, seed)?;
    advance(&mut *gas, ELASTIC[0] / enskog, &mut ())?;
    let (before, origin) = (gas.work_counters().collisions, gas.time());
    advance(&mut *gas, (ELASTIC[0] + ELASTIC[1]) / enskog, &mut ())?;
    let collisions = (gas.work_counters().collisions - before) as f64;
    let count = gas.particle_count() as f64;
    let rate = 2.0 * collisions / count / (gas.time() - origin) / enskog;
    let mut gas = monte_carlo(&start, RESTITUTION, parameters, seed)?;
    advance(&mut *gas, haff_time(), &mut ())?;
    let temperature = energy(&gas.particles()).temperature;
    advance(&mut *gas, 3.0 * haff_time(), &mut ())?;
    let cumulant = energy(&gas.particles()).fourth_cumulant;
    Ok([
        rate / (1.0 - count.recip()).sqrt(),
        temperature / cooling::relaxing_haff_law(RESTITUTION, 1.0),
        unbiased_cumulant(cumulant, gas.particle_count()),
    ])
}

/// Returns the number of replicas for a scheme's parameters. The total number of simulators is
/// constant, with at least 16 replicas.
fn replicas(effort: &Effort, parameters: &Parameters) -> u64 {
    let simulators = if effort.quick { 400 } else { 16_000 };
    (simulators / u64::from(parameters.simulators_per_particle)).max(16)
}

/// Tests the convergence of all requested Monte Carlo schemes in weight, cell size and time step.
pub(super) fn test_convergence(log: &mut TrialLog) -> Done {
    for method in log.effort.methods.clone() {
        for sweep in sweeps(&method) {
            swept(log, &method, sweep)?;
        }
    }
    Ok(())
}

fn swept(log: &mut TrialLog, method: &Method, (name, tends_to, values): Sweep) -> Done {
    // Limits of the quantities by theory.
    let limits = [1.0, 1.0, cumulant()?];
    let mut points: [Vec<FitPoint>; 3] = Default::default();
    let mut here =
        RowPlace::new("convergence", method.name, "", PACKING, 0.0).only_default(method.default);
    let mut total = 0.0;
    for (h, parameters) in values {
        let count = replicas(&log.effort, &parameters);
        let (found, seconds) = over_seeds(0..count, |seed| measure(parameters, seed))?;
        here.setting = format!("{name} {h:.4}");
        here.seconds = seconds;
        total += seconds;
        for (index, points) in points.iter_mut().enumerate() {
            let found = mean(found.iter().map(|gas| gas[index]))?;
            points.push(FitPoint {
                x: h,
                y: found.value,
                error: found.standard_error.unwrap_or(f64::NAN),
            });
            log.claim(&here, QUANTITIES[index], limits[index], found, None);
        }
    }
    here.seconds = total;
    here.setting = format!("{name} to 0");
    for (index, points) in points.iter().enumerate() {
        let what = QUANTITIES[index];
        let line = fit::richardson(points, tends_to)?;
        let order = fit::order(points)?;
        let claimed = method.claims(SchemeSetting::Refined, SchemeQuantity::Limit);
        let (chi, freedom) = (line.chi_squared, line.degrees_of_freedom);
        log.claim(
            &here,
            format!("{what}, order {tends_to} (chi² {chi:.1} of {freedom})"),
            limits[index],
            estimate(line.intercept, line.intercept_error),
            claimed.then_some(TOLERANCES[index]),
        );
        let slope = estimate(line.slope, line.slope_error);
        log.claim(&here, format!("{what}, slope"), 0.0, slope, None);
        // Order of the error, only where the error is resolved.
        if line.slope.abs() > 5.0 * line.slope_error {
            let half = 0.5 * (order.range[1] - order.range[0]);
            let found = estimate(order.value, half);
            log.claim(
                &here,
                format!("{what}, measured order"),
                tends_to,
                found,
                None,
            );
        }
    }
    Ok(())
}
