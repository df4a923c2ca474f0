//! Gases around obstacles, and counts by cell.

use nalgebra::{Vector2, Vector3, vector};
use stosszahl_dsmc::{
    BoundaryConditions, DsmcEngine, Parameters, PartnerDisplacement, Scheme, WallClearance,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{FallingDisks, FallingParticles, grains, ideal_gas, no_gravity};
use stosszahl_model::walls::{Obstacle, ObstacleShape};
use stosszahl_model::{
    Domain, Face, Gravity, ParticleState, Plane, Rebound, Smooth, Space, State, Volume, Wall,
    Walls, samples,
};

use crate::support::{PARAMETERS, sphere_for_unit_path};

const SPECULAR: Rebound = Rebound::Restitutive {
    restitution: 1.0,
    slip: 1.0,
};

fn obstacle(outline: ObstacleShape, law: Rebound) -> Obstacle {
    Obstacle::new(outline, law).expect("an obstacle")
}

fn disk(x: f64, y: f64, radius: f64) -> Obstacle {
    let centre = vector![x, y];
    obstacle(ObstacleShape::Circle { centre, radius }, SPECULAR)
}

fn block(low: [f64; 2], high: [f64; 2], law: Rebound) -> Obstacle {
    let points = vec![
        low.into(),
        vector![high[0], low[1]],
        high.into(),
        vector![low[0], high[1]],
    ];
    obstacle(ObstacleShape::Polygon { points }, law)
}

fn around<S: Space>(obstacles: Vec<Obstacle>, clearance: WallClearance) -> BoundaryConditions<S> {
    BoundaryConditions {
        clearance,
        obstacles,
        ..BoundaryConditions::default()
    }
}

/// Removes particles that overlap an obstacle from a state.
fn outside(
    mut state: State<FallingDisks>,
    obstacles: &[Obstacle],
    radius: f64,
) -> State<FallingDisks> {
    let is_free = |body: &ParticleState<FallingDisks>| {
        let mut near = obstacles.iter();
        let lengths = state.domain.lengths();
        !near.any(|obstacle| {
            let images =
                (-1..=1).flat_map(|x| (-1..=1).map(move |y| vector![f64::from(x), f64::from(y)]));
            let mut images = images.map(|image| body.position + image.component_mul(&lengths));
            images.any(|image| obstacle.overlaps(image, radius, 0.0))
        })
    };
    let bodies = state.bodies.iter().copied().filter(is_free).collect();
    state.bodies = bodies;
    state
}

/// Elastic disks around specular obstacles in a periodic box, some across its edge, keep their
/// energy and stay outside. Density is uniform, and the collision rate is that of the free volume.
/// z = 4.4 for fractions of particles, and the Poisson error for collisions, with 1 % for the
/// sampled volume.
#[test]
fn a_gas_around_obstacles_stays_in_equilibrium() {
    let obstacles = vec![
        disk(5.0, 5.0, 2.0),
        disk(0.75, 0.75, 0.75),
        block([9.0, 2.0], [10.0, 4.0], SPECULAR),
        obstacle(
            ObstacleShape::Segment {
                ends: [vector![1.0, 8.0], vector![4.0, 9.0]],
            },
            SPECULAR,
        ),
    ];
    for (clearance, radius) in [(WallClearance::Centre, 0.0), (WallClearance::Radius, 0.1)] {
        let boundaries = around(obstacles.clone(), clearance);
        let scene = grains(0.2, 1.0, Smooth, no_gravity());
        let domain = Domain::periodic(vector![10.0, 10.0]).expect("a box");
        let all = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 20_000, 1.0, 3);
        let state = outside(all, &obstacles, radius);
        let count = state.bodies.len() as f64;
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.count_cells();
        engine.advance(1.0, u64::MAX, &mut ());
        let end = engine.state();
        let energy = end.kinetic_energy(&scene) / state.kinetic_energy(&scene);
        assert!((energy - 1.0).abs() < 1e-12, "{energy}");
        let still_out = outside(end.clone(), &obstacles, radius - 1e-8);
        assert_eq!(still_out.bodies.len(), end.bodies.len());
        let room = count / 20_000.0 * 100.0;
        let left = end
            .bodies
            .iter()
            .filter(|body| (6.0..8.0).contains(&body.position[0]));
        let left = left.filter(|body| body.position[1] > 7.5).count() as f64;
        let share = 5.0 / room;
        assert!(
            (left - count * share).abs() < 4.4 * (count * share).sqrt(),
            "{left}"
        );
        let packing = count * Plane::particle_volume(0.1) / room;
        let pairs = 0.5 * count * Plane::collision_rate(packing, 1.0) / 0.2;
        let found = engine.tally().collisions as f64;
        let error = (4.4 / pairs.sqrt()).hypot(0.01);
        assert!((found / pairs - 1.0).abs() < error, "{found} {pairs}");
        let ledgers = engine.ledgers();
        assert!(
            ledgers
                .obstacles
                .iter()
                .all(|ledger| ledger.contacts > 100.0)
        );
        let given = ledgers.total().1 - (end.momentum(&scene) - state.momentum(&scene));
        assert!(
            given.norm() < 1e-8 && ledgers.settled_particles == 0,
            "{given}"
        );
        // Counts by cell add up to the total.
        let counts = engine.take_cell_counts();
        assert_eq!(counts.len(), engine.grid().cells());
        let counted: f64 = counts.iter().map(|count| count.collisions).sum();
        assert_eq!(counted, found);
        assert!(counts[5 + 10 * 5].collisions == 0.0 && counts[7 + 10 * 8].collisions > 100.0);
        assert!(
            engine
                .take_cell_counts()
                .iter()
                .all(|count| count.collisions == 0.0)
        );
    }
}

