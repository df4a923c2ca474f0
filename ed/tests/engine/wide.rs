//! Boxes so wide that disks hardly ever collide.

use nalgebra::vector;
use stosszahl_ed::{DissipationRule, EventDrivenEngine};
use stosszahl_model::samples::{disks, state};
use stosszahl_model::{Domain, Plane};

/// Two disks in a box of ten million diameters reach the time without a collision: cells follow the
/// free path, so that hardly any are crossed.
#[test]
fn disks_that_do_not_meet_reach_the_time() {
    const SIDE: f64 = 1e7;
    let domain = Domain::<Plane>::periodic(vector![SIDE, SIDE]).expect("a box");
    let half = 0.5 * SIDE;
    let one = (vector![1.0, 1.0], vector![1.0, 0.3]);
    let start = state(domain, [one, (vector![half, half], vector![-0.7, 0.2])]);
    let mut engine: EventDrivenEngine<_> =
        EventDrivenEngine::new(disks(0.9), DissipationRule::Scene, start).expect("a gas");
    let until = 1e8;
    let reached = engine.advance(until, u64::MAX, &mut ());
    assert!(matches!(reached, Ok(true)), "{reached:?}");
    assert_eq!(engine.time(), until);
}
