//! Small gases for tests and examples: particle models, and initial states that a seed determines.
//!
//! All functions panic on invalid values. Equal arguments give equal bytes.

#![allow(clippy::missing_panics_doc, reason = "said once, at the top")]

use rand::RngExt;

use crate::domain::Domain;
use crate::field::{Free, Gravity};
use crate::initial::{self, Arrangement, PlacementError};
use crate::interrupt::Interrupt;
use crate::particle::Particle;
use crate::physics::{ParticleModel, Scene, VectorOf};
use crate::random::{Purpose, Streams};
use crate::restitution::{Constant, Law};
use crate::simulation::Particles;
use crate::sizes::{Monodisperse, Polydisperse, Sizes};
use crate::space::{Plane, Space, Vector, Volume};
use crate::species::{Species, SpeciesProperties};
use crate::state::{ParticleState, State};
use crate::surface::{Smooth, Surface};

/// Smooth particles in free flight between collisions, with the contact law that programs have:
/// engines for it are compiled already.
pub type SmoothParticles<S, Z = Monodisperse> = Scene<S, Smooth, Law, Z, Free>;
/// Smooth equal hard disks.
pub type EqualDisks = SmoothParticles<Plane>;
/// Smooth hard disks, each with its own radius and mass.
pub type DiskMixture = SmoothParticles<Plane, Polydisperse>;
/// Particles of one or several species under gravity, with the contact law that programs have.
pub type FallingParticles<S, C> = Scene<S, C, Law, Species, Gravity<S>>;
/// Smooth hard disks of one or several species under gravity.
pub type FallingDisks = FallingParticles<Plane, Smooth>;

/// Size of unit particles: diameter and mass one.
pub const UNIT: Monodisperse = Monodisperse {
    radius: 0.5,
    mass: 1.0,
};

/// Creates the contact law of a constant coefficient of restitution.
pub fn law(restitution: f64) -> Law {
    Constant::new(restitution).expect("a coefficient").into()
}

/// Creates the model of smooth particles of given sizes in free flight.
pub fn smooth_particles<S: Space, Z>(
    restitution: impl Into<Law>,
    sizes: Z,
) -> SmoothParticles<S, Z> {
    Scene::new(Smooth, restitution.into(), sizes, Free)
}

/// Creates the model of smooth unit particles in the plane or in space.
pub fn equal<S: Space>(restitution: f64) -> SmoothParticles<S> {
    smooth_particles(law(restitution), UNIT)
}

/// Creates the model of smooth unit disks.
pub fn disks(restitution: f64) -> EqualDisks {
    equal(restitution)
}

/// Creates the model of smooth disks with the given (radius, mass) pairs.
pub fn mixture(restitution: f64, sizes: impl IntoIterator<Item = (f64, f64)>) -> DiskMixture {
    let sizes = Polydisperse::new(sizes.into_iter().collect());
    smooth_particles(law(restitution), sizes.expect("sizes"))
}

/// Creates the sizes of species from the (radius, mass, number of particles) of each.
pub fn species(kinds: impl IntoIterator<Item = (f64, f64, usize)>) -> Species {
    let kind = |(radius, mass, count)| SpeciesProperties {
        radius,
        mass,
        count,
    };
    Species::new(kinds.into_iter().map(kind).collect()).expect("species")
}

/// Creates the model of any number of equal particles of mass one under gravity.
pub fn grains<S: Space, C: Surface<S>>(
    diameter: f64,
    restitution: f64,
    surface: C,
    gravity: Gravity<S>,
) -> FallingParticles<S, C> {
    let one = species([(0.5 * diameter, 1.0, u32::MAX as usize)]);
    Scene::new(surface, law(restitution), one, gravity)
}

/// Returns zero gravity.
pub fn no_gravity<S: Space>() -> Gravity<S> {
    Gravity::new(S::from_components(|_| 0.0)).expect("finite")
}

/// Creates the periodic square in which `count` unit disks have the given packing fraction.
pub fn square(count: usize, packing_fraction: f64) -> Domain<Plane> {
    let area = count as f64 * Plane::particle_volume(UNIT.radius) / packing_fraction;
    let width = area.sqrt();
    // The area is exact to the last bit so.
    Domain::periodic(Plane::from_components(|axis| [width, area / width][axis])).expect("a box")
}

