//! Tests of the engine as a whole.

mod plain;

use nalgebra::Vector2;
use rand::RngExt;
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::samples::{EqualDisks, SmoothParticles, equal};
use stosszahl_model::{
    Collision, Domain, Free, Observer, ParticleModel, ParticleState, Plane, Sizes, Smooth, Space,
    State, VectorOf, Volume, samples,
};

use crate::{
    DsmcEngine, Neighbourhood, Parameters, PartnerDisplacement, Scheme, SimulatorStart, Tracked,
    Untracked,
};
use plain::Plain;

/// State with positions uniform in a box, and velocity components uniform from -1 to 1.
pub(crate) fn start<P: ParticleModel>(count: usize, sides: VectorOf<P>, seed: u64) -> State<P> {
    let mut stream = Streams::new(seed, 0).stream_at(Purpose::Placement, [0, 0]);
    let mut vector = |low: f64, high: VectorOf<P>| {
        P::Space::from_components(|axis| low + (high[axis] - low) * stream.random::<f64>())
    };
    let ones = P::Space::from_components(|_| 1.0);
    let bodies = (0..count).map(|_| (vector(0.0, sides), vector(-1.0, ones)));
    samples::state(Domain::periodic(sides).expect("a box"), bodies)
}

/// The mean of independent values and its standard error.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

pub(crate) fn in_pool<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().expect("threads").install(work)
}

const PARAMETERS: Parameters = Parameters {
    scheme: Scheme::Boltzmann,
    displacement: PartnerDisplacement::None,
    cell_size: Some(2.0),
    simulators_per_particle: 1,
    copies: SimulatorStart::Independent,
    steps_per_cell_crossing: 4.0,
    max_contact_value: 10.0,
};

/// Compares the engine with the plain one after two runs, and again for other tiles.
fn compare<P>(scene: &P, parameters: Parameters, sides: VectorOf<P>, count: usize, step: f64)
where
    P: ParticleModel<Surface = Smooth, Field = Free>,
{
    let state = start::<P>(count, sides, 1);
    let streams = Streams::new(3, 0);
    for per_tile in [1, 40, 4096] {
        let mut engine = DsmcEngine::new(scene, parameters, &state, streams).expect("an engine");
        engine.retile(per_tile);
        engine.hold_step(step);
        let counts = engine.grid().counts().map(|count| count as usize);
        let mut plain = Plain::new(scene, parameters, &state, streams, counts);
        let mut collisions = 0;
        for (first, steps) in [(0, 7), (7, 5)] {
            engine.advance(f64::INFINITY, steps, &mut ());
            collisions += plain.advance(steps, first, step);
            let found = engine.state();
            let mut bodies = found.bodies.clone();
            for (order, (position, velocity, index)) in plain.members.iter().enumerate() {
                let index = P::Sizes::index_of(scene.sizes().tag_of(*index), order);
                bodies[index] = ParticleState::new(*position, *velocity);
            }
            assert_eq!(found.bodies, bodies, "tiles {:?}", engine.grid().tiles());
        }
        assert_eq!(engine.tally().collisions, collisions);
        assert!(collisions > 100, "{collisions}");
    }
}

#[test]
fn disks_are_those_of_the_plain_engine() {
    for (scheme, displacement) in [
        (Scheme::Boltzmann, PartnerDisplacement::None),
        (Scheme::FreeVolume, PartnerDisplacement::Diameter),
        (
            Scheme::Enskog(Neighbourhood::Cells(1)),
            PartnerDisplacement::Inelastic,
        ),
    ] {
        let parameters = Parameters {
            scheme,
            displacement,
            ..PARAMETERS
        };
        let sides = Vector2::new(30.0, 22.0);
        compare(&equal::<Plane>(0.8), parameters, sides, 400, 0.3125);
    }
}

/// Steps so long that many simulators cross several tiles, or the box.
#[test]
fn far_flyers_are_those_of_the_plain_engine() {
    let sides = Vector2::new(30.0, 22.0);
    compare(&equal::<Plane>(0.8), PARAMETERS, sides, 400, 50.0);
}

#[test]
fn spheres_are_those_of_the_plain_engine() {
    let sides = nalgebra::Vector3::new(9.0, 14.0, 11.0);
    for scheme in [Scheme::Boltzmann, Scheme::Enskog(Neighbourhood::Cells(1))] {
        let parameters = Parameters {
            scheme,
            ..PARAMETERS
        };
        compare(&equal::<Volume>(1.0), parameters, sides, 600, 0.3125);
    }
}

