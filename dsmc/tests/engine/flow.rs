//! Flows through open faces, and simulator weights that depend on position.

use nalgebra::{Vector2, Vector3, vector};
use stosszahl_dsmc::{
    BoundaryConditions, DisplacementTracking, DsmcEngine, DsmcError, Inflow, Parameters,
    SimulatorWeights, Tracked,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{FallingDisks, FallingParticles, grains, ideal_gas, no_gravity};
use stosszahl_model::walls::{Obstacle, ObstacleShape, Vibration};
use stosszahl_model::{
    Face, Gravity, Plane, Rebound, Rough, Scene, Sizes, Smooth, Space, State, Surface, Volume,
    Wall, Walls, samples,
};

use crate::support::{PARAMETERS, disk_for_unit_path, sphere_for_unit_path};

/// Inflow through the lower face of the first axis.
fn inflow<S: Space>(density: f64, velocity: S::Vector, temperature: f64) -> Inflow<S> {
    Inflow {
        axis: 0,
        side: 0,
        density,
        velocity,
        temperature,
        spin_temperature: temperature,
        like: 0,
    }
}

/// Channel along the first axis, open at both ends.
fn channel<S: Space>(inflows: Vec<Inflow<S>>, side: Face<S>) -> BoundaryConditions<S> {
    let faces = [[Face::Open; 2], [side; 2], [Face::Periodic; 2]];
    BoundaryConditions {
        walls: Walls::new(&faces).expect("fit"),
        inflows,
        ..BoundaryConditions::default()
    }
}

/// A rough gas that drifts through a free channel keeps density, velocity and temperatures in four
/// slices within 1 %, for a subsonic and a supersonic drift. The channel starts empty; 40 samples,
/// each a transit apart, of 1000 spheres per slice give errors of 0.5 % for a density with Poisson
/// noise, and less for the others.
#[test]
fn a_drifting_gas_stays_uniform() {
    let density = 100.0;
    for drift in [0.8, 3.0] {
        let stream = inflow::<Volume>(density, vector![drift, 0.2, 0.0], 0.5);
        let back = Inflow { side: 1, ..stream };
        let boundaries = channel(vec![stream, back], Face::Periodic);
        let surface = Rough::new(1.0, Volume::INERTIA).expect("a surface");
        let scene = grains(sphere_for_unit_path(density), 1.0, surface, no_gravity());
        let lengths = vector![8.0, 2.0, 2.5];
        let state = samples::state(boundaries.walls.domain(lengths).expect("a box"), []);
        let mut engine: DsmcEngine<FallingParticles<Volume, Rough>, Tracked> =
            DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        let transit = 8.0 / drift;
        let mut slices = [[0.0; 5]; 4];
        for sample in 0..40 {
            engine.advance((4.0 + f64::from(sample)) * transit, u64::MAX, &mut ());
            engine.visit(
                |position, velocity: Vector3<f64>, spin: Vector3<f64>, _, weight| {
                    assert_eq!(weight, 1.0);
                    let slice = &mut slices[(position[0] / 2.0) as usize];
                    let own = velocity - vector![drift, 0.2, 0.0];
                    let radius = scene.sizes.largest_radius();
                    let more = [
                        1.0,
                        velocity[0],
                        own.norm_squared() / 3.0,
                        0.4 * radius * radius * spin.norm_squared() / 3.0,
                        velocity[1],
                    ];
                    for (sum, value) in slice.iter_mut().zip(more) {
                        *sum += value;
                    }
                },
            );
        }
        for [count, momentum, heat, turning, aside] in slices {
            let found = count / (40.0 * 2.0 * 5.0);
            assert!((found / density - 1.0).abs() < 0.01, "{drift}: {found}");
            let speed = momentum / count;
            assert!((speed - drift).abs() < 0.01, "{drift}: {speed}");
            assert!((aside / count - 0.2).abs() < 0.01);
            assert!((heat / count / 0.5 - 1.0).abs() < 0.01, "{drift}: {heat}");
            assert!((turning / count / 0.5 - 1.0).abs() < 0.01, "{drift}");
        }
        check_ledgers(&engine, &scene);
    }
}

/// Checks that the ledgers account for the content of the box: to the rounding of sums of some 1e5
/// terms.
fn check_ledgers<S: Space, C: Surface<S>, F: DisplacementTracking<S>>(
    engine: &DsmcEngine<FallingParticles<S, C>, F>,
    scene: &FallingParticles<S, C>,
) {
    let (mass, momentum, energy) = engine.ledgers().total();
    let (mut there, mut moving, mut heat) = (0.0, S::Vector::default(), 0.0);
    engine.visit(|_, velocity, spin, _, weight| {
        use stosszahl_model::Vector;
        there += weight;
        moving += velocity * weight;
        let turning = scene
            .surface
            .spin_energy(1.0, scene.sizes.largest_radius(), spin);
        heat += weight * (0.5 * velocity.square() + turning);
    });
    assert!((mass - there).abs() < 1e-7, "{mass} {there}");
    for axis in 0..S::DIMENSION {
        assert!((momentum[axis] - moving[axis]).abs() < 1e-7);
    }
    assert!((energy - heat).abs() < 1e-7, "{energy} {heat}");
}

/// No particles enter with zero density or with a gas that drifts outwards; a channel then empties,
/// and an empty one stays empty, in a finite number of steps.
#[test]
fn without_flux_a_channel_runs_empty() {
    let scene = grains(0.01, 1.0, Smooth, no_gravity());
    for stream in [
        inflow::<Plane>(0.0, vector![5.0, 0.0], 1.0),
        inflow::<Plane>(50.0, vector![-5.0, 0.0], 0.0),
        inflow::<Plane>(50.0, vector![0.0, 1.0], 0.0),
    ] {
        let boundaries = channel(vec![stream], Face::Wall(Wall::specular()));
        let domain = boundaries.walls.domain(vector![4.0, 3.0]).expect("a box");
        let state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 200, 1.0, 3);
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.advance(1e4, u64::MAX, &mut ());
        assert_eq!(engine.simulators(), 0);
        assert!(engine.state().bodies.is_empty());
        let gone = engine.ledgers().open[0][0].particles + engine.ledgers().open[0][1].particles;
        assert_eq!(gone, -200.0);
        assert_eq!(engine.ledgers().inflows[0].particles, 0.0);
        let steps = engine.tally().steps;
        engine.advance(2e4, u64::MAX, &mut ());
        assert!(engine.tally().steps < 2 * steps + 1_000_000);
    }
}

