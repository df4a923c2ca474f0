//! Cross-cell collisions against a plain search, against theory, and for any number of threads.

use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoroshiro128PlusPlus;
use rayon::prelude::*;
use stosszahl_model::equation_of_state;
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{DiskMixture, EqualDisks, UNIT, equal, law, mixture};
use stosszahl_model::{
    Collision, Observer, ParticleModel, Plane, Scene, Shear, Sheared, Sizes, Smooth, Space, State,
    Vector, VectorOf, Volume,
};
use stosszahl_theory::cooling;

use super::coloured_sweep::sweep_around;
use super::halo_copy::HaloCopy;
use super::lanes::{self, CellRow, LINES, Plain, SimdBackend};
use super::partners::Search;
use super::search_ranges::ranges;
use super::search_target::Aim;
use super::tile_collider::line_of_centres;
use crate::particle::DisplacementTracking;
use crate::tests::{Seen, in_pool, mean_and_error, start};
use crate::{
    DsmcEngine, Neighbourhood, Parameters, PartnerDisplacement, Scheme, SimulatorStart, Tracked,
    Untracked,
};

const PARAMETERS: Parameters = Parameters {
    scheme: Scheme::ContactPoint { radius: None },
    displacement: PartnerDisplacement::None,
    cell_size: None,
    simulators_per_particle: 1,
    copies: SimulatorStart::Independent,
    steps_per_cell_crossing: 4.0,
    max_contact_value: 100.0,
};

const SCHEMES: [Scheme; 3] = [
    Scheme::ContactPoint { radius: None },
    Scheme::Esmc(Neighbourhood::Cells(1)),
    Scheme::StochasticDisks { stiffness: 2.0 },
];

/// In wide and narrow boxes, and in wide ones that slide in a shear flow, partners are those within the radius of their contact points, with
/// equal chance, or the nearest if there is none, as a search through all particles finds.
#[test]
fn partners_are_those_of_a_plain_search() {
    let drew = search_like_a_plain_one(|_| equal(1.0));
    assert!(
        drew > 0,
        "nowhere are there enough that some are drawn first"
    );
    search_like_a_plain_one(unequal);
}

/// However large the radius, as in a dilute gas between walls, a search stays within its cells.
fn stays_around<P: ParticleModel>(
    patch: &HaloCopy<P>,
    aim: Aim<VectorOf<P>>,
    cell: usize,
    cells: usize,
) {
    let block = patch.block_within(aim, 1e9, cells);
    assert_eq!(block.sides, [2 * cells + 1, 2 * cells + 1, 1]);
    assert_eq!(block.first, cell - cells * (1 + patch.strides()[1]));
}

/// Chi-squared of draws among `among` equally likely outcomes, twenty for each.
fn squares_of_draws(among: usize, mut draw: impl FnMut() -> usize) -> f64 {
    let mut counts = vec![0.0_f64; among];
    for _ in 0..20 * among {
        counts[draw()] += 1.0;
    }
    counts.iter().map(|n| (n - 20.0).powi(2) / 20.0).sum()
}

/// All SIMD implementations at once; they must agree.
#[derive(Clone, Copy)]
struct AllLanes;

