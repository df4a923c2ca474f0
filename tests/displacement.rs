//! Displacements across the periodic box: both engines against closed forms and against the diffusion of Enskog.

#[allow(dead_code, unused_imports, reason = "each test file uses its own part")]
mod support;

use nalgebra::{Vector2, vector};
use stosszahl_ed::{Checkpoint, Dissipation, Engine};
use stosszahl_model::initial::Arrangement;
use stosszahl_model::{Body, Domain, State};
use support::{Disks, disks, gas};

fn tracked(state: State<Disks>) -> Checkpoint<Disks> {
    let windings = vec![[0; 2]; state.bodies.len()];
    Checkpoint {
        windings,
        ..state.into()
    }
}

/// Positions of disks that were never wrapped.
fn unwrapped(gas: &Checkpoint<Disks>) -> Vec<Vector2<f64>> {
    let lengths = gas.state.domain.lengths();
    let winding = |w: &[i32; 2]| vector![f64::from(w[0]), f64::from(w[1])].component_mul(&lengths);
    let bodies = gas.state.bodies.iter().zip(&gas.windings);
    bodies.map(|(body, w)| body.position + winding(w)).collect()
}

fn leg(gas: Checkpoint<Disks>, restitution: f64, until: f64) -> Checkpoint<Disks> {
    let mut engine =
        Engine::<_>::new(disks(restitution), Dissipation::Scene, gas).expect("an engine");
    assert!(engine.advance(until, u64::MAX, &mut ()).expect("a leg"));
    engine.checkpoint()
}

/// Disks in lanes of their own: v t, in legs that end where they please and on the edge of the box. Each of the at
/// most 1e4 crossings rounds a position of the size of the box, 4, by 4e-16.
#[test]
fn free_flight_is_velocity_times_time() {
    let domain = Domain::periodic(vector![1.5, 4.0]).expect("a box");
    let lanes = [(0.0, 1.5), (1.2, -0.75), (2.4, -1e-30)];
    let bodies: Vec<_> = lanes
        .iter()
        .map(|&(y, v)| Body::new(vector![0.0, y], vector![v, 0.0]))
        .collect();
    let start = State {
        time: 0.0,
        domain,
        bodies,
    };
    let mut gas = tracked(start.clone());
    for time in [0.1, 1.0, 2.0, 3.5, 1000.0, 7777.7] {
        gas = leg(gas, 0.5, time);
        for (now, then) in unwrapped(&gas).iter().zip(&start.bodies) {
            let expected = then.position + then.velocity * time;
            assert!((now - expected).norm() < 4e-12, "{time}: {now} {expected}");
        }
    }
    assert_eq!(gas.windings[0][0], 7777);
    assert_eq!(gas.windings[2], [0, 0]);
    // Going up and down too.
    let mut turned = start;
    for body in &mut turned.bodies {
        body.velocity = vector![0.0, 2.0 * body.velocity[0]];
        body.position = vector![0.0, 0.0];
    }
    turned.bodies.truncate(1);
    let gas = leg(tracked(turned), 0.5, 8.0);
    assert_eq!((gas.windings[0], unwrapped(&gas)[0][1]), ([0, 6], 24.0));
}

/// In a gas, against displacements that are added up over times so short that no disk moves by half a box; in boxes of
/// many cells, of three, of two and of one. 1e-10: 40 sums, each of positions that round to 1e-14, and their windings.
#[test]
fn windings_add_up_to_the_displacements() {
    for (count, packing) in [(400, 0.25), (6, 0.3), (4, 0.5), (2, 0.35)] {
        let start = gas(Arrangement::Square, count, packing, 5);
        let lengths = start.domain.lengths();
        let mut sums: Vec<Vector2<f64>> = start.bodies.iter().map(|body| body.position).collect();
        let mut gas = tracked(start.clone());
        let mut plain: Checkpoint<Disks> = start.into();
        let speed = gas
            .state
            .bodies
            .iter()
            .map(|b| b.velocity.norm())
            .sum::<f64>();
        let step = 0.45 * lengths.min() / speed;
        for i in 1..=400 {
            let before = gas.state.clone();
            gas = leg(gas, 1.0, f64::from(i) * step);
            plain = leg(plain, 1.0, f64::from(i) * step);
            for (sum, (now, then)) in sums
                .iter_mut()
                .zip(gas.state.bodies.iter().zip(&before.bodies))
            {
                *sum += before.domain.displacement(now.position, then.position);
            }
        }
        for (sum, found) in sums.iter().zip(unwrapped(&gas)) {
            assert!((sum - found).norm() < 1e-10, "{count} disks: {sum} {found}");
        }
        // Whether displacements are followed changes nothing else.
        assert_eq!(gas.state.bodies, plain.state.bodies);
        assert_eq!(gas.tally, plain.tally);
        assert!(plain.windings.is_empty());
        assert!(gas.windings.iter().any(|w| *w != [0, 0]) || count == 400);
    }
}

#[test]
fn windings_of_other_disks_are_refused() {
    let mut start = tracked(gas(Arrangement::Square, 16, 0.2, 5));
    start.windings.pop();
    let refused = Engine::<_>::new(disks(1.0), Dissipation::Scene, start);
    assert_eq!(
        refused.err().expect("an error").to_string(),
        "15 windings for 16 disks; allowed are none, or one for each disk"
    );
}