/// A supersonic stream into an empty channel: the inflow is density times speed, within z = 4.4 of
/// the error of randomly rounded numbers, which is below Poisson's. It fills the channel evenly and
/// leaves at the far end.
#[test]
fn a_supersonic_stream_fills_an_empty_channel() {
    let (density, drift) = (40.0, 20.0);
    let stream = inflow::<Plane>(density, vector![drift, 0.0], 1.0);
    let boundaries = channel(vec![stream], Face::Wall(Wall::specular()));
    let scene = grains(disk_for_unit_path(density), 1.0, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![10.0, 5.0]).expect("a box");
    let state = samples::state(domain, []);
    let mut engine: DsmcEngine<FallingDisks> =
        DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
    assert_eq!(engine.simulators(), 0);
    engine.advance(10.0, u64::MAX, &mut ());
    let entered = engine.ledgers().inflows[0].particles;
    let expected = density * drift * 5.0 * 10.0;
    assert!(
        (entered - expected).abs() < 4.4 * expected.sqrt(),
        "{entered} {expected}"
    );
    let there = engine.simulators() as f64;
    let full = density * 10.0 * 5.0;
    assert!((there - full).abs() < 4.4 * full.sqrt(), "{there} {full}");
    assert_eq!(engine.ledgers().open[0][0].particles, 0.0);
    check_ledgers(&engine, &scene);
}