impl SimdBackend for AllLanes {
    fn look(
        self,
        runs: &[CellRow<'_>; LINES],
        point: [f64; 2],
        limit: f64,
        but: usize,
    ) -> lanes::SearchResult {
        let seen = Plain.look(runs, point, limit, but);
        #[cfg(target_arch = "x86_64")]
        if let Some(wide) = lanes::Avx2::detect() {
            assert_eq!(wide.look(runs, point, limit, but), seen);
        }
        seen
    }

    fn bit_after(self, bits: u32, skip: u32) -> u32 {
        Plain.bit_after(bits, skip)
    }
}

/// Boxes in which searches are compared, with the number of disks: wide and narrow, and wide ones
/// that slide by a fraction of a cell and by more than the widest tile.
fn searched_boxes() -> impl Iterator<Item = ([f64; 2], usize, Option<Shear>)> {
    let wide = [([40.0, 30.0], 300), ([20.0, 15.0], 600), ([6.0, 5.0], 120)];
    let narrow = [([60.0, 3.0], 60), ([1.5, 2.5], 5)];
    let shears = [0.3, 5.7].map(|offset| Shear { rate: 1.0, offset });
    let resting = (wide.into_iter().chain(narrow)).map(|(sides, count)| (sides, count, None));
    resting.chain(
        wide.into_iter()
            .flat_map(move |(sides, count)| shears.map(|shear| (sides, count, Some(shear)))),
    )
}

/// Compares searches with a plain one. Returns the number of tiles in which some candidates are
/// drawn first.
fn search_like_a_plain_one<P: ParticleModel<Space = Plane>>(scene: impl Fn(usize) -> P) -> u32 {
    let mut drew = 0;
    for (sides, count, shear) in searched_boxes() {
        let mut state = start::<P>(count, Vector2::from(sides), 9);
        state.domain = state.domain.sheared(shear).expect("a periodic box");
        for radius in [0.0, 1.0, 2.5] {
            let parameters = Parameters {
                scheme: Scheme::ContactPoint {
                    radius: Some(radius),
                },
                ..PARAMETERS
            };
            let mut engine = DsmcEngine::new(&scene(count), parameters, &state, Streams::new(1, 0))
                .expect("an engine");
            engine.retile(40);
            let grid = engine.grid.clone();
            let domain = state.domain;
            let sizes = engine.scene.sizes().clone();
            let mean = engine.constants.mean_radius;
            let ranges = ranges::<P>(parameters.scheme, &grid, &sizes, mean, radius, 1.0);
            let reach = (ranges.near + ranges.shift) as f64;
            // Excess over the mean radius, and position, of each particle.
            let all: Vec<_> = (engine.state().bodies.iter().enumerate())
                .map(|(index, body)| (sizes.radius(sizes.tag_of(index)) - mean, body.position))
                .collect();
            let (mut expected, mut squares) = (0.0, 0.0);
            let tiles = &mut engine.tiles;
            let results = sweep_around(false, &grid, tiles, None, |number, around| {
                let mut stream = Xoroshiro128PlusPlus::seed_from_u64(number as u64);
                let in_cell = around.home().in_cell();
                let mut search = Search::<P, _>::new(&grid, AllLanes, radius, ranges, in_cell);
                let mut patch = HaloCopy::default();
                patch.fill(&around, &grid, ranges, false, (&sizes, mean));
                let mut results = Vec::new();
                let [columns, rows, _] = around.home().place.sides.map(|side| side as usize);
                let cells = (0..columns * rows).map(|cell| [cell % columns, cell / columns, 0]);
                let members = |cell| patch.members(patch.own_cell(cell), 1);
                for who in cells.flat_map(members).collect::<Vec<_>>() {
                    let own = around.read(patch.home(who)).position;
                    let along = Plane::random_direction(&mut stream);
                    let point = own + along;
                    let aim = Aim { point, along };
                    let distance = |&(more, at): &(f64, Vector2<f64>)| {
                        domain.distance(at, domain.wrap(point + along * more))
                    };
                    let cell = patch.cell_of(point);
                    stays_around(&patch, aim, cell, reach as usize);
                    let others = || all.iter().filter(|(_, at)| *at != own);
                    let near: Vec<_> = others().filter(|one| distance(one) < radius).collect();
                    let mut draw = || {
                        let pick = stream.random_range(0..1_u64 << 32);
                        let found =
                            search.partner(&mut patch, aim, cell, who, pick, &mut stream)?;
                        Some(around.read(patch.home(found)).position)
                    };
                    if near.is_empty() {
                        // In the cells around, where there are particles.
                        let column = |axis: usize, x: f64| (x / grid.width()[axis]).floor();
                        let is_around = |&&(_, at): &&(f64, Vector2<f64>)| {
                            let seen = point + domain.images().nearest(at - point);
                            (0..2).all(|axis| {
                                let apart = column(axis, seen[axis]) - column(axis, point[axis]);
                                apart.abs() <= reach
                            })
                        };
                        let next = others().filter(is_around).map(distance);
                        let mut nearest = next.fold(f64::MAX, f64::min);
                        if nearest == f64::MAX {
                            nearest = others().map(distance).fold(f64::MAX, f64::min);
                        }
                        match draw() {
                            Some(at) => {
                                let found = others().find(|(_, other)| *other == at);
                                let found = distance(found.expect("one of them"));
                                assert!((found - nearest).abs() < 1e-12);
                            }
                            // Beyond three cells the search ends.
                            None => assert!(nearest > 3.0 * grid.width().min() - 1e-9),
                        }
                        continue;
                    }
                    let square = squares_of_draws(near.len(), || {
                        let at = draw().expect("there is one");
                        let found = near.iter().position(|(_, other)| *other == at);
                        found.expect("it is near")
                    });
                    results.push((near.len() as f64 - 1.0, square));
                }
                ((results, search.draws), Vec::new())
            });
            for (results, draws) in results.into_iter().map(|one| one.1) {
                drew += u32::from(draws);
                for (freedom, square) in results {
                    expected += freedom;
                    squares += square;
                }
            }
            // Chi-squared of f degrees of freedom: mean f, standard deviation sqrt(2 f); z = 4.4,
            // and some for the skew at small f.
            let allowed = 4.4 * (2.0_f64 * expected).sqrt() + 10.0;
            assert!((squares - expected).abs() < allowed, "{squares} {expected}");
        }
    }
    drew
}

/// The velocity bound of a cell reports that no partner is fast enough only if a loop over all
/// particles agrees, and mostly then; also after one becomes fast. The bound of a cell is no less
/// than that of any cell it reaches.
#[test]
#[allow(
    clippy::too_many_lines,
    reason = "one look at a gas, and all that is asked of it"
)]
fn bounds_of_speed_are_those_of_a_plain_search() {
    type Moving = (Vector2<f64>, Vector2<f64>);
    let directions =
        [0.0_f64, 0.3, 1.9, 2.8, 4.0, 5.5].map(|angle| Vector2::new(angle.cos(), angle.sin()));
    for (sides, count, per_tile) in [
        ([60.0, 50.0], 900, 300),
        ([60.0, 6.0], 120, 40),
        ([90.0, 80.0], 60, 20),
        ([2.5, 3.5], 5, 5),
    ] {
        let state = start::<EqualDisks>(count, Vector2::from(sides), 4);
        let parameters = Parameters {
            cell_size: Some(1.7),
            ..PARAMETERS
        };
        let scene = equal::<Plane>(1.0);
        let mut engine =
            DsmcEngine::<_, Untracked>::new(&scene, parameters, &state, Streams::new(1, 0))
                .expect("an engine");
        engine.retile(per_tile);
        let grid = engine.grid.clone();
        let ranges = ranges::<EqualDisks>(parameters.scheme, &grid, scene.sizes(), 0.5, 0.5, 1.0);
        assert_eq!((ranges.point, ranges.near, ranges.far), (1, 1, 3));
        let counts = grid.counts();
        let apart = |one: [u32; 3], other: [u32; 3]| {
            let ring = |axis: usize| {
                let apart = one[axis].abs_diff(other[axis]);
                apart.min(counts[axis] - apart)
            };
            ring(0).max(ring(1))
        };
        let (mut told, mut silent, mut lonely) = (0, 0, 0);
        for hot in [false, true] {
            let tiles = &mut engine.tiles;
            let found = sweep_around(false, &grid, tiles, None, |number, mut around| {
                let mut patch = HaloCopy::default();
                patch.fill(&around, &grid, ranges, true, (scene.sizes(), 0.5));
                let place = around.home().place;
                let [columns, rows, _] = place.sides.map(|side| side as usize);
                let mut all = Vec::new();
                let mut cold = hot && number == 0;
                for row in 0..rows {
                    patch.bound_line([row, 0]);
                    // The first particle of the tile, as if it had collided after the bounds were
                    // found.
                    let mut cells = (0..columns).map(|column| patch.own_cell([column, row, 0]));
                    let here = cells.find(|&cell| !patch.members(cell, 1).is_empty());
                    if let Some(here) = here
                        && std::mem::take(&mut cold)
                    {
                        let who = patch.members(here, 1).start;
                        let velocity = Vector2::new(30.0, 40.0);
                        around.set(patch.home(who), velocity, ());
                        patch.set(who, velocity, true);
                        // Results found before did not include it.
                        all.clear();
                    }
                    for column in 0..columns {
                        let cell = around.home().cell_at(column + columns * row);
                        // One step further, possibly outside the box.
                        let at = patch.step_from(patch.own_cell([column, row, 0]), [1, -1, 0]);
                        let along = patch.bounds[column];
                        let slow = directions.map(|k| {
                            [-0.8, 0.1, 0.9].map(|speed| (k, speed, patch.is_slow(at, k, speed)))
                        });
                        all.push((cell, slow, directions.map(|k| along.against(k))));
                    }
                }
                (all, Vec::new())
            });
            let bodies = engine.state().bodies;
            let all: Vec<Moving> = bodies
                .iter()
                .map(|body| (body.position, body.velocity))
                .collect();
            let plain = |cell, cells, k: Vector2<f64>| {
                let near = all
                    .iter()
                    .filter(|(at, _)| apart(cell, grid.cell_at(*at)) <= cells);
                near.fold(f64::NEG_INFINITY, |most, (_, velocity)| {
                    most.max(-velocity.dot(&k))
                })
            };
            // The first tile comes first, so that all others include it.
            for (cell, slow, along) in found.into_iter().flat_map(|one| one.1) {
                let ring =
                    |axis: usize, step: u32| (cell[axis] + counts[axis] + step - 1) % counts[axis];
                let there = [ring(0, 2), ring(1, 0), 0];
                let near = all
                    .iter()
                    .filter(|(at, _)| apart(there, grid.cell_at(*at)) <= 1)
                    .count();
                for (k, speed, is_slow) in slow.into_iter().flatten() {
                    let is_known = plain(there, 1, k) > speed;
                    // Boxes of several velocities are wider than these.
                    assert!(!(is_slow && is_known), "{cell:?}: {speed}");
                    if near <= 1 {
                        assert!(!is_slow, "partners from afar are not known");
                        lonely += 1;
                    }
                    told += u32::from(is_slow);
                    silent += u32::from(!is_slow && !is_known && near > 1);
                }
                for (k, bound) in directions.into_iter().zip(along) {
                    assert!(bound >= plain(cell, 2, k), "{cell:?}: {bound}");
                }
            }
        }
        // In narrow boxes no bound is given.
        assert!(lonely > 0 || count != 60);
        assert!(told > 2 * silent || count < 900, "{told} {silent}");
    }
}

