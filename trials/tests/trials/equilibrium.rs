//! Elastic disks against known results: conservation over millions of collisions, equation of
//! state, collision rate, impact parameters. Values from the literature with their source.

use crate::support::{EqualDisks, disks, disordered};
use stosszahl_analysis::equilibrium::impact_uniform;
use stosszahl_ed::{DissipationRule, EventDrivenEngine};
use stosszahl_model::{Collision, Observer, State};
use stosszahl_trials::validate::exact::{COMPRESSIBILITY, equation_of_state};

fn equilibrated(
    count: usize,
    packing: f64,
    seed: u64,
    collisions_per_particle: u64,
) -> EventDrivenEngine<EqualDisks> {
    let start = disordered(count, packing, seed);
    let mut engine =
        EventDrivenEngine::new(disks(1.0), DissipationRule::Scene, start).expect("an engine");
    engine
        .advance(
            f64::INFINITY,
            collisions_per_particle * count as u64 / 2,
            &mut (),
        )
        .expect("collisions");
    engine
}

fn restarted(engine: &EventDrivenEngine<EqualDisks>) -> EventDrivenEngine<EqualDisks> {
    let mut state: State<EqualDisks> = engine.state();
    state.time = 0.0;
    EventDrivenEngine::new(disks(1.0), DissipationRule::Scene, state).expect("an engine")
}

/// Runs five million collisions of ten thousand disks: energy to 1e-11, no overlap beyond 1e-11 d.
#[test]
fn energy_and_exclusion_hold_over_millions_of_collisions() {
    let scene = disks(1.0);
    let mut engine = equilibrated(10_000, 0.25, 1, 10);
    let energy = engine.state().kinetic_energy(&scene);
    let mut worst = 0.0_f64;
    // Segments as in a run.
    for _ in 0..50 {
        engine
            .advance(f64::INFINITY, 100_000, &mut ())
            .expect("collisions");
        worst = worst.max(engine.worst_overlap());
        engine = restarted(&engine);
        worst = worst.max(engine.worst_overlap());
    }
    let drift = engine.state().kinetic_energy(&scene) / energy - 1.0;
    println!("5e6 collisions: relative energy drift {drift:e}, worst overlap {worst:e} d");
    assert!(drift.abs() <= 1e-11, "energy drift {drift:e}");
    assert!(worst <= 1e-11, "overlap {worst:e}");
}

/// Compares Z from the virial with the ten-term virial series of Kolafa & Rottner, Mol. Phys. 104,
/// 3435 (2006), within 0.2 %. The collision rate is compared with omega = 4 (Z - 1)/sqrt(pi) of the
/// same run, within 0.1 %. Errors are from ten blocks; both tolerances must be at least 3 measured
/// standard errors wide.
#[test]
fn equation_of_state_and_collision_rate() {
    for (packing, expected) in COMPRESSIBILITY {
        let found = equation_of_state(10_000, packing, 10, 800_000).expect("a gas");
        let [(z, z_error), (quotient, quotient_error)] = [found.factor, found.rate]
            .map(|part| (part.value, part.standard_error.expect("ten blocks")));
        println!(
            "packing {packing}: Z = {z:.5} +- {z_error:.5} (expected {expected}), rate over virial {quotient:.5} +- {quotient_error:.5}"
        );
        assert!(
            3.0 * z_error < 0.002 * expected,
            "Z = {z} +- {z_error}: too wide"
        );
        assert!(
            (z / expected - 1.0).abs() < 0.002,
            "Z = {z} +- {z_error}, expected {expected}"
        );
        assert!(
            3.0 * quotient_error < 0.001,
            "rate over virial +- {quotient_error}: too wide"
        );
        assert!(
            (quotient - 1.0).abs() < 0.001,
            "rate over virial {quotient} +- {quotient_error}"
        );
    }
}

#[derive(Default)]
struct Bins([u64; 20]);

impl Observer for Bins {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.0[((20.0 * collision.impact_square().sqrt()) as usize).min(19)] += 1;
        }
    }
}

/// Tests P(b/d) = 1 in elastic equilibrium at every density, fluid and crystal (Luding, Müller &
/// McNamara 1998, Fig. 3a): 2e5 collisions and p > 0.001 each.
#[test]
fn impact_parameters_are_uniform_at_every_density() {
    for packing in [0.01, 0.05, 0.1, 0.25, 0.5, 0.6, 0.7, 0.7495, 0.75] {
        let mut engine = equilibrated(1_980, packing, 3, 60);
        let mut bins = Bins::default();
        engine
            .advance(f64::INFINITY, 200_000, &mut bins)
            .expect("collisions");
        let test = impact_uniform(&bins.0);
        println!(
            "packing {packing}: chi-squared {:.2}, p = {:.4}",
            test.statistic,
            test.p_value.unwrap_or(f64::NAN)
        );
        assert_eq!(test.passed, Some(true), "packing {packing}: {test:?}");
    }
}
