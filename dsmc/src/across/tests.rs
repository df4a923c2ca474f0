//! Partners across cells: against a plain search, against theory, and for any number of threads.

use nalgebra::Vector2;
use rand::SeedableRng;
use rand_xoshiro::Xoroshiro128PlusPlus;
use stosszahl_model::random::Streams;
use stosszahl_model::{Plane, Space, State};

use super::partners::Search;
use super::shared::{At, sweep_around};
use super::speeds::{Speeds, patches};
use crate::tests::{Equal, Seen, equal, in_pool, start};
use crate::{Copies, Displacement, Engine, Followed, Neighbourhood, Parameters, Scheme};

const PARAMETERS: Parameters = Parameters {
    scheme: Scheme::ContactPoint { radius: None },
    displacement: Displacement::None,
    cell_size: None,
    simulators_per_disk: 1,
    copies: Copies::Independent,
    steps_per_crossing: 8.0,
    largest_contact_value: 100.0,
};

const SCHEMES: [Scheme; 3] = [
    Scheme::ContactPoint { radius: None },
    Scheme::Esmc(Neighbourhood::Cells(1)),
    Scheme::StochasticDisks { stiffness: 2.0 },
];

/// In each of several boxes, wide and narrow: partners are among those within the radius, each as often as any other, or
/// the nearest of all where there is none, as a search through all says.
#[test]
fn partners_are_those_of_a_plain_search() {
    for (sides, count) in [([40.0, 30.0], 300), ([60.0, 3.0], 60), ([1.5, 2.5], 5)] {
        let state = start::<Equal<Plane>>(count, Vector2::from(sides), 9);
        for radius in [0.0, 1.0, 2.5] {
            let parameters = Parameters {
                scheme: Scheme::ContactPoint {
                    radius: Some(radius),
                },
                ..PARAMETERS
            };
            let mut engine = Engine::new(&equal(1.0), parameters, &state, Streams::new(1, 0))
                .expect("an engine");
            engine.retile(40);
            let grid = engine.grid.clone();
            let domain = state.domain;
            let all = engine.state().bodies;
            let (mut expected, mut squares) = (0.0, 0.0);
            let results = sweep_around(false, &grid, &mut engine.tiles, |number, around| {
                let mut stream = Xoroshiro128PlusPlus::seed_from_u64(number as u64);
                let mut search = Search::new(&grid, radius);
                let home = around.tile(around.middle());
                let mut results = Vec::new();
                for index in 0..home.simulators.len() as u32 {
                    let who = At {
                        tile: around.middle(),
                        index,
                    };
                    let own = home.simulators[index as usize].position;
                    let point = own + Plane::random_direction(&mut stream);
                    let place = |at: At| around.read(at).position;
                    let near: Vec<_> = all
                        .iter()
                        .map(|body| body.position)
                        .filter(|&at| at != own && domain.distance(at, point) < radius)
                        .collect();
                    let mut draw = || search.partner(&around, point, who, &mut stream).map(place);
                    if near.is_empty() {
                        let nearest = all
                            .iter()
                            .map(|body| body.position)
                            .filter(|&at| at != own)
                            .map(|at| domain.distance(at, point))
                            .fold(f64::MAX, f64::min);
                        match draw() {
                            Some(at) => {
                                assert!((domain.distance(at, point) - nearest).abs() < 1e-12);
                            }
                            // Beyond three cells nobody is sought.
                            None => assert!(nearest > 3.0 * grid.width().min() - 1e-9),
                        }
                        continue;
                    }
                    let mut counts = vec![0.0; near.len()];
                    let draws = 40 * near.len();
                    for _ in 0..draws {
                        let at = draw().expect("there is one");
                        let found = near.iter().position(|&other| other == at);
                        counts[found.expect("it is near")] += 1.0;
                    }
                    let square = counts
                        .iter()
                        .map(|n: &f64| (n - 40.0).powi(2) / 40.0)
                        .sum::<f64>();
                    results.push((near.len() as f64 - 1.0, square));
                }
                results
            });
            for (freedom, square) in results.into_iter().flatten() {
                expected += freedom;
                squares += square;
            }
            // Chi-squared of so many degrees of freedom f: f, and its standard deviation sqrt(2 f); z = 4.4, and some for
            // the skew where f is small.
            let allowed = 4.4 * (2.0_f64 * expected).sqrt() + 10.0;
            assert!((squares - expected).abs() < allowed, "{squares} {expected}");
        }
    }
}

