//! Disks between walls: conservation, restarts, pressure, refusals, and hard cases.

use nalgebra::vector;
use stosszahl_ed::{
    DiskBoundaries, DissipationRule, EventDrivenCheckpoint, EventDrivenEngine, EventDrivenError,
    Touchable,
};
use stosszahl_model::equation_of_state::contact_value;
use stosszahl_model::samples::{EqualDisks, disks, grains};
use stosszahl_model::walls::{Face, ObstacleShape, Vibration, Wall, WallLedger, Walls};
use stosszahl_model::{Domain, ParticleModel, ParticleState, Plane, Rebound, State, samples};

use crate::support::{alone, bounces, closed, down, gas, obstacle, rough, vibrates, walled};

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Specular walls conserve the energy, and give the momentum that the disks have gained.
#[test]
fn a_closed_box_conserves_energy() {
    let boundaries = closed();
    for side in [40.0, 24.0] {
        let scene = disks(1.0);
        let state = gas(&scene, &boundaries, [side, side], 300, 1);
        let (energy, momentum) = (state.kinetic_energy(&scene), state.momentum(&scene));
        let mut engine = EventDrivenEngine::<_>::between(
            scene.clone(),
            DissipationRule::Scene,
            state,
            &boundaries,
        )
        .expect("an engine");
        engine
            .advance(f64::INFINITY, 300_000, &mut ())
            .expect("collisions");
        let state = engine.state();
        // A walk of 3e5 steps of some 1e-16 each, over hundreds of disks.
        assert!((state.kinetic_energy(&scene) / energy - 1.0).abs() < 1e-12);
        assert!(engine.worst_overlap() < 1e-12);
        let given = engine.ledgers().iter().map(|ledger| ledger.momentum);
        let given = given.fold(vector![0.0, 0.0], |sum, one| sum + one);
        // Sums of about 1e5 contacts of order 1 have rounding errors of 1e-11 each at the most.
        assert!((state.momentum(&scene) - momentum - given).norm() < 1e-8);
        assert!(
            engine
                .ledgers()
                .iter()
                .all(|ledger| ledger.energy.abs() < 1e-10)
        );
        assert!(engine.tally().rebounds > 10_000);
    }
}

/// The pressure on the walls of a slit, momentum over time and length, is that of the bulk, p = n T
/// (1 + 2 phi chi), with the density of its middle third, away from the layers at the walls. Time
/// is cut into twenty parts, whose scatter is the standard error, and the density has one too; z =
/// 4.4 and the 0.2 % by which Henderson's formula may be off.
#[test]
fn pressure_on_walls_is_that_of_the_bulk() {
    let boundaries = walled([None, Some([Wall::specular(); 2])]);
    for packing in [0.05, 0.3] {
        let (count, height) = (1200_usize, 36.0);
        let width = count as f64 * std::f64::consts::FRAC_PI_4 / packing / height;
        let scene = disks(1.0);
        let state = gas(&scene, &boundaries, [width, height], count, 2);
        let temperature = state.temperature(&scene);
        let mut engine =
            EventDrivenEngine::<_>::between(scene, DissipationRule::Scene, state, &boundaries)
                .expect("an engine");
        engine
            .advance(f64::INFINITY, 20_000, &mut ())
            .expect("collisions");
        let (mut pressures, mut densities) = (Vec::new(), Vec::new());
        let span = 150.0;
        for _ in 0..20 {
            let before: f64 = [2, 3]
                .map(|face: usize| engine.ledgers()[face].momentum[1].abs())
                .iter()
                .sum();
            let mut inside = 0;
            for _ in 0..20 {
                engine
                    .advance(engine.time() + span / 20.0, u64::MAX, &mut ())
                    .expect("collisions");
                let middle = |body: &&ParticleState<EqualDisks>| {
                    (body.position[1] / height - 0.5).abs() < 1.0 / 6.0
                };
                inside += engine.state().bodies.iter().filter(middle).count();
            }
            let after: f64 = [2, 3]
                .map(|face: usize| engine.ledgers()[face].momentum[1].abs())
                .iter()
                .sum();
            pressures.push((after - before) / (2.0 * width * span));
            densities.push(f64::from(inside as u32) / 20.0 / (width * height / 3.0));
        }
        let (pressure, pressure_error) = mean_and_error(&pressures);
        let (density, density_error) = mean_and_error(&densities);
        let phi = density * std::f64::consts::FRAC_PI_4;
        let expected = density * temperature * (1.0 + 2.0 * phi * contact_value(phi));
        // d ln p/d ln n = 1 + phi Z'/Z, below 3 here.
        let error = (pressure_error / expected).hypot(3.0 * density_error / density);
        let off = pressure / expected - 1.0;
        println!("packing {packing}, in the middle {phi:.4}: {off:.4} +- {error:.4}");
        assert!(error < 0.01);
        assert!(off.abs() < 4.4 * error + 0.002);
    }
}

