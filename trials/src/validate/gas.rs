//! Initial states, simulations by either engine, and measurements that all parts of the validation
//! share.

use nalgebra::{Vector2, Vector3};
use stosszahl_analysis::energy::EnergySample;
use stosszahl_analysis::modes::{Amplitude, Modes, shear_waves};
use stosszahl_dsmc::{BoundaryConditions, CellGas, DsmcEngine, Parameters, Tracked};
use stosszahl_ed::DissipationRule;
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::samples::{EqualDisks, UNIT, particles_of, state};
use stosszahl_model::{Budget, Observer, ParticleSpec, Particles, Simulation, State, initial};

use crate::gas::{disks, disordered, domain, law, relaxed};
use crate::{Done, TrialError};

/// Creates randomly placed unit disks at T = 1, equilibrated by some elastic collisions per disk
/// under exact dynamics, at time zero.
pub(super) fn start(
    count: usize,
    packing: f64,
    seed: u64,
    collisions: f64,
) -> Result<Particles, TrialError> {
    let start = relaxed(disordered(count, packing, seed)?, collisions)?;
    Ok(particles_of(&UNIT, &start))
}

fn grains(restitution: f64) -> Result<ParticleSpec, TrialError> {
    Ok(ParticleSpec::equal(
        UNIT.radius,
        UNIT.mass,
        law(restitution)?,
    ))
}

/// Creates an event-driven simulation of unit disks from initial particles.
pub(super) fn exact(
    start: &Particles,
    restitution: f64,
) -> Result<Box<dyn Simulation>, TrialError> {
    let (boundaries, grains) = (
        stosszahl_ed::DiskBoundaries::periodic(),
        grains(restitution)?,
    );
    Ok(stosszahl_ed::simulate(
        &grains,
        DissipationRule::Scene,
        &boundaries,
        start,
    )?)
}

/// Creates a Monte Carlo simulation with fresh Maxwellian velocities of every simulator, zero
/// momentum and T = 1 exactly. Otherwise the simulators of a disk would have rotated copies of its
/// velocity, as far from a Maxwellian as the few disks are.
pub(super) fn monte_carlo(
    start: &Particles,
    restitution: f64,
    parameters: Parameters,
    seed: u64,
) -> Result<Box<dyn Simulation>, TrialError> {
    let streams = Streams::new(seed, 1);
    let gas = CellGas {
        grains: &grains(restitution)?,
        parameters,
        boundaries: &BoundaryConditions::default(),
        streams,
        displacements: false,
    };
    let mut gas = stosszahl_dsmc::simulate(&gas, std::slice::from_ref(start))?;
    let changes = to_maxwellian(&gas.particles(), streams)?;
    let changes: Vec<_> = changes.iter().map(|change| change.push(0.0)).collect();
    gas.add_velocities(&changes)?;
    Ok(gas)
}

/// Creates an elastic Monte Carlo engine, whose counters also have the momentum transfer of
/// collisions.
pub(super) fn cells(
    start: &Particles,
    parameters: Parameters,
    seed: u64,
) -> Result<DsmcEngine<EqualDisks, Tracked>, TrialError> {
    let (streams, domain) = (
        Streams::new(seed, 1),
        domain(start.lengths[0], start.lengths[1])?,
    );
    let (places, velocities) = columns(start);
    let start = state(domain, places.into_iter().zip(velocities));
    let mut engine = DsmcEngine::setup(&disks(1.0)?, parameters, streams).start(&start)?;
    engine.kick(&to_maxwellian(
        &particles_of(&UNIT, &engine.state()),
        streams,
    )?);
    Ok(engine)
}

/// Returns the velocity changes that give every particle a new Maxwellian velocity.
fn to_maxwellian(gas: &Particles, streams: Streams) -> Result<Vec<Vector2<f64>>, TrialError> {
    let (places, velocities) = columns(gas);
    let places = places.into_iter().map(|at| (at, Vector2::zeros()));
    let mut other: State<EqualDisks> = state(domain(gas.lengths[0], gas.lengths[1])?, places);
    let mut stream = streams.stream_at(Purpose::Velocities, [1, 0]);
    initial::maxwellian(&disks(1.0)?, &mut other, 1.0, &mut stream);
    let bodies = other.bodies.iter().zip(velocities);
    Ok(bodies.map(|(new, old)| new.velocity - old).collect())
}

/// Advances a simulation to a time in the segments of a usual run, from checkpoint to checkpoint.
pub(super) fn advance(gas: &mut dyn Simulation, until: f64, observer: &mut dyn Observer) -> Done {
    while !gas.advance(until, Budget::Leg, observer)? {}
    Ok(())
}

/// Adds shear waves to a gas in all given modes, with a velocity amplitude over the thermal speed.
pub(super) fn kick(gas: &mut dyn Simulation, modes: &Modes, velocity: f64) -> Done {
    let changes = shear_waves(modes, &columns(&gas.particles()).0, velocity)?;
    let changes: Vec<Vector3<f64>> = changes.iter().map(|change| change.push(0.0)).collect();
    Ok(gas.add_velocities(&changes)?)
}

/// Returns positions and velocities of particles in the plane, as two lists.
pub(super) fn columns(gas: &Particles) -> (Vec<Vector2<f64>>, Vec<Vector2<f64>>) {
    let columns = |one: &stosszahl_model::Particle| (one.position.xy(), one.velocity.xy());
    gas.all.iter().map(columns).unzip()
}

/// Creates the Fourier modes with the given indices in the box of a gas.
pub(super) fn modes(gas: &Particles, indices: Vec<[i32; 2]>) -> Result<Modes, TrialError> {
    Ok(Modes::new([gas.lengths[0], gas.lengths[1]], indices)?)
}

/// Measures the Fourier amplitudes of density and velocity in the given modes of a gas.
pub(super) fn amplitudes(gas: &Particles, modes: &Modes) -> Result<Vec<Amplitude>, TrialError> {
    let (positions, velocities) = columns(gas);
    Ok(modes.measure(&positions, &velocities)?)
}

/// Measures the temperature and the fourth cumulant a2 of a gas.
pub(super) fn energy(gas: &Particles) -> EnergySample {
    EnergySample::of_particles(gas, 0)
}

/// Measures the amplitudes of shear waves, `2/N Σ v_t cos(k · r)` and with the sine, and the
/// temperature without them. Here `v_t` is the transverse velocity of N particles at r.
///
/// A wave of amplitude a has the energy a²/4 a disk, and T is the energy of a disk.
pub(super) fn waves(gas: &Particles, modes: &Modes) -> Result<(Vec<[f64; 2]>, f64), TrialError> {
    let scale = 2.0 / gas.all.len().max(1) as f64;
    let waves: Vec<_> = amplitudes(gas, modes)?
        .iter()
        .map(|amplitude| amplitude.transverse.map(|part| scale * part))
        .collect();
    let flow: f64 = waves.iter().flatten().map(|a| a * a / 4.0).sum();
    Ok((waves, energy(gas).temperature - flow))
}
