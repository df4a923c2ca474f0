//! Specification of the particles of a gas at run time (sizes, contact laws, field), and the
//! particle models that engines need for it.
//!
//! Engines are generic; a program that reads a case is not. [`ParticleSpec`] describes the
//! particles and makes the [`Scene`] that stands for them. An engine's crate chooses among scenes
//! by what changes that which is stored or computed for each particle. All else is data in it.

use nalgebra::Vector3;

use crate::field::{Free, Gravity, Sheared};
use crate::images::Shear;
use crate::invalid::InvalidValue;
use crate::physics::Scene;
use crate::restitution::Law;
use crate::sizes::{Monodisperse, Polydisperse, Sizes as _};
use crate::space::Space;
use crate::species::Species;
use crate::surface::{Rough, Smooth, Surface};

/// Size distribution chosen at run time: radii and masses of all particles.
#[derive(Clone, Debug, PartialEq)]
pub enum SizeDistribution {
    /// One radius and one mass for all particles.
    Equal(Monodisperse),
    /// Individual radius and mass of each particle.
    Each(Polydisperse),
    /// Several species, each with one radius and mass, one after the other.
    Species(Species),
}

/// Specification of the particles of a gas: sizes, contact laws, and the field in which they fly.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticleSpec {
    /// Radii \[length\] and masses \[mass\] of all particles.
    pub sizes: SizeDistribution,
    /// Normal contact law: the coefficient of restitution.
    pub restitution: Law,
    /// Tangential contact law of rough particles; `None` for smooth particles, which do not spin.
    pub rough: Option<Rough>,
    /// Uniform acceleration by gravity \[length/time^2\]; `None` without.
    pub gravity: Option<Vector3<f64>>,
    /// Shear rate a of the uniform flow u = (a y, 0) \[1/time\]; velocities are relative to it.
    /// `None` without shear.
    pub shear_rate: Option<f64>,
    /// Displacement of the periodic image above along the first axis at time 0 of the shear flow,
    /// from 0 to the width of the box \[length\].
    pub shear_offset: f64,
    /// True if the box has walls, obstacles or open faces.
    pub is_bounded: bool,
}

impl ParticleSpec {
    /// Creates smooth particles of one radius \[length\] and mass \[mass\] in a periodic box.
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

    /// Returns the shear flow with its state at time 0; `None` without shear.
    pub fn shear(&self) -> Option<Shear> {
        let offset = self.shear_offset;
        self.shear_rate.map(|rate| Shear { rate, offset })
    }

    /// Returns true if particles are smooth and fly freely in a periodic box, so that any type of
    /// sizes will do.
    pub fn is_plain(&self) -> bool {
        self.rough.is_none()
            && self.gravity.is_none()
            && self.shear_rate.is_none()
            && !self.is_bounded
    }

    /// Returns the particle model of smooth particles of these sizes in free flight, for
    /// specifications that are [`Self::is_plain`].
    pub fn plain<S: Space, Z>(&self, sizes: Z) -> Scene<S, Smooth, Law, Z, Free> {
        Scene::new(Smooth, self.restitution.clone(), sizes, Free)
    }

    /// Returns the particle model of any particles with this surface, under gravity or without.
    /// Sizes become species; `count` is the number of particles.
    ///
    /// # Errors
    /// [`InvalidValue`] for sizes or fields out of range.
    pub fn scene<S: Space, C: Surface<S>>(
        &self,
        surface: C,
        count: usize,
    ) -> Result<Scene<S, C, Law, Species, Gravity<S>>, InvalidValue> {
        let (law, sizes) = (self.restitution.clone(), self.species(count)?);
        Ok(Scene::new(surface, law, sizes, self.field()?))
    }

    /// Returns the particle model of smooth particles of these sizes in a uniform shear flow.
    ///
    /// # Errors
    /// [`InvalidValue`] for a rate that is zero or not finite, and where gravity acts too.
    pub fn sheared_smooth<S: Space, Z>(
        &self,
        sizes: Z,
    ) -> Result<Scene<S, Smooth, Law, Z, Sheared>, InvalidValue> {
        let law = self.restitution.clone();
        Ok(Scene::new(Smooth, law, sizes, self.flow()?))
    }

    /// Returns the particle model of any particles with this surface in a uniform shear flow. Sizes
    /// become species; `count` is the number of particles.
    ///
    /// # Errors
    /// [`InvalidValue`] for sizes or rates out of range, and where gravity acts too.
    pub fn sheared<S: Space, C: Surface<S>>(
        &self,
        surface: C,
        count: usize,
    ) -> Result<Scene<S, C, Law, Species, Sheared>, InvalidValue> {
        let (law, sizes) = (self.restitution.clone(), self.species(count)?);
        Ok(Scene::new(surface, law, sizes, self.flow()?))
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