/// Lines of centres k have the density `W(k) = sum L_i |k_i|`: means of f/W equal those of f over
/// all directions, divided by the integral of W. z = 4.5 at measured standard errors of 0.5 %;
/// eleven means: a false alarm in 10^4.
#[test]
fn lines_of_centres_have_the_density_of_the_bound() {
    type Function = (fn(&[f64]) -> f64, f64);
    fn check<S: Space>(sides: S::Vector, mean_component: f64) {
        let mut stream = Xoroshiro128PlusPlus::seed_from_u64(5);
        let total: f64 = (0..S::DIMENSION).map(|axis| sides[axis]).sum();
        let functions: [Function; 5] = [
            (|_| 1.0, 1.0),
            (|k| k[0] * k[0], 1.0 / S::DIMENSION as f64),
            (|k| k[1] * k[1], 1.0 / S::DIMENSION as f64),
            (|k| k[0] * k[1], 0.0),
            (|k| k[0].abs(), mean_component),
        ];
        let mut found = [const { Vec::new() }; 5];
        for _ in 0..100_000 {
            let k = line_of_centres::<S>(sides, &mut stream);
            assert!((k.square() - 1.0).abs() < 1e-14);
            let components: Vec<f64> = (0..S::DIMENSION).map(|axis| k[axis]).collect();
            let weight: f64 = (0..S::DIMENSION)
                .map(|axis| sides[axis] * k[axis].abs())
                .sum();
            for (values, (function, _)) in found.iter_mut().zip(functions) {
                values.push(function(&components) * mean_component * total / weight);
            }
        }
        for (values, (_, expected)) in found.iter().zip(functions) {
            let (mean, error) = mean_and_error(values);
            assert!(
                (mean - expected).abs() < 4.5 * error,
                "{mean} {error} {expected}"
            );
            assert!(error < 0.005);
        }
    }
    check::<Plane>(Vector2::new(1.0, 3.0), std::f64::consts::FRAC_2_PI);
    check::<Volume>(nalgebra::Vector3::new(1.0, 2.0, 0.5), 0.5);
}

