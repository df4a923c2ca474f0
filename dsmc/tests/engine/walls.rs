//! Walls around the gas: conservation, exchange of momentum and energy, and hard cases.

use nalgebra::{Vector2, vector};
use stosszahl_analysis::statistics::Estimate;
use stosszahl_dsmc::{
    BoundaryConditions, DsmcEngine, DsmcError, Neighbourhood, Parameters, PartnerDisplacement,
    Scheme, SimulatorWeights, Tracked, WallClearance,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{FallingDisks, FallingParticles, grains, ideal_gas, no_gravity};
use stosszahl_model::walls::Vibration;
use stosszahl_model::{
    Domain, Face, Gravity, ParticleState, Plane, Rebound, Rough, Smooth, Space, State, Wall, Walls,
    samples,
};

use crate::support::{PARAMETERS, disk_for_unit_path};

fn between(faces: [[Face<Plane>; 2]; 2]) -> BoundaryConditions<Plane> {
    BoundaryConditions {
        walls: Walls::new(&faces).expect("fit"),
        ..BoundaryConditions::default()
    }
}

fn boxed(wall: Wall<Plane>) -> BoundaryConditions<Plane> {
    between([[Face::Wall(wall); 2]; 2])
}

fn domain(boundaries: &BoundaryConditions<Plane>, sides: [f64; 2]) -> Domain<Plane> {
    boundaries.walls.domain(sides.into()).expect("a box")
}

/// Engine with one disk in a box.
fn alone(
    boundaries: &BoundaryConditions<Plane>,
    field: Gravity<Plane>,
    position: Vector2<f64>,
    velocity: Vector2<f64>,
) -> DsmcEngine<FallingDisks> {
    let state = samples::state(domain(boundaries, [10.0, 10.0]), [(position, velocity)]);
    let scene = grains(1.0, 1.0, Smooth, field);
    DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
        .between(boundaries)
        .start(&state)
        .expect("an engine")
}

/// Elastic disks that all fly along the first axis, in a specular box: energy equilibrates between
/// both axes and is conserved, and the density becomes uniform. Errors: 1e-10 for the energy; z =
/// 4.4 for fractions of energy and of particles.
#[test]
fn a_specular_box_is_an_equilibrium() {
    let count = 20_000;
    let boundaries = boxed(Wall::specular());
    let scene = grains(disk_for_unit_path(50.0), 1.0, Smooth, no_gravity());
    let domain = domain(&boundaries, [20.0, 20.0]);
    let mut state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, count, 1.0, 1);
    for body in &mut state.bodies {
        body.velocity = vector![body.velocity.norm().copysign(body.velocity[0]), 0.0];
        body.position[0] *= 0.5;
    }
    let mut engine = DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    let _: &DsmcEngine<FallingDisks> = &engine;
    engine.advance(100.0, u64::MAX, &mut ());
    let end = engine.state();
    assert_eq!(end.bodies.len(), count);
    let energy = end.kinetic_energy(&scene);
    assert!((energy / state.kinetic_energy(&scene) - 1.0).abs() < 1e-10);
    let n = count as f64;
    let squares = end.bodies.iter().map(|body| body.velocity.map(|v| v * v));
    let sum: Vector2<f64> = squares.sum();
    let (temperature, difference) = (energy / n, (sum[0] - sum[1]) / n);
    // The difference of two squares of Gaussians has the variance 4 T^2.
    assert!(difference.abs() < 4.4 * 2.0 * temperature / n.sqrt());
    let mut quarters = [0.0; 4];
    for body in &end.bodies {
        quarters[(body.position[0] / 5.0) as usize] += 1.0;
    }
    for quarter in quarters {
        assert!(
            (quarter - n / 4.0).abs() < 4.4 * (n * 3.0 / 16.0).sqrt(),
            "{quarters:?}"
        );
    }
    let given = engine.ledgers().walls[0][0];
    assert!(given.contacts > 1000.0 && given.momentum[0] > 0.0 && given.momentum[1] == 0.0);
    assert!(given.energy.abs() < 1e-10 * energy);
}

