//! Gases without positions: equal disks and spheres that cool, and a published mixture.

use std::time::Instant;

use stosszahl_analysis::statistics::Estimate;
use stosszahl_analysis::theory::{Component, Contact as TheoryContact, CoolingState, Mixture};
use stosszahl_dsmc::homogeneous::{Bounce, Contact, Engine, Gas, Slots, moments};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Constant, Free, Monodisperse, Plane, Scene, Smooth, Space, Volume};

use crate::bench_mixture::{BenchMixture, Counts, Pick, measure};
use crate::validate::table::{Place, Row};
use crate::validate::{Trouble, over_seeds};

/// Restitution, particles and number density of the cooling gas.
const RESTITUTION: f64 = 0.8;
const PARTICLES: usize = 20_000;
const DENSITY: f64 = 0.1;
/// When it is looked at, over `t_0`.
const TIMES: [f64; 2] = [1.0, 4.0];
/// Sonine orders of the theory: one more would change a2 by 1e-5.
const ORDERS: usize = 6;

fn place(scheme: &str, setting: &str, packing: f64, began: Instant) -> Place {
    Place {
        part: "homogeneous",
        scheme: scheme.to_owned(),
        setting: setting.to_owned(),
        packing,
        seconds: began.elapsed().as_secs_f64(),
        default: true,
    }
}

/// Energy and collisions over those of theory, and a2 less that of theory, at each time, of one gas.
fn course<S: Space>(seed: u64) -> Result<Vec<[f64; 3]>, Trouble> {
    let law = Constant::new(RESTITUTION).ok_or(Trouble::Restitution(RESTITUTION))?;
    let scene = Scene {
        space: S::default(),
        surface: Smooth,
        restitution: law,
        sizes: Monodisperse {
            radius: 0.5,
            mass: 1.0,
        },
        field: Free,
    };
    let streams = Streams::new(seed, 0);
    let mut velocities = streams.at(Purpose::Velocities, [0, 0]);
    let volume = PARTICLES as f64 / DENSITY;
    let gas = Gas::maxwellian(
        scene,
        Contact::Enskog,
        volume,
        PARTICLES,
        |_| 1.0,
        &mut velocities,
    )?;
    let mut engine: Engine<_, Slots, ()> = Engine::new(gas, (), Bounce, streams)?;
    let one = Component {
        mass: 1.0,
        diameter: 1.0,
        density: DENSITY,
    };
    let mixture = Mixture::new(S::DIMENSION, vec![one], law, TheoryContact::Enskog)?;
    let haff = CoolingState::of(&mixture, 1.0)?.time;
    let times = TIMES.map(|time| time * haff);
    let mut found = Vec::new();
    for theory in mixture.expand(ORDERS, &[1.0], &times)? {
        engine.advance(theory.time, u64::MAX, &mut ())?;
        let now = &moments(engine.gas(), None, None)[0];
        let collisions = 2.0 * engine.tally().collisions as f64 / PARTICLES as f64;
        found.push([
            now.temperature / theory.temperatures[0],
            collisions / theory.collisions[0],
            now.fourth_cumulant - theory.fourth_cumulants[0],
        ]);
    }
    Ok(found)
}

/// Cooling in the plane or in space against the kinetic equations, from a Maxwellian start: K and collisions to 0.5 %, and a2 to
/// 0.003.
fn cooling<S: Space>(seeds: u64) -> Result<Vec<Row>, Trouble> {
    let began = Instant::now();
    let courses = over_seeds(0..seeds, course::<S>)?;
    let setting = format!("{PARTICLES} in {} dimensions", S::DIMENSION);
    let packing = S::ball(0.5) * DENSITY;
    let here = place("homogeneous", &setting, packing, began);
    let estimate = |index: usize, what: usize| {
        let values: Vec<f64> = courses.iter().map(|course| course[index][what]).collect();
        Estimate::over_replicas(&values).ok_or(Trouble::NoReplicas)
    };
    let mut rows = Vec::new();
    for (index, time) in TIMES.into_iter().enumerate() {
        let energy = estimate(index, 0)?;
        rows.push(here.row(
            format!("K/theory at t/t0 = {time}"),
            1.0,
            energy,
            Some(0.005),
        ));
        let collisions = estimate(index, 1)?;
        rows.push(here.row(
            format!("collisions/theory at t/t0 = {time}"),
            1.0,
            collisions,
            Some(0.005),
        ));
    }
    let what = format!("a2 less that of theory at t/t0 = {}", TIMES[1]);
    rows.push(here.row(what, 0.0, estimate(TIMES.len() - 1, 2)?, Some(0.003)));
    Ok(rows)
}

/// Cooling of equal disks and equal spheres.
pub(super) fn haff(quick: bool) -> Result<Vec<Row>, Trouble> {
    let seeds = if quick { 24 } else { 100 };
    let mut rows = cooling::<Plane>(seeds)?;
    rows.extend(cooling::<Volume>(seeds)?);
    Ok(rows)
}

/// Table I of Bodrova & Osinsky (2024): 1.2·10⁶ spheres of 125 sizes, restitution 0.5, to t = 100. Published are 12.0727 and
/// 12.0678 million collisions and energies of 1.233e4 and 1.235e4 (with their exponent corrected).
pub(super) fn published_mixture() -> Result<Vec<Row>, Trouble> {
    let began = Instant::now();
    let runs = over_seeds(0..3, |seed| {
        let work = BenchMixture {
            selection: Pick::Own,
            monomers: 1_000_000,
            counts: Counts::Nearest,
            restitution: 0.5,
            collisions: None,
            until: 100.0,
            seed: seed + 1,
            json: false,
        };
        Ok(measure(&work)?)
    })?;
    let estimate = |values: Vec<f64>| Estimate::over_replicas(&values).ok_or(Trouble::NoReplicas);
    let collisions = estimate(runs.iter().map(|run| run.collisions as f64 / 1e6).collect())?;
    let energy = estimate(runs.iter().map(|run| run.final_energy / 1e4).collect())?;
    let here = place("mixture", "Table I", 0.0, began);
    Ok(vec![
        here.row(
            "10⁶ collisions (Bodrova & Osinsky 2024)",
            12.070,
            collisions,
            Some(0.025),
        ),
        here.row("K/10⁴ (Bodrova & Osinsky 2024)", 1.234, energy, Some(0.012)),
    ])
}
