//! Support for the tests of both engines.

use stosszahl::model::initial::Arrangement;
use stosszahl::model::samples::{
    EqualDisks, FallingDisks, law, no_gravity, placed_disks, species, square, state,
};
use stosszahl::model::{ParticleState, Scene, Smooth, State};

/// Creates the model of disks of species, by radius, mass and count.
pub fn kinds(restitution: f64, all: impl IntoIterator<Item = (f64, f64, usize)>) -> FallingDisks {
    Scene::new(Smooth, law(restitution), species(all), no_gravity())
}

/// Converts a gas to one of disks that may differ.
pub fn as_kinds(gas: &State<EqualDisks>) -> State<FallingDisks> {
    let body = |body: &ParticleState<EqualDisks>| (body.position, body.velocity);
    state(gas.domain, gas.bodies.iter().map(body))
}

/// Creates a Maxwellian gas of unit disks at temperature one in a square box.
pub fn gas(
    arrangement: Arrangement,
    count: usize,
    packing_fraction: f64,
    seed: u64,
) -> State<EqualDisks> {
    let domain = square(count, packing_fraction);
    placed_disks(arrangement, count, domain, seed).expect("a gas")
}

/// Mean of independent values and its standard error.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}
