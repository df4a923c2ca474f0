//! Cross-cell schemes between open faces and walls: resumed runs, starts from an empty box, and
//! interrupted steps.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{
    BoundaryConditions, DsmcEngine, Inflow, Neighbourhood, Parameters, Scheme, SimulatorWeights,
    WallClearance,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{FallingDisks, grains, ideal_gas, law, no_gravity};
use stosszahl_model::{
    Domain, Face, Free, Interrupt, Plane, Polydisperse, Restitution, Scene, Smooth, State, Wall,
    Walls, samples,
};

use crate::support::{PARAMETERS, disk_for_unit_path};

const ACROSS: Parameters = Parameters {
    scheme: Scheme::ContactPoint { radius: None },
    cell_size: None,
    max_contact_value: 100.0,
    ..PARAMETERS
};

/// Channel between specular walls, open at both ends, with inflows of one density and drift.
fn channel(density: f64, drift: f64) -> BoundaryConditions<Plane> {
    let faces = [
        [Face::Open; 2],
        [Face::Wall(Wall::specular()); 2],
        [Face::Periodic; 2],
    ];
    let stream = |side| Inflow {
        axis: 0,
        side,
        density,
        velocity: vector![drift, 0.0],
        temperature: 1.0,
        spin_temperature: 0.0,
        like: 0,
    };
    BoundaryConditions {
        walls: Walls::new(&faces).expect("fit"),
        clearance: WallClearance::Radius,
        inflows: vec![stream(0), stream(1)],
        ..BoundaryConditions::default()
    }
}

/// A run stopped and resumed after half of its steps gives the bytes of an uninterrupted run:
/// positions, velocities, counters and ledgers.
fn stops_change_nothing(
    scene: &FallingDisks,
    parameters: Parameters,
    state: &State<FallingDisks>,
    boundaries: &BoundaryConditions<Plane>,
    steps: u64,
) {
    let streams = Streams::new(3, 0);
    let run = |stop: bool| {
        let mut engine: DsmcEngine<FallingDisks> = DsmcEngine::setup(scene, parameters, streams)
            .between(boundaries)
            .start(state)
            .expect("an engine");
        engine.advance(f64::INFINITY, steps, &mut ());
        let before = engine.simulators();
        if stop {
            let checkpoint = engine.checkpoint();
            let domain = state.domain;
            engine = DsmcEngine::setup(scene, parameters, streams)
                .between(boundaries)
                .resume(domain, checkpoint)
                .expect("an engine");
        }
        engine.advance(f64::INFINITY, steps, &mut ());
        let tiles = engine.grid().tiles();
        let ledgers = engine.ledgers().clone();
        (
            before,
            tiles,
            engine.state().bodies,
            engine.tally(),
            ledgers,
        )
    };
    let through = run(false);
    // The number of simulators at the stop differs from that at the start; tiles must not follow
    // it.
    let started = state.bodies.len() * parameters.simulators_per_particle as usize;
    assert!(through.0.abs_diff(started) > started / 5, "{}", through.0);
    assert!(through.3.collisions > 100, "{:?}", through.3);
    assert!(through == run(true));
}

#[test]
fn continued_flows_with_partners_across_cells_are_the_same_bytes() {
    let boundaries = channel(0.3, 2.0);
    let scene: FallingDisks = grains(1.0, 0.9, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![60.0, 40.0]).expect("a box");
    let state = ideal_gas(&scene, domain, 0.5, 250, 1.0, 5);
    for scheme in [ACROSS.scheme, Scheme::Esmc(Neighbourhood::Cells(1))] {
        let parameters = Parameters { scheme, ..ACROSS };
        stops_change_nothing(&scene, parameters, &state, &boundaries, 40);
    }
}

/// Sums over tiles depend in their last digits on the order of adding, and thus on the tiles.
#[test]
fn continued_sums_at_boundaries_are_the_same_bytes() {
    let faces = [[Face::Wall(Wall::specular()); 2]; 2];
    let boundaries = BoundaryConditions {
        walls: Walls::new(&[faces[0], faces[1], [Face::Periodic; 2]]).expect("fit"),
        weights: SimulatorWeights::along(0, vec![1.0, 0.25]).expect("factors"),
        ..BoundaryConditions::default()
    };
    let scene: FallingDisks = grains(disk_for_unit_path(10.0), 1.0, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![80.0, 50.0]).expect("a box");
    let state = ideal_gas(&scene, domain, 0.0, 40_000, 1.0, 5);
    stops_change_nothing(&scene, PARAMETERS, &state, &boundaries, 3);
}