/// Between diffuse walls at temperature 1 a gas that was at 3 ends at 1, also where the walls slide
/// with it.
#[test]
fn diffuse_walls_give_their_temperature() {
    let wall = Wall {
        sliding: vector![0.5, 0.0],
        ..Wall::still(Rebound::Diffuse { temperature: 1.0 })
    };
    let boundaries = walled([None, Some([wall; 2])]);
    let scene = grains(1.0, 1.0, rough(1.0), down(0.0));
    let mut state = gas(&scene, &boundaries, [30.0, 12.0], 100, 3);
    for body in &mut state.bodies {
        body.velocity *= 3.0_f64.sqrt();
    }
    let mut engine =
        EventDrivenEngine::<_>::between(scene.clone(), DissipationRule::Scene, state, &boundaries)
            .expect("an engine");
    engine
        .advance(300.0, u64::MAX, &mut ())
        .expect("collisions");
    let (mut hot, mut spinning, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    // The energy forgets within some ten units of time; parts of 200 are independent.
    for _ in 0..20 {
        let mut sums = [0.0; 3];
        for _ in 0..100 {
            engine
                .advance(engine.time() + 2.0, u64::MAX, &mut ())
                .expect("collisions");
            let mut state = engine.state();
            sums[2] += state.momentum(&scene)[0] / 100.0;
            for body in &mut state.bodies {
                body.velocity -= wall.sliding;
            }
            sums[0] += state.temperature(&scene);
            sums[1] += state.spin_temperature(&scene);
        }
        hot.push(sums[0] / 100.0);
        spinning.push(sums[1] / 100.0);
        speeds.push(sums[2] / 100.0);
    }
    for (name, values, expected) in [
        ("T", hot, 1.0),
        ("R", spinning, 1.0),
        ("speed", speeds, 0.5),
    ] {
        let (mean, error) = mean_and_error(&values);
        println!("{name}: {mean:.4} +- {error:.4}");
        assert!(error < 0.01);
        assert!((mean - expected).abs() < 4.4 * error);
    }
}

/// In a long leg the engine makes fresh starts by itself: to the bits, such a start is a checkpoint
/// made by the caller, which a file may hold. The case has all that has a memory: contact times,
/// spins, windings, ledgers, random numbers, vibrations.
#[test]
fn starting_afresh_is_a_cut() {
    let diffuse = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let mut boundaries = walled([None, Some([vibrates(bounces(0.9, 0.5), 0.3, 0.7), diffuse])]);
    boundaries.obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![1.0, 5.0],
        radius: 0.8,
    }));
    let scene = grains(1.0, 0.9, rough(0.4), down(0.3));
    let (count, collisions) = (40, 130_000);
    let mut start = EventDrivenCheckpoint::from(gas(&scene, &boundaries, [12.0, 9.0], count, 4));
    start.state.time = 1e3;
    start.image_flags = vec![[0; 2]; count];
    let new = |checkpoint| {
        EventDrivenEngine::<_>::between(
            scene.clone(),
            DissipationRule::ContactTime(1e-3),
            checkpoint,
            &boundaries,
        )
        .expect("an engine")
    };
    let mut whole = new(start.clone());
    whole
        .advance(f64::INFINITY, collisions, &mut ())
        .expect("collisions");
    let whole = whole.checkpoint();
    let mut engine = new(start.clone());
    let mut before = engine.tally();
    let cut = loop {
        assert!(before.collisions < collisions, "no fresh start");
        engine
            .advance(f64::INFINITY, 1, &mut ())
            .expect("a collision");
        let now = engine.tally();
        let events = now.collisions + now.crossings + now.rebounds;
        let events = events - before.collisions - before.crossings - before.rebounds;
        if now.pushes - before.pushes > 3 * events + count as u64 / 2 {
            break before.collisions;
        }
        before = now;
    };
    let mut first = new(start);
    first
        .advance(f64::INFINITY, cut, &mut ())
        .expect("collisions");
    let mut second = new(first.checkpoint());
    second
        .advance(f64::INFINITY, collisions - cut, &mut ())
        .expect("collisions");
    let second = second.checkpoint();
    assert_eq!(second.state.bodies, whole.state.bodies);
    assert_eq!(second.state.time, whole.state.time);
    assert_eq!(second.image_flags, whole.image_flags);
    assert_eq!(second.last_contact, whole.last_contact);
    assert_eq!(second.ledgers, whole.ledgers);
    assert_eq!(second.tally, whole.tally);
    assert!(
        whole
            .ledgers
            .iter()
            .enumerate()
            .all(|(ledger, b)| (b.contacts > 1000.0) == (ledger > 1))
    );
}

