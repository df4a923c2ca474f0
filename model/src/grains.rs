//! The physics of a gas as data: choices of run time, and the types that they become.
//!
//! Engines are generic; a program that reads a case is not. [`ParticleSpec`] describes the
//! particles and makes the [`Scene`] that stands for them. An engine's crate chooses among scenes
//! by what changes that which is stored or computed for each particle. All else is data in it.

use nalgebra::Vector3;

use crate::field::{Field, Free, Gravity, Sheared};
use crate::images::Shear;
use crate::invalid::InvalidValue;
use crate::physics::Scene;
use crate::restitution::Law;
use crate::sizes::{Monodisperse, Polydisperse, Sizes as _};
use crate::space::Space;
use crate::species::Species;
use crate::surface::{Rough, Smooth, Surface};

/// Radii and masses of all particles.
#[derive(Clone, Debug, PartialEq)]
pub enum SizeDistribution {
    /// One radius and one mass for all.
    Equal(Monodisperse),
    /// Radius and mass of each particle.
    Each(Polydisperse),
    /// Species, one after the other.
    Species(Species),
}

/// Particles, their contact laws, and the field that they fly in.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticleSpec {
    /// Radii \[length\] and masses.
    pub sizes: SizeDistribution,
    /// The normal contact law.
    pub restitution: Law,
    /// The tangential contact law; none for smooth particles, which do not spin.
    pub rough: Option<Rough>,
    /// A uniform acceleration \[length/time^2\].
    pub gravity: Option<Vector3<f64>>,
    /// Shear rate a of the flow u = (a y, 0) \[1/time\]; velocities are relative to it.
    pub shear_rate: Option<f64>,
    /// Displacement of the box above along the first axis at time 0 of the shear flow, from 0 to the
    /// width of the box \[length\].
    pub shear_offset: f64,
    /// True if walls, obstacles or openings are in the box.
    pub is_bounded: bool,
}

impl ParticleSpec {
    /// Creates smooth particles of one radius \[length\] and mass in a periodic box.
    pub fn equal(radius: f64, mass: f64, restitution: impl Into<Law>) -> Self {
        Self {
            sizes: SizeDistribution::Equal(Monodisperse { radius, mass }),
            restitution: restitution.into(),
            rough: None,
            gravity: None,
            shear_rate: None,
            shear_offset: 0.0,
            is_bounded: false,
        }
    }

    /// Returns the sizes as species, which scenes with walls, spin or gravity need. `count`: number
    /// of particles.
    ///
    /// # Errors
    /// [`InvalidValue`] for sizes out of range.
    pub fn species(&self, count: usize) -> Result<Species, InvalidValue> {
        let kind = |radius, mass, count| crate::species::SpeciesProperties {
            radius,
            mass,
            count,
        };
        match &self.sizes {
            SizeDistribution::Species(species) => Ok(species.clone()),
            SizeDistribution::Equal(one) => Species::new(vec![kind(one.radius, one.mass, count)]),
            SizeDistribution::Each(all) => {
                let pairs = all.pairs().iter();
                let each = pairs.map(|&(radius, mass)| kind(radius, mass, 1));
                let numbers = (0..all.pairs().len()).map(|index| all.species_of(all.tag_of(index)));
                Species::new(each.collect())?.of_kinds(numbers.collect())
            }
        }
    }

    /// Returns the shear flow as it is at time 0; `None` without one.
    pub fn shear(&self) -> Option<Shear> {
        let offset = self.shear_offset;
        self.shear_rate.map(|rate| Shear { rate, offset })
    }

    /// Returns true if particles are smooth and fly freely in a periodic box, so that sizes need
    /// not be species.
    pub fn is_plain(&self) -> bool {
        self.rough.is_none()
            && self.gravity.is_none()
            && self.shear_rate.is_none()
            && !self.is_bounded
    }

    /// Returns the scene of smooth particles of these sizes in free flight, for grains that are
    /// [`Self::is_plain`].
    pub fn plain<S: Space, Z>(&self, sizes: Z) -> Scene<S, Smooth, Law, Z, Free> {
        scene(Smooth, self, sizes, Free)
    }

    /// Returns the scene of any grains, with this surface; sizes are species, and `count` is the
    /// number of particles.
    ///
    /// # Errors
    /// [`InvalidValue`] for sizes or fields out of range.
    pub fn scene<S: Space, C: Surface<S>>(
        &self,
        surface: C,
        count: usize,
    ) -> Result<Scene<S, C, Law, Species, Gravity<S>>, InvalidValue> {
        Ok(scene(surface, self, self.species(count)?, self.field()?))
    }

    /// Returns the scene of smooth particles of these sizes in a uniform shear flow.
    ///
    /// # Errors
    /// [`InvalidValue`] for a rate that is zero or not finite, and where gravity acts too.
    pub fn sheared_smooth<S: Space, Z>(
        &self,
        sizes: Z,
    ) -> Result<Scene<S, Smooth, Law, Z, Sheared>, InvalidValue> {
        Ok(scene(Smooth, self, sizes, self.flow()?))
    }

    /// Returns the scene of any grains in a uniform shear flow, with this surface; sizes are
    /// species.
    ///
    /// # Errors
    /// [`InvalidValue`] for sizes or rates out of range, and where gravity acts too.
    pub fn sheared<S: Space, C: Surface<S>>(
        &self,
        surface: C,
        count: usize,
    ) -> Result<Scene<S, C, Law, Species, Sheared>, InvalidValue> {
        Ok(scene(surface, self, self.species(count)?, self.flow()?))
    }

    fn flow(&self) -> Result<Sheared, InvalidValue> {
        let rate = self.shear_rate.unwrap_or_default();
        let is_alone = self.gravity.is_none() && !self.is_bounded;
        let allowed = "a periodic box without gravity, walls and obstacles";
        InvalidValue::require(is_alone, "shear rate", rate, allowed)?;
        Sheared::new(rate)
    }

    fn field<S: Space>(&self) -> Result<Gravity<S>, InvalidValue> {
        let pull = self.gravity.unwrap_or_default();
        Gravity::new(S::from_components(|axis| pull[axis]))
    }
}

fn scene<S: Space, C: Surface<S>, Z, F: Field<S>>(
    surface: C,
    grains: &ParticleSpec,
    sizes: Z,
    field: F,
) -> Scene<S, C, Law, Z, F> {
    Scene {
        space: S::default(),
        surface,
        restitution: grains.restitution.clone(),
        sizes,
        field,
    }
}
