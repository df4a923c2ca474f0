//! Gas of particles without positions.

use rand::Rng;
use serde::{Deserialize, Serialize};
use stosszahl_model::initial::VelocityDistribution;
use stosszahl_model::{
    Free, InvalidValue, ParticleModel, Sizes, Smooth, Space, Vector, VectorOf, memory,
};

use super::error::HomogeneousError;
use super::kernel::{CollisionKernel, PairCorrelationFactor};

/// Physics of smooth particles in free flight.
pub trait SmoothPhysics: ParticleModel<Surface = Smooth, Field = Free> {}
impl<P: ParticleModel<Surface = Smooth, Field = Free>> SmoothPhysics for P {}

/// Tag that identifies the size of a particle.
pub type TagOf<P> = <<P as ParticleModel>::Sizes as Sizes>::Tag;

/// Mark of a particle that has merged into another and waits for removal.
pub(crate) const GONE: u32 = u32::MAX;

/// One particle: 32 bytes, so that a pair is two cache lines.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
#[repr(align(32))]
pub struct GasParticle<P: ParticleModel> {
    /// Velocity \[length/time\].
    pub velocity: VectorOf<P>,
    /// Tag of the size.
    pub tag: TagOf<P>,
    /// Position of the particle in the selection of pairs.
    pub(crate) mark: u32,
}

impl<P: ParticleModel> GasParticle<P> {
    /// Creates a particle that is in no selection yet.
    pub fn new(velocity: VectorOf<P>, tag: TagOf<P>) -> Self {
        Self {
            velocity,
            tag,
            mark: 0,
        }
    }

    /// Returns true if the particle has merged into another particle.
    #[inline]
    pub fn is_gone(&self) -> bool {
        self.mark == GONE
    }
}

#[expect(
    clippy::expl_impl_clone_on_copy,
    reason = "a derived Clone would demand `P: Clone`"
)]
impl<P: ParticleModel> Clone for GasParticle<P> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P: ParticleModel> Copy for GasParticle<P> {}

/// Squared speed below which the fastest particle counts as at rest: products of speeds would soon
/// underflow.
pub(crate) const COLDEST: f64 = 1e-280;

/// Gas without positions: collisions depend on speeds and sizes alone.
#[derive(Clone, Debug)]
pub struct HomogeneousGas<P: ParticleModel> {
    pub(crate) scene: P,
    pub(crate) kernel: CollisionKernel,
    pub(crate) contact: PairCorrelationFactor,
    pub(crate) volume: f64,
    pub(crate) particles: Vec<GasParticle<P>>,
    /// Number of particles that are gone but still in the list.
    pub(crate) gone: usize,
}

/// Returns the group of radii that lie within 1/16 of each other: exponent and four bits of the
/// fraction.
#[inline]
pub(crate) fn size_key(radius: f64) -> u32 {
    (radius.to_bits() >> 48) as u32
}

impl<P: SmoothPhysics> HomogeneousGas<P> {
    /// Creates a gas of particles in a volume (an area in the plane). Particles are reordered by
    /// size; equals keep their order.
    ///
    /// # Errors
    /// [`HomogeneousError`] if the volume is not positive and finite, a velocity not finite, the
    /// gas packed too densely for its contact values, or 2^31 particles or more.
    pub fn new(
        scene: P,
        contact: PairCorrelationFactor,
        volume: f64,
        particles: impl IntoIterator<Item = (VectorOf<P>, TagOf<P>)>,
    ) -> Result<Self, HomogeneousError> {
        InvalidValue::unless_positive("volume", volume)?;
        let particles = particles.into_iter();
        let mut list = memory::reserved(particles.size_hint().0);
        for (velocity, tag) in particles {
            let square = velocity.square();
            InvalidValue::require(
                square.is_finite(),
                "squared speed",
                square,
                "a finite number",
            )?;
            list.push(GasParticle::new(velocity, tag));
        }
        let count = list.len();
        InvalidValue::require(
            count < 1 << 31,
            "number of particles",
            count as f64,
            "below 2^31",
        )?;
        let mut gas = Self {
            kernel: CollisionKernel::dilute(P::Space::DIMENSION, volume),
            scene,
            contact,
            volume,
            particles: list,
            gone: 0,
        };
        gas.sort();
        gas.measure_contacts()?;
        Ok(gas)
    }

