//! Boxes so wide that disks hardly ever meet.

use nalgebra::{Vector2, vector};
use stosszahl_ed::{Dissipation, Engine, EngineError};
use stosszahl_model::{Body, Domain, Plane, State};

use crate::support::disks;

/// An engine of few disks in a million cells starts afresh again and again while they fly: it gives up after as much work as
/// ten million crossings are, some seconds, although hardly any cell is crossed.
#[test]
fn disks_that_do_not_meet_are_given_up() {
    const SIDE: f64 = 1e7;
    let at = |place: f64, velocity: Vector2<f64>| Body::new(vector![place, place], velocity);
    let start = State {
        time: 0.0,
        domain: Domain::<Plane>::periodic(vector![SIDE, SIDE]).expect("a box"),
        bodies: vec![
            at(1.0, vector![1.0, 0.3]),
            at(0.5 * SIDE, vector![-0.7, 0.2]),
        ],
    };
    let scene = disks(0.9);
    let mut engine: Engine<_> = Engine::new(scene, Dissipation::Scene, start).expect("a gas");
    // Some twenty thousand fresh starts on the way: it would get there in some seconds more.
    let until = 1e8;
    let given_up = engine.advance(until, u64::MAX, &mut ());
    let Err(EngineError::NoCollisions { time, .. }) = given_up else {
        panic!("{given_up:?}");
    };
    assert!(time < until, "{time}");
}
