//! Test of gases without positions: cooling of equal disks and spheres, and a published
//! polydisperse mixture.

use std::time::Instant;

use stosszahl_dsmc::homogeneous::{
    AliasTableSelection, HomogeneousEngine, PairCorrelationFactor, moments,
};
use stosszahl_model::samples::{SmoothParticles, UNIT, smooth_particles};
use stosszahl_model::{Plane, Space, Volume};
use stosszahl_theory::{
    Component, ContactValues as TheoryContact, CoolingState, MaxwellianMixture,
};

use super::over_seeds;
use crate::bench::{BenchMixture, BenchWork as _, CountRounding, SelectionArgument};
use crate::gas::{law, without_positions};
use crate::table::{RowPlace, mean};
use crate::{Done, TrialError, TrialLog};

/// Coefficient of restitution of the cooling gas without positions.
const RESTITUTION: f64 = 0.8;
/// Number of particles of the cooling gas without positions.
const PARTICLES: usize = 20_000;
/// Number density of the cooling gas in D dimensions \[1/length^D\].
const DENSITY: f64 = 0.1;
/// Sample times of the cooling gas, in units of Haff's time `t_0`.
const TIMES: [f64; 2] = [1.0, 4.0];
/// Sonine orders of the theory of cooling. One more would change a2 by 1e-5.
const ORDERS: usize = 6;

/// Simulates one cooling gas without positions. Returns energy and collisions over theory, and the
/// difference of a2 to theory, at each sample time.
fn course<S: Space>(seed: u64) -> Result<Vec<[f64; 3]>, TrialError> {
    let law = law(RESTITUTION)?;
    let scene: SmoothParticles<S> = smooth_particles(law.clone(), UNIT);
    let extent = (PARTICLES as f64 / DENSITY, PARTICLES);
    let mut engine: HomogeneousEngine<_, AliasTableSelection> =
        without_positions(scene, PairCorrelationFactor::Enskog, extent, |_| 1.0, seed)?;
    let one = Component {
        mass: 1.0,
        diameter: 1.0,
        density: DENSITY,
    };
    let mixture = MaxwellianMixture::new(S::DIMENSION, vec![one], law, TheoryContact::Enskog)?;
    let haff = CoolingState::at_temperature(&mixture, 1.0)?.time;
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

/// Tests cooling without positions in two or three dimensions against the kinetic equations, from a
/// Maxwellian start. Energy and collisions must agree to 0.5 %, a2 to 0.003.
fn cooling<S: Space>(log: &mut TrialLog) -> Done {
    let began = Instant::now();
    let seeds = if log.effort.quick { 24 } else { 100 };
    let (courses, _) = over_seeds(0..seeds, course::<S>)?;
    let setting = format!("{PARTICLES} in {} dimensions", S::DIMENSION);
    let seconds = began.elapsed().as_secs_f64();
    let here = RowPlace::new(
        "homogeneous",
        "homogeneous",
        setting,
        S::particle_volume(0.5) * DENSITY,
        seconds,
    );
    let over = |time: usize, what: usize| mean(courses.iter().map(|course| course[time][what]));
    for (index, time) in TIMES.into_iter().enumerate() {
        for (part, what) in ["K", "collisions"].into_iter().enumerate() {
            let what = format!("{what}/theory at t/t0 = {time}");
            log.claim(&here, what, 1.0, over(index, part)?, Some(0.005));
        }
    }
    let what = format!("a2 less that of theory at t/t0 = {}", TIMES[1]);
    log.claim(&here, what, 0.0, over(TIMES.len() - 1, 2)?, Some(0.003));
    Ok(())
}

/// Tests cooling of equal disks and equal spheres without positions, and Table I of Bodrova &
/// Osinsky (2024). The table has 1.2·10⁶ spheres of 125 sizes with restitution 0.5, to t = 100.
/// Published are 12.0727 and 12.0678 million collisions and energies of 1.233e4 and 1.235e4 (with
/// their exponent corrected).
pub(super) fn test_spheres(log: &mut TrialLog) -> Done {
    cooling::<Plane>(log)?;
    cooling::<Volume>(log)?;
    let began = Instant::now();
    let (runs, _) = over_seeds(0..3, |seed| {
        BenchMixture {
            selection: SelectionArgument::AliasTables,
            monomers: 1_000_000,
            counts: CountRounding::Nearest,
            restitution: 0.5,
            collisions: None,
            until: 100.0,
            seed: seed + 1,
            json: false,
        }
        .measure_speed()
    })?;
    let seconds = began.elapsed().as_secs_f64();
    let here = RowPlace::new("homogeneous", "mixture", "Table I", 0.0, seconds);
    for (what, name, unit, expected, tolerance) in [
        ("10⁶ collisions", "collisions", 1e6, 12.070, 0.025),
        ("K/10⁴", "final_energy", 1e4, 1.234, 0.012),
    ] {
        let found = mean(runs.iter().map(|run| run.number(name) / unit))?;
        let what = format!("{what} (Bodrova & Osinsky 2024)");
        log.claim(&here, what, expected, found, Some(tolerance));
    }
    Ok(())
}