/// The bound of each cell is the largest speed within reach as a look at all simulators finds it, also when one becomes fast.
#[test]
fn bounds_of_speed_are_those_of_a_plain_search() {
    for (sides, count, per_tile) in [
        ([60.0, 50.0], 900, 300),
        ([60.0, 6.0], 120, 40),
        ([2.5, 3.5], 5, 5),
    ] {
        let state = start::<Equal<Plane>>(count, Vector2::from(sides), 4);
        let mut engine =
            Engine::new(&equal(1.0), PARAMETERS, &state, Streams::new(1, 0)).expect("an engine");
        engine.retile(per_tile);
        let grid = engine.grid.clone();
        let all = engine.state().bodies;
        let width = grid.width();
        let counts = grid.counts();
        let is_in_reach = |one: [u32; 3], other: [u32; 3]| {
            (0..2).all(|axis| {
                let apart = one[axis].abs_diff(other[axis]);
                let around = apart.min(counts[axis] - apart);
                f64::from(around) <= (grid.reach() / width[axis]).ceil()
            })
        };
        let cells = sweep_around(false, &grid, &mut engine.tiles, |_, around| {
            let mut cells = 0;
            for patch in patches(&around.tile(around.middle()).place) {
                let mut speeds = Speeds::new(&grid, &around, patch);
                let plain = |speeds: &Speeds<Plane>, cell| {
                    (all.iter())
                        .filter(|body| is_in_reach(cell, grid.cell_at(body.position)))
                        .map(|body| speeds.square(body.velocity).sqrt())
                        .fold(0.0, f64::max)
                };
                for cell in patch.cells() {
                    assert_eq!(speeds.spread(cell), plain(&speeds, cell));
                    cells += 1;
                }
                let Some(cell) = patch.cells().next() else {
                    continue;
                };
                // A neighbour, around the box where the cell is at its edge.
                let hot = [(cell[0] + counts[0] - 1) % counts[0], cell[1], cell[2]];
                let velocity = speeds.middle() + Vector2::new(30.0, 40.0);
                speeds.note(hot, velocity);
                for cell in patch.cells() {
                    let expected = if is_in_reach(cell, hot) {
                        speeds.square(velocity).sqrt()
                    } else {
                        plain(&speeds, cell)
                    };
                    assert_eq!(speeds.spread(cell), expected);
                }
            }
            cells
        });
        assert_eq!(cells.iter().sum::<usize>(), grid.cells());
    }
}

/// The rate and the pressure of the elastic gas are Enskog's, with one simulator per disk in cells of two diameters, and with
/// eight: 1 % and 2 %, 0.5 % and 1 %. Twelve gases; the standard errors must be a third of that at most.
#[test]
fn elastic_rate_and_pressure_are_enskogs() {
    for (simulators, disks, rate_bar, pressure_bar) in
        [(1, 6000, 0.01, 0.02), (8, 1500, 0.005, 0.01)]
    {
        for packing in [0.1, 0.4] {
            let chi = Plane::contact_value(packing);
            let theory = Plane::collision_rate(packing, chi);
            let side = (f64::from(disks) * Plane::ball(0.5) / packing).sqrt();
            let mut found = [const { Vec::new() }; 2];
            for seed in 0..12 {
                let state = start::<Equal<Plane>>(disks as usize, Vector2::new(side, side), seed);
                let temperature = state.temperature(&equal(1.0));
                let parameters = Parameters {
                    cell_size: Some(2.0),
                    simulators_per_disk: simulators,
                    ..PARAMETERS
                };
                let mut engine =
                    Engine::new(&equal(1.0), parameters, &state, Streams::new(seed, 0))
                        .expect("an engine");
                // From places at random to those of the scheme, and from no idea of its distance to the right one.
                engine.advance(30.0 / theory, u64::MAX, &mut ());
                let (before, from) = (engine.tally(), engine.time());
                engine.advance(from + 20.0 / theory, u64::MAX, &mut ());
                let (after, duration) = (engine.tally(), engine.time() - from);
                let collisions = (after.collisions - before.collisions) as f64;
                let speed = temperature.sqrt();
                found[0].push(
                    2.0 * collisions / engine.simulators() as f64 / duration / theory / speed,
                );
                let virial = after.virial - before.virial;
                let z = 1.0 + virial / (2.0 * f64::from(disks) * temperature * duration);
                found[1].push(z / (1.0 + 2.0 * packing * chi));
            }
            for (values, bar) in found.iter().zip([rate_bar, pressure_bar]) {
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
                let error = (variance / n).sqrt();
                let what = format!("{simulators} {packing}: {mean} ± {error}");
                assert!(error < bar / 3.0, "too wide: {what}");
                assert!((mean - 1.0).abs() < bar + 3.0 * error, "{what}");
            }
        }
    }
}