fn refused<P: ParticleModel<Space = Plane>>(
    scene: P,
    state: State<P>,
    boundaries: &DiskBoundaries,
) -> EventDrivenError {
    match EventDrivenEngine::<P>::between(scene, DissipationRule::Scene, state, boundaries) {
        Ok(_) => panic!("not refused"),
        Err(error) => error,
    }
}

#[test]
fn what_does_not_fit_is_refused_and_named() {
    let boundaries = closed();
    let lengths = [6.0, 5.0];
    let state = |at: [f64; 2]| alone(&boundaries, lengths, at, [0.0, 0.0]);
    let scene = || disks(1.0);
    // States inside the wall by 0.1, and outside the box.
    let error = refused(scene(), state([5.6, 2.0]), &boundaries);
    let EventDrivenError::Overlap {
        disk: 0,
        what,
        depth,
        ..
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(what, Touchable::Wall { axis: 0, side: 1 });
    assert!((depth - 0.1).abs() < 1e-12);
    let error = refused(scene(), state([3.0, -2.0]), &boundaries);
    assert!(
        error
            .to_string()
            .contains("the wall of axis 1, side 0 by 2.5"),
        "{error}"
    );
    // A wall that is away from its face when the disk starts.
    let floor = vibrates(Wall::specular(), 1.0, 2.0);
    let moving = walled([None, Some([floor, Wall::specular()])]);
    let mut late = alone(&moving, lengths, [3.0, 1.3], [0.0, 0.0]);
    assert!(
        EventDrivenEngine::<_>::between(scene(), DissipationRule::Scene, late.clone(), &moving)
            .is_ok()
    );
    late.time = 1.0;
    let error = refused(scene(), late, &moving);
    assert!(
        error
            .to_string()
            .contains("overlaps the wall of axis 1, side 0"),
        "{error}"
    );
}

/// Refuses an obstacle, another box, a wall too near to its opposite, and an open face.
#[test]
fn boundaries_that_do_not_fit_are_refused() {
    let boundaries = closed();
    let lengths = [6.0, 5.0];
    let state = |at: [f64; 2]| alone(&boundaries, lengths, at, [0.0, 0.0]);
    let scene = || disks(1.0);
    let mut with = closed();
    with.obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![1.0, 1.0],
        radius: 0.5,
    }));
    with.obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![4.0, 3.0],
        radius: 0.5,
    }));
    let error = refused(scene(), state([3.5, 2.5]), &with);
    assert!(
        matches!(
            error,
            EventDrivenError::Overlap {
                disk: 0,
                what: Touchable::Obstacle(1),
                ..
            }
        ),
        "{error}"
    );
    with.obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![4.0, 3.0],
        radius: 2.5,
    }));
    let error = refused(scene(), state([3.0, 2.5]), &with);
    assert!(
        matches!(error, EventDrivenError::BadObstacle { obstacle: 2, .. }),
        "{error}"
    );
    let error = refused(scene(), state([3.0, 2.5]), &DiskBoundaries::periodic());
    assert!(
        matches!(
            error,
            EventDrivenError::UnlikeBox {
                axis: 0,
                state: false
            }
        ),
        "{error}"
    );
    let floor = vibrates(Wall::specular(), 1.0, 2.0);
    let tight = walled([None, Some([floor, floor])]);
    let error = refused(
        scene(),
        alone(&tight, [6.0, 2.9], [3.0, 1.4], [0.0; 2]),
        &tight,
    );
    assert!(
        matches!(error, EventDrivenError::NoRoom { axis: 1, .. }),
        "{error}"
    );
    let open = DiskBoundaries {
        walls: Walls::new(&[[Face::Wall(Wall::specular()), Face::Open]]).expect("faces"),
        ..DiskBoundaries::periodic()
    };
    let error = refused(scene(), alone(&open, lengths, [3.0, 2.5], [0.0; 2]), &open);
    assert!(
        matches!(error, EventDrivenError::OpenFace { axis: 0, side: 1 }),
        "{error}"
    );
    // A checkpoint with other walls.
    let mut checkpoint = EventDrivenCheckpoint::from(state([3.0, 2.5]));
    checkpoint.ledgers = vec![WallLedger::default(); 3];
    let error =
        EventDrivenEngine::<_>::between(scene(), DissipationRule::Scene, checkpoint, &boundaries)
            .err();
    assert!(matches!(
        error,
        Some(EventDrivenError::WrongLedgers {
            found: 3,
            expected: 4
        })
    ));
}

