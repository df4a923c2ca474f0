//! Boxes so wide that disks hardly ever collide.

use nalgebra::{Vector2, vector};
use stosszahl_ed::{DissipationRule, EventDrivenEngine};
use stosszahl_model::{Domain, ParticleState, Plane, State};

use crate::support::disks;

/// Two disks in a box of ten million diameters reach the time without a collision: cells follow the
/// free path, so that hardly any are crossed.
#[test]
fn disks_that_do_not_meet_reach_the_time() {
    const SIDE: f64 = 1e7;
    let at =
        |place: f64, velocity: Vector2<f64>| ParticleState::new(vector![place, place], velocity);
    let start = State {
        time: 0.0,
        domain: Domain::<Plane>::periodic(vector![SIDE, SIDE]).expect("a box"),
        bodies: vec![
            at(1.0, vector![1.0, 0.3]),
            at(0.5 * SIDE, vector![-0.7, 0.2]),
        ],
    };
    let scene = disks(0.9);
    let mut engine: EventDrivenEngine<_> =
        EventDrivenEngine::new(scene, DissipationRule::Scene, start).expect("a gas");
    let until = 1e8;
    let reached = engine.advance(until, u64::MAX, &mut ());
    assert!(matches!(reached, Ok(true)), "{reached:?}");
    assert_eq!(engine.time(), until);
}
