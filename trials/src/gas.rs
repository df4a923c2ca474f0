//! Gases for trials of the engines: particle models, boxes, initial states and engines.

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_dsmc::homogeneous::{
    self, Bounce, PairCorrelationFactor, SelectionMethod, SmoothPhysics,
};
use stosszahl_dsmc::{Parameters, PartnerDisplacement, Scheme, SimulatorStart};
use stosszahl_ed::{DissipationRule, EventDrivenEngine};
use stosszahl_model::initial::{self, Arrangement};
use stosszahl_model::random::{Purpose, Stream, Streams};
use stosszahl_model::samples::{
    DiskMixture, EqualDisks, SmoothParticles, UNIT, placed_disks, smooth_particles, species,
};
use stosszahl_model::{
    Constant, Domain, Interrupt, Law, Plane, Polydisperse, Sizes, Species, State, Volume,
};

use crate::TrialError;

/// Smooth hard spheres of several species.
pub type Spheres = SmoothParticles<Volume, Species>;

/// Default parameters of a Monte Carlo scheme in trials.
pub const PLAIN: Parameters = Parameters {
    scheme: Scheme::Boltzmann,
    displacement: PartnerDisplacement::None,
    cell_size: None,
    simulators_per_particle: 1,
    copies: SimulatorStart::Independent,
    steps_per_cell_crossing: 4.0,
    max_contact_value: 10.0,
};

/// Creates the contact law of a constant coefficient of restitution.
pub(crate) fn law(restitution: f64) -> Result<Law, TrialError> {
    Ok(Constant::new(restitution)?.into())
}

/// Creates the model of unit disks with a coefficient of restitution.
///
/// # Errors
///
/// As `law`.
pub fn disks(restitution: f64) -> Result<EqualDisks, TrialError> {
    Ok(smooth_particles(law(restitution)?, UNIT))
}

/// Creates the model of disks with the given (radius, mass) pairs and a coefficient of restitution.
pub(crate) fn mixture(sizes: Vec<(f64, f64)>, restitution: f64) -> Result<DiskMixture, TrialError> {
    Ok(smooth_particles(
        law(restitution)?,
        Polydisperse::new(sizes)?,
    ))
}

/// Creates the model of sphere species, given as (diameter, mass, number), with a coefficient of
/// restitution.
pub(crate) fn spheres(
    kinds: &[(f64, f64, usize)],
    restitution: f64,
) -> Result<Spheres, TrialError> {
    let kinds = kinds.iter();
    let sizes = species(kinds.map(|&(diameter, mass, count)| (0.5 * diameter, mass, count)));
    Ok(smooth_particles(law(restitution)?, sizes))
}

/// Creates a periodic rectangular box with a width and a height \[length\].
pub(crate) fn domain(width: f64, height: f64) -> Result<Domain<Plane>, TrialError> {
    Ok(Domain::periodic(vector![width, height])?)
}

/// Creates the random number stream of a trial from a seed.
pub(crate) fn random(seed: u64) -> Stream {
    Streams::new(seed, 0).stream_at(Purpose::Placement, [0, 0])
}

/// Draws uniform random positions in a rectangle. Particles there may overlap.
pub(crate) fn scattered(
    count: usize,
    low: [f64; 2],
    sides: [f64; 2],
    stream: &mut Stream,
) -> Vec<Vector2<f64>> {
    let mut place = |axis: usize| low[axis] + sides[axis] * stream.random::<f64>();
    (0..count).map(|_| vector![place(0), place(1)]).collect()
}

/// Draws random positions of disks without overlap in a periodic box.
///
/// # Errors
///
/// [`PlacementError`](initial::PlacementError) if a disk finds no free position.
pub(crate) fn random_places<Z: Sizes>(
    sizes: &Z,
    count: usize,
    domain: &Domain<Plane>,
    seed: u64,
) -> Result<Vec<Vector2<f64>>, initial::PlacementError> {
    let radii: Vec<f64> = (0..count)
        .map(|index| sizes.radius(sizes.tag_of(index)))
        .collect();
    let found = initial::place_unequal(
        &radii,
        domain,
        &Streams::new(seed, 0),
        &Interrupt::default(),
    );
    Ok(found?.positions)
}

/// Creates a Maxwellian gas of unit disks at temperature one, in a box whose height over width is
/// `aspect`.
pub(crate) fn fluid(
    arrangement: Arrangement,
    disks: usize,
    packing_fraction: f64,
    aspect: f64,
    seed: u64,
) -> Result<State<EqualDisks>, TrialError> {
    let area = disks as f64 * std::f64::consts::FRAC_PI_4 / packing_fraction;
    let width = (area / aspect).sqrt();
    let domain = domain(width, area / width)?;
    Ok(placed_disks(arrangement, disks, domain, seed)?)
}

/// Creates a gas of randomly placed unit disks at temperature one in a square box.
///
/// # Errors
/// As `fluid`.
pub fn disordered(disks: usize, packing: f64, seed: u64) -> Result<State<EqualDisks>, TrialError> {
    fluid(Arrangement::Disordered, disks, packing, 1.0, seed)
}

/// Equilibrates unit disks by a number of elastic collisions per disk under exact dynamics, and
/// resets the time to zero.
pub(crate) fn relaxed(
    start: State<EqualDisks>,
    collisions_each: f64,
) -> Result<State<EqualDisks>, TrialError> {
    let collisions = (0.5 * collisions_each * start.bodies.len() as f64).ceil() as u64;
    let mut engine =
        EventDrivenEngine::<EqualDisks>::new(disks(1.0)?, DissipationRule::Elastic, start)?;
    engine.advance(f64::INFINITY, collisions, &mut ())?;
    let mut state = engine.into_state();
    state.time = 0.0;
    Ok(state)
}

/// Creates an engine for a gas without positions, with a particle number, a volume and a
/// temperature of each species.
pub(crate) fn without_positions<P: SmoothPhysics, S: SelectionMethod<P>>(
    scene: P,
    contact: PairCorrelationFactor,
    (volume, count): (f64, usize),
    temperature: impl Fn(u32) -> f64,
    seed: u64,
) -> Result<homogeneous::HomogeneousEngine<P, S>, TrialError> {
    let streams = Streams::new(seed, 0);
    let mut start = streams.stream_at(Purpose::Velocities, [0, 0]);
    let gas = homogeneous::HomogeneousGas::maxwellian(
        scene,
        contact,
        volume,
        count,
        temperature,
        &mut start,
    )?;
    Ok(homogeneous::HomogeneousEngine::new(
        gas,
        (),
        Bounce,
        streams,
    )?)
}
