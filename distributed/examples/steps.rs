//! Seconds of a step of one gas in several processes, and their use: steps only, without start,
//! sample or checkpoint.
//!
//!     cargo build --release -p stosszahl-mpi --features mpi --example steps
//!     RAYON_NUM_THREADS=2 mpirun -n 1 target/release/examples/steps dilute 1000000 50 7
//!     RAYON_NUM_THREADS=1 mpirun -n 2 target/release/examples/steps dilute 1000000 50 7
//!
//! Arguments: the gas (`dilute`, `contact`, `channel`; `disks` and `spheres`: the work of
//! `stosszahl-trials bench dsmc`), number of simulators, steps between two readings of the clock,
//! and number of readings.

#![allow(clippy::print_stdout, reason = "a program that says what it measured")]

#[allow(dead_code, reason = "steps need not all of it")]
#[path = "../src/world.rs"]
mod world;

use std::env;
use std::sync::Arc;
use std::time::Instant;

use mpi::Threading;
use nalgebra::vector;
use rand::RngExt as _;
use stosszahl::dsmc::{
    BoundaryConditions, DsmcEngine, Inflow, Parameters, PartnerDisplacement, Ranks, Scheme,
    SimulatorStart,
};
use stosszahl::model::random::{Purpose, Streams};
use stosszahl::model::{
    Constant, Domain, Face, Free, Monodisperse, ParticleModel, ParticleState, Plane, Rebound,
    Scene, Smooth, Space, State, Volume, Wall, Walls,
};

use world::World;

type Equal<S> = Scene<S, Smooth, Constant, Monodisperse, Free>;

fn equal<S: Space>(radius: f64, restitution: f64) -> Equal<S> {
    Scene {
        space: S::default(),
        surface: Smooth,
        restitution: Constant::new(restitution).expect("a coefficient"),
        sizes: Monodisperse { radius, mass: 1.0 },
        field: Free,
    }
}

/// Creates uniform positions, and velocities of a temperature of about one.
fn start<S: Space>(count: usize, domain: Domain<S>) -> State<Equal<S>> {
    let mut stream = Streams::new(1, 0).stream_at(Purpose::Placement, [0, 0]);
    let mut body = || {
        let (mut position, mut velocity) = (S::Vector::default(), S::Vector::default());
        for axis in 0..S::DIMENSION {
            position[axis] = domain.lengths()[axis] * stream.random::<f64>();
            velocity[axis] = (0..12).map(|_| stream.random::<f64>()).sum::<f64>() - 6.0;
        }
        ParticleState::new(position, velocity)
    };
    State {
        time: 0.0,
        domain,
        bodies: (0..count).map(|_| body()).collect(),
    }
}

fn parameters(scheme: Scheme, cell: Option<f64>) -> Parameters {
    Parameters {
        scheme,
        displacement: PartnerDisplacement::None,
        cell_size: cell,
        simulators_per_particle: 1,
        copies: SimulatorStart::Independent,
        steps_per_cell_crossing: 4.0,
        max_contact_value: 10.0,
    }
}

/// Creates a square of disks at a packing fraction.
fn in_a_box(count: usize, packing: f64, scheme: Scheme) -> DsmcEngine<Equal<Plane>> {
    let side = (count as f64 * std::f64::consts::FRAC_PI_4 / packing).sqrt();
    let domain = Domain::periodic(vector![side, side]).expect("a box");
    let streams = Streams::new(1, 0);
    let state = start(count, domain);
    DsmcEngine::setup(&equal(0.5, 0.9), parameters(scheme, None), streams)
        .start(&state)
        .expect("an engine")
}

/// Creates elastic particles, 10 in a cell of half a mean free path, with 0.07 pair collisions for
/// each in a step.
fn elastic<S: Space>(count: usize) -> DsmcEngine<Equal<S>> {
    const PER_CELL: f64 = 10.0;
    let (path, dimension) = (S::mean_free_path(1.0, 1.0), S::DIMENSION as f64);
    let power = (0.5 * path).powf(dimension) / (S::particle_volume(0.5) * PER_CELL);
    let packing = power.powf(1.0 / (dimension - 1.0));
    let cell = 0.5 * path / packing;
    let cells = (count as f64 / PER_CELL).powf(1.0 / dimension).round();
    let side = cell * cells;
    let domain = Domain::periodic(S::from_components(|_| side)).expect("a box");
    let state = start((PER_CELL * cells.powf(dimension)).round() as usize, domain);
    let parameters = parameters(Scheme::Boltzmann, Some(cell));
    let (scene, streams) = (equal(0.5, 1.0), Streams::new(1, 0));
    let mut engine = DsmcEngine::setup(&scene, parameters, streams)
        .start(&state)
        .expect("an engine");
    engine.hold_step(0.14 / S::collision_rate(packing, 1.0));
    engine
}

