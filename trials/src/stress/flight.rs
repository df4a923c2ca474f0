//! Hard cases of Monte Carlo free flight over long times, and of bitwise equality with any number
//! of threads and after a restart.

use rand::RngExt;
use rayon::ThreadPoolBuilder;
use stosszahl_dsmc::{DsmcCheckpoint, DsmcEngine, Scheme};
use stosszahl_model::State;
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{EqualDisks, state};

use super::schemes::{Setup, engine, setups, uniform, warm};
use crate::gas::{disks, domain, mixture, random, scattered};
use crate::{Done, TrialError, TrialLog};

trials! {
    "free-flight" => free_flight,
        "1e5 steps of nothing but free flight, 5 disks in square boxes and in boxes of 1 : 1000 and 1000 : 1, of one, two and many \
         cells; steps of the engine's own and held at 0.37",
        "positions to 1e-11 L of x0 + v t, whose product is exact; velocities the same bits";
    "threads" => threads,
        "20 160 simulators in few and many tiles, by 1, 2 and 3 threads, restitution 0.9, packing 0.2, 2 steps; every scheme",
        "the same bytes of the checkpoint with any number of threads; with other tiles the same gas, unless partners are across cells";
    "kills" => kills,
        "the same gas and one of 300, ended after legs of 1 and 2 steps and begun again from bytes; every scheme",
        "the bytes of the gas that goes on in memory";
}

/// Returns the distance of the coordinate `place` from `from` + v t along a periodic axis
/// \[length\]. The products v t and n L for n box lengths L are exact, as sums of two numbers.
fn off(from: f64, velocity: f64, time: f64, length: f64, place: f64) -> f64 {
    let way = velocity * time;
    let way_rest = velocity.mul_add(time, -way);
    let rounds = ((from - place + way) / length).round();
    let ring = rounds * length;
    let ring_rest = rounds.mul_add(length, -ring);
    ((way - ring) + (from - place) + (way_rest - ring_rest)).abs()
}

fn free_flight(log: &mut TrialLog) -> Done {
    let steps = if log.effort.long { 10_000_000 } else { 100_000 };
    let mut worst = 0.0_f64;
    let boxes = [
        ([30.0, 30.0], None),
        ([30.0, 30.0], Some(30.0)),
        ([30.0, 30.0], Some(15.0)),
        ([1.0, 1000.0], Some(1000.0)),
        ([1.0, 1000.0], Some(500.0)),
        ([1000.0, 1.0], Some(500.0)),
        ([1000.0, 1.0], Some(20.0)),
    ];
    for (sides, cell_size) in boxes {
        for step in [0.0, 0.37] {
            let [width, height] = sides;
            about!(log; "{width} x {height}, cells {cell_size:?}, step {step}");
            let mut parameters = setups()[0].parameters;
            parameters.scheme = Scheme::Collisionless;
            parameters.cell_size = cell_size;
            let mut stream = random(10);
            let places = scattered(5, [0.0; 2], sides, &mut stream);
            let equal = warm(domain(width, height)?, places, 10)?;
            // Equal disks have no identity; with sizes of their own, even equal ones, they keep
            // their order.
            let scene = mixture(vec![(0.5, 1.0); equal.bodies.len()], 1.0)?;
            let bodies = equal
                .bodies
                .iter()
                .map(|body| (body.position, body.velocity));
            let mut start = state(equal.domain, bodies);
            start.time = stream.random::<f64>();
            let mut engine = DsmcEngine::new(&scene, parameters, &start, Streams::new(1, 0))?;
            engine.hold_step(step);
            engine.advance(f64::INFINITY, steps, &mut ());
            let time = engine.time() - start.time;
            let end = engine.state();
            let mut most = 0.0_f64;
            for (before, after) in start.bodies.iter().zip(&end.bodies) {
                must!(log, before.velocity == after.velocity; "another velocity");
                for (axis, side) in sides.into_iter().enumerate() {
                    let [from, to] = [before, after].map(|body| body.position[axis]);
                    most = most.max(off(from, before.velocity[axis], time, side, to) / side);
                }
            }
            log.at_most("off", most, 1e-11);
            worst = worst.max(most);
        }
    }
    found!(log; "{steps} steps each, off by {worst:.1e} L at most");
    Ok(())
}

fn gas_of(setup: Setup, simulators: usize) -> Result<State<EqualDisks>, TrialError> {
    uniform(
        simulators / setup.parameters.simulators_per_particle as usize,
        0.2,
        11,
    )
}

/// Returns the serialised checkpoint of a Monte Carlo engine.
fn checkpoint_bytes(engine: &DsmcEngine<EqualDisks>) -> Result<Vec<u8>, TrialError> {
    Ok(postcard::to_allocvec(&engine.checkpoint())?)
}

fn threads(log: &mut TrialLog) -> Done {
    let mut other = Vec::new();
    for setup in setups() {
        let start = gas_of(setup, 20_160)?;
        let mut ends = Vec::new();
        for tile in [8_000, 500] {
            about!(log; "{}, tiles of {tile}", setup.name);
            let mut one = Vec::new();
            for threads in [1, 2, 3] {
                let mut engine = engine(setup, 0.9, &start)?;
                engine.retile(tile);
                let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
                pool.install(|| engine.advance(f64::INFINITY, 2, &mut ()));
                let bytes = checkpoint_bytes(&engine)?;
                if threads == 1 {
                    one = bytes;
                    ends.push(engine.state().bodies);
                } else {
                    must!(log, bytes == one; "other bytes with {threads} threads");
                }
            }
        }
        if ends.iter().any(|end| *end != ends[0]) {
            must!(log, setup.parameters.scheme.is_cross_cell(); "another gas with other tiles");
            other.push(setup.name);
        }
    }
    found!(log; "another gas with other tiles: {}", other.join(", "));
    Ok(())
}

fn kills(log: &mut TrialLog) -> Done {
    for simulators in [304, 20_160] {
        for setup in setups() {
            about!(log; "{} of {simulators}", setup.name);
            let start = gas_of(setup, simulators)?;
            let mut steady = engine(setup, 0.9, &start)?;
            let mut killed = checkpoint_bytes(&steady)?;
            for leg in [1, 2] {
                steady.advance(f64::INFINITY, leg, &mut ());
                let (scene, streams) = (disks(0.9)?, Streams::new(1, 0));
                let from: DsmcCheckpoint<EqualDisks> = postcard::from_bytes(&killed)?;
                let mut engine = DsmcEngine::<EqualDisks>::setup(&scene, setup.parameters, streams)
                    .resume(start.domain, from)?;
                engine.advance(f64::INFINITY, leg, &mut ());
                killed = checkpoint_bytes(&engine)?;
                let same = killed == checkpoint_bytes(&steady)?;
                must!(log, same; "other bytes after {leg} steps");
            }
        }
    }
    log.found("two gases, two legs each");
    Ok(())
}