/// Weights of 1 and 3.7: over 1e6 changes of weight, splits and merges conserve particles, mass,
/// momentum and energy on average, to 3 standard errors of the mean over 24 gases, and the density
/// is uniform.
#[test]
fn splits_and_merges_are_fair() {
    let weights = SimulatorWeights::along(0, vec![1.0, 3.7, 0.3]).expect("factors");
    let boundaries = BoundaryConditions {
        weights,
        ..BoundaryConditions::default()
    };
    let scene = grains(1e-3, 1.0, Smooth, no_gravity());
    let parameters = Parameters {
        steps_per_cell_crossing: 1.0,
        ..PARAMETERS
    };
    let gases = 24;
    let mut samples = Vec::new();
    let mut changes = 0;
    let mut thirds = [0.0; 3];
    for seed in 0..gases {
        let domain = boundaries.walls.domain(vector![6.0, 6.0]).expect("a box");
        let mut state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 10_000, 1.0, seed);
        for body in &mut state.bodies {
            body.velocity[0] += 1.0;
        }
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, parameters, Streams::new(seed, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.advance(16.0, u64::MAX, &mut ());
        let balance = engine.ledgers().balance;
        assert_eq!(balance.particles, balance.mass);
        samples.push([
            balance.particles,
            balance.momentum[0],
            balance.momentum[1],
            balance.energy,
        ]);
        changes += engine.ledgers().balanced;
        let mut there = 0.0;
        engine.visit(|position, _, (), _, weight| {
            thirds[(position[0] / 2.0) as usize] += weight;
            there += weight;
        });
        assert!((there - 10_000.0 - balance.particles).abs() < 1e-7);
    }
    assert!(changes > 1_000_000, "{changes}");
    let n = gases as f64;
    for quantity in 0..4 {
        let values = samples.iter().map(|sample| sample[quantity]);
        let mean = values.clone().sum::<f64>() / n;
        let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let error = (variance / n).sqrt();
        assert!(mean.abs() < 3.0 * error, "{quantity}: {mean} +- {error}");
        // Relative to 1e4 particles and their energies.
        assert!(error < 200.0, "{quantity}: the error {error} is too wide");
    }
    for third in thirds {
        let share = 3.0 * third / (n * 10_000.0);
        assert!((share - 1.0).abs() < 0.02, "{thirds:?}");
    }
}

/// With walls, gravity, inflows, weights and collisions, results have the same bytes for any number
/// of threads, any tiles, and through a stop.
#[test]
fn threads_tiles_and_stops_change_nothing() {
    let factors = vec![1.0, 0.8, 0.5, 1.7, 1.0, 2.5, 1.0, 0.6];
    nothing_changes(
        SimulatorWeights::table([4, 2, 1], factors).expect("factors"),
        |x| x,
    );
}

/// Threads, tiles and stops change nothing with adaptive weights, which change before and after the
/// stop: the gas starts 5.7 times denser than the mean at one end, and at a sixth of the mean at
/// the other.
#[test]
fn they_change_nothing_where_weights_follow_the_number() {
    let following = SimulatorWeights::following(0, 8).expect("slices");
    nothing_changes(following, |x| 12.0 * (x / 12.0).powi(6));
}

/// Checks that threads, tiles and stops change nothing. `place`: maps uniform coordinates along the
/// channel to initial ones.
fn nothing_changes(weights: SimulatorWeights, place: impl Fn(f64) -> f64) {
    let density = 400.0;
    let mut floor = Wall::<Plane>::still(Rebound::Diffuse { temperature: 0.7 });
    floor.sliding = vector![0.3, 0.0];
    floor.vibration = Vibration::new(0.3, 1.1).ok();
    let disk = ObstacleShape::Circle {
        centre: vector![6.0, 2.5],
        radius: 0.8,
    };
    let disk = Obstacle::new(disk, Rebound::Diffuse { temperature: 1.2 }).expect("an obstacle");
    let boundaries = BoundaryConditions {
        obstacles: vec![disk.clone()],
        walls: Walls::new(&[
            [Face::Open; 2],
            [Face::Wall(floor), Face::Wall(Wall::specular())],
        ])
        .expect("fit"),
        inflows: vec![
            inflow(density, vector![1.0, 0.0], 1.0),
            Inflow {
                side: 1,
                ..inflow(0.5 * density, vector![-0.2, 0.0], 2.0)
            },
        ],
        weights,
        ..BoundaryConditions::default()
    };
    let field = Gravity::new(vector![0.05, -0.2]).expect("finite");
    let surface = Rough::new(0.5, Plane::INERTIA).expect("a surface");
    let scene = grains(disk_for_unit_path(density), 0.9, surface, field);
    let domain = boundaries.walls.domain(vector![12.0, 5.0]).expect("a box");
    let mut state = ideal_gas(&scene, domain, 0.0, 24_000, 1.0, 4);
    for body in &mut state.bodies {
        body.position[0] = place(body.position[0]);
    }
    state.bodies.retain(|body| !disk.holds(body.position));
    let streams = Streams::new(9, 0);
    let run = |threads: usize, per_tile: Option<usize>, stop: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads").install(|| {
            let mut engine = DsmcEngine::<_, Tracked>::setup(&scene, PARAMETERS, streams)
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
            if let Some(per_tile) = per_tile {
                engine.retile(per_tile);
            }
            engine.advance(f64::INFINITY, 12, &mut ());
            if stop {
                let checkpoint = engine.checkpoint();
                engine = DsmcEngine::setup(&scene, PARAMETERS, streams)
                    .between(&boundaries)
                    .resume(domain, checkpoint)
                    .expect("an engine");
            }
            engine.advance(f64::INFINITY, 12, &mut ());
            (
                engine.state().bodies,
                engine.displacements(),
                engine.time(),
                engine.tally().collisions,
                engine.ledgers().clone(),
            )
        })
    };
    let alone = run(1, None, false);
    assert!(
        alone.3 > 5000 && alone.4.balanced > 5000,
        "{} {}",
        alone.3,
        alone.4.balanced
    );
    for (threads, stop) in [(2, false), (3, true), (1, true)] {
        assert!(
            alone == run(threads, None, stop),
            "{threads} threads, {stop}"
        );
    }
    // Sums over tiles are added in another order.
    for per_tile in [1, 300, 1_000_000] {
        let other = run(2, Some(per_tile), false);
        assert!(alone.0 == other.0 && alone.1 == other.1, "{per_tile}");
        assert_eq!((alone.2, alone.3), (other.2, other.3));
        assert_eq!(alone.4.balanced, other.4.balanced);
    }
}

