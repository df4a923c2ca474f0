//! Starts, and what all parts ask of a gas.

use nalgebra::Vector2;
use stosszahl_analysis::energy::EnergySample;
use stosszahl_analysis::modes::{Amplitude, Modes};
use stosszahl_dsmc::{Engine, Follow, Parameters};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Constant, Plane, State, initial};

use crate::Trouble;
use crate::gas::{Disks, UNIT, disks, disordered, particles, relaxed};

/// A disordered start of unit disks at T = 1, after some elastic collisions of each disk under exact dynamics, time
/// zero.
pub(super) fn start(
    count: usize,
    packing: f64,
    seed: u64,
    collisions: f64,
) -> Result<State<Disks>, Trouble> {
    relaxed(disordered(count, packing, seed)?, collisions)
}

/// A Monte Carlo gas from a start, with velocities of its own for each simulator: Maxwellian, momentum zero and T = 1
/// exactly. Otherwise those of several simulators of a disk would be turned copies, and as far from a Maxwellian as
/// those of the few disks.
pub(super) fn monte_carlo<F: Follow<Plane>>(
    start: &State<Disks>,
    restitution: f64,
    parameters: Parameters,
    seed: u64,
) -> Result<Engine<Disks, F>, Trouble> {
    let streams = Streams::new(seed, 1);
    let mut engine = Engine::<Disks, F>::start(&disks(restitution)?, parameters, start, streams)?;
    let before = engine.state();
    let mut after = before.clone();
    let mut stream = streams.at(Purpose::Velocities, [1, 0]);
    initial::maxwellian(engine.scene(), &mut after, 1.0, &mut stream);
    let changes: Vec<_> = after
        .bodies
        .iter()
        .zip(&before.bodies)
        .map(|(new, old)| new.velocity - old.velocity)
        .collect();
    engine.kick(&changes);
    Ok(engine)
}

/// Positions and velocities of a state.
pub(super) fn columns(state: &State<Disks>) -> (Vec<Vector2<f64>>, Vec<Vector2<f64>>) {
    state
        .bodies
        .iter()
        .map(|body| (body.position, body.velocity))
        .unzip()
}

/// Amplitudes of modes of a state.
pub(super) fn amplitudes(state: &State<Disks>, modes: &Modes) -> Result<Vec<Amplitude>, Trouble> {
    let (positions, velocities) = columns(state);
    Ok(modes.measure(&positions, &velocities)?)
}

/// Temperature and a2 of a state of unit disks.
pub(super) fn energy(state: &State<Disks>) -> EnergySample {
    EnergySample::new(&particles(Constant::ELASTIC, UNIT), state, 0)
}

/// Shear waves: their velocities `2/N Σ v_t cos(k · r)` and the same with the sine, and the temperature without them.
///
/// A wave of amplitude a has the energy a²/4 a disk, and T is the energy of a disk.
pub(super) fn waves(state: &State<Disks>, modes: &Modes) -> Result<(Vec<[f64; 2]>, f64), Trouble> {
    let scale = 2.0 / state.bodies.len().max(1) as f64;
    let waves: Vec<_> = amplitudes(state, modes)?
        .iter()
        .map(|amplitude| amplitude.transverse.map(|part| scale * part))
        .collect();
    let flow: f64 = waves.iter().flatten().map(|a| a * a / 4.0).sum();
    Ok((waves, energy(state).temperature - flow))
}