/// Elastic disks at half the temperature of diffuse sliding walls take on the temperature and
/// velocity of the walls, each to 1 % of the temperature and of the thermal speed. Ten samples,
/// some relaxation times apart, of 20 000 disks have standard errors of 0.2 %.
#[test]
fn diffuse_walls_give_their_temperature_and_velocity() {
    let count = 20_000;
    let mut wall = Wall::<Plane>::still(Rebound::Diffuse { temperature: 2.0 });
    wall.sliding = vector![0.5, 0.0];
    let boundaries = between([[Face::Periodic; 2], [Face::Wall(wall); 2]]);
    let scene = grains(disk_for_unit_path(200.0), 1.0, Smooth, no_gravity());
    let domain = domain(&boundaries, [20.0, 5.0]);
    let state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, count, 1.0, 2);
    let mut engine = DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    let _: &DsmcEngine<FallingDisks> = &engine;
    let (mut drift, mut temperature, mut at_walls) = (0.0, 0.0, [0.0; 2]);
    for sample in 0..10 {
        engine.advance(100.0 + 10.0 * f64::from(sample), u64::MAX, &mut ());
        let end = engine.state();
        let mean = end.momentum(&scene) / count as f64;
        let heat = end.temperature(&scene) - 0.5 * mean.norm_squared();
        drift += mean[0] / 10.0;
        temperature += heat / 10.0;
        // Slip of the gas next to the lower wall.
        let near = end.bodies.iter().filter(|body| body.position[1] < 0.5);
        for body in near {
            at_walls[0] += body.velocity[0];
            at_walls[1] += 1.0;
        }
    }
    let thermal = 2.0_f64.sqrt();
    assert!((temperature / 2.0 - 1.0).abs() < 0.01, "{temperature}");
    assert!((drift - 0.5).abs() < 0.01 * thermal, "{drift}");
    let slip = at_walls[0] / at_walls[1] - 0.5;
    assert!(slip.abs() < 0.01 * thermal, "{slip}");
}

/// Ledgers of vibrating, sliding, rough and diffuse walls and of gravity account for the momentum
/// and energy of spinning particles: to a random walk of some 1e5 roundings of the exchanged
/// amounts.
#[test]
fn ledgers_close() {
    let count = 2000;
    let mut floor = Wall::<Plane>::still(Rebound::Restitutive {
        restitution: 0.9,
        slip: -0.5,
    });
    floor.vibration = Vibration::new(0.4, 1.3).ok();
    let mut side = Wall::still(Rebound::Restitutive {
        restitution: 0.7,
        slip: 0.3,
    });
    side.sliding = vector![0.0, 0.4];
    let top = Wall::still(Rebound::Diffuse { temperature: 1.5 });
    let boundaries = BoundaryConditions {
        clearance: WallClearance::Radius,
        ..between([[Face::Wall(side); 2], [Face::Wall(floor), Face::Wall(top)]])
    };
    let surface = Rough::new(1.0, Plane::INERTIA).expect("a surface");
    let field = Gravity::new(vector![0.1, -0.5]).expect("finite");
    let scene = grains(0.1, 1.0, surface, field);
    let domain = domain(&boundaries, [10.0, 8.0]);
    let state = ideal_gas(&scene, domain, 0.5, count, 1.0, 3);
    let streams = Streams::new(1, 0);
    let mut engine: DsmcEngine<_, Tracked> = DsmcEngine::setup(&scene, PARAMETERS, streams)
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    engine.advance(20.0, u64::MAX, &mut ());
    let end = engine.state();
    let (mass, momentum, energy) = engine.ledgers().total();
    assert_eq!(mass, 0.0);
    let weight = vector![0.1, -0.5] * (20.0 * count as f64);
    let change = end.momentum(&scene) - state.momentum(&scene);
    assert!(
        (change - weight - momentum).norm() < 1e-8,
        "{change} {weight} {momentum}"
    );
    let total = |state: &State<_>| {
        let fallen = |body: &ParticleState<FallingParticles<Plane, Rough>>| {
            0.1 * body.position[0] - 0.5 * body.position[1]
        };
        let potential = -state.bodies.iter().map(fallen).sum::<f64>();
        state.kinetic_energy(&scene) + state.spin_energy(&scene) + potential
    };
    let change = total(&end) - total(&state);
    assert!((change - energy).abs() < 1e-8, "{change} {energy}");
    let given = &engine.ledgers().walls;
    let contacts = given.iter().take(2).flatten().map(|ledger| ledger.contacts);
    assert!(contacts.clone().all(|number| number > 200.0), "{given:?}");
    for body in &end.bodies {
        let [x, y] = [body.position[0], body.position[1]];
        assert!((0.05..=9.95).contains(&x) && (0.05..=7.95).contains(&y));
    }
}