/// The same bytes for one, two and three threads and through a stop in between.
#[test]
fn threads_and_stops_change_nothing() {
    let scene = equal::<Plane>(0.8);
    let state = start::<Equal<Plane>>(20_000, Vector2::new(250.0, 255.0), 2);
    let streams = Streams::new(5, 0);
    for scheme in SCHEMES {
        let parameters = Parameters {
            scheme,
            ..PARAMETERS
        };
        let run = |threads: usize, stop: bool| {
            in_pool(threads, || {
                let mut seen = Seen::default();
                let mut engine = Engine::<_, Followed>::start(&scene, parameters, &state, streams)
                    .expect("an engine");
                engine.retile(1000);
                assert!(engine.grid().tiles()[..2].iter().all(|&tiles| tiles >= 3));
                engine.advance(f64::INFINITY, 3, &mut seen);
                if stop {
                    let checkpoint = engine.checkpoint();
                    let domain = state.domain;
                    engine = Engine::resume(&scene, parameters, domain, checkpoint, streams)
                        .expect("an engine");
                    engine.retile(1000);
                }
                engine.advance(f64::INFINITY, 3, &mut seen);
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
        assert!(alone.1.collisions > 2000, "{:?}", alone.1);
        assert_eq!(alone.4.0.len() as u64, alone.1.collisions);
        for (threads, stop) in [(1, true), (2, false), (3, true)] {
            assert!(
                alone == run(threads, stop),
                "{scheme:?}: {threads} threads, {stop}"
            );
        }
    }
}

/// Coherent copies have the energy and momentum of the state each, and its long waves; independent ones have not.
#[test]
fn coherent_copies_keep_long_waves() {
    let scene = equal::<Plane>(1.0);
    let side = 100.0;
    let mut state: State<Equal<Plane>> = start(4000, Vector2::new(side, side), 3);
    let wave = std::f64::consts::TAU / side;
    for body in &mut state.bodies {
        body.velocity[1] += (wave * body.position[0]).cos();
    }
    let amplitude = |state: &State<Equal<Plane>>| {
        let sum = |body: &stosszahl_model::Body<_>| {
            let body: &stosszahl_model::Body<Equal<Plane>> = body;
            body.velocity[1] * (wave * body.position[0]).cos()
        };
        2.0 * state.bodies.iter().map(sum).sum::<f64>() / state.bodies.len() as f64
    };
    let own = amplitude(&state);
    for (copies, kept) in [(Copies::Coherent, true), (Copies::Independent, false)] {
        let parameters = Parameters {
            simulators_per_disk: 16,
            copies,
            ..PARAMETERS
        };
        let engine =
            Engine::new(&scene, parameters, &state, Streams::new(1, 0)).expect("an engine");
        let found = engine.state();
        let scale = 1.0 / state.kinetic_energy(&scene);
        let energy = found.kinetic_energy(engine.scene()) / 16.0 * scale;
        assert!((energy - 1.0).abs() < 1e-12, "{energy}");
        // Copies are moved by at most a neighbourhood of 9 d, and means over it are taken: together a few per cent. The
        // thermal noise of the turned velocities is sqrt(2/(16 . 4000)) = 0.006.
        let ratio = amplitude(&found) / own;
        assert_eq!((ratio - 1.0).abs() < 0.06, kept, "{copies:?}: {ratio}");
    }
}