/// A disk that comes to a wall at 1e-12 of its speed, and one that flies along it at its distance:
/// reflected or left alone.
#[test]
fn grazing_a_wall() {
    let boundaries = walled([None, Some([Wall::specular(); 2])]);
    for (height, speed) in [
        (0.5 + 1e-12, -1e-12),
        (0.5, 0.0),
        (0.5, -1e-12),
        (0.5, 1e-12),
        (4.5, 1e-300),
    ] {
        let state = alone(&boundaries, [6.0, 5.0], [3.0, height], [1.0, speed]);
        let mut engine =
            EventDrivenEngine::<_>::between(disks(1.0), DissipationRule::Scene, state, &boundaries)
                .expect("an engine");
        assert!(engine.advance(100.0, u64::MAX, &mut ()).expect("flight"));
        let body = engine.state().bodies[0];
        assert_eq!(body.velocity[0], 1.0);
        assert_eq!(
            body.velocity[1],
            if height > 4.0 { -speed } else { speed.abs() }
        );
        let away = (body.position[1] - 0.5).min(4.5 - body.position[1]);
        assert!(away > -1e-15, "{away:e}");
        let hit = speed < 0.0 || height > 4.0;
        assert_eq!(engine.tally().rebounds, u64::from(hit), "{height} {speed}");
    }
}

/// A disk flies into a wedge of one degree between a wall and a plate, and out again. It has at
/// most as many contacts as the angle fits into two right angles, keeps its energy, and is never
/// inside a wall.
#[test]
fn a_disk_leaves_a_wedge_of_one_degree() {
    let angle = 1.0_f64.to_radians();
    let mut boundaries = closed();
    boundaries.obstacles.push(obstacle(ObstacleShape::Segment {
        ends: [
            vector![0.0, 0.0],
            vector![99.0 * angle.cos(), 99.0 * angle.sin()],
        ],
    }));
    for steepness in [0.0, 0.003, 0.3] {
        let state = alone(&boundaries, [100.0, 10.0], [95.0, 0.6], [-1.0, -steepness]);
        let mut engine =
            EventDrivenEngine::<_>::between(disks(1.0), DissipationRule::Scene, state, &boundaries)
                .expect("an engine");
        let mut nearest = f64::INFINITY;
        for _ in 0..60 {
            engine
                .advance(engine.time() + 1.0, u64::MAX, &mut ())
                .expect("contacts");
            assert!(engine.worst_overlap() < 1e-13);
            nearest = nearest.min(engine.state().bodies[0].position[0]);
        }
        let body = engine.state().bodies[0];
        let energy = body.velocity.norm_squared() / (1.0 + steepness * steepness) - 1.0;
        assert!(energy.abs() < 1e-13);
        let contacts = engine.tally().rebounds;
        println!("steepness {steepness}: {contacts} contacts, nearest {nearest}");
        assert!((50..=181).contains(&contacts), "{contacts}");
        // The disk touches both sides where the wedge is one diameter wide.
        assert!(nearest > 0.5 / (0.5 * angle).tan() - 1e-9);
        assert!(body.velocity[0] > 0.0);
    }
}

/// No disk stays in a floor that moves ten times as fast as the disks, nor in one that moves away
/// from them.
#[test]
fn a_floor_may_be_faster_than_the_disks() {
    for (amplitude, period) in [(0.5, 0.1), (1.0, 0.2), (0.01, 0.002)] {
        let floor = vibrates(bounces(0.7, 1.0), amplitude, period);
        let boundaries = walled([None, Some([floor, bounces(0.7, 1.0)])]);
        let scene = disks(0.8);
        let mut state = gas(&scene, &boundaries, [12.0, 7.0], 30, 6);
        for body in &mut state.bodies {
            body.velocity *= 0.1;
        }
        let mut engine = EventDrivenEngine::<_>::between(
            scene,
            DissipationRule::ContactTime(1e-6),
            state,
            &boundaries,
        )
        .expect("an engine");
        for _ in 0..50 {
            engine
                .advance(engine.time() + 0.37, u64::MAX, &mut ())
                .expect("contacts");
            assert!(
                engine.worst_overlap() < 1e-11,
                "{:e}",
                engine.worst_overlap()
            );
        }
        assert!(engine.tally().rebounds > 50);
        // The moving floor has added energy.
        assert!(engine.ledgers()[2].energy > 0.0);
    }
}

