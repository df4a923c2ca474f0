//! Sedimentation of particles in a closed box against the barometric solution (Kawasaki 1985,
//! section 3.1 and appendices A and B).

use nalgebra::vector;
use stosszahl_dsmc::{BoundaryConditions, DsmcEngine, Parameters, Tracked};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::samples::{FallingParticles, ideal_gas};
use stosszahl_model::{
    Face, Gravity, Rough, Scene, Sizes, State, Volume, Wall, Walls, initial, samples,
};

use crate::support::{PARAMETERS, sphere_for_unit_path};

type Column = FallingParticles<Volume, Rough>;

/// Height of the column \[mean free paths\].
const HEIGHT: f64 = 10.0;
const PULL: f64 = 0.1;

/// Species: mass, diameter and number.
#[derive(Clone, Copy)]
struct Species {
    mass: f64,
    diameter: f64,
    count: usize,
}

impl Species {
    /// Weight over thermal energy, m g L/T.
    fn weight(&self, temperature: f64) -> f64 {
        self.mass * PULL * HEIGHT / temperature
    }
}

/// Mean height of the barometric solution over that of the column, for a weight x: 1/x - 1/(e^x -
/// 1).
fn mean_height(weight: f64) -> f64 {
    1.0 / weight - 1.0 / weight.exp_m1()
}

/// Densities at the bottom and at the top over the mean.
fn ends(weight: f64) -> [f64; 2] {
    [weight / -(-weight).exp_m1(), weight / weight.exp_m1()]
}