/// The collision rate follows the density in the free volume, for centres that stay half a diameter
/// from the walls or for a wall displaced inwards: z = 4.4 of the Poisson error, below 1.5 %.
#[test]
fn density_is_that_of_the_room() {
    let count = 4000;
    let mut slow = Wall::<Plane>::specular();
    slow.vibration = Vibration::new(3.0, 1e9).ok();
    for (clearance, wall, insets) in [
        (WallClearance::Centre, Wall::specular(), [0.0, 0.0]),
        (WallClearance::Radius, Wall::specular(), [0.5, 0.5]),
        (WallClearance::Centre, slow, [1.5, 0.0]),
    ] {
        let still = Face::Wall(Wall::specular());
        let boundaries = BoundaryConditions {
            clearance,
            ..between([[still; 2], [Face::Wall(wall), still]])
        };
        let scene = grains(1.0, 1.0, Smooth, no_gravity());
        let domain = domain(&boundaries, [10.0, 10.0]);
        let aside = insets[1];
        let mut state = ideal_gas::<FallingDisks>(&scene, domain, aside, count, 1.0, 5);
        // A quarter of a period: half of the amplitude.
        state.time = 2.5e8;
        let height = 10.0 - insets[0] - insets[1];
        for body in &mut state.bodies {
            let share = (body.position[1] - aside) / (10.0 - 2.0 * aside);
            body.position[1] = insets[0] + height * share;
        }
        let parameters = Parameters {
            cell_size: Some(2.0),
            ..PARAMETERS
        };
        let mut engine = DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
        let _: &DsmcEngine<FallingDisks> = &engine;
        engine.advance(state.time + 1.0, u64::MAX, &mut ());
        let packing = count as f64 * Plane::particle_volume(0.5) / ((10.0 - 2.0 * aside) * height);
        let pairs = 0.5 * (count - 1) as f64 * Plane::collision_rate(packing, 1.0);
        let found = engine.tally().collisions as f64;
        assert!(
            (found - pairs).abs() < 4.4 * pairs.sqrt() + 2.0,
            "{found} {pairs}"
        );
        assert!(4.4 / pairs.sqrt() < 0.015);
    }
}

/// Coordinate that moves to and fro between 0 and `length`, reflected at both.
fn folded(x: f64, length: f64) -> f64 {
    let along = x.rem_euclid(2.0 * length);
    along.min(2.0 * length - along)
}

/// Free flight in a specular box for thousands of contacts against its mirror images, in short
/// steps and in steps that cross the box, with tiles of one cell and with one tile: at most 1e5
/// roundings of the box.
#[test]
fn flight_between_walls_is_that_of_mirror_images() {
    let boundaries = boxed(Wall::specular());
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    let domain = domain(&boundaries, [10.0, 10.0]);
    let state = ideal_gas(&scene, domain, 0.0, 300, 1.0, 6);
    let parameters = Parameters {
        scheme: Scheme::Collisionless,
        ..PARAMETERS
    };
    for (step, per_tile) in [(0.25, 1), (0.25, 100_000), (30.0, 30)] {
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.retile(per_tile);
        engine.hold_step(step);
        engine.advance(300.0, u64::MAX, &mut ());
        let mut expected: Vec<Vector2<f64>> = (state.bodies.iter())
            .map(|body| (body.position + body.velocity * 300.0).map(|x| folded(x, 10.0)))
            .collect();
        let end = engine.state();
        let mut found: Vec<_> = end.bodies.iter().map(|body| body.position).collect();
        let order = |a: &Vector2<f64>, b: &Vector2<f64>| a[0].total_cmp(&b[0]);
        expected.sort_by(order);
        found.sort_by(order);
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).norm() < 1e-10,
                "{step}: {found} {expected}"
            );
        }
    }
}

