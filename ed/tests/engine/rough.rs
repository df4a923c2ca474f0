//! Disks that spin: conservation laws and cooling.

use std::f64::consts::PI;

use stosszahl_ed::{DiskBoundaries, DissipationRule, EventDrivenEngine};
use stosszahl_model::equation_of_state::contact_value;
use stosszahl_model::samples::{FallingParticles, grains};
use stosszahl_model::{Plane, Rough, Smooth, State, Surface};

use crate::support::{down, gas, rough};

type Disks = FallingParticles<Plane, Rough>;

fn start(scene: &Disks, side: f64, count: usize, seed: u64) -> State<Disks> {
    gas(
        scene,
        &DiskBoundaries::periodic(),
        [side, side],
        count,
        seed,
    )
}

fn engine(
    scene: &Disks,
    dissipation: DissipationRule,
    state: State<Disks>,
) -> EventDrivenEngine<Disks> {
    EventDrivenEngine::new(scene.clone(), dissipation, state).expect("an engine")
}

/// Energy and momentum after a million collisions, with tangential restitution -1 and 1.
#[test]
fn energy_and_momentum_are_conserved() {
    for tangential in [-1.0, 1.0] {
        let scene = grains(1.0, 1.0, rough(tangential), down(0.0));
        let state = start(&scene, 50.0, 1000, 1);
        let energy =
            |state: &State<Disks>| state.kinetic_energy(&scene) + state.spin_energy(&scene);
        let (before, momentum) = (energy(&state), state.momentum(&scene));
        let mut engine = engine(&scene, DissipationRule::Scene, state.clone());
        engine
            .advance(f64::INFINITY, 1_000_000, &mut ())
            .expect("collisions");
        let state_now = engine.state();
        // A walk of 1e6 steps of some 1e-16 each, over a thousand disks.
        let drift = energy(&state_now) / before - 1.0;
        println!("beta {tangential}: energy {drift:e}");
        assert!(drift.abs() < 1e-11, "{drift:e}");
        assert!((state_now.momentum(&scene) - momentum).norm() < 1e-10);
        assert!(engine.worst_overlap() < 1e-12);
        let exchanged = state_now.spin_energy(&scene) - state.spin_energy(&scene);
        assert_eq!(exchanged.abs() < 1e-9 * before, tangential < 0.0);
    }
}

/// Perfectly rough disks return to their start: velocities and spins are reversed after a time, and
/// run for an equal time.
#[test]
fn perfectly_rough_disks_return_to_their_start() {
    let scene = grains(1.0, 1.0, rough(1.0), down(0.0));
    let begin = start(&scene, 80.0, 2000, 2);
    let mut engine = engine(&scene, DissipationRule::Scene, begin.clone());
    engine
        .advance(f64::INFINITY, 2000, &mut ())
        .expect("collisions");
    let mut state = engine.state();
    for body in &mut state.bodies {
        body.velocity = -body.velocity;
        body.spin = -body.spin;
    }
    let mut back =
        EventDrivenEngine::<Disks>::new(scene, DissipationRule::Scene, state).expect("an engine");
    back.advance(2.0 * engine.time(), u64::MAX, &mut ())
        .expect("collisions");
    let end = back.state();
    for (one, other) in begin.bodies.iter().zip(&end.bodies) {
        // Tolerance: a collision or two a disk, each of which multiplies 1e-14 by less than a
        // hundred.
        assert!(begin.domain.distance(one.position, other.position) < 1e-9);
        assert!((one.spin + other.spin).norm() < 1e-9);
    }
}