/// In steps so long that disks cross the box several times, every contact with an obstacle is
/// found, also across a periodic face.
#[test]
fn nothing_flies_through_an_obstacle() {
    let obstacles = vec![block([4.0, 0.0], [6.0, 10.0], SPECULAR)];
    let boundaries = around(obstacles, WallClearance::Centre);
    let scene = grains(0.2, 1.0, Smooth, no_gravity());
    let body = (vector![1.0, 2.0], vector![-1.0, 0.5]);
    let domain = Domain::periodic(vector![10.0, 10.0]).expect("a box");
    let state = samples::state(domain, [body]);
    for step in [0.25, 7.0, 100.0] {
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.hold_step(step);
        engine.advance(100.0, u64::MAX, &mut ());
        // Motion between 6 and 14 along the first axis: from 11 it reaches the obstacle at 6 after
        // 5, then every 8.
        let end = engine.state().bodies[0];
        assert_eq!(engine.ledgers().obstacles[0].contacts, 12.0);
        assert_eq!(end.velocity, vector![-1.0, 0.5]);
        assert!(
            (end.position - vector![7.0, 2.0]).norm() < 1e-7,
            "{step}: {end:?}"
        );
    }
}

/// A particle that falls on an obstacle of restitution 0.5 comes to rest on it.
#[test]
fn a_grain_comes_to_rest_on_a_block() {
    let law = Rebound::Restitutive {
        restitution: 0.5,
        slip: 1.0,
    };
    let boundaries = BoundaryConditions {
        walls: Walls::new(&[[Face::Periodic; 2], [Face::Wall(Wall::specular()); 2]]).expect("fit"),
        ..around(
            vec![block([4.0, 1.0], [6.0, 2.0], law)],
            WallClearance::Radius,
        )
    };
    let down = Gravity::<Plane>::new(vector![0.0, -2.0]).expect("finite");
    let scene = grains(1.0, 1.0, Smooth, down);
    let domain = boundaries.walls.domain(vector![10.0, 10.0]).expect("a box");
    let state = samples::state(domain, [(vector![5.0, 4.0], vector![0.0, 0.0])]);
    let mut engine: DsmcEngine<FallingDisks> =
        DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
    engine.advance(100.0, u64::MAX, &mut ());
    let body = engine.state().bodies[0];
    assert!(
        (body.position - vector![5.0, 2.5]).norm() < 1e-8,
        "{body:?}"
    );
    assert!(body.velocity.norm() < 1e-6, "{body:?}");
}

/// A particle of restitution 0 slides down a frictionless slope of 45 degrees: g t^2/4 along each
/// axis in time t, while the slope gives it the momentum g t/2 along each. Tolerance: rounding, and
/// its initial height of 1e-9 above the slope, below 1e-6.
#[test]
fn a_grain_slides_down_a_slope() {
    let law = Rebound::Restitutive {
        restitution: 0.0,
        slip: 1.0,
    };
    let points = vec![vector![1.0, 1.0], vector![9.0, 1.0], vector![1.0, 9.0]];
    let slope = obstacle(ObstacleShape::Polygon { points }, law);
    let boundaries = BoundaryConditions {
        walls: Walls::new(&[[Face::Wall(Wall::specular()); 2]; 2]).expect("fit"),
        ..around(vec![slope], WallClearance::Radius)
    };
    let down = Gravity::<Plane>::new(vector![0.0, -0.5]).expect("finite");
    let scene = grains(1.0, 1.0, Smooth, down);
    let aside = 0.5_f64.sqrt() * (0.5 + 1e-9);
    let begin = vector![3.0 + aside, 7.0 + aside];
    let domain = boundaries.walls.domain(vector![10.0, 10.0]).expect("a box");
    let state = samples::state(domain, [(begin, vector![0.0, 0.0])]);
    let mut engine: DsmcEngine<FallingDisks> =
        DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
    engine.hold_step(0.01);
    engine.advance(4.0, u64::MAX, &mut ());
    let body = engine.state().bodies[0];
    // a t^2/2 along each axis, a = g/2.
    let way = 0.5 * 0.25 * 16.0;
    assert!(
        (body.position - begin - vector![way, -way]).norm() < 1e-6,
        "{body:?}"
    );
    assert!(
        (body.velocity - vector![1.0, -1.0]).norm() < 1e-6,
        "{body:?}"
    );
    let given = engine.ledgers().obstacles[0].momentum;
    assert!((given - vector![1.0, 1.0]).norm() < 1e-6, "{given}");
}