/// Collision rate and pressure of the elastic gas over Enskog's, after relaxation from random
/// positions.
fn over_enskog(parameters: Parameters, disks: u32, packing: f64, seed: u64) -> [f64; 2] {
    let chi = Plane::contact_value(packing);
    let theory = Plane::collision_rate(packing, chi);
    let side = (f64::from(disks) * Plane::particle_volume(0.5) / packing).sqrt();
    let state = start::<EqualDisks>(disks as usize, Vector2::new(side, side), seed);
    let temperature = state.temperature(&equal(1.0));
    let mut engine =
        DsmcEngine::new(&equal(1.0), parameters, &state, Streams::new(seed, 0)).expect("an engine");
    // Ten collisions per particle: the excess of the distance is learnt from some three hundred in
    // all.
    engine.advance(10.0 / theory, u64::MAX, &mut ());
    let (before, from) = (engine.tally(), engine.time());
    engine.advance(from + 20.0 / theory, u64::MAX, &mut ());
    let (after, duration) = (engine.tally(), engine.time() - from);
    let each = 2.0 * (after.collisions - before.collisions) as f64 / engine.simulators() as f64;
    let virial = after.virial - before.virial;
    let z = 1.0 + virial / (2.0 * f64::from(disks) * temperature * duration);
    [
        each / duration / theory / temperature.sqrt(),
        z / (1.0 + 2.0 * packing * chi),
    ]
}