/// A channel that starts empty fills by supersonic inflow: 24 d of it hold the density of the
/// stream within 10 %, which is z = 4 for 16 samples of 96 disks with Poisson noise.
#[test]
fn an_empty_channel_fills() {
    let (density, drift) = (0.05, 4.0);
    let faces = [[Face::Open; 2], [Face::Periodic; 2], [Face::Periodic; 2]];
    let boundaries = BoundaryConditions {
        walls: Walls::new(&faces).expect("fit"),
        ..channel(density, drift)
    };
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![80.0, 80.0]).expect("a box");
    let state = samples::state(domain, []);
    for copies in [1, 4] {
        let parameters = Parameters {
            simulators_per_particle: copies,
            ..ACROSS
        };
        let mut engine: DsmcEngine<FallingDisks> =
            DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        // Tiles are made for the expected number.
        assert!(engine.grid().cells() > 100);
        let mut inside = 0.0;
        for sample in 0..16 {
            engine.advance(60.0 + 10.0 * f64::from(sample), u64::MAX, &mut ());
            engine.visit(|position, _, (), _, weight| {
                inside += f64::from(u8::from((28.0..52.0).contains(&position[0]))) * weight / 16.0;
            });
        }
        let found = inside / (24.0 * 80.0);
        assert!((found / density - 1.0).abs() < 0.1, "{copies}: {found}");
        let tally = engine.tally();
        assert!(tally.collisions > 1000 && tally.trials < 100 * tally.collisions);
    }
}

/// A step of disks of very different sizes takes some 10^9 candidates: an interrupt stops it, and
/// nothing continues.
#[test]
fn a_long_step_can_be_broken_off() {
    let count = 300;
    let sizes = samples::species([(100.0, 1.0, 1), (0.01, 1e-3, count - 1)]);
    let scene: FallingDisks = Scene::new(Smooth, law(1.0), sizes, no_gravity());
    let side = 400.0;
    let body = |i: usize| {
        let turn = i as f64;
        let place = Vector2::new((37.0 * turn) % side, (61.7 * turn) % side);
        (place, vector![turn.cos(), turn.sin()])
    };
    let domain = Domain::periodic(vector![side, side]).expect("a box");
    let state = samples::state(domain, (0..count).map(body));
    for scheme in [
        ACROSS.scheme,
        Scheme::Esmc(Neighbourhood::Mean),
        Scheme::StochasticDisks { stiffness: 1.0 },
        Scheme::Boltzmann,
    ] {
        let parameters = Parameters {
            scheme,
            simulators_per_particle: 64,
            cell_size: Some(200.0),
            steps_per_cell_crossing: 1.0,
            ..ACROSS
        };
        let mut engine =
            DsmcEngine::<FallingDisks>::new(&scene, parameters, &state, Streams::new(1, 0))
                .expect("an engine");
        let interrupt = Interrupt::default();
        interrupt.raise();
        engine.set_stop_flag(&interrupt);
        assert!(!engine.is_interrupted());
        assert!(!engine.advance(1e6, u64::MAX, &mut ()));
        assert!(engine.is_interrupted());
        let (steps, collisions) = (engine.tally().steps, engine.tally().collisions);
        assert!(steps <= 1 && collisions < 10_000, "{steps} {collisions}");
        // Half a step is not a state to continue from.
        engine.set_stop_flag(&Interrupt::default());
        assert!(!engine.advance(1e6, u64::MAX, &mut ()));
        assert_eq!(engine.tally().steps, steps);
    }
}

/// Elastic law that raises an interrupt at the tenth collision.
#[derive(Clone, Debug, Default)]
struct Tenth(Interrupt, Arc<AtomicU64>);

impl Restitution for Tenth {
    fn normal_restitution(&self, _approach: f64) -> f64 {
        if self.1.fetch_add(1, Ordering::Relaxed) == 9 {
            self.0.raise();
        }
        1.0
    }
}

/// A search for the partner of a large disk takes long; none starts after the interrupt is raised.
#[test]
fn no_partner_of_unequal_disks_is_sought_after_an_interrupt() {
    let sizes = (0..400).map(|i| (if i == 0 { 5.0 } else { 0.5 }, 1.0));
    let law = Tenth::default();
    let sizes = Polydisperse::new(sizes.collect()).expect("sizes");
    let scene: Scene<Plane, _, _, _, _> = Scene::new(Smooth, law.clone(), sizes, Free);
    let domain = Domain::periodic(vector![60.0, 60.0]).expect("a box");
    let state = ideal_gas(&scene, domain, 0.0, 400, 1.0, 3);
    let mut engine: DsmcEngine<_> =
        DsmcEngine::new(&scene, ACROSS, &state, Streams::new(1, 0)).expect("an engine");
    engine.set_stop_flag(&law.0);
    assert!(!engine.advance(1e6, u64::MAX, &mut ()));
    assert_eq!(law.1.load(Ordering::Relaxed), 10);
}
