//! Support for the tests of both engines.

use nalgebra::vector;
use stosszahl::model::initial::{self, Arrangement};
use stosszahl::model::random::{Purpose, Streams};
use stosszahl::model::{
    Constant, Domain, Free, Gravity, Interrupt, Law, Monodisperse, ParticleState, Plane,
    Polydisperse, Scene, Smooth, Species, SpeciesProperties, State,
};

/// Smooth equal disks of diameter and mass one. All scenes here have the types that programs use:
/// an engine takes seconds to compile, and those are there.
pub type Disks = Scene<Plane, Smooth, Law, Monodisperse, Free>;

/// Smooth disks of any sizes, for exact dynamics.
pub type Mixture = Scene<Plane, Smooth, Law, Polydisperse, Free>;

/// Smooth disks of several species, for Monte Carlo.
pub type Kinds = Scene<Plane, Smooth, Law, Species, Gravity<Plane>>;

/// Creates the scene of unit disks with the given restitution.
pub fn disks(restitution: f64) -> Disks {
    Scene {
        space: Plane,
        surface: Smooth,
        restitution: Constant::new(restitution).expect("a coefficient").into(),
        sizes: Monodisperse {
            radius: 0.5,
            mass: 1.0,
        },
        field: Free,
    }
}

/// Creates the scene of species, by radius, mass and count.
pub fn kinds(restitution: f64, all: impl IntoIterator<Item = (f64, f64, usize)>) -> Kinds {
    let kind = |(radius, mass, count)| SpeciesProperties {
        radius,
        mass,
        count,
    };
    Scene {
        space: Plane,
        surface: Smooth,
        restitution: disks(restitution).restitution,
        sizes: Species::new(all.into_iter().map(kind).collect()).expect("species"),
        field: Gravity::new(vector![0.0, 0.0]).expect("finite"),
    }
}

/// Converts a gas to one of disks that may differ.
pub fn as_kinds(gas: &State<Disks>) -> State<Kinds> {
    let bodies = gas.bodies.iter();
    State {
        time: gas.time,
        domain: gas.domain,
        bodies: bodies
            .map(|body| ParticleState::new(body.position, body.velocity))
            .collect(),
    }
}

/// Creates a Maxwellian gas of unit disks at temperature one in a square box.
pub fn gas(
    arrangement: Arrangement,
    count: usize,
    packing_fraction: f64,
    seed: u64,
) -> State<Disks> {
    let area = count as f64 * std::f64::consts::FRAC_PI_4 / packing_fraction;
    let width = area.sqrt();
    let domain = Domain::periodic(vector![width, area / width]).expect("a box");
    let streams = Streams::new(seed, 0);
    let never = Interrupt::default();
    let placement =
        initial::place_disks(arrangement, count, 1.0, &domain, &streams, &never).expect("a gas");
    let bodies = placement.positions.into_iter();
    let mut state = State {
        time: 0.0,
        domain,
        bodies: bodies
            .map(|at| ParticleState::new(at, vector![0.0, 0.0]))
            .collect(),
    };
    let mut stream = streams.stream_at(Purpose::Velocities, [0, 0]);
    initial::maxwellian(&disks(1.0), &mut state, 1.0, &mut stream);
    state
}

/// Mean of independent values and its standard error.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}