    /// Creates a gas with Maxwellian velocities; `temperature` is the temperature of each species
    /// \[energy\]: [`HomogeneousGas::drawn`].
    ///
    /// # Errors
    /// As [`HomogeneousGas::new`].
    pub fn maxwellian(
        scene: P,
        contact: PairCorrelationFactor,
        volume: f64,
        count: usize,
        temperature: impl Fn(u32) -> f64,
        stream: &mut impl Rng,
    ) -> Result<Self, HomogeneousError> {
        let law = VelocityDistribution::MAXWELLIAN;
        Self::drawn(scene, contact, volume, count, temperature, law, stream)
    }

    /// Creates a gas of `count` particles, numbered from 0, whose sizes the scene has by their
    /// number. Velocities are of a distribution, with the given temperature m<v^2>/D for each
    /// species, without drift.
    ///
    /// # Errors
    /// As [`HomogeneousGas::new`].
    pub fn drawn(
        scene: P,
        contact: PairCorrelationFactor,
        volume: f64,
        count: usize,
        temperature: impl Fn(u32) -> f64,
        law: VelocityDistribution,
        stream: &mut impl Rng,
    ) -> Result<Self, HomogeneousError> {
        let sizes = scene.sizes().clone();
        let particles = (0..count).map(|index| {
            let tag = sizes.tag_of(index);
            let spread = (temperature(sizes.species_of(tag)) / sizes.mass(tag)).sqrt();
            (law.draw::<P::Space>(spread, stream), tag)
        });
        let mut gas = Self::new(scene, contact, volume, particles)?;
        gas.set_temperatures(temperature);
        Ok(gas)
    }

    /// Removes the drift and gives every species its temperature exactly, if it has more than two
    /// particles.
    fn set_temperatures(&mut self, temperature: impl Fn(u32) -> f64) {
        for _ in 0..3 {
            self.remove_drift();
            let mut species: Vec<(usize, f64)> = Vec::new();
            let sizes = self.scene.sizes();
            for particle in &self.particles {
                let kind = sizes.species_of(particle.tag) as usize;
                if kind >= species.len() {
                    species.resize(kind + 1, (0, 0.0));
                }
                species[kind].0 += 1;
                species[kind].1 += sizes.mass(particle.tag) * particle.velocity.square();
            }
            let factors: Vec<f64> = species
                .iter()
                .enumerate()
                .map(|(kind, &(count, twice))| {
                    let wanted = (count * P::Space::DIMENSION) as f64 * temperature(kind as u32);
                    if count > 2 && twice > 0.0 {
                        (wanted / twice).sqrt()
                    } else {
                        1.0
                    }
                })
                .collect();
            for particle in &mut self.particles {
                let kind = self.scene.sizes().species_of(particle.tag) as usize;
                particle.velocity = particle.velocity * factors[kind];
            }
        }
        self.remove_drift();
    }

    /// Subtracts the velocity of the centre of mass.
    pub fn remove_drift(&mut self) {
        self.remove_drift_of(|_| true);
    }

    /// Subtracts the velocity of the centre of mass of some species from theirs.
    pub(crate) fn remove_drift_of(&mut self, chosen: impl Fn(u32) -> bool) {
        self.remove_drift_if(chosen, |_, _| true);
    }

    /// Subtracts a drift that rounding has left: below 1e-10 of the thermal speed. The drift would
    /// never decay while the gas cools, and at last exceed all relative motion.
    pub(crate) fn remove_rounding(&mut self, chosen: impl Fn(u32) -> bool) {
        self.remove_drift_if(chosen, |drift, thermal| drift < 1e-20 * thermal);
    }