/// Free flight under gravity: each disk bounces on the floor with its own period 2 sqrt(v^2 + 2 g
/// h)/g.
#[test]
fn bouncing_is_periodic() {
    let boundaries = between([[Face::Periodic; 2], [Face::Wall(Wall::specular()); 2]]);
    let pull = 2.0;
    let field = Gravity::<Plane>::new(vector![0.0, -pull]).expect("finite");
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, field);
    let domain = domain(&boundaries, [10.0, 10.0]);
    let mut state = ideal_gas(&scene, domain, 0.0, 300, 1.0, 6);
    for body in &mut state.bodies {
        body.position[1] *= 0.3;
    }
    let parameters = Parameters {
        scheme: Scheme::Collisionless,
        ..PARAMETERS
    };
    for (step, per_tile) in [(0.0625, 1), (0.25, 30), (20.0, 100_000)] {
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.retile(per_tile);
        engine.hold_step(step);
        engine.advance(100.0, u64::MAX, &mut ());
        let mut expected: Vec<f64> = (state.bodies.iter())
            .map(|body| {
                let (height, velocity) = (body.position[1], body.velocity[1]);
                let fastest = (velocity * velocity + 2.0 * pull * height).sqrt();
                // Time since it left the floor.
                let since = (fastest - velocity) / pull + 100.0;
                let since = since.rem_euclid(2.0 * fastest / pull);
                fastest * since - 0.5 * pull * since * since
            })
            .collect();
        let end = engine.state();
        let mut found: Vec<f64> = end.bodies.iter().map(|body| body.position[1]).collect();
        expected.sort_by(f64::total_cmp);
        found.sort_by(f64::total_cmp);
        // Each of some hundred bounces is off by some roundings, times speed and number of later
        // bounces.
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-9,
                "{step}: {found} {expected}"
            );
        }
    }
}

/// A corner reverses the velocity of a disk exactly, also along the diagonal.
#[test]
fn a_corner_turns_around() {
    let boundaries = boxed(Wall::specular());
    for (position, velocity) in [
        (vector![1.0, 1.0], vector![-2.0, -2.0]),
        (vector![9.0, 9.5], vector![1.0, 0.5]),
        (vector![0.25, 9.75], vector![-0.125, 0.125]),
    ] {
        let mut engine = alone(&boundaries, no_gravity(), position, velocity);
        engine.hold_step(1.0);
        engine.advance(4.0, u64::MAX, &mut ());
        let body = engine.state().bodies[0];
        assert_eq!(body.velocity, -velocity);
        let folded = position.zip_map(&velocity, |x, v| {
            let y = x + 4.0 * v;
            if y < 0.0 {
                -y
            } else if y > 10.0 {
                20.0 - y
            } else {
                y
            }
        });
        assert!((body.position - folded).norm() < 1e-14);
    }
}

/// A disk that grazes a wall at 1e-12 in speed and height touches it in time, and stays inside.
#[test]
fn grazing_disks_touch_and_stay_inside() {
    let boundaries = boxed(Wall::specular());
    for speed in [1e-12, 1e-15, 1e-300] {
        let mut engine = alone(
            &boundaries,
            no_gravity(),
            vector![5.0, 1e-12],
            vector![0.1, -speed],
        );
        engine.hold_step(0.25);
        engine.advance(3.0, u64::MAX, &mut ());
        let body = engine.state().bodies[0];
        let touched = speed == 1e-12;
        assert_eq!(engine.ledgers().walls[1][0].contacts, f64::from(touched));
        assert_eq!(body.velocity[1], if touched { speed } else { -speed });
        assert!((body.position[1] - 1e-12).abs() < 3.0 * speed + 1e-15 && body.position[1] >= 0.0);
    }
    // On the wall itself, along it, and on the opposite one.
    for y in [0.0, 10.0] {
        let mut engine = alone(
            &boundaries,
            no_gravity(),
            vector![5.0, y],
            vector![0.1, 0.0],
        );
        engine.advance(10.0, u64::MAX, &mut ());
        let body = engine.state().bodies[0];
        assert!((body.position[1] - y).abs() < 1e-14);
        assert_eq!(body.velocity, vector![0.1, 0.0]);
    }
}