/// Rate and pressure of the elastic gas are Enskog's, within tolerances of at least three standard
/// errors. Cases: cells of two diameters; default cells in a dilute gas, whose partners are farther
/// away than a neighbourhood is wide; cells of 0.6 d, where a search often finds no partner; many
/// simulators, with the density taken halfway to the contact.
#[test]
fn elastic_rate_and_pressure_are_enskogs() {
    for (simulators, disks, gases, packing, cell_size, bars) in [
        (1, 6000, 6, 0.1, Some(2.0), [0.01, 0.02]),
        (1, 6000, 6, 0.4, Some(2.0), [0.01, 0.02]),
        (8, 1500, 12, 0.1, Some(2.0), [0.005, 0.01]),
        (8, 1500, 12, 0.4, Some(2.0), [0.005, 0.01]),
        (1, 9000, 9, 0.01, None, [0.0075, 0.01]),
        (4, 2250, 6, 0.01, None, [0.01, 0.01]),
        (4, 1500, 9, 0.1, Some(0.6), [0.01, 0.01]),
        (16, 750, 9, 0.25, None, [0.005, 0.01]),
        (16, 750, 9, 0.5, None, [0.005, 0.01]),
    ] {
        let parameters = Parameters {
            cell_size,
            simulators_per_particle: simulators,
            ..PARAMETERS
        };
        let found: Vec<_> = (0..gases)
            .into_par_iter()
            .map(|seed| over_enskog(parameters, disks, packing, seed))
            .collect();
        for (which, bar) in bars.into_iter().enumerate() {
            let values: Vec<f64> = found.iter().map(|both| both[which]).collect();
            let (mean, error) = mean_and_error(&values);
            let what = format!("{simulators} {packing} {cell_size:?}: {mean} ± {error}");
            assert!(error < bar / 3.0, "too wide: {what}");
            assert!((mean - 1.0).abs() < bar + 3.0 * error, "{what}");
        }
    }
}

/// Structure factor of an elastic gas around k d = 1, after relaxation from random positions: mean
/// over several waves and times.
fn structure(parameters: Parameters, disks: u32, packing: f64, seed: u64) -> f64 {
    let theory = Plane::collision_rate(packing, Plane::contact_value(packing));
    let side = (f64::from(disks) * Plane::particle_volume(0.5) / packing).sqrt();
    let state = start::<EqualDisks>(disks as usize, Vector2::new(side, side), seed);
    let mut engine =
        DsmcEngine::new(&equal(1.0), parameters, &state, Streams::new(seed, 0)).expect("an engine");
    let unit = std::f64::consts::TAU / side;
    let most = (1.1 / unit) as i32;
    let waves: Vec<_> = (-most..=most)
        .flat_map(|x| (0..=most).map(move |y| Vector2::new(f64::from(x), f64::from(y)) * unit))
        .filter(|k| (k.norm() - 1.0).abs() < 0.1)
        .collect();
    let samples = 10;
    let mut sum = 0.0;
    for sample in 0..samples {
        let until = (30.0 + 4.0 * f64::from(sample)) / theory;
        engine.advance(until, u64::MAX, &mut ());
        let bodies = engine.state().bodies;
        for wave in &waves {
            let phases = bodies.iter().map(|body| wave.dot(&body.position).sin_cos());
            let (sin, cos) = phases.fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1));
            sum += (sin * sin + cos * cos) / bodies.len() as f64;
        }
    }
    sum / (f64::from(samples) * waves.len() as f64)
}