/// Particles of restitution 0.5 fall into a funnel that holds a disk, and come to rest in wedges
/// between its sides, the disk and the floor. The run ends, no particle is inside an obstacle or
/// outside the box, the energy only falls, and the ledgers balance.
#[test]
fn grains_come_to_rest_in_wedges() {
    let law = Rebound::Restitutive {
        restitution: 0.5,
        slip: 1.0,
    };
    let polygon = |points: [[f64; 2]; 3]| {
        let points = points.into_iter().map(Into::into).collect();
        obstacle(ObstacleShape::Polygon { points }, law)
    };
    let centre = vector![5.2, 2.0];
    let disk = ObstacleShape::Circle {
        centre,
        radius: 0.7,
    };
    let obstacles = vec![
        polygon([[0.0, 0.0], [4.5, 0.0], [0.0, 5.0]]),
        polygon([[5.5, 0.0], [10.0, 0.0], [10.0, 2.0]]),
        obstacle(disk, law),
    ];
    for clearance in [WallClearance::Centre, WallClearance::Radius] {
        let boundaries = BoundaryConditions {
            walls: Walls::new(&[[Face::Wall(Wall::still(law)); 2]; 2]).expect("fit"),
            ..around(obstacles.clone(), clearance)
        };
        let down = Gravity::<Plane>::new(vector![0.0, -1.0]).expect("finite");
        let scene = grains(0.2, 1.0, Smooth, down);
        let domain = boundaries.walls.domain(vector![10.0, 10.0]);
        let mut state: State<FallingDisks> =
            ideal_gas(&scene, domain.expect("a box"), 0.1, 200, 1.0, 3);
        for body in &mut state.bodies {
            body.position[1] = 6.0 + 0.3 * body.position[1];
        }
        let parameters = Parameters {
            scheme: Scheme::Collisionless,
            ..PARAMETERS
        };
        let mut engine: DsmcEngine<_> = DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
        let radius = if clearance == WallClearance::Radius {
            0.1
        } else {
            0.0
        };
        let energy = |state: &State<FallingDisks>| {
            let heights = state.bodies.iter().map(|body| body.position[1]);
            state.kinetic_energy(&scene) + heights.sum::<f64>()
        };
        let mut last = energy(&state);
        for sample in 1..=20 {
            engine.advance(5.0 * f64::from(sample), u64::MAX, &mut ());
            let now = engine.state();
            assert!(energy(&now) <= last + 1e-9, "{last} {}", energy(&now));
            last = energy(&now);
            for body in &now.bodies {
                let deepest = obstacles
                    .iter()
                    .map(|obstacle| obstacle.clearance(body.position));
                assert!(deepest.fold(9.0, f64::min) > radius - 1e-6, "{body:?}");
                assert!(body.position.min() >= radius && body.position.max() <= 10.0 - radius);
            }
        }
        let end = engine.state();
        let moving = end.kinetic_energy(&scene);
        assert!(moving < 1.0, "{moving}");
        let (_, momentum, given) = engine.ledgers().total();
        let weight = vector![0.0, -1.0] * (100.0 * 200.0);
        let change = end.momentum(&scene) - state.momentum(&scene) - weight;
        assert!((change - momentum).norm() < 1e-3, "{change} {momentum}");
        assert!((given - (last - energy(&state))).abs() < 1e-3, "{given}");
    }
}

/// In three dimensions obstacles are prisms: spheres around a cylinder keep their energy, stay
/// outside, and fill the rest.
#[test]
fn spheres_flow_around_a_cylinder() {
    let boundaries = around::<Volume>(vec![disk(3.0, 3.0, 1.5)], WallClearance::Centre);
    let density = 100.0;
    let scene = grains(sphere_for_unit_path(density), 1.0, Smooth, no_gravity());
    let domain = Domain::periodic(vector![6.0, 6.0, 3.0]).expect("a box");
    let mut state: State<FallingParticles<Volume, Smooth>> =
        ideal_gas(&scene, domain, 0.0, 10_000, 1.0, 3);
    let from_axis = |position: Vector3<f64>| (position.xy() - Vector2::new(3.0, 3.0)).norm();
    state.bodies.retain(|body| from_axis(body.position) > 1.5);
    let mut engine: DsmcEngine<_> = DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    engine.advance(10.0, u64::MAX, &mut ());
    let end = engine.state();
    let energy = end.kinetic_energy(&scene) / state.kinetic_energy(&scene);
    assert!((energy - 1.0).abs() < 1e-12, "{energy}");
    let nearest = end.bodies.iter().map(|body| from_axis(body.position));
    assert!(nearest.fold(9.0, f64::min) > 1.5 - 1e-9);
    assert!(engine.ledgers().obstacles[0].momentum[2] == 0.0);
}