    /// Subtracts the velocity of the centre of mass of some species if `remove`, given its square
    /// and their mean squared speed, is true.
    fn remove_drift_if(&mut self, chosen: impl Fn(u32) -> bool, remove: impl Fn(f64, f64) -> bool) {
        let sizes = self.scene.sizes();
        let among = |particle: &GasParticle<P>| {
            !particle.is_gone() && chosen(sizes.species_of(particle.tag))
        };
        let (mut mass, mut energy) = (0.0, 0.0);
        let mut momentum = VectorOf::<P>::default();
        for particle in self.particles.iter().filter(|particle| among(particle)) {
            mass += sizes.mass(particle.tag);
            energy += 0.5 * sizes.mass(particle.tag) * particle.velocity.square();
            momentum += particle.velocity * sizes.mass(particle.tag);
        }
        let drift = momentum * (1.0 / f64::max(mass, f64::MIN_POSITIVE));
        if !remove(
            drift.square(),
            2.0 * energy / f64::max(mass, f64::MIN_POSITIVE),
        ) {
            return;
        }
        for particle in self.particles.iter_mut().filter(|particle| among(particle)) {
            particle.velocity -= drift;
        }
    }

    /// Removes merged particles and sorts all remaining ones by size; equals keep their order.
    pub(crate) fn sort(&mut self) {
        if self.gone > 0 {
            self.particles.retain(|particle| !particle.is_gone());
            self.gone = 0;
        }
        let sizes = self.scene.sizes();
        let key = |particle: &GasParticle<P>| size_key(sizes.radius(particle.tag));
        if !self.particles.is_sorted_by_key(key) {
            self.particles.sort_by_key(key);
        }
    }

    /// Adapts the kernel to the current sizes.
    pub(crate) fn measure_contacts(&mut self) -> Result<(), HomogeneousError> {
        let radii = self.alive().map(|particle| self.radius(particle));
        let kernel = CollisionKernel::of_gas(self.contact, P::Space::DIMENSION, self.volume, radii);
        let largest = self.scene.sizes().largest_radius();
        let found = kernel.rate_coefficient(largest, largest);
        let mut coefficients = kernel.coefficients().iter().flatten();
        let is_good = found.is_finite() && coefficients.all(|&m| m >= 0.0);
        let name = "collision rate of the largest pair per speed";
        let allowed = "a finite number: the gas is packed too densely, or its volume is too small";
        InvalidValue::require(is_good, name, found, allowed)?;
        self.kernel = kernel;
        Ok(())
    }

    /// Returns the particles that are not gone.
    pub fn alive(&self) -> impl Iterator<Item = &GasParticle<P>> {
        self.particles.iter().filter(|particle| !particle.is_gone())
    }

    /// Number of particles that are not gone.
    pub fn count(&self) -> usize {
        self.particles.len() - self.gone
    }

    /// Returns the scene.
    pub fn scene(&self) -> &P {
        &self.scene
    }

    /// Volume \[length^D\]; an area in the plane.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Returns the current kernel.
    pub fn kernel(&self) -> &CollisionKernel {
        &self.kernel
    }

    /// Radius of a particle \[length\].
    #[inline]
    pub fn radius(&self, particle: &GasParticle<P>) -> f64 {
        self.scene.sizes().radius(particle.tag)
    }

    /// Mass of a particle.
    #[inline]
    pub fn mass(&self, particle: &GasParticle<P>) -> f64 {
        self.scene.sizes().mass(particle.tag)
    }

    /// Kinetic energy, (1/2) sum m v^2 \[energy\].
    pub fn kinetic_energy(&self) -> f64 {
        let twice: f64 = self
            .alive()
            .map(|particle| self.mass(particle) * particle.velocity.square())
            .sum();
        0.5 * twice
    }

    /// Momentum, sum m v.
    pub fn momentum(&self) -> VectorOf<P> {
        let mut sum = VectorOf::<P>::default();
        for particle in self.alive() {
            sum += particle.velocity * self.mass(particle);
        }
        sum
    }
}