/// Temperatures of translation and rotation by the theory of Huthmann & Zippelius, Phys. Rev. E 56,
/// R6275 (1997), with Maxwellian distributions: dT/dt = -G A T^(3/2) + G B T^(1/2) R and dR/dt = 2
/// G (B T^(3/2) - C T^(1/2) R), from (1, 1).
fn two_temperatures(restitution: f64, tangential: f64, rate: f64, until: f64) -> [f64; 2] {
    let q = 0.5;
    let eta = q * (1.0 + tangential) / (2.0 * (1.0 + q));
    let a = (1.0 - restitution * restitution) / 4.0 + 0.5 * eta * (1.0 - eta);
    let (b, c) = (eta * eta / (2.0 * q), eta / (2.0 * q) * (1.0 - eta / q));
    let slope = |[t, r]: [f64; 2]| {
        let root = t.sqrt();
        [
            rate * (b * root * r - a * t * root),
            2.0 * rate * (b * t * root - c * root * r),
        ]
    };
    let add = |x: [f64; 2], y: [f64; 2], h: f64| [x[0] + h * y[0], x[1] + h * y[1]];
    let mut now = [1.0, 1.0];
    let h = until / 1000.0;
    for _ in 0..1000 {
        let k1 = slope(now);
        let k2 = slope(add(now, k1, 0.5 * h));
        let k3 = slope(add(now, k2, 0.5 * h));
        let k4 = slope(add(now, k3, h));
        now = add(
            add(add(add(now, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0),
            k4,
            h / 6.0,
        );
    }
    now
}

/// Dilute rough disks cool as the two-temperature theory says, to 2 %: the theory knows neither the
/// fourth cumulant nor the correlation of spin and velocity, which together are worth a per cent.
/// The gas has a density of 1 %, and eight replicas with a standard error that must be below a per
/// cent.
#[test]
fn dilute_disks_cool_as_the_two_temperature_theory_says() {
    let (count, packing) = (4000, 0.01);
    let side = (count as f64 * PI / 4.0 / packing).sqrt();
    let density = packing * 4.0 / PI;
    let rate = 4.0 * PI.sqrt() * density * contact_value(packing);
    for (restitution, tangential) in [(0.9, 0.0), (0.9, 0.9), (0.9, -0.8), (0.6, 0.5), (1.0, 0.0)] {
        let scene = grains(1.0, restitution, rough(tangential), down(0.0));
        // Four collisions a disk at the temperature of the start.
        let until = 8.0 / rate;
        let replicas = 8;
        let mut found = [Vec::new(), Vec::new()];
        for replica in 0..replicas {
            let mut state = start(&scene, side, count, 10 + replica);
            let spinning = state.spin_temperature(&scene).sqrt();
            for body in &mut state.bodies {
                body.spin /= spinning;
            }
            let mut engine = engine(&scene, DissipationRule::Scene, state);
            assert!(
                engine
                    .advance(until, u64::MAX, &mut ())
                    .expect("collisions")
            );
            let state = engine.state();
            found[0].push(state.temperature(&scene));
            found[1].push(state.spin_temperature(&scene));
        }
        let theory = two_temperatures(restitution, tangential, rate, until);
        for (name, (values, theory)) in ["translation", "rotation"]
            .iter()
            .zip(found.iter().zip(theory))
        {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let (off, error) = (mean / theory - 1.0, (variance / n).sqrt() / theory);
            println!(
                "{restitution} {tangential} {name}: {mean:.4} {theory:.4} off by {off:.4} +- {error:.4}"
            );
            assert!(error < 0.01);
            assert!(off.abs() < 0.02 + 4.0 * error);
        }
    }
}

/// Elastic contacts are smooth too: neither energy is touched.
#[test]
fn equilibration_leaves_spins_alone() {
    let scene = grains(1.0, 0.5, rough(0.3), down(0.0));
    let state = start(&scene, 20.0, 200, 4);
    let mut engine = engine(&scene, DissipationRule::Elastic, state.clone());
    engine
        .advance(f64::INFINITY, 10_000, &mut ())
        .expect("collisions");
    let now = engine.state();
    assert!((now.kinetic_energy(&scene) / state.kinetic_energy(&scene) - 1.0).abs() < 1e-12);
    // Units are a power of two, so that spins come back bit by bit.
    for (one, other) in now.bodies.iter().zip(&state.bodies) {
        assert_eq!(one.spin, other.spin);
    }
}

/// A spin that is no number is refused, and smooth disks store none.
#[test]
fn spins_are_checked_and_smooth_disks_have_none() {
    let scene = grains(1.0, 0.5, rough(0.3), down(0.0));
    let mut state = start(&scene, 20.0, 20, 4);
    state.bodies[7].spin[0] = f64::NAN;
    let refused =
        EventDrivenEngine::<Disks>::new(scene.clone(), DissipationRule::Scene, state).err();
    let refused = refused.expect("a bad spin").to_string();
    assert!(refused.contains("disk 7"), "{refused}");
    let smooth = grains(1.0, 0.5, Smooth, down(0.0));
    let energy = Surface::<stosszahl_model::Plane>::spin_energy(&smooth.surface, 1.0, 0.5, ());
    assert_eq!(energy, 0.0);
    let state = gas(&smooth, &DiskBoundaries::periodic(), [20.0, 20.0], 20, 4);
    let plain =
        EventDrivenEngine::<_>::new(smooth, DissipationRule::Scene, state).expect("an engine");
    let state = start(&scene, 20.0, 20, 4);
    let spinning =
        EventDrivenEngine::<Disks>::new(scene, DissipationRule::Scene, state).expect("an engine");
    assert_eq!(spinning.memory_bytes() - plain.memory_bytes(), 20 * 8);
}