#[test]
fn a_grain_inside_an_obstacle_is_named() {
    let scene = grains(0.2, 1.0, Smooth, no_gravity());
    let domain = Domain::periodic(vector![10.0, 10.0]).expect("a box");
    let mut state = State::<FallingDisks> {
        time: 0.0,
        domain,
        bodies: vec![
            ParticleState::new(vector![1.0, 1.0], vector![0.0, 0.0]),
            ParticleState::new(vector![7.05, 5.0], vector![0.0, 0.0]),
        ],
    };
    let start = |state: &State<FallingDisks>, obstacles, clearance| {
        let boundaries = around(obstacles, clearance);
        DsmcEngine::<FallingDisks>::setup(&scene, PARAMETERS, Streams::new(1, 0))
            .between(&boundaries)
            .start(state)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    let two = || vec![disk(3.0, 3.0, 1.0), disk(5.0, 5.0, 2.0)];
    assert_eq!(start(&state, two(), WallClearance::Centre), Ok(()));
    let said = start(&state, two(), WallClearance::Radius).expect_err("overlaps");
    assert!(
        said.contains("simulator 1 at (7.05") && said.contains("obstacle 1"),
        "{said}"
    );
    state.bodies[0].position = vector![3.5, 3.0];
    let said = start(&state, two(), WallClearance::Centre).expect_err("inside");
    assert!(
        said.contains("simulator 0") && said.contains("obstacle 0"),
        "{said}"
    );
    let said =
        start(&state, vec![disk(9.5, 5.0, 1.0)], WallClearance::Centre).expect_err("reaches out");
    assert!(said.contains("obstacle 0: reaches from (8.5"), "{said}");
}

/// Default cells follow the free path in the area that obstacles leave: they equal those of a gas
/// in that area alone.
#[test]
fn default_cells_follow_the_free_area() {
    let scene = grains(0.1, 1.0, Smooth, no_gravity());
    let domain = Domain::<Plane>::periodic(vector![40.0, 40.0]).expect("a box");
    let bodies = vec![block([10.0, 0.0], [40.0, 40.0], SPECULAR)];
    let state = outside(ideal_gas(&scene, domain, 0.0, 4000, 1.0, 1), &bodies, 0.05);
    let parameters = Parameters {
        cell_size: None,
        ..PARAMETERS
    };
    for (clearance, width) in [(WallClearance::Centre, 10.0), (WallClearance::Radius, 9.9)] {
        let boundaries = around(bodies.clone(), clearance);
        let engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        let packing = state.bodies.len() as f64 * Plane::particle_volume(0.05) / (40.0 * width);
        let wanted = parameters.cells(&domain, packing, 0.1);
        let found = engine.grid().counts().map(|count| count as usize);
        assert_eq!(found, wanted, "{clearance:?}");
        // Averaged over the whole box, the path would be four times as long.
        assert!(wanted[0] > 2 * parameters.cells(&domain, packing / 4.0, 0.1)[0]);
    }
}

/// Counts by cell add up to the tally, for pairs within cells and cross-cell.
#[test]
fn counts_by_cell_add_up() {
    let scene = grains(1.0, 0.9, Smooth, no_gravity());
    let domain = Domain::periodic(vector![20.0, 20.0]).expect("a box");
    let state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 150, 1.0, 3);
    for (scheme, displacement) in [
        (Scheme::Boltzmann, PartnerDisplacement::Diameter),
        (
            Scheme::ContactPoint { radius: None },
            PartnerDisplacement::None,
        ),
    ] {
        let parameters = Parameters {
            scheme,
            displacement,
            cell_size: Some(2.0),
            ..PARAMETERS
        };
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::new(&scene, parameters, &state, Streams::new(1, 0)).expect("an engine");
        assert!(engine.take_cell_counts().is_empty());
        engine.count_cells();
        engine.advance(5.0, u64::MAX, &mut ());
        let counts = engine.take_cell_counts();
        let collisions: f64 = counts.iter().map(|count| count.collisions).sum();
        let virial: f64 = counts.iter().map(|count| count.virial).sum();
        assert!(collisions > 100.0);
        assert_eq!(collisions, engine.tally().collisions as f64);
        assert!((virial / engine.tally().virial - 1.0).abs() < 1e-9);
    }
}
