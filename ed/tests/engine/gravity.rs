//! Disks under gravity: energy, profiles, and disks that come to rest.

use nalgebra::vector;
use stosszahl_ed::{
    DiskBoundaries, DissipationRule, EventDrivenEngine, EventDrivenError, Touchable,
};
use stosszahl_model::equation_of_state::contact_value;
use stosszahl_model::samples::grains;
use stosszahl_model::walls::{ObstacleShape, Wall};
use stosszahl_model::{Field, Gravity, ParticleModel, Plane, Smooth, State};

use crate::support::{alone, bounces, closed, down, gas, obstacle, rough, vibrates, walled};

/// Kinetic energy, including that of rotation, and potential energy in the field.
fn energy<P: ParticleModel<Space = Plane>>(scene: &P, state: &State<P>) -> f64 {
    let pull = scene.field().acceleration();
    let place: f64 = state
        .bodies
        .iter()
        .map(|body| -pull.dot(&body.position))
        .sum();
    state.kinetic_energy(scene) + state.spin_energy(scene) + place
}

/// Elastic disks, smooth and perfectly rough, between specular walls and around obstacles conserve
/// their energy after some hundred thousand collisions and more contacts with walls and obstacles,
/// and no disk is outside.
#[test]
fn energy_is_conserved_and_no_disk_gets_out() {
    let mut boundaries = closed();
    boundaries.obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![8.0, 4.0],
        radius: 1.0,
    }));
    boundaries.obstacles.push(obstacle(ObstacleShape::Polygon {
        points: vec![vector![15.0, 3.0], vector![19.0, 5.0], vector![17.0, 9.0]],
    }));
    for tilt in [0.0, 0.4] {
        let field = Gravity::new(vector![tilt, -0.5]).expect("a field");
        let smooth = energy_drift(&grains(1.0, 1.0, Smooth, field), &boundaries);
        let rough = energy_drift(&grains(1.0, 1.0, rough(1.0), field), &boundaries);
        println!("smooth {smooth:e}, rough {rough:e}");
        // A walk of a million steps of some 1e-16 each, over a hundred disks.
        assert!(smooth.abs() < 1e-12 && rough.abs() < 1e-12);
    }
}

fn energy_drift<P: ParticleModel<Space = Plane>>(scene: &P, boundaries: &DiskBoundaries) -> f64 {
    let state = gas(scene, boundaries, [24.0, 18.0], 120, 1);
    let before = energy(scene, &state);
    let mut engine =
        EventDrivenEngine::<P>::between(scene.clone(), DissipationRule::Scene, state, boundaries)
            .expect("an engine");
    for _ in 0..10 {
        engine
            .advance(f64::INFINITY, 30_000, &mut ())
            .expect("collisions");
        let worst = engine.worst_overlap();
        assert!(worst < 1e-12, "{worst:e}");
    }
    assert!(engine.tally().rebounds > 20_000);
    energy(scene, &engine.state()) / before - 1.0
}

/// One ball on a specular floor comes back to its height ten thousand times, each after 2 sqrt(2
/// h/g).
#[test]
fn a_bouncing_ball_keeps_its_height() {
    let boundaries = walled([None, Some([Wall::specular(); 2])]);
    let scene = grains(1.0, 1.0, Smooth, down(2.0));
    let state = alone(&boundaries, [5.0, 4.0], [1.0, 1.5], [0.3, 0.0]);
    let mut engine =
        EventDrivenEngine::<_>::between(scene, DissipationRule::Scene, state, &boundaries)
            .expect("an engine");
    let contacts = 10_000_u32;
    engine
        .advance(2.0 * f64::from(contacts), u64::MAX, &mut ())
        .expect("contacts");
    assert_eq!(engine.tally().rebounds, u64::from(contacts));
    let body = engine.state().bodies[0];
    // Times are rounded to 1e-12 at each of some ten fresh starts, and to 1e-16 at each contact.
    assert!(
        (body.position[1] - 1.5).abs() < 1e-9 && body.velocity[1].abs() < 1e-9,
        "{body:?}"
    );
    assert!(engine.worst_overlap() < 1e-12);
}