#[test]
fn mixtures_are_those_of_the_plain_engine() {
    for scheme in [Scheme::FreeVolume, Scheme::Enskog(Neighbourhood::Cells(1))] {
        let parameters = Parameters {
            scheme,
            displacement: PartnerDisplacement::Diameter,
            ..PARAMETERS
        };
        let sides = Vector2::new(25.0, 22.0);
        let sizes = [(0.5, 1.0), (0.25, 0.2)].into_iter().cycle();
        let scene = samples::mixture(0.9, sizes.take(400));
        compare(&scene, parameters, sides, 400, 0.4375);
    }
}

/// Observer that records all collisions.
#[derive(Default, PartialEq, Debug)]
pub(crate) struct Seen(pub(crate) Vec<Collision>);

impl Observer for Seen {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.0.extend_from_slice(batch);
    }
}

/// With many simulators, so that threads are used: bytes, counters and observed collisions are
/// equal for one, two and three threads; with adaptive steps, through a stop in between, and with
/// displacements tracked.
#[test]
fn threads_and_stops_change_nothing() {
    for scheme in [Scheme::Boltzmann, Scheme::Enskog(Neighbourhood::Cells(2))] {
        let parameters = Parameters {
            scheme,
            displacement: PartnerDisplacement::Diameter,
            ..PARAMETERS
        };
        let scene = equal::<Plane>(0.8);
        let state = start::<EqualDisks>(30_000, Vector2::new(300.0, 310.0), 2);
        let streams = Streams::new(5, 0);
        let run = |threads: usize, stop: bool| {
            in_pool(threads, || {
                let mut seen = Seen::default();
                let mut engine = DsmcEngine::<_, Tracked>::setup(&scene, parameters, streams)
                    .start(&state)
                    .expect("an engine");
                engine.advance(f64::INFINITY, 6, &mut seen);
                if stop {
                    let checkpoint = engine.checkpoint();
                    let domain = state.domain;
                    engine = DsmcEngine::setup(&scene, parameters, streams)
                        .resume(domain, checkpoint)
                        .expect("an engine");
                }
                engine.advance(f64::INFINITY, 6, &mut seen);
                let ways = engine.displacements();
                (
                    engine.state().bodies,
                    engine.tally(),
                    engine.time(),
                    ways,
                    seen,
                )
            })
        };
        let alone = run(1, false);
        assert!(alone.1.collisions > 10_000, "{:?}", alone.1);
        assert_eq!(alone.4.0.len() as u64, alone.1.collisions);
        for (threads, stop) in [(1, true), (2, false), (2, true), (3, false)] {
            assert!(alone == run(threads, stop), "{threads} threads, {stop}");
        }
    }
}

/// Adaptive steps and counters do not depend on the tiles; only sums are added in another order.
#[test]
fn tiles_change_nothing() {
    let state = start::<EqualDisks>(5000, Vector2::new(150.0, 90.0), 4);
    let run = |per_tile: usize| {
        let mut engine = DsmcEngine::new(&equal(0.7), PARAMETERS, &state, Streams::new(5, 0))
            .expect("an engine");
        engine.retile(per_tile);
        engine.advance(f64::INFINITY, 60, &mut ());
        (engine.state().bodies, engine.time(), engine.tally())
    };
    let (bodies, time, tally) = run(4096);
    for per_tile in [1, 17, 300, 1_000_000] {
        let (other_bodies, other_time, other) = run(per_tile);
        assert_eq!((&bodies, time), (&other_bodies, other_time), "{per_tile}");
        assert_eq!(
            (tally.trials, tally.collisions),
            (other.trials, other.collisions)
        );
        assert!((tally.separation / other.separation - 1.0).abs() < 1e-12);
        assert!((tally.virial / other.virial - 1.0).abs() < 1e-12);
    }
}

/// Memory of the whole engine per simulator, for smooth equal disks: 32 bytes are the record
/// itself.
#[test]
fn a_simulator_takes_at_most_48_bytes() {
    for (per_cell, scheme) in [
        (10.0, Scheme::Boltzmann),
        (10.0, Scheme::FreeVolume),
        (10.0, Scheme::Enskog(Neighbourhood::Cells(2))),
        (1.27, Scheme::FreeVolume),
    ] {
        let count = 200_000;
        let side = (count as f64 / per_cell).sqrt() * 2.0;
        let state = start::<EqualDisks>(count, Vector2::new(side, side), 7);
        let parameters = Parameters {
            scheme,
            ..PARAMETERS
        };
        let mut engine = DsmcEngine::new(&equal(1.0), parameters, &state, Streams::new(1, 0))
            .expect("an engine");
        for _ in 0..3 {
            engine.advance(f64::INFINITY, 20, &mut ());
            let each = engine.memory_bytes() as f64 / count as f64;
            assert!(each <= 48.0, "{each} bytes with {scheme:?}");
        }
    }
}