/// Creates spheres that flow in on the left, between two walls.
fn in_a_channel(count: usize) -> DsmcEngine<Equal<Volume>> {
    let side = (count as f64 / 2000.0).cbrt();
    let sides = vector![8.0 * side, 4.0 * side, 0.25 * side];
    let density = count as f64 / (sides[0] * sides[1] * sides[2]);
    let wall = || Face::Wall(Wall::<Volume>::still(Rebound::Diffuse { temperature: 1.0 }));
    let faces = [[Face::Open; 2], [wall(), wall()], [Face::Periodic; 2]];
    let walls = Walls::new(&faces).expect("faces");
    let domain = walls.domain(sides).expect("a box");
    let boundaries = BoundaryConditions {
        walls,
        inflows: vec![Inflow {
            axis: 0,
            side: 0,
            density,
            velocity: vector![3.0, 0.0, 0.0],
            temperature: 1.0,
            spin_temperature: 1.0,
            like: 0,
        }],
        ..BoundaryConditions::default()
    };
    // Diameter for a mean free path of one.
    let diameter = (density * std::f64::consts::PI * std::f64::consts::SQRT_2)
        .sqrt()
        .recip();
    let mut state = start(count, domain);
    for body in &mut state.bodies {
        body.velocity[0] += 3.0;
    }
    let parameters = parameters(Scheme::Boltzmann, Some(0.25));
    let (scene, streams) = (equal(0.5 * diameter, 0.9), Streams::new(1, 0));
    DsmcEngine::setup(&scene, parameters, streams)
        .between(&boundaries)
        .start(&state)
        .expect("an engine")
}

/// Prints the milliseconds of a step, several times, in the root process.
fn measure<P: ParticleModel>(
    mut engine: DsmcEngine<P>,
    world: &Arc<World>,
    steps: u64,
    looks: usize,
) {
    if world.size() > 1 {
        engine.distribute_among(world.clone());
    }
    engine.advance(f64::INFINITY, 3 * steps.min(20), &mut ());
    let before = world.traffic();
    let mut times: Vec<f64> = (0..looks)
        .map(|_| {
            let began = Instant::now();
            engine.advance(f64::INFINITY, steps, &mut ());
            1e3 * began.elapsed().as_secs_f64() / steps as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let after = world.traffic();
    let all = steps as f64 * looks as f64;
    println!(
        "rank {} of {}: {:.3} ms (least {:.3}, most {:.3}); in exchanges {:.3} ms, rounds {:.2}, bytes {:.0}",
        world.rank(),
        world.size(),
        times[looks / 2],
        times[0],
        times[looks - 1],
        1e3 * (after.seconds - before.seconds) / all,
        (after.rounds - before.rounds) as f64 / all,
        (after.bytes - before.bytes) as f64 / all,
    );
}

fn main() {
    let (_universe, _) = mpi::initialize_with_threading(Threading::Serialized).expect("MPI");
    let arguments: Vec<String> = env::args().skip(1).collect();
    let number = |place: usize, otherwise: u64| {
        let given = arguments.get(place).and_then(|text| text.parse().ok());
        given.unwrap_or(otherwise)
    };
    let (count, steps, looks) = (number(1, 100_000), number(2, 50), number(3, 5));
    let (count, looks) = (count as usize, looks as usize);
    let world = Arc::new(World::new());
    match arguments.first().map(String::as_str) {
        Some("contact") => {
            let engine = in_a_box(count, 0.2, Scheme::CONTACT_POINT);
            measure(engine, &world, steps, looks);
        }
        Some("disks") => measure(elastic::<Plane>(count), &world, steps, looks),
        Some("spheres") => measure(elastic::<Volume>(count), &world, steps, looks),
        Some("channel") => measure(in_a_channel(count), &world, steps, looks),
        _ => {
            let engine = in_a_box(count, 0.01, Scheme::Boltzmann);
            measure(engine, &world, steps, looks);
        }
    }
}
