//! Cooling of a gas in a box too small for shear modes to grow, against Haff's law.
//!
//! r = 0.8 at packing 0.25, where shear modes grow in boxes of more than 17.3 d: 48 disks in a box of 12.3 d. So few have
//! effects of their own: shear modes below the threshold hold more than their thermal share, which is 1/N of all, and a
//! pair of N with momentum zero is faster than two free ones. All go with 1/N, the number of simulators: with 64 for
//! each disk they are below a thousandth. With one for each disk the gas is compared with exact dynamics of 48 disks,
//! which has them too.

use std::time::Instant;

use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_analysis::theory::{Component, Contact, Mixture, TheoryError};
use stosszahl_dsmc::Unfollowed;
use stosszahl_ed as ed;
use stosszahl_model::{Constant, kinetic, transport};

use super::gas::{energy, monte_carlo, scene, start};
use super::schemes::{Method, Quantity, Setting};
use super::table::{Place, Row, against, over};
use super::{Effort, Trouble, over_seeds};
use crate::bench::Disks;

/// Packing fraction, coefficient of restitution, and number of disks.
pub(super) const PACKING: f64 = 0.25;
pub(super) const RESTITUTION: f64 = 0.8;
pub(super) const DISKS: usize = 48;
/// Elastic collisions of each disk before: RSA is close to equilibrium, and the box is small.
pub(super) const EQUILIBRATE: f64 = 50.0;

/// a2 of the homogeneous cooling state of the Boltzmann equation at this restitution, in six Sonine orders: -0.0262, where the
/// simplest formula has -0.0219.
pub(super) fn cumulant() -> Result<f64, TheoryError> {
    let disk = Component {
        mass: 1.0,
        diameter: 1.0,
        density: 1.0,
    };
    let law = Constant::new(RESTITUTION).unwrap_or(Constant::ELASTIC);
    let gas = Mixture::new(2, vec![disk], law, Contact::Dilute)?;
    // Some thirty collisions of each.
    let found = gas.expand(6, &[1.0], &[100.0])?;
    Ok(found[0].fourth_cumulants[0])
}

/// Times over `t_0`.
const TIMES: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
/// Simulators for each disk that stand for none of the noise of few.
const MANY: u32 = 64;

/// Temperatures at the times, the mean of a2 over the later ones, and wall time of one gas.
struct Course {
    temperatures: Vec<f64>,
    cumulants: Vec<f64>,
    seconds: f64,
}

pub(super) fn haff_time() -> f64 {
    kinetic::haff_time(PACKING, RESTITUTION, kinetic::contact_value(PACKING))
}

impl Course {
    fn new(began: Instant, states: &[stosszahl_model::State<Disks>]) -> Self {
        let samples: Vec<_> = states
            .iter()
            .map(|state| (energy(state), state.bodies.len()))
            .collect();
        Self {
            temperatures: samples
                .iter()
                .map(|(sample, _)| sample.temperature)
                .collect(),
            cumulants: samples
                .iter()
                .map(|(sample, count)| unbiased_cumulant(sample.fourth_cumulant, *count))
                .collect(),
            seconds: began.elapsed().as_secs_f64(),
        }
    }

    fn exact(seed: u64) -> Result<Self, Trouble> {
        let began = Instant::now();
        let mut gas: ed::Checkpoint<Disks> = start(DISKS, PACKING, seed, EQUILIBRATE)?.into();
        let mut states = Vec::new();
        for time in TIMES {
            let mut engine =
                ed::Engine::<Disks>::new(scene(RESTITUTION)?, ed::Dissipation::Scene, gas)?;
            engine.advance(time * haff_time(), u64::MAX, &mut ())?;
            gas = engine.checkpoint();
            states.push(gas.state.clone());
        }
        Ok(Self::new(began, &states))
    }

    fn monte_carlo(parameters: stosszahl_dsmc::Parameters, seed: u64) -> Result<Self, Trouble> {
        let began = Instant::now();
        let state = start(DISKS, PACKING, seed, EQUILIBRATE)?;
        let mut engine = monte_carlo::<Unfollowed>(&state, RESTITUTION, parameters, seed)?;
        let mut states = Vec::new();
        for time in TIMES {
            engine.advance(time * haff_time(), u64::MAX, &mut ());
            states.push(engine.state());
        }
        Ok(Self::new(began, &states))
    }
}

