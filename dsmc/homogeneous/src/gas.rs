//! Gas of particles without positions: creation from velocity distributions, removal of drift,
//! energy and momentum.

use rand::Rng;
use serde::{Deserialize, Serialize};
use stosszahl_model::initial::VelocityDistribution;
use stosszahl_model::{
    Free, InvalidValue, ParticleModel, Sizes, Smooth, Space, Vector, VectorOf, memory,
};

use super::error::HomogeneousError;
use super::kernel::{CollisionKernel, PairCorrelationFactor};

/// Particle model with smooth surfaces and without a field, as a gas without positions requires.
pub trait SmoothPhysics: ParticleModel<Surface = Smooth, Field = Free> {}
impl<P: ParticleModel<Surface = Smooth, Field = Free>> SmoothPhysics for P {}

/// Tag of a particle model by which the radius, mass and species of a particle are found.
pub type TagOf<P> = <<P as ParticleModel>::Sizes as Sizes>::Tag;

/// Value of `mark` for a particle that has merged into another and is not yet removed from the
/// list.
pub(crate) const GONE: u32 = u32::MAX;

/// Particle of a gas without positions: velocity, tag of its size, and place in the pair selection.
/// Its 32 bytes make a pair two cache lines.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
#[repr(align(32))]
pub struct GasParticle<P: ParticleModel> {
    /// Velocity of the particle \[length/time\].
    pub velocity: VectorOf<P>,
    /// Tag by which radius, mass and species of the particle are found.
    pub tag: TagOf<P>,
    /// Index by which the pair selection finds the particle: its group or size class.
    pub(crate) mark: u32,
}

impl<P: ParticleModel> GasParticle<P> {
    /// Creates a particle that is not yet in any pair selection.
    pub fn new(velocity: VectorOf<P>, tag: TagOf<P>) -> Self {
        Self {
            velocity,
            tag,
            mark: 0,
        }
    }

    /// Returns true if the particle has merged into another, and is not yet removed from the list.
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

/// Squared speed below which the fastest particle counts as at rest \[length^2/time^2\]: products
/// of speeds would soon underflow.
pub(crate) const COLDEST: f64 = 1e-280;

/// Homogeneous gas of particles without positions: collision rates depend on speeds and radii
/// alone.
#[derive(Clone, Debug)]
pub struct HomogeneousGas<P: ParticleModel> {
    pub(crate) scene: P,
    pub(crate) kernel: CollisionKernel,
    pub(crate) contact: PairCorrelationFactor,
    pub(crate) volume: f64,
    pub(crate) particles: Vec<GasParticle<P>>,
    /// Number of particles that have merged into others but are still in the list.
    pub(crate) gone: usize,
}

/// Returns the number of the size class of a radius: radii in a class differ by less than 1/16. It
/// consists of the exponent and four bits of the fraction.
#[inline]
pub(crate) fn size_key(radius: f64) -> u32 {
    (radius.to_bits() >> 48) as u32
}

impl<P: SmoothPhysics> HomogeneousGas<P> {
    /// Creates a gas of particles in a volume (an area in two dimensions) \[length^D\]. Particles
    /// are sorted by radius; equals keep their order.
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

    /// Creates a gas of `count` particles with Maxwellian velocities; `temperature` gives that of
    /// each species \[energy\], see [`HomogeneousGas::drawn`].
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

    /// Creates a gas of `count` particles with random velocities and the sizes of the particle
    /// model. Velocities follow the distribution `law` without drift, with exactly the temperature
    /// m<v^2>/D of each species \[energy\].
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

    /// Removes the drift and scales the velocities of each species with more than two particles to
    /// exactly its temperature \[energy\].
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

    /// Subtracts the centre-of-mass velocity of the gas from all velocities.
    pub fn remove_drift(&mut self) {
        self.remove_drift_of(|_| true);
    }

    /// Subtracts the common centre-of-mass velocity of the chosen species from the velocities of
    /// their particles.
    pub(crate) fn remove_drift_of(&mut self, chosen: impl Fn(u32) -> bool) {
        self.remove_drift_if(chosen, |_, _| true);
    }

    /// Subtracts the centre-of-mass velocity of the chosen species if it is below 1e-10 of the
    /// thermal speed, as rounding leaves it. It would never decay while the gas cools, and at last
    /// exceed all relative motion.
    pub(crate) fn remove_rounding(&mut self, chosen: impl Fn(u32) -> bool) {
        self.remove_drift_if(chosen, |drift, thermal| drift < 1e-20 * thermal);
    }

    /// Subtracts the centre-of-mass velocity of the chosen species if `remove` is true, given the
    /// square of that velocity and the species' mean squared speed.
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

    /// Removes merged particles from the list and sorts the others by radius; equals keep their
    /// order.
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

    /// Recomputes the collision kernel, with its contact values, for the current radii.
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

    /// Returns the particles of the gas, without those that have merged into others.
    pub fn alive(&self) -> impl Iterator<Item = &GasParticle<P>> {
        self.particles.iter().filter(|particle| !particle.is_gone())
    }

    /// Returns the number of particles, without those that have merged into others.
    pub fn count(&self) -> usize {
        self.particles.len() - self.gone
    }

    /// Returns the particle model: sizes and collision law.
    pub fn scene(&self) -> &P {
        &self.scene
    }

    /// Returns the volume of the gas \[length^D\], in two dimensions an area.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Returns the collision kernel for the current radii.
    pub fn kernel(&self) -> &CollisionKernel {
        &self.kernel
    }

    /// Returns the radius of a particle \[length\].
    #[inline]
    pub fn radius(&self, particle: &GasParticle<P>) -> f64 {
        self.scene.sizes().radius(particle.tag)
    }

    /// Returns the mass of a particle \[mass\].
    #[inline]
    pub fn mass(&self, particle: &GasParticle<P>) -> f64 {
        self.scene.sizes().mass(particle.tag)
    }

    /// Returns the kinetic energy of the gas, (1/2) sum m v^2 \[energy\].
    pub fn kinetic_energy(&self) -> f64 {
        let twice: f64 = self
            .alive()
            .map(|particle| self.mass(particle) * particle.velocity.square())
            .sum();
        0.5 * twice
    }

    /// Returns the total momentum of the gas, sum m v \[mass length/time\].
    pub fn momentum(&self) -> VectorOf<P> {
        let mut sum = VectorOf::<P>::default();
        for particle in self.alive() {
            sum += particle.velocity * self.mass(particle);
        }
        sum
    }
}