/// A wall much faster than the disks throws all of them, and leaves none behind.
#[test]
fn a_wall_faster_than_the_grains_leaves_none_behind() {
    let mut wall = Wall::<Plane>::specular();
    wall.vibration = Vibration::new(2.0, 0.2).ok();
    let boundaries = between([
        [Face::Periodic; 2],
        [Face::Wall(wall), Face::Wall(Wall::specular())],
    ]);
    let scene = grains(0.1, 0.9, Smooth, no_gravity());
    let domain = domain(&boundaries, [10.0, 10.0]);
    let state = ideal_gas::<FallingDisks>(&scene, domain, 2.5, 500, 1e-2, 3);
    let mut engine = DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    let _: &DsmcEngine<FallingDisks> = &engine;
    for sample in 1..=50 {
        let time = 0.37 * f64::from(sample);
        engine.advance(time, u64::MAX, &mut ());
        let height = wall.displacement(time);
        let state = engine.state();
        let lowest = state
            .bodies
            .iter()
            .map(|body| body.position[1])
            .fold(10.0, f64::min);
        assert!(lowest >= height - 1e-9, "{time}: {lowest} {height}");
    }
    let end = engine.state();
    // Thrown at twice the wall's speed of 20; their collisions dissipate most of it.
    assert!(end.temperature(&scene) > 1.0, "{}", end.temperature(&scene));
    assert_eq!(engine.ledgers().settled_particles, 0);
}

/// A particle that falls onto a floor of restitution 0.5 comes to rest there after infinitely many
/// contacts in finite time: the contacts end, are counted, and the floor carries its weight.
#[test]
fn a_grain_comes_to_rest_on_the_floor() {
    let floor = Wall::still(Rebound::Restitutive {
        restitution: 0.5,
        slip: 1.0,
    });
    for clearance in [WallClearance::Centre, WallClearance::Radius] {
        let boundaries = BoundaryConditions {
            clearance,
            ..boxed(floor)
        };
        let down = Gravity::<Plane>::new(vector![0.0, -2.0]).expect("finite");
        let mut engine: DsmcEngine<FallingDisks> =
            alone(&boundaries, down, vector![5.0, 1.5], vector![0.0, 0.0]);
        engine.advance(50.0, u64::MAX, &mut ());
        let body = engine.state().bodies[0];
        let height = if clearance == WallClearance::Radius {
            0.5
        } else {
            0.0
        };
        assert_eq!(body.position, vector![5.0, height]);
        assert_eq!(body.velocity, vector![0.0, 0.0]);
        let ledger = engine.ledgers().walls[1][0];
        assert!((ledger.momentum[1] - 100.0).abs() < 1e-10, "{ledger:?}");
        assert!(
            (ledger.energy + 2.0 * (1.5 - height)).abs() < 1e-12,
            "{ledger:?}"
        );
        // At rest from the start.
        let at_rest = vector![5.0, height];
        let mut engine: DsmcEngine<FallingDisks> =
            alone(&boundaries, down, at_rest, vector![0.0, 0.0]);
        engine.advance(50.0, u64::MAX, &mut ());
        assert_eq!(engine.state().bodies[0].position, at_rest);
        assert_eq!(engine.ledgers().settled_particles, 0);
        // A corner into which the particle slides.
        let aslant = Gravity::<Plane>::new(vector![-1.0, -2.0]).expect("finite");
        let mut engine: DsmcEngine<FallingDisks> =
            alone(&boundaries, aslant, at_rest, vector![3.0, 0.0]);
        engine.advance(50.0, u64::MAX, &mut ());
        let body = engine.state().bodies[0];
        assert_eq!(body.position, vector![height, height]);
        assert_eq!(body.velocity, vector![0.0, 0.0]);
    }
}