/// Free flight for 1e5 steps gives `x_0` + v t to 1e-11 of the box, the accumulated rounding of 1e5
/// additions.
#[test]
fn free_flight_is_exact() {
    let state = start::<EqualDisks>(40, Vector2::new(12.0, 10.0), 9);
    let parameters = Parameters {
        scheme: Scheme::Collisionless,
        ..PARAMETERS
    };
    let mut engine = DsmcEngine::<_, Tracked>::setup(&equal(1.0), parameters, Streams::new(1, 0))
        .start(&state)
        .expect("an engine");
    engine.retile(1);
    engine.hold_step(0.013);
    for _ in 0..10 {
        engine.advance(f64::INFINITY, 10_000, &mut ());
    }
    assert_eq!(engine.tally().steps, 100_000);
    let found = engine.state();
    let time = engine.time();
    for body in &found.bodies {
        let known = state
            .bodies
            .iter()
            .find(|known| known.velocity == body.velocity)
            .expect("its velocity");
        let expected = state.domain.wrap(known.position + known.velocity * time);
        let missed = state.domain.distance(body.position, expected);
        assert!(missed < 1.2e-10, "{missed}");
    }
}

/// Elastic spheres have the rate, energy and momentum of theory. Sixteen gases; z = 4 standard
/// errors of the mean, which must be below 0.1 %. Cells of about 400 simulators: the finite number
/// changes the rate by 1/400 at most, and n(n - 1) of an ideal gas corrects it exactly.
#[test]
fn spheres_collide_at_the_rate_of_theory() {
    let (count, side) = (20_000, 40.0);
    let mut rates = Vec::new();
    for seed in 0..16 {
        let sides = nalgebra::Vector3::new(side, side, side);
        let mut state = start::<SmoothParticles<Volume>>(count, sides, seed);
        let mut stream = Streams::new(seed, 0).stream_at(Purpose::Velocities, [0, 0]);
        let scene = equal::<Volume>(1.0);
        stosszahl_model::initial::maxwellian(&scene, &mut state, 1.0, &mut stream);
        let parameters = Parameters {
            cell_size: Some(10.0),
            ..PARAMETERS
        };
        let mut engine =
            DsmcEngine::<_, Untracked>::setup(&scene, parameters, Streams::new(seed, 0))
                .start(&state)
                .expect("an engine");
        engine.advance(4.0, u64::MAX, &mut ());
        let packing = state.packing_fraction(&scene);
        let rate = 2.0 * engine.tally().collisions as f64 / count as f64 / engine.time();
        rates.push(rate / Volume::collision_rate(packing, 1.0));
        let end = engine.state();
        // Random walk of 1e5 roundings.
        let energy = end.kinetic_energy(&scene) / state.kinetic_energy(&scene);
        assert!((energy - 1.0).abs() < 1e-13, "{energy}");
        assert!(end.momentum(&scene).norm() < 1e-10);
    }
    let (mean, error) = mean_and_error(&rates);
    assert!(error < 0.001, "the error {error} is too wide");
    assert!((mean - 1.0).abs() < 4.0 * error, "{mean} ± {error}");
}

/// Collisional virial follows from the displacement: without it, pairs within a cell carry no
/// momentum on average; with it, elastic disks carry Z - 1 = (pi/2) n d^2 chi at the rate of
/// theory.
#[test]
fn virial_is_that_of_the_displacement() {
    let count = 20_000;
    let side = 400.0;
    for displacement in [PartnerDisplacement::None, PartnerDisplacement::Diameter] {
        let state = start::<EqualDisks>(count, Vector2::new(side, side), 3);
        let scene = equal::<Plane>(1.0);
        let parameters = Parameters {
            displacement,
            cell_size: Some(10.0),
            steps_per_cell_crossing: 20.0,
            ..PARAMETERS
        };
        let mut engine =
            DsmcEngine::new(&scene, parameters, &state, Streams::new(1, 0)).expect("an engine");
        engine.advance(40.0, u64::MAX, &mut ());
        let temperature = state.temperature(&scene);
        let scale = 2.0 * count as f64 * temperature * engine.time();
        let excess = engine.tally().virial / scale;
        let rate = 2.0 * engine.tally().collisions as f64 / count as f64 / engine.time();
        // omega = 4 (Z - 1) sqrt(T)/sqrt(pi).
        let expected = rate * std::f64::consts::PI.sqrt() / (4.0 * temperature.sqrt());
        let expected = if displacement == PartnerDisplacement::None {
            0.0
        } else {
            expected
        };
        // Each collision carries momentum over up to a cell width, with random sign: a spread of
        // about 6 d . 1.5 sqrt(T), and 4.4 standard errors of the mean.
        let spread = 9.0 * temperature.sqrt() * (engine.tally().collisions as f64).sqrt() / scale;
        assert!(
            (excess - expected).abs() < 4.4 * spread,
            "{excess} {expected} ± {spread}"
        );
        assert!(4.4 * spread < 0.3 * rate, "{spread} is too wide");
    }
}
