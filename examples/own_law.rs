//! A custom collision law: the generic engines take any [`Restitution`].

#![allow(clippy::print_stdout)]

use stosszahl::ed::{DissipationRule, EventDrivenEngine};
use stosszahl::model::samples::{self, UNIT};
use stosszahl::model::{Domain, Free, Restitution, Scene, Smooth};
use stosszahl::prelude::*;

/// Restitution that is 1 below a threshold of the approach speed and lower above it.
#[derive(Clone, Debug)]
struct Threshold {
    speed: f64,
    above: f64,
}

impl Restitution for Threshold {
    fn normal_restitution(&self, approach: f64) -> f64 {
        if approach < self.speed {
            1.0
        } else {
            self.above
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gas = Gas::disks(1000).packing_fraction(0.1).build()?;
    let law = Threshold {
        speed: 0.5,
        above: 0.8,
    };
    let scene = Scene::new(Smooth, law, UNIT, Free);
    let [x, y, _] = gas.particles.lengths;
    let bodies = gas.particles.all.iter();
    let bodies = bodies.map(|one| (one.position.xy(), one.velocity.xy()));
    let state = samples::state(Domain::periodic([x, y].into())?, bodies);
    let mut engine = EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, state)?;
    for time in [10.0, 100.0, 1000.0] {
        engine.advance(time, u64::MAX, &mut ())?;
        println!("T({time}) = {:.4}", engine.state().temperature(&scene));
    }
    // Little cooling below the threshold: collisions keep the energy once the relative speed, about
    // sqrt(2 T), is lower.
    let end = engine.state().temperature(&scene);
    assert!(
        end > 0.005 && end < 0.5,
        "cooling slows down at the threshold"
    );
    Ok(())
}