/// A particle at rest on a vibrating floor stays on it while the floor accelerates less than
/// gravity, is thrown when it accelerates more, and lands again.
#[test]
fn a_grain_rides_on_a_shaking_floor() {
    let mut floor = Wall::<Plane>::still(Rebound::Restitutive {
        restitution: 0.0,
        slip: 1.0,
    });
    floor.vibration = Vibration::new(0.25, 1.0).ok();
    let boundaries = between([
        [Face::Periodic; 2],
        [Face::Wall(floor), Face::Wall(Wall::specular())],
    ]);
    let down = Gravity::<Plane>::new(vector![0.0, -2.0]).expect("finite");
    let mut engine: DsmcEngine<FallingDisks> =
        alone(&boundaries, down, vector![5.0, 0.0], vector![0.0, 0.0]);
    engine.hold_step(0.0625);
    // On the way in, the particle is on the floor and has its speed of one half.
    engine.advance(0.375, u64::MAX, &mut ());
    let body = engine.state().bodies[0];
    assert_eq!((body.position[1], body.velocity[1]), (0.1875, 0.5));
    // From the turn at one half it flies, (t - 1/2)/2 - (t - 1/2)^2 above a quarter, until the
    // floor meets it.
    engine.advance(0.75, u64::MAX, &mut ());
    let body = engine.state().bodies[0];
    assert!((body.position[1] - 0.3125).abs() < 1e-12, "{body:?}");
    assert!(body.velocity[1].abs() < 1e-12, "{body:?}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    let boundaries = boxed(Wall::specular());
    let boxed_domain = domain(&boundaries, [10.0, 10.0]);
    let state = ideal_gas(&scene, boxed_domain, 1.0, 10, 1.0, 1);
    let start = |parameters: Parameters,
                 state: &State<FallingDisks>,
                 boundaries: &BoundaryConditions<Plane>| {
        DsmcEngine::<FallingDisks>::setup(&scene, parameters, Streams::new(1, 0))
            .between(boundaries)
            .start(state)
            .map(|_| ())
            .expect_err("refused")
            .to_string()
    };
    let contact = Parameters {
        scheme: Scheme::ContactPoint { radius: None },
        ..PARAMETERS
    };
    let weighted = BoundaryConditions {
        weights: SimulatorWeights::along(0, vec![1.0, 2.0]).expect("factors"),
        ..boundaries.clone()
    };
    let said = start(contact, &state, &weighted);
    assert!(
        said.contains("contact-point") && said.contains("weights"),
        "{said}"
    );
    let displaced = Parameters {
        displacement: PartnerDisplacement::Diameter,
        ..PARAMETERS
    };
    assert!(start(displaced, &state, &boundaries).contains("displacement"));
    let said = start(PARAMETERS, &state, &BoundaryConditions::default());
    assert!(said.contains("axis 0: the box is not periodic"), "{said}");
    let mut outside = state.clone();
    outside.bodies[3].position[1] = 10.5;
    let said = start(PARAMETERS, &outside, &boundaries);
    assert!(
        said.contains("simulator 3 is at 10.5 along axis 1"),
        "{said}"
    );
    outside.bodies[3].position[1] = 9.75;
    let radius = BoundaryConditions {
        clearance: WallClearance::Radius,
        ..boundaries.clone()
    };
    let said = start(PARAMETERS, &outside, &radius);
    assert!(said.contains("allowed: 0.5 to 9.5"), "{said}");
    let mut wide = Wall::<Plane>::specular();
    wide.vibration = Vibration::new(6.0, 1.0).ok();
    let said = start(PARAMETERS, &state, &boxed(wide));
    assert!(said.contains("take 12 of 10"), "{said}");
    let periodic = DsmcEngine::<FallingDisks>::new(&scene, PARAMETERS, &state, Streams::new(1, 0));
    assert!(matches!(
        periodic,
        Err(DsmcError::UnlikeFaces { axis: 0, .. })
    ));
}

/// Pressure of dense elastic disks on the walls of a specular box, over Enskog's equation of state
/// at the density in the middle. Checks that energy is conserved.
fn pressure_over_bulk(scheme: Scheme, side: f64, seed: u64) -> f64 {
    let boundaries = BoundaryConditions {
        clearance: WallClearance::Radius,
        ..boxed(Wall::specular())
    };
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    let domain = domain(&boundaries, [side, side]);
    let state = ideal_gas(&scene, domain, 0.5, 500, 1.0, seed);
    let parameters = Parameters {
        scheme,
        cell_size: None,
        simulators_per_particle: 8,
        ..PARAMETERS
    };
    let mut engine: DsmcEngine<FallingDisks> =
        DsmcEngine::setup(&scene, parameters, Streams::new(seed, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
    let energy = engine.state().kinetic_energy(&scene);
    engine.advance(20.0, u64::MAX, &mut ());
    let before = engine.ledgers().walls;
    let (mut middle, samples) = (0.0, 200);
    for sample in 1..=samples {
        engine.advance(20.0 + f64::from(sample), u64::MAX, &mut ());
        engine.visit(|position, _, (), _, weight| {
            let inside = |x: f64| (8.0..32.0).contains(&x);
            if inside(position[0]) && inside(position[1]) {
                middle += weight / f64::from(samples);
            }
        });
    }
    let end = engine.state().kinetic_energy(&scene);
    assert!((end / energy - 1.0).abs() < 1e-11);
    let walls = engine.ledgers().walls;
    let given = |axis: usize| {
        let faces = walls[axis].iter().zip(before[axis]);
        faces.map(move |(now, before)| (now.momentum - before.momentum)[axis].abs())
    };
    let push: f64 = (0..2).flat_map(given).sum();
    let density = middle / (24.0 * 24.0);
    let packing = density * Plane::particle_volume(0.5);
    let bulk = density * (1.0 + 2.0 * packing * Plane::contact_value(packing));
    push / (4.0 * (side - 1.0) * f64::from(samples)) / bulk
}

/// Cross-cell schemes of dense elastic disks give wall pressures equal to the bulk pressure, to 2
/// %. Four gases; their standard error must be at most a fifth of that.
fn dense_disks_press_on_their_walls(scheme: Scheme) {
    let found: Vec<f64> = (0..4)
        .map(|seed| pressure_over_bulk(scheme, 40.0, seed))
        .collect();
    let found = Estimate::over_replicas(&found).expect("four");
    assert!(
        found.standard_error.is_some_and(|error| error < 0.004),
        "too wide: {found:?}"
    );
    assert!((found.value - 1.0).abs() < 0.02, "{found:?}");
}

#[test]
fn dense_disks_press_on_their_walls_from_contact_points() {
    dense_disks_press_on_their_walls(Scheme::ContactPoint { radius: None });
}

#[test]
fn dense_disks_press_on_their_walls_by_esmc() {
    dense_disks_press_on_their_walls(Scheme::Esmc(Neighbourhood::Cells(2)));
}

/// Several sets of simulators between walls fill the box as evenly as the start: the mean height of
/// 200 disks with 64 simulators each, whose sets are reflected as wholes, is that of 64 draws of a
/// set's mean (z = 4.4). Starts given one by one are taken unchanged, or refused with the reason.
#[test]
fn several_simulators_start_evenly_between_walls() {
    let boundaries = boxed(Wall::specular());
    let scene: FallingDisks = grains(0.01, 1.0, Smooth, no_gravity());
    let domain = domain(&boundaries, [10.0, 10.0]);
    let state = |seed| ideal_gas::<FallingDisks>(&scene, domain, 0.0, 200, 1.0, seed);
    let parameters = Parameters {
        simulators_per_particle: 64,
        ..PARAMETERS
    };
    let streams = Streams::new(1, 0);
    let engine = DsmcEngine::<FallingDisks>::setup(&scene, parameters, streams)
        .between(&boundaries)
        .start(&state(1))
        .expect("an engine");
    let all = engine.state().bodies;
    assert_eq!(all.len(), 64 * 200);
    let error = 10.0 / (12.0_f64 * 64.0).sqrt();
    for axis in 0..2 {
        let mean = all.iter().map(|body| body.position[axis]).sum::<f64>() / all.len() as f64;
        assert!((mean - 5.0).abs() < 4.4 * error, "{axis}: {mean}");
    }
    let two = Parameters {
        simulators_per_particle: 2,
        ..PARAMETERS
    };
    let sets = [state(1), state(2)];
    let engine = DsmcEngine::<FallingDisks>::setup(&scene, two, streams)
        .between(&boundaries)
        .start_sets(&sets)
        .expect("an engine");
    let energy: f64 = sets.iter().map(|set| set.kinetic_energy(&scene)).sum();
    let found = engine.state().kinetic_energy(engine.scene());
    assert!((found / energy - 1.0).abs() < 1e-14);
    let said = DsmcEngine::<FallingDisks>::setup(&scene, two, streams)
        .between(&boundaries)
        .start_sets(&sets[..1])
        .map(|_| ())
        .expect_err("refused")
        .to_string();
    assert!(said.contains("1 states for 2 simulators"), "{said}");
}