/// Structure factor of many simulators agrees with hard disks within 5 %: S(1/d) = 0.358 at packing
/// 0.25 (Baus & Colot, Phys. Rev. A 36, 3912 (1987)). With a neighbourhood of 3 d around the
/// simulator it was too large by a quarter.
#[test]
fn many_simulators_have_the_structure_of_disks() {
    let parameters = Parameters {
        simulators_per_particle: 16,
        ..PARAMETERS
    };
    let found: Vec<_> = (0..6)
        .map(|seed| structure(parameters, 500, 0.25, seed) / 0.358)
        .collect();
    let (mean, error) = mean_and_error(&found);
    assert!(error < 0.04, "too wide: {mean} ± {error}");
    assert!((mean - 1.0).abs() < 0.05 + 3.0 * error, "{mean} ± {error}");
}

/// Energy over its initial value after 1.5 Haff times at restitution 0.8.
fn energy_left(parameters: Parameters, disks: u32, packing: f64, seed: u64) -> f64 {
    let scene = equal::<Plane>(0.8);
    let side = (f64::from(disks) * Plane::particle_volume(0.5) / packing).sqrt();
    let state = start::<EqualDisks>(disks as usize, Vector2::new(side, side), seed);
    let temperature = state.temperature(&scene);
    let mut engine =
        DsmcEngine::new(&scene, parameters, &state, Streams::new(seed, 0)).expect("an engine");
    let haff = cooling::haff_time(packing, 0.8, Plane::contact_value(packing));
    engine.advance(1.5 * haff / temperature.sqrt(), u64::MAX, &mut ());
    engine.state().temperature(&scene) / temperature
}

/// Repeated collisions of pairs among few simulators leave the excess energy that is estimated,
/// within a factor of 1.6: in a dilute gas, and in one where partners stay within reach for several
/// mean free paths. The standard error may be an eighth of the estimate.
#[test]
fn repeated_pairs_leave_the_energy_that_is_estimated() {
    for (packing, simulators) in [(0.03, 200_000), (0.25, 80_000)] {
        let gas = |copies: u32| {
            let parameters = Parameters {
                simulators_per_particle: copies,
                ..PARAMETERS
            };
            let seeds: Vec<u64> = (0..12).collect();
            let disks = simulators / copies / seeds.len() as u32;
            let left: Vec<f64> = (seeds.par_iter())
                .map(|&seed| energy_left(parameters, disks, packing, seed))
                .collect();
            let estimate = parameters.excess_of_repeated_pairs::<Plane>(packing, 1.0, 0.8);
            (mean_and_error(&left), estimate)
        };
        let ((few, few_error), much) = gas(1);
        let ((many, many_error), little) = gas(8);
        let estimate = much - little;
        let (found, error) = (few / many - 1.0, few_error.hypot(many_error) / many);
        let what = format!("{packing}: {found} ± {error}, estimate {estimate}");
        assert!(error < estimate / 8.0, "too wide: {what}");
        assert!(found > estimate / 1.6 - 3.0 * error, "{what}");
        assert!(found < estimate * 1.6 + 3.0 * error, "{what}");
    }
}

/// Collision numbers by kind of pair, recognised by reduced mass.
#[derive(Default)]
struct Kinds([u64; 3]);

/// Interpolated n chi and curvature of unequal disks match direct evaluation: the error is below
/// h^2/8 of the largest second derivative in between, estimated within 5 % from the table entries a
/// step h apart.
#[test]
fn rates_from_a_table_are_those_that_are_computed() {
    let state = start::<DiskMixture>(100, Vector2::new(30.0, 30.0), 1);
    let engine =
        DsmcEngine::<_, Untracked>::new(&unequal(100), PARAMETERS, &state, Streams::new(1, 0))
            .expect("an engine");
    let rates = engine.rates.expect("a scheme around contact points");
    let at = |place: f64| rates.covered_chi_there(place / 2048.0);
    for entry in 100..1500 {
        let entry = f64::from(entry);
        let packing = (entry + 0.5) / 2048.0;
        let (found, exact) = (rates.covered_chi_near(packing), at(entry + 0.5));
        let entries = [-1.0, 0.0, 1.0, 2.0].map(|step| at(entry + step));
        for which in [0, 1] {
            let second = |here: usize| {
                let ends = entries[here - 1][which] + entries[here + 1][which];
                (ends - 2.0 * entries[here][which]).abs()
            };
            // Rounding: n chi in its last digits, the curvature by these over 0.02^2.
            let rounding = [1e-14, 1e-10][which] * exact[which].abs();
            let allowed = 1.05 * second(1).max(second(2)) / 8.0 + rounding;
            let off = (found[which] - exact[which]).abs();
            assert!(off < allowed, "{packing}: {found:?} {exact:?}");
        }
        let plain = packing * Plane::contact_value(packing);
        assert!((exact[0] / plain - 1.0).abs() < 1e-14);
    }
}