/// Root of an increasing function, by bisection.
fn solve(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if function(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Final temperature from energy conservation: 3 T per particle (three translational and three
/// rotational degrees of freedom) and potential energy.
fn final_temperature(species: &[Species], start: f64) -> f64 {
    let energy = |temperature: f64, height: &dyn Fn(&Species) -> f64| {
        let each = |species: &Species| {
            let potential = species.mass * PULL * HEIGHT * height(species);
            species.count as f64 * (3.0 * temperature + potential)
        };
        species.iter().map(each).sum::<f64>()
    };
    let begin = energy(start, &|_| 0.5);
    let excess = |t: f64| energy(t, &|species| mean_height(species.weight(t))) - begin;
    solve(excess, start, 10.0 * start)
}

fn column(species: &[Species]) -> Column {
    let kinds = species.iter();
    let sizes = samples::species(kinds.map(|one| (0.5 * one.diameter, one.mass, one.count)));
    let surface = Rough::new(1.0, 0.4).expect("a surface");
    let field = Gravity::new(vector![0.0, 0.0, -PULL]).expect("finite");
    Scene::new(surface, samples::law(1.0), sizes, field)
}

/// Results of a falling column: temperature after 10 mean free times, and means of temperature and
/// heights from `begin` mean free times on. `slices`: numbers in tenths of the column, by species.
struct Fall {
    early: f64,
    temperature: f64,
    heights: Vec<f64>,
    slices: Vec<[f64; 10]>,
}

const SAMPLES: u32 = 100;

fn fall(species: &[Species], start: f64, mean_free_time: f64, begin: f64) -> Fall {
    let scene = column(species);
    let walls = Walls::new(&[
        [Face::Periodic; 2],
        [Face::Periodic; 2],
        [Face::Wall(Wall::specular()); 2],
    ]);
    let boundaries = BoundaryConditions {
        walls: walls.expect("fit"),
        ..BoundaryConditions::default()
    };
    let domain = boundaries.walls.domain(vector![0.5, 0.5, HEIGHT]);
    let count = species.iter().map(|kind| kind.count).sum::<usize>();
    let mut state: State<Column> = ideal_gas(&scene, domain.expect("a box"), 0.0, count, start, 1);
    let mut stream = Streams::new(1, 0).stream_at(Purpose::Spins, [0, 0]);
    initial::thermal_spins(&scene, &mut state, start, &mut stream);
    let parameters = Parameters {
        cell_size: Some(0.5),
        steps_per_cell_crossing: 1.0,
        ..PARAMETERS
    };
    let mut engine: DsmcEngine<Column, Tracked> =
        DsmcEngine::setup(&scene, parameters, Streams::new(1, 0))
            .between(&boundaries)
            .start(&state)
            .expect("an engine");
    let total = |state: &State<Column>| {
        let bodies = state.bodies.iter().enumerate();
        let mass = |index| scene.sizes.mass(scene.sizes.tag_of(index));
        let potential = bodies.map(|(index, body)| PULL * mass(index) * body.position[2]);
        potential.sum::<f64>() + state.kinetic_energy(&scene) + state.spin_energy(&scene)
    };
    let energy = total(&state);
    engine.advance(10.0 * mean_free_time, u64::MAX, &mut ());
    let mut found = Fall {
        early: engine.state().temperature(&scene),
        temperature: 0.0,
        heights: vec![0.0; species.len()],
        slices: vec![[0.0; 10]; species.len()],
    };
    for sample in 0..SAMPLES {
        let time = (begin + f64::from(sample)) * mean_free_time;
        engine.advance(time, u64::MAX, &mut ());
        let state = engine.state();
        found.temperature += state.temperature(&scene) / f64::from(SAMPLES);
        let mut first = 0;
        for (number, kind) in species.iter().enumerate() {
            for body in &state.bodies[first..first + kind.count] {
                let share = body.position[2] / HEIGHT;
                let each = 1.0 / (f64::from(SAMPLES) * kind.count as f64);
                found.heights[number] += share * each;
                found.slices[number][(10.0 * share) as usize] += 10.0 * each;
            }
            first += kind.count;
        }
    }
    let end = total(&engine.state());
    assert!((end / energy - 1.0).abs() < 1e-11, "{end} {energy}");
    assert_eq!(engine.ledgers().settled_particles, 0);
    found
}

/// Checks the temperature within 1 %, the densities at both ends, by the barometric law with the
/// measured mean height, within `ends_within`, and the density in tenths of the column within
/// `slices`. Densities at the ends may be off by four standard deviations, which were measured over
/// eight seeds: one end of 14 then fails for one seed in a thousand.
fn check(species: &[Species], start: f64, found: &Fall, [ends_within, slices]: [f64; 2]) {
    let expected = final_temperature(species, start);
    assert!(
        (found.temperature / expected - 1.0).abs() < 0.01,
        "{} {expected}",
        found.temperature
    );
    for (number, kind) in species.iter().enumerate() {
        let height = found.heights[number];
        let weight = solve(|weight| height - mean_height(weight), 1e-3, 100.0);
        let known = kind.weight(expected);
        for (found, expected) in ends(weight).into_iter().zip(ends(known)) {
            // The dilute gas above heavy particles is exponentially sensitive: its error is taken
            // relative to the density below.
            let off = (found - expected).abs() / expected.max(0.1);
            assert!(off < ends_within, "{number}: {found} {expected}");
        }
        for (tenth, density) in found.slices[number].into_iter().enumerate() {
            let at = |tenth: f64| (-known * 0.1 * tenth).exp();
            let tenth = tenth as f64;
            let expected = 10.0 * (at(tenth) - at(tenth + 1.0)) / -(-known).exp_m1();
            let off = (density - expected).abs() / expected.max(0.1);
            assert!(off < slices, "{number}, {tenth}: {density} {expected}");
        }
    }
}

/// In the units of section 2.4 the initial temperature is 1/2, so a particle's weight times the
/// height is two. The formulas give 1.0962 for the final over the initial temperature, and 2.175
/// and 0.351 for the densities at the ends over the mean. Around ten mean free times the gas is
/// hotter by more than 2 %: it overshoots.
#[test]
fn one_species_settles() {
    let count = 16_000;
    let diameter = sphere_for_unit_path(count as f64 / (0.25 * HEIGHT));
    let species = [Species {
        mass: 1.0,
        diameter,
        count,
    }];
    let expected = final_temperature(&species, 0.5);
    assert!((expected / 0.5 - 1.0962).abs() < 1e-4);
    let [bottom, top] = ends(species[0].weight(expected));
    assert!((bottom - 2.175).abs() < 1e-3 && (top - 0.351).abs() < 1e-3);
    let mean_free_time = 0.5 * std::f64::consts::PI.sqrt();
    let found = fall(&species, 0.5, mean_free_time, 100.0);
    // The standard deviation is 0.47 % above.
    check(&species, 0.5, &found, [0.02, 0.03]);
    assert!(found.early / expected > 1.02, "{}", found.early);
}

/// Checks two species of equal numbers, in appendix A's units: mean free path and mean collision
/// time of the mixture are one.
fn two_species(
    masses: [f64; 2],
    diameters: [f64; 2],
    expected: [f64; 3],
    begin: f64,
    ends_within: f64,
) {
    let count = 8000;
    let density = count as f64 / (0.25 * HEIGHT);
    let (mut path, mut rate) = (0.0, 0.0);
    for p in 0..2 {
        let (mut inverse, mut collisions) = (0.0, 0.0);
        for q in 0..2 {
            let section = (diameters[p] + diameters[q]).powi(2) * density;
            inverse += 0.25 * std::f64::consts::PI * section * (1.0 + masses[p] / masses[q]).sqrt();
            let inverse_mass = (masses[p] + masses[q]) / (masses[p] * masses[q]);
            collisions += 0.5 * (2.0 * std::f64::consts::PI * inverse_mass).sqrt() * section;
        }
        path += 0.5 / inverse;
        rate += 0.5 * collisions;
    }
    // The unit of length fixes the diameters, then the unit of time the temperature: T_0 = 1 for
    // these masses.
    let shrunk = path.sqrt();
    let heavier = (rate * path).powi(2);
    let species = [0, 1].map(|kind| Species {
        mass: masses[kind] * heavier,
        diameter: diameters[kind] * shrunk,
        count,
    });
    let temperature = final_temperature(&species, 1.0);
    assert!((temperature - expected[0]).abs() < 1e-4, "{temperature}");
    for kind in 0..2 {
        let [bottom, _] = ends(species[kind].weight(temperature));
        assert!((bottom - expected[kind + 1]).abs() < 2e-3, "{bottom}");
    }
    let found = fall(&species, 1.0, 1.0, begin);
    check(&species, 1.0, &found, [ends_within, 0.06]);
}

#[test]
fn equal_masses_settle() {
    // The standard deviation is 1.8 % above, 0.8 % below.
    two_species(
        [1.0, 1.0],
        [0.464, 1.0],
        [1.2189, 2.881, 2.881],
        120.0,
        0.074,
    );
}

#[test]
fn light_grains_settle_among_heavy_ones() {
    // The standard deviation is at most 0.41 %.
    two_species([0.1, 1.0], [1.0, 1.0], [1.5461, 1.339, 6.163], 150.0, 0.02);
}

#[test]
fn light_and_small_grains_settle_among_heavy_and_large_ones() {
    // The standard deviation is at most 0.70 %.
    two_species(
        [0.1, 1.0],
        [0.464, 1.0],
        [1.7299, 1.389, 6.977],
        150.0,
        0.03,
    );
}