/// Means over replicas of T at each time and of a2.
struct Means {
    temperatures: Vec<Estimate>,
    cumulant: Estimate,
    seconds: f64,
}

impl Means {
    fn new(courses: &[Course]) -> Result<Self, Trouble> {
        let mean = |value: &dyn Fn(&Course) -> f64| {
            Estimate::over_replicas(&courses.iter().map(value).collect::<Vec<_>>())
                .ok_or(Trouble::NoReplicas)
        };
        let times = 0..TIMES.len();
        Ok(Self {
            temperatures: times
                .map(|time| mean(&|course| course.temperatures[time]))
                .collect::<Result<_, _>>()?,
            // At t_0 a2 is relaxed to 1 - 2^-6.4: the mean is 0.3 % short.
            cumulant: mean(&|course| {
                course.cumulants.iter().sum::<f64>() / course.cumulants.len() as f64
            })?,
            seconds: courses.iter().map(|course| course.seconds).sum(),
        })
    }
}

fn place(scheme: &str, setting: &str, seconds: f64, default: bool) -> Place {
    Place {
        part: "cooling",
        scheme: scheme.to_owned(),
        setting: setting.to_owned(),
        packing: PACKING,
        seconds,
        default,
    }
}

fn law(time: f64) -> f64 {
    transport::relaxing_haff_law(RESTITUTION, time)
}

/// All settings of the schemes, and exact dynamics.
pub(super) fn run(
    effort: Effort,
    methods: &[Method],
    say: &(dyn Fn(&Row) + Sync),
) -> Result<Vec<Row>, Trouble> {
    let few = if effort.quick { 400 } else { 10_000 };
    let many = if effort.quick { 16 } else { 400 };
    let exact = Means::new(&over_seeds(0..few, Course::exact)?)?;
    let simplest = kinetic::fourth_cumulant(2, RESTITUTION);
    let cumulant = cumulant()?;
    let mut rows = Vec::new();
    let mut add = |row: Row| {
        say(&row);
        rows.push(row);
    };
    let here = place("event-driven", "48 disks", exact.seconds, false);
    for (time, found) in TIMES.into_iter().zip(&exact.temperatures) {
        let what = format!("K/Haff at t/t0 = {time}");
        add(here.row(what, 1.0, over(*found, law(time)), None));
    }
    add(here.row("a2", cumulant, exact.cumulant, None));
    for method in methods {
        for setting in Setting::ALL {
            let mut parameters = method.at(setting);
            if setting == Setting::Refined {
                parameters.simulators_per_disk = parameters.simulators_per_disk.max(MANY);
            }
            let copies = parameters.simulators_per_disk;
            let replicas = (few / u64::from(copies)).max(many);
            let found = over_seeds(0..replicas, |seed| Course::monte_carlo(parameters, seed))?;
            let found = Means::new(&found)?;
            let name = format!("{} {copies}", setting.name());
            let here = place(method.name, &name, found.seconds, method.default);
            let claim = |quantity, tolerance| method.claims(setting, quantity).then_some(tolerance);
            for (index, time) in TIMES.into_iter().enumerate() {
                let own = found.temperatures[index];
                let (what, ratio) = if copies == 1 {
                    (
                        "K/K of event-driven",
                        against(own, exact.temperatures[index]),
                    )
                } else {
                    ("K/Haff", over(own, law(time)))
                };
                add(here.row(
                    format!("{what} at t/t0 = {time}"),
                    1.0,
                    ratio,
                    claim(Quantity::Cooling, 0.01),
                ));
            }
            add(here.row(
                "a2",
                cumulant,
                found.cumulant,
                claim(Quantity::Cumulant, 0.002),
            ));
            let first = "a2, first Sonine order";
            add(here.row(first, simplest, found.cumulant, None));
        }
    }
    Ok(rows)
}