/// Radii and masses of unequal disks.
const UNEQUAL: [(f64, f64); 2] = [(0.5, 1.0), (1.0, 4.0)];

/// Elastic disks of two sizes in turn.
fn unequal(count: usize) -> DiskMixture {
    mixture(1.0, UNEQUAL.into_iter().cycle().take(count))
}

impl Observer for Kinds {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let mass = collision.reduced_mass;
            self.0[usize::from(mass > 0.6) + usize::from(mass > 1.0)] += 1;
        }
    }
}

/// Disks of diameters 1 and 2 and masses 1 and 4 collide at the rates of Enskog's theory of
/// mixtures, `n_i n_j d_ij chi_ij sqrt(2 pi T/mu)`: each kind of pair within 1.2 % with two
/// simulators per disk, 1.5 % with sixteen and a neighbourhood of 35 simulators, 0.6 % in one of
/// many. Averages over 12, 4 and 8 gases; the standard errors are at most half of that.
#[test]
fn unequal_disks_meet_at_the_rates_of_a_mixture() {
    let (disks, packing) = (1000_u32, 0.2);
    let kinds = UNEQUAL;
    let scene = unequal(disks as usize);
    let half = f64::from(disks) / 2.0;
    let area = half * (Plane::particle_volume(0.5) + Plane::particle_volume(1.0)) / packing;
    let side = area.sqrt();
    // M_1/M_2 of the diameters.
    let moments = (1.0 + 2.0) / (1.0 + 4.0);
    let rate = |i: usize, j: usize, temperature: f64| {
        let diameters = [2.0 * kinds[i].0, 2.0 * kinds[j].0];
        let chi = equation_of_state::mixture_contact_value(
            Plane::contact_value(packing),
            packing,
            diameters,
            moments,
        );
        let mass = kinds[i].1 * kinds[j].1 / (kinds[i].1 + kinds[j].1);
        let pairs = if i == j { 0.5 } else { 1.0 } * half * half / area;
        let speed = (std::f64::consts::TAU * temperature / mass).sqrt();
        pairs * 0.5 * (diameters[0] + diameters[1]) * chi * speed
    };
    let settings = [
        (2, None, 12_u64, 0.012),
        (16, None, 4, 0.015),
        (16, Some(2.6), 8, 0.006),
    ];
    for (simulators, cell_size, gases, bar) in settings {
        let of_gas = |seed| {
            let state = start::<DiskMixture>(disks as usize, Vector2::new(side, side), seed);
            let temperature = state.kinetic_energy(&scene) / f64::from(disks);
            let parameters = Parameters {
                simulators_per_particle: simulators,
                cell_size,
                ..PARAMETERS
            };
            let mut engine = DsmcEngine::new(&scene, parameters, &state, Streams::new(seed, 0))
                .expect("an engine");
            let unit = half / (rate(0, 0, temperature) + rate(0, 1, temperature));
            engine.advance(5.0 * unit, u64::MAX, &mut ());
            let mut seen = Kinds::default();
            engine.advance(25.0 * unit, u64::MAX, &mut seen);
            [(0, (0, 0)), (1, (0, 1)), (2, (1, 1))].map(|(kind, (i, j)): (usize, _)| {
                let expected = rate(i, j, temperature) * 20.0 * unit * f64::from(simulators);
                seen.0[kind] as f64 / expected
            })
        };
        let gases: Vec<[f64; 3]> = (0..gases).into_par_iter().map(of_gas).collect();
        let found = [0, 1, 2].map(|kind| gases.iter().map(|gas| gas[kind]).collect::<Vec<_>>());
        for (kind, values) in found.iter().enumerate() {
            let (mean, error) = mean_and_error(values);
            let what = format!("{simulators} simulators, kind {kind}: {mean} ± {error}");
            assert!(error < bar / 2.0, "too wide: {what}");
            assert!((mean - 1.0).abs() < bar + 3.0 * error, "{what}");
        }
    }
}