/// Creates a state at time zero from positions and velocities of particles without spin.
pub fn state<P: ParticleModel>(
    domain: Domain<P::Space>,
    bodies: impl IntoIterator<Item = (VectorOf<P>, VectorOf<P>)>,
) -> State<P> {
    let bodies = bodies.into_iter();
    State {
        time: 0.0,
        domain,
        bodies: bodies
            .map(|(at, velocity)| ParticleState::new(at, velocity))
            .collect(),
    }
}

/// Creates a state of particles at given positions with Maxwellian velocities of a temperature
/// \[energy\], without spin and total momentum.
pub fn maxwellian<P: ParticleModel>(
    scene: &P,
    domain: Domain<P::Space>,
    positions: impl IntoIterator<Item = VectorOf<P>>,
    temperature: f64,
    seed: u64,
) -> State<P> {
    let bodies = positions.into_iter();
    let mut state = state(domain, bodies.map(|at| (at, VectorOf::<P>::default())));
    let mut stream = Streams::new(seed, 0).stream_at(Purpose::Velocities, [0, 0]);
    initial::maxwellian(scene, &mut state, temperature, &mut stream);
    state
}

/// Creates an ideal gas: uniform random positions in a box without its margins \[length\], where
/// particles may overlap, and [`maxwellian`] velocities.
pub fn ideal_gas<P: ParticleModel>(
    scene: &P,
    domain: Domain<P::Space>,
    margin: f64,
    count: usize,
    temperature: f64,
    seed: u64,
) -> State<P> {
    let mut stream = Streams::new(seed, 0).stream_at(Purpose::Placement, [0, 0]);
    let lengths = domain.lengths();
    let positions = (0..count).map(|_| {
        P::Space::from_components(|axis| {
            margin + (lengths[axis] - 2.0 * margin) * stream.random::<f64>()
        })
    });
    maxwellian(scene, domain, positions, temperature, seed)
}

/// Creates an [`ideal_gas`] of unit particles at temperature one in a periodic square or cube.
pub fn ideal_particles(dimension: usize, side: f64, count: usize, seed: u64) -> Particles {
    fn particles<S: Space>(side: f64, count: usize, seed: u64) -> Particles {
        let domain = Domain::periodic(S::from_components(|_| side)).expect("a box");
        let state = ideal_gas(&equal::<S>(1.0), domain, 0.0, count, 1.0, seed);
        particles_of(&UNIT, &state)
    }
    match dimension {
        2 => particles::<Plane>(side, count, seed),
        _ => particles::<Volume>(side, count, seed),
    }
}

/// Creates a gas of unit disks without overlap, at temperature one.
///
/// # Errors
/// As [`initial::place_disks`].
pub fn placed_disks(
    arrangement: Arrangement,
    count: usize,
    domain: Domain<Plane>,
    seed: u64,
) -> Result<State<EqualDisks>, PlacementError> {
    let (streams, never) = (Streams::new(seed, 0), Interrupt::default());
    let placed = initial::place_disks(arrangement, count, 1.0, &domain, &streams, &never)?;
    Ok(maxwellian(&disks(1.0), domain, placed.positions, 1.0, seed))
}

/// Converts a state of smooth particles to the list that all engines share.
pub fn particles_of<P: ParticleModel<Surface = Smooth>>(
    sizes: &P::Sizes,
    state: &State<P>,
) -> Particles {
    let particle = |(index, body): (usize, &ParticleState<P>)| {
        let tag = sizes.tag_of(index);
        Particle {
            position: body.position.spatial(),
            velocity: body.velocity.spatial(),
            species: sizes.species_of(tag),
            ..Particle::at_rest(sizes.radius(tag), sizes.mass(tag))
        }
    };
    let dimension = P::Space::DIMENSION;
    Particles {
        time: state.time,
        dimension,
        lengths: state.domain.lengths().spatial().into(),
        periodic: [0, 1, 2].map(|axis| axis >= dimension || state.domain.is_periodic(axis)),
        all: state.bodies.iter().enumerate().map(particle).collect(),
    }
}