/// A ball at rest on the floor, one let fall, and one on top of a disk: with a contact time they
/// settle after finitely many contacts and stay; without one they are a collapse, which is
/// reported.
#[test]
fn a_ball_comes_to_rest() {
    let mut boundaries = walled([Some([Wall::specular(); 2]), Some([bounces(0.6, 0.5); 2])]);
    boundaries.obstacles.push(
        stosszahl_model::walls::Obstacle::new(
            ObstacleShape::Circle {
                centre: vector![7.0, 2.0],
                radius: 1.0,
            },
            bounces(0.6, 1.0).rebound,
        )
        .expect("a disk"),
    );
    let (weight, contact_time) = (1.5, 1e-3);
    let scene = grains(1.0, 0.6, Smooth, down(weight));
    for (at, rest, what) in [
        ([2.0, 0.5], 0.5, Touchable::Wall { axis: 1, side: 0 }),
        ([2.0, 3.0], 0.5, Touchable::Wall { axis: 1, side: 0 }),
        ([7.0, 3.5], 3.5, Touchable::Obstacle(0)),
        ([7.0, 4.2], 3.5, Touchable::Obstacle(0)),
    ] {
        let state = alone(&boundaries, [9.0, 9.0], at, [0.0, 0.0]);
        let new = |dissipation| {
            EventDrivenEngine::<_>::between(scene.clone(), dissipation, state.clone(), &boundaries)
                .expect("an engine")
        };
        let mut engine = new(DissipationRule::ContactTime(contact_time));
        let until = 20.0;
        assert!(engine.advance(until, u64::MAX, &mut ()).expect("rest"));
        let hops = engine.tally().rebounds as f64 * contact_time / until;
        println!("{at:?}: {hops:.2} contacts a contact time");
        assert!(hops < 2.1, "{hops}");
        let body = engine.state().bodies[0];
        // Height of hops that last less than a contact time.
        let height = weight * contact_time * contact_time / 8.0;
        assert!(body.position[1] - rest < 1.01 * height && body.position[1] - rest > -1e-15);
        assert!(engine.worst_overlap() < 1e-15);

        let error = new(DissipationRule::Scene).advance(until, u64::MAX, &mut ());
        let error = error.expect_err("an endless cascade");
        println!("{error}");
        let EventDrivenError::WallCollapse {
            disk: 0,
            what: found,
            time,
            ..
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!(found, what);
        // The geometric series of bounces: t = sqrt(2 h/g) (1 + e)/(1 - e).
        let fall = (2.0 * (at[1] - rest) / weight).sqrt();
        assert!((time - 4.0 * fall).abs() < 1e-6, "{time}");
    }
}

/// Disks poured into a box settle in a heap in the TC model: contacts are many, but finitely many,
/// the heat goes, and nothing overlaps.
#[test]
fn disks_settle_in_a_heap() {
    let boundaries = walled([Some([bounces(0.5, 1.0); 2]), Some([bounces(0.5, 1.0); 2])]);
    let scene = grains(1.0, 0.5, Smooth, down(1.0));
    let state = gas(&scene, &boundaries, [6.0, 20.0], 20, 3);
    let mut engine = EventDrivenEngine::<_>::between(
        scene.clone(),
        DissipationRule::ContactTime(1e-3),
        state,
        &boundaries,
    )
    .expect("an engine");
    let begin = energy(&scene, &engine.state());
    for _ in 0..20 {
        engine.advance(40.0, 100_000, &mut ()).expect("no collapse");
        assert!(
            engine.worst_overlap() < 1e-12,
            "{:e}",
            engine.worst_overlap()
        );
    }
    let state = engine.state();
    println!("at {}: {begin} to {}", state.time, energy(&scene, &state));
    assert!(state.temperature(&scene) < 1e-3);
    assert!(state.bodies.iter().all(|body| body.position[1] < 7.0));
    assert!(energy(&scene, &state) < 0.4 * begin);
}

/// A dense box on a floor that shakes it with several times its weight: no event is lost, and
/// nothing overlaps.
#[test]
fn a_vibrated_box_loses_no_event() {
    let floor = vibrates(bounces(0.9, 1.0), 0.5, 0.5);
    let boundaries = walled([
        Some([bounces(0.9, 1.0); 2]),
        Some([floor, bounces(0.9, 1.0)]),
    ]);
    for (count, side) in [(60, 10.0), (20, 6.0)] {
        let scene = grains(1.0, 0.9, Smooth, down(1.0));
        let state = gas(&scene, &boundaries, [side, 11.0], count, 4);
        let mut engine = EventDrivenEngine::<_>::between(
            scene,
            DissipationRule::ContactTime(1e-4),
            state,
            &boundaries,
        )
        .expect("an engine");
        for _ in 0..50 {
            engine
                .advance(engine.time() + 1.0, u64::MAX, &mut ())
                .expect("contacts");
            assert!(
                engine.worst_overlap() < 1e-9,
                "{:e}",
                engine.worst_overlap()
            );
        }
        assert!(engine.tally().rebounds > 500);
    }
}

/// Mean height of a gas above a floor, and mean of its square, for the hydrostatic profile
/// dp/dy = -n g with p = n T (1 + 2 phi chi).
fn hydrostatic(temperature: f64, weight: f64, column: f64, height: f64) -> [f64; 2] {
    let steps = 20_000;
    let h = height / f64::from(steps);
    let profile = |bottom: f64| {
        let (mut density, mut sums) = (bottom, [0.0; 3]);
        for step in 0..steps {
            let y = (f64::from(step) + 0.5) * h;
            let phi = density * std::f64::consts::FRAC_PI_4;
            // d(n Z)/dn, Z = 1 + 2 phi chi = (1 + phi^2/8)/(1 - phi)^2.
            let z = 1.0 + 2.0 * phi * contact_value(phi);
            let slope = phi / 4.0 / (1.0 - phi).powi(2) + 2.0 * z / (1.0 - phi);
            density -= h * density * weight / temperature / (z + phi * slope);
            sums[0] += density * h;
            sums[1] += density * y * h;
            sums[2] += density * y * y * h;
        }
        sums
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if profile(middle)[0] < column {
            low = middle;
        } else {
            high = middle;
        }
    }
    let sums = profile(low);
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// The profile of a dilute elastic gas under gravity. Twenty stretches of time give the standard
/// errors; z = 4.4, and a per mille for the layer at the floor, which the local density does not
/// know.
#[test]
fn a_dilute_gas_has_the_barometric_profile() {
    let boundaries = walled([None, Some([Wall::specular(); 2])]);
    let (width, height, count, weight) = (1500.0, 31.0, 150, 0.2);
    let scene = grains(1.0, 1.0, Smooth, down(weight));
    let state = gas(&scene, &boundaries, [width, height], count, 5);
    let mut engine =
        EventDrivenEngine::<_>::between(scene.clone(), DissipationRule::Scene, state, &boundaries)
            .expect("an engine");
    engine
        .advance(1500.0, u64::MAX, &mut ())
        .expect("collisions");
    let mut blocks: [Vec<f64>; 3] = Default::default();
    for _ in 0..20 {
        let mut sums = [0.0; 3];
        let samples = 200;
        for _ in 0..samples {
            engine
                .advance(engine.time() + 10.0, u64::MAX, &mut ())
                .expect("collisions");
            let state = engine.state();
            sums[0] += state.temperature(&scene);
            for body in &state.bodies {
                let above = body.position[1] - 0.5;
                sums[1] += above / f64::from(count as u32);
                sums[2] += above * above / f64::from(count as u32);
            }
        }
        for (block, sum) in blocks.iter_mut().zip(sums) {
            block.push(sum / f64::from(samples));
        }
    }
    let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let temperature = mean(&blocks[0]);
    let expected = hydrostatic(temperature, weight, count as f64 / width, height - 1.0);
    for (values, expected) in blocks[1..].iter().zip(expected) {
        let (n, mean) = (values.len() as f64, mean(values));
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let error = (variance / n).sqrt() / expected;
        let off = mean / expected - 1.0;
        println!("T = {temperature:.4}: {mean:.4} {expected:.4} off by {off:.4} +- {error:.4}");
        assert!(error < 0.01);
        assert!(off.abs() < 4.4 * error + 0.001);
    }
}