/// Results have the same bytes for one, two and three threads and through a stop in between.
#[test]
fn threads_and_stops_change_nothing() {
    let state = start(8_000, Vector2::new(158.0, 161.0), 2);
    threads_and_stops_change_nothing_in::<_, Tracked>(&equal::<Plane>(0.8), &state);
}

/// Results of sheared gases, whose tiles slide past each other, have the same bytes for one, two and
/// three threads and through a stop in between.
#[test]
fn threads_and_stops_change_nothing_in_a_shear_flow() {
    let mut state = start(8_000, Vector2::new(158.0, 161.0), 2);
    let shear = Shear {
        rate: -0.3,
        offset: 71.3,
    };
    state.domain = (state.domain.sheared(Some(shear))).expect("a periodic box");
    let flow = Sheared::new(shear.rate).expect("a rate");
    let scene = Scene::new(Smooth, law(0.8), UNIT, flow);
    threads_and_stops_change_nothing_in::<_, Untracked>(&scene, &state);
}

fn threads_and_stops_change_nothing_in<P, F>(scene: &P, state: &State<P>)
where
    P: ParticleModel<Space = Plane>,
    F: DisplacementTracking<Plane>,
{
    let streams = Streams::new(5, 0);
    let single = SCHEMES.map(|scheme| (scheme, 1));
    for (scheme, simulators_per_particle) in single.into_iter().chain([(SCHEMES[0], 16)]) {
        let parameters = Parameters {
            scheme,
            simulators_per_particle,
            ..PARAMETERS
        };
        let run = |threads: usize, stop: bool| {
            in_pool(threads, || {
                let mut seen = Seen::default();
                let mut engine = DsmcEngine::<P, F>::setup(scene, parameters, streams)
                    .start(state)
                    .expect("an engine");
                engine.retile(500);
                assert!(engine.grid().tiles()[..2].iter().all(|&tiles| tiles >= 3));
                engine.advance(f64::INFINITY, 3, &mut seen);
                if stop {
                    let checkpoint = engine.checkpoint();
                    let domain = state.domain;
                    engine = DsmcEngine::setup(scene, parameters, streams)
                        .resume(domain, checkpoint)
                        .expect("an engine");
                    engine.retile(500);
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
        assert!(alone.1.collisions > 800, "{:?}", alone.1);
        assert_eq!(alone.4.0.len() as u64, alone.1.collisions);
        for (threads, stop) in [(1, true), (2, false), (3, true)] {
            assert!(
                alone == run(threads, stop),
                "{scheme:?}: {threads} threads, {stop}"
            );
        }
    }
}

/// Coherent copies each have the energy, momentum and long waves of the state; independent copies
/// lack the waves.
#[test]
fn coherent_copies_keep_long_waves() {
    let scene = equal::<Plane>(1.0);
    let side = 100.0;
    let mut state: State<EqualDisks> = start(4000, Vector2::new(side, side), 3);
    let wave = std::f64::consts::TAU / side;
    for body in &mut state.bodies {
        body.velocity[1] += (wave * body.position[0]).cos();
    }
    let amplitude = |state: &State<EqualDisks>| {
        let sum = |body: &stosszahl_model::ParticleState<_>| {
            let body: &stosszahl_model::ParticleState<EqualDisks> = body;
            body.velocity[1] * (wave * body.position[0]).cos()
        };
        2.0 * state.bodies.iter().map(sum).sum::<f64>() / state.bodies.len() as f64
    };
    let own = amplitude(&state);
    for (copies, kept) in [
        (SimulatorStart::Coherent, true),
        (SimulatorStart::Independent, false),
    ] {
        let parameters = Parameters {
            simulators_per_particle: 16,
            copies,
            ..PARAMETERS
        };
        let engine =
            DsmcEngine::new(&scene, parameters, &state, Streams::new(1, 0)).expect("an engine");
        let found = engine.state();
        let scale = 1.0 / state.kinetic_energy(&scene);
        let energy = found.kinetic_energy(engine.scene()) / 16.0 * scale;
        assert!((energy - 1.0).abs() < 1e-12, "{energy}");
        // Copies are moved by at most a neighbourhood of 9 d, and means over it are taken: together
        // a few per cent. The thermal noise of the turned velocities is sqrt(2/(16 . 4000)) =
        // 0.006.
        let ratio = amplitude(&found) / own;
        assert_eq!((ratio - 1.0).abs() < 0.06, kept, "{copies:?}: {ratio}");
    }
}
