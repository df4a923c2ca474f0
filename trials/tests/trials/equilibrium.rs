//! Impact parameters of elastic disks. `stosszahl-trials validate` has what else is known of them:
//! conservation, equation of state, collision rate.

use stosszahl_analysis::equilibrium::impact_uniform;
use stosszahl_ed::{DissipationRule, EventDrivenEngine};
use stosszahl_model::samples::EqualDisks;
use stosszahl_model::{Collision, Observer};
use stosszahl_trials::gas::{disks, disordered};

fn equilibrated(
    count: usize,
    packing: f64,
    seed: u64,
    collisions_per_particle: u64,
) -> EventDrivenEngine<EqualDisks> {
    let start = disordered(count, packing, seed).expect("a gas");
    let scene = disks(1.0).expect("a coefficient");
    let mut engine =
        EventDrivenEngine::new(scene, DissipationRule::Scene, start).expect("an engine");
    engine
        .advance(
            f64::INFINITY,
            collisions_per_particle * count as u64 / 2,
            &mut (),
        )
        .expect("collisions");
    engine
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
