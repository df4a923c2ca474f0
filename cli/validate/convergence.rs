//! What is left at vanishing simulator weight, cell size and step, and of which order the errors are.
//!
//! 48 disks at packing 0.25 in a box of 12.3 d, where no shear mode grows: the elastic collision rate over Enskog's, the energy at
//! `t_0` of the cooling gas with r = 0.8 over Haff's law, and its a2 at `3 t_0`. Weights are swept in cells of two diameters; cells and
//! steps at many simulators for each disk, so that the few that a small cell holds are still many.
//!
//! The rate of N simulators of momentum zero is divided by `sqrt(1 - 1/N)`: N (N - 1) pairs, each sqrt(N/(N - 1)) faster
//! than that of free ones.

use std::time::Instant;

use stosszahl_analysis::fit::{self, Point};
use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_dsmc::{Parameters, Unfollowed};
use stosszahl_model::{kinetic, transport};

use super::cooling::{DISKS, EQUILIBRATE, PACKING, RESTITUTION, cumulant, haff_time};
use super::gas::{energy, monte_carlo, start};
use super::schemes::{Method, Quantity, Setting};
use super::table::{Place, Row};
use super::{Effort, Trouble, over_seeds};

/// Simulators for each disk while cells and steps are swept.
const MANY: u32 = 64;
/// Elastic time that is left to relax and that is measured, in mean free times.
const ELASTIC: [f64; 2] = [10.0, 50.0];

/// What is varied: its name, the order of its error by theory, and values of h with the choices they stand for.
struct Sweep {
    name: &'static str,
    order: f64,
    values: Vec<(f64, Parameters)>,
}

fn sweeps(method: &Method) -> [Sweep; 3] {
    let base = method.at(Setting::Single);
    let side = (DISKS as f64 * std::f64::consts::FRAC_PI_4 / PACKING).sqrt();
    let many = Parameters {
        simulators_per_disk: MANY,
        ..base
    };
    [
        Sweep {
            name: "weight",
            order: 1.0,
            values: [1, 2, 4, 8, 16]
                .map(|simulators_per_disk| {
                    let parameters = Parameters {
                        simulators_per_disk,
                        ..base
                    };
                    (f64::from(simulators_per_disk).recip(), parameters)
                })
                .to_vec(),
        },
        Sweep {
            name: "cell",
            order: 2.0,
            values: [3.0, 4.0, 6.0, 8.0, 12.0]
                .map(|count| {
                    let cell = side / count;
                    let parameters = Parameters {
                        cell_size: Some(cell),
                        ..many
                    };
                    (cell, parameters)
                })
                .to_vec(),
        },
        Sweep {
            name: "step",
            order: 2.0,
            values: [1.0, 2.0, 4.0, 8.0]
                .map(|steps_per_crossing: f64| {
                    let parameters = Parameters {
                        steps_per_crossing,
                        ..many
                    };
                    (steps_per_crossing.recip(), parameters)
                })
                .to_vec(),
        },
    ]
}

/// Rate and energy of one gas over theory, its a2, and its wall time.
struct Found {
    values: [f64; 3],
    seconds: f64,
}

/// What the values are of.
const QUANTITIES: [&str; 3] = ["collision rate/Enskog", "K/Haff at t0", "a2 at 3 t0"];
/// How far from it the limit of a scheme that claims it may be.
const TOLERANCES: [f64; 3] = [0.005, 0.01, 0.002];