/// A vibrating wall far from time zero is where its period says.
#[test]
fn vibrations_keep_their_phase() {
    let vibration = Vibration::new(0.5, 2.0).expect("a vibration");
    let floor = vibrates(Wall::specular(), 0.5, 2.0);
    let boundaries = walled([None, Some([floor, Wall::specular()])]);
    for begin in [0.0, 1e6, 12_345.5] {
        let mut state = alone(&boundaries, [3.0, 9.0], [1.0, 3.0], [0.0, -1.0]);
        state.time = begin;
        let mut engine =
            EventDrivenEngine::<_>::between(disks(1.0), DissipationRule::Scene, state, &boundaries)
                .expect("an engine");
        engine
            .advance(begin + 4.0, u64::MAX, &mut ())
            .expect("a contact");
        let phase = begin.rem_euclid(2.0);
        // The floor is at d and moves at +-1/2 when the disk, after 2.5 - d, gets there.
        let contact = (0..4000)
            .map(|step| 0.001 * f64::from(step))
            .find(|t| 2.5 - t <= vibration.displacement(phase + t))
            .expect("they meet");
        let speed = 1.0 + 2.0 * vibration.velocity(phase + contact);
        assert_eq!(engine.state().bodies[0].velocity[1], speed, "{begin}");
    }
}

/// Disks in a row against a wall, with a restitution below that of collapse: an error that names
/// what happened, and none in the TC model.
#[test]
fn collapse_against_a_wall_is_told() {
    let boundaries = walled([Some([bounces(0.1, 1.0); 2]), None]);
    let scene = disks(0.1);
    let domain = boundaries.walls.domain(vector![20.0, 4.0]).expect("a box");
    let body = |disk: f64| (vector![1.0 + 1.5 * disk, 2.0], vector![-disk, 0.0]);
    let state = samples::state(domain, [0.0, 1.0, 2.0, 3.0].map(body));
    let new = |dissipation| {
        EventDrivenEngine::<_>::between(scene.clone(), dissipation, state.clone(), &boundaries)
            .expect("an engine")
    };
    let error = new(DissipationRule::Scene)
        .advance(1e3, u64::MAX, &mut ())
        .expect_err("a collapse");
    println!("{error}");
    assert!(error.to_string().contains("inelastic collapse"), "{error}");
    let mut engine = new(DissipationRule::ContactTime(1e-3));
    assert!(
        engine
            .advance(1e3, 1_000_000, &mut ())
            .expect("no collapse")
    );
    assert!(engine.worst_overlap() < 1e-12);
}

/// Work for disks far from any wall: none. The box has more cells inside than at its walls, and
/// predictions, crossings and pushes a collision are those of a periodic gas to a few per cent.
#[test]
fn walls_cost_only_those_who_are_near() {
    let boundaries = closed();
    let scene = disks(1.0);
    let side = 100.0;
    let walled = gas(&scene, &boundaries, [side, side], 3000, 7);
    let mut around = walled.clone();
    around.domain = Domain::periodic(vector![side, side]).expect("a box");
    let run = |state, boundaries: &DiskBoundaries| {
        let mut engine = EventDrivenEngine::<_>::between(
            scene.clone(),
            DissipationRule::Scene,
            state,
            boundaries,
        )
        .expect("an engine");
        engine
            .advance(f64::INFINITY, 30_000, &mut ())
            .expect("collisions");
        engine.tally()
    };
    let (walled, periodic) = (
        run(walled, &boundaries),
        run(around, &DiskBoundaries::periodic()),
    );
    assert_eq!(periodic.rebounds, 0);
    for (one, other) in [
        (walled.predictions, periodic.predictions),
        (walled.crossings, periodic.crossings),
        (walled.pushes, periodic.pushes),
    ] {
        let ratio = one as f64 / other as f64;
        assert!((0.9..1.1).contains(&ratio), "{walled:?} {periodic:?}");
    }
}
