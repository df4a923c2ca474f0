//! State of a gas, its particles in a box at one time: the form in which engines, measurements and
//! files exchange it.

use serde::{Deserialize, Serialize};

use crate::domain::Domain;
use crate::physics::{ParticleModel, SpinOf, VectorOf};
use crate::sizes::Sizes;
use crate::space::{Space, Vector};
use crate::surface::Surface;

/// State of one particle: position, velocity and spin, as engines exchange it. Engines keep working
/// storage of their own.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct ParticleState<P: ParticleModel> {
    /// Position of the particle \[length\], inside the box.
    pub position: VectorOf<P>,
    /// Velocity of the particle's centre \[length/time\].
    pub velocity: VectorOf<P>,
    /// Angular velocity of the particle \[1/time\]; `()` for smooth particles.
    pub spin: SpinOf<P>,
}

impl<P: ParticleModel> ParticleState<P> {
    /// Creates the state of a particle that does not spin.
    pub fn new(position: VectorOf<P>, velocity: VectorOf<P>) -> Self {
        Self {
            position,
            velocity,
            spin: SpinOf::<P>::default(),
        }
    }
}

// A derived `Clone` or `Copy` would require it of `P` too.
#[expect(
    clippy::expl_impl_clone_on_copy,
    reason = "a derived Clone would demand `P: Clone`"
)]
impl<P: ParticleModel> Clone for ParticleState<P> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P: ParticleModel> Copy for ParticleState<P> {}
impl<P: ParticleModel> PartialEq for ParticleState<P> {
    fn eq(&self, other: &Self) -> bool {
        self.position == other.position
            && self.velocity == other.velocity
            && self.spin == other.spin
    }
}
impl<P: ParticleModel> std::fmt::Debug for ParticleState<P> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Body")
            .field("position", &self.position)
            .field("velocity", &self.velocity)
            .field("spin", &self.spin)
            .finish()
    }
}

/// State of a gas: all particles in their box at one time.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct State<P: ParticleModel> {
    /// Time at which the gas has this state \[time\].
    pub time: f64,
    /// Box of the gas, with its periodic axes.
    pub domain: Domain<P::Space>,
    /// States of all particles; the index of a particle in this list gives its size.
    pub bodies: Vec<ParticleState<P>>,
}

impl<P: ParticleModel> Clone for State<P> {
    fn clone(&self) -> Self {
        Self {
            time: self.time,
            domain: self.domain,
            bodies: self.bodies.clone(),
        }
    }
}

impl<P: ParticleModel> State<P> {
    /// Returns the kinetic energy of translation of all particles, sum of m v^2/2 \[energy\].
    pub fn kinetic_energy(&self, scene: &P) -> f64 {
        let sizes = scene.sizes();
        let twice: f64 = self
            .bodies
            .iter()
            .enumerate()
            .map(|(index, body)| sizes.mass(sizes.tag_of(index)) * body.velocity.square())
            .sum();
        0.5 * twice
    }

    /// Returns the kinetic energy of rotation of all particles, sum of I w^2/2 \[energy\]; zero for
    /// smooth particles.
    pub fn spin_energy(&self, scene: &P) -> f64 {
        let sizes = scene.sizes();
        let bodies = self.bodies.iter().enumerate();
        bodies
            .map(|(index, body)| {
                let tag = sizes.tag_of(index);
                let (mass, radius) = (sizes.mass(tag), sizes.radius(tag));
                scene.surface().spin_energy(mass, radius, body.spin)
            })
            .sum()
    }

    /// Returns the rotational granular temperature, <I w^2>/`ROTATIONS` \[energy\].
    pub fn spin_temperature(&self, scene: &P) -> f64 {
        let degrees = (P::Space::ROTATIONS * self.bodies.len().max(1)) as f64;
        2.0 * self.spin_energy(scene) / degrees
    }

    /// Returns the total momentum of the particles, sum of m v \[mass length/time\].
    pub fn momentum(&self, scene: &P) -> VectorOf<P> {
        let sizes = scene.sizes();
        let mut total = VectorOf::<P>::default();
        for (index, body) in self.bodies.iter().enumerate() {
            total += body.velocity * sizes.mass(sizes.tag_of(index));
        }
        total
    }

    /// Returns the granular temperature of translation, <m v^2>/D \[energy\].
    pub fn temperature(&self, scene: &P) -> f64 {
        let degrees = (P::Space::DIMENSION * self.bodies.len().max(1)) as f64;
        2.0 * self.kinetic_energy(scene) / degrees
    }

    /// Returns the packing fraction: the fraction of the box that particles cover.
    pub fn packing_fraction(&self, scene: &P) -> f64 {
        let sizes = scene.sizes();
        let covered: f64 = (0..self.bodies.len())
            .map(|index| P::Space::particle_volume(sizes.radius(sizes.tag_of(index))))
            .sum();
        covered / self.domain.volume()
    }
}