#[test]
fn streams_that_have_no_meaning_are_refused() {
    let scene = grains(0.1, 1.0, Smooth, no_gravity());
    let good = inflow::<Plane>(1.0, vector![1.0, 0.0], 1.0);
    let refuse = |stream: Inflow<Plane>| {
        let boundaries = channel(vec![good, stream], Face::Periodic);
        let domain = boundaries.walls.domain(vector![4.0, 3.0]).expect("a box");
        let state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 5, 1.0, 3);
        DsmcEngine::<FallingDisks>::setup(&scene, PARAMETERS, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .map(|_| ())
            .expect_err("refused")
            .to_string()
    };
    for (stream, part) in [
        (
            Inflow {
                density: -1.0,
                ..good
            },
            "inflow 1: density = -1",
        ),
        (
            Inflow {
                density: 1e10,
                ..good
            },
            "density = 10000000000; allowed: at most 2^30",
        ),
        (
            Inflow {
                temperature: f64::NAN,
                ..good
            },
            "temperature = NaN",
        ),
        (Inflow { axis: 2, ..good }, "axis = 2"),
        (Inflow { axis: 1, ..good }, "where the face is open"),
        (Inflow { side: 2, ..good }, "side = 2"),
        (
            Inflow {
                velocity: vector![f64::INFINITY, 0.0],
                ..good
            },
            "velocity = inf",
        ),
    ] {
        let said = refuse(stream);
        assert!(said.contains(part), "{said}");
    }
}