fn measure(parameters: Parameters, seed: u64) -> Result<Found, Trouble> {
    let began = Instant::now();
    let start = start(DISKS, PACKING, seed, EQUILIBRATE)?;
    let chi = kinetic::contact_value(PACKING);
    let enskog = kinetic::collision_rate(PACKING, chi, 0.0);
    let mut gas = monte_carlo::<Unfollowed>(&start, 1.0, parameters, seed)?;
    gas.advance(ELASTIC[0] / enskog, u64::MAX, &mut ());
    let (before, origin) = (gas.tally().collisions, gas.time());
    gas.advance((ELASTIC[0] + ELASTIC[1]) / enskog, u64::MAX, &mut ());
    let collisions = (gas.tally().collisions - before) as f64;
    let count = gas.simulators() as f64;
    let rate = 2.0 * collisions / count / (gas.time() - origin) / enskog;
    let mut gas = monte_carlo::<Unfollowed>(&start, RESTITUTION, parameters, seed)?;
    gas.advance(haff_time(), u64::MAX, &mut ());
    let temperature = energy(&gas.state()).temperature;
    gas.advance(3.0 * haff_time(), u64::MAX, &mut ());
    let cumulant = energy(&gas.state()).fourth_cumulant;
    Ok(Found {
        values: [
            rate / (1.0 - count.recip()).sqrt(),
            temperature / transport::relaxing_haff_law(RESTITUTION, 1.0),
            unbiased_cumulant(cumulant, gas.simulators()),
        ],
        seconds: began.elapsed().as_secs_f64(),
    })
}

/// Replicas: as many simulators in all, whatever the weight, but never few.
fn replicas(effort: Effort, parameters: &Parameters) -> u64 {
    let simulators = if effort.quick { 400 } else { 16_000 };
    (simulators / u64::from(parameters.simulators_per_disk)).max(16)
}

/// All sweeps of the schemes.
pub(super) fn run(
    effort: Effort,
    methods: &[Method],
    say: &(dyn Fn(&Row) + Sync),
) -> Result<Vec<Row>, Trouble> {
    let mut rows = Vec::new();
    for method in methods {
        for sweep in sweeps(method) {
            for row in swept(effort, method, &sweep)? {
                say(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

fn swept(effort: Effort, method: &Method, sweep: &Sweep) -> Result<Vec<Row>, Trouble> {
    // What they tend to.
    let limits = [1.0, 1.0, cumulant()?];
    let mut rows = Vec::new();
    let mut points: [Vec<Point>; 3] = Default::default();
    let mut here = Place {
        part: "convergence",
        scheme: method.name.to_owned(),
        setting: String::new(),
        packing: PACKING,
        seconds: 0.0,
        default: method.default,
    };
    let mut total = 0.0;
    for &(h, parameters) in &sweep.values {
        let count = replicas(effort, &parameters);
        let found = over_seeds(0..count, |seed| measure(parameters, seed))?;
        here.setting = format!("{} {h:.4}", sweep.name);
        here.seconds = found.iter().map(|gas| gas.seconds).sum();
        total += here.seconds;
        for (index, points) in points.iter_mut().enumerate() {
            let values: Vec<_> = found.iter().map(|gas| gas.values[index]).collect();
            let estimate = Estimate::over_replicas(&values).ok_or(Trouble::NoReplicas)?;
            points.push(Point {
                x: h,
                y: estimate.value,
                error: estimate.standard_error.unwrap_or(f64::NAN),
            });
            rows.push(here.row(QUANTITIES[index], limits[index], estimate, None));
        }
    }
    here.seconds = total;
    for (index, points) in points.iter().enumerate() {
        let line = fit::richardson(points, sweep.order)?;
        let order = fit::order(points)?;
        let estimate = |value, error| Estimate {
            value,
            standard_error: Some(error),
            replicas: points.len(),
        };
        let claimed = method.claims(Setting::Refined, Quantity::Limit);
        here.setting = format!("{} to 0", sweep.name);
        rows.push(here.row(
            format!(
                "{}, order {} (chi² {:.1} of {})",
                QUANTITIES[index], sweep.order, line.chi_squared, line.degrees_of_freedom
            ),
            limits[index],
            estimate(line.intercept, line.intercept_error),
            claimed.then_some(TOLERANCES[index]),
        ));
        rows.push(here.row(
            format!("{}, slope", QUANTITIES[index]),
            0.0,
            estimate(line.slope, line.slope_error),
            None,
        ));
        // The order means something only where the error is seen.
        if line.slope.abs() > 5.0 * line.slope_error {
            let half = 0.5 * (order.range[1] - order.range[0]);
            rows.push(here.row(
                format!("{}, measured order", QUANTITIES[index]),
                sweep.order,
                estimate(order.value, half),
                None,
            ));
        }
    }
    Ok(rows)
}