/// Species may flow in and out; particles with individual sizes may not.
#[test]
fn only_species_can_flow() {
    let boundaries = channel(
        vec![Inflow {
            like: 1,
            ..inflow::<Plane>(30.0, vector![2.0, 0.0], 1.0)
        }],
        Face::Periodic,
    );
    let domain = boundaries.walls.domain(vector![4.0, 3.0]).expect("a box");
    let [first, second] = [1.0, 2.0].map(|x| vector![x, 1.0]);
    let rest = vector![0.0, 0.0];
    let individual = samples::mixture(0.9, [(0.1, 1.0), (0.05, 0.5)]);
    let state = samples::state(domain, [(first, rest), (second, rest)]);
    let refused = DsmcEngine::<_>::setup(&individual, PARAMETERS, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state);
    assert!(matches!(refused, Err(DsmcError::Individuals)));
    let sizes = samples::species([(0.01, 1.0, 1), (0.02, 0.5, 1)]);
    let species = Scene::new(Smooth, samples::law(0.9), sizes, no_gravity());
    let state = samples::state(domain, [(first, rest), (second, rest)]);
    let mut engine = DsmcEngine::<_>::setup(&species, PARAMETERS, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    engine.advance(20.0, u64::MAX, &mut ());
    let mut kinds = [0; 2];
    let mut light = Vec::new();
    engine.visit(|position, _: Vector2<f64>, (), kind: u32, _| {
        kinds[kind as usize] += 1;
        if kind == 1 {
            light.push(position);
        }
    });
    // Species follow each other.
    let state = engine.state();
    assert_eq!(state.bodies.len(), kinds[0] + kinds[1]);
    let second = state.bodies[kinds[0]..].iter().map(|body| body.position);
    assert!(second.eq(light));
    assert!(kinds[0] <= 1 && kinds[1] > 200, "{kinds:?}");
    assert_eq!(
        engine.ledgers().inflows[0].mass,
        0.5 * engine.ledgers().inflows[0].particles
    );
}

/// Atmosphere over a warm floor, whose density falls by a factor of 24 from the lowest to the
/// highest fifth of its height, after 40 mean free times. Returns the engine, and mean particles,
/// temperature and simulators of each fifth over forty samples.
///
/// Checks the barometric density and the floor's temperature up to the top, to 2 %. Samples of 4000
/// simulators in each fifth, renewed in some ten samples, have errors below 0.8 %.
fn atmosphere(count: f64, weights: SimulatorWeights) -> (DsmcEngine<FallingDisks>, [[f64; 3]; 5]) {
    let height = 10.0;
    let pull = 0.4;
    let floor = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let boundaries = BoundaryConditions {
        walls: Walls::new(&[
            [Face::Periodic; 2],
            [Face::Wall(floor), Face::Wall(Wall::specular())],
        ])
        .expect("fit"),
        weights,
        ..BoundaryConditions::default()
    };
    let density = count / (4.0 * height);
    let field = Gravity::new(vector![0.0, -pull]).expect("finite");
    let scene = grains(disk_for_unit_path(density), 1.0, Smooth, field);
    let domain = boundaries
        .walls
        .domain(vector![4.0, height])
        .expect("a box");
    let mut state: State<FallingDisks> = ideal_gas(&scene, domain, 0.0, count as usize, 1.0, 8);
    for body in &mut state.bodies {
        // Maps uniform numbers to barometric heights.
        let below = body.position[1] / height;
        body.position[1] = -(-below * -(-pull * height).exp_m1()).ln_1p() / pull;
    }
    let mut engine: DsmcEngine<FallingDisks> =
        DsmcEngine::setup(&scene, PARAMETERS, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
    let samples = 40;
    let mut fifths = [[0.0; 3]; 5];
    for sample in 0..samples {
        engine.advance(40.0 + 5.0 * f64::from(sample), u64::MAX, &mut ());
        engine.visit(|position, velocity: Vector2<f64>, (), _, weight| {
            let fifth = &mut fifths[(position[1] / 2.0) as usize];
            fifth[0] += weight / f64::from(samples);
            fifth[1] += weight * 0.5 * velocity.norm_squared() / f64::from(samples);
            fifth[2] += 1.0 / f64::from(samples);
        });
    }
    let total: f64 = fifths.iter().map(|fifth| fifth[0]).sum();
    for (number, fifth) in fifths.iter_mut().enumerate() {
        let expected = share(number as u32) / (0..5).map(share).sum::<f64>();
        let found = fifth[0] / total;
        assert!(
            (found / expected - 1.0).abs() < 0.02,
            "{number}: {found} {expected}"
        );
        fifth[1] /= fifth[0];
        assert!((fifth[1] - 1.0).abs() < 0.02, "{number}: {}", fifth[1]);
    }
    (engine, fifths)
}

/// Density of a fifth of the atmosphere over that of the lowest fifth.
fn share(fifth: u32) -> f64 {
    (-0.8 * f64::from(fifth)).exp()
}

#[test]
fn weights_do_not_change_an_atmosphere() {
    let weights = SimulatorWeights::along(1, (0..5).map(share).collect()).expect("factors");
    let count = 4000.0 / (1.0 - (-0.8_f64).exp()) * (1.0 - (-4.0_f64).exp());
    let (engine, fifths) = atmosphere(count, weights);
    assert!(engine.simulators() > 18_000);
    let fewest = fifths.iter().map(|fifth| fifth[2]).fold(f64::MAX, f64::min);
    assert!(fewest > 3000.0, "{fifths:?}");
    assert!(engine.ledgers().balanced > 100_000);
}

/// Adaptive weights keep the number of simulators in each fifth between half and twice the initial
/// mean, where fixed ones give from a fortieth to 2.8 times, and do not change the atmosphere.
#[test]
fn weights_follow_the_number() {
    let count = 32_000.0;
    let weights = SimulatorWeights::following(1, 5).expect("slices");
    let (engine, fifths) = atmosphere(count, weights);
    for (number, [_, _, simulators]) in fifths.into_iter().enumerate() {
        // A fifth may exceed its bounds until the next adaptation.
        let over_mean = simulators / (count / 5.0);
        assert!((0.45..2.1).contains(&over_mean), "{number}: {over_mean}");
    }
    assert!(engine.ledgers().balanced > 100_000);
}
