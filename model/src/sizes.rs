//! Sizes of particles, radius and mass: one for the whole gas, or one for each particle.

use std::fmt::Debug;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::invalid::InvalidValue;

/// Sizes of the particles of a gas: radius \[length\] and mass \[mass\], found by a tag.
///
/// Engines that keep particles out of their first order carry a [`Sizes::Tag`] with each: nothing
/// for equal particles, the index for unequal ones.
pub trait Sizes: Clone + Debug + Send + Sync + 'static {
    /// True if the type has one radius and mass for all particles, so that pair factors are
    /// compile-time constants.
    const UNIFORM: bool;
    /// True if a tag belongs to one particle only, so that no particle can be added.
    const INDIVIDUAL: bool;
    /// Tag that an engine stores with each particle to find its size.
    type Tag: Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned + Send + Sync;

    /// Returns the size tag of the particle with an index in the state.
    fn tag_of(&self, index: usize) -> Self::Tag;
    /// Returns the index in the state of a particle with a size tag; `order`, its index in memory,
    /// is used where equal particles store no index.
    fn index_of(tag: Self::Tag, order: usize) -> usize;
    /// Returns the sizes of `times` copies of the gas, one copy after the other.
    #[must_use]
    fn repeat_sizes(&self, times: usize) -> Self;
    /// Returns the radius of a particle with a size tag \[length\].
    fn radius(&self, tag: Self::Tag) -> f64;
    /// Returns the mass of a particle with a size tag \[mass\].
    fn mass(&self, tag: Self::Tag) -> f64;
    /// Returns the largest radius of all particles \[length\].
    fn largest_radius(&self) -> f64;
    /// Returns true if all particles have the same radius and mass, as in a single species.
    #[inline]
    fn are_equal(&self) -> bool {
        Self::UNIFORM
    }
    /// Returns the species of a particle with a size tag, from 0; 0 if there is only one.
    #[inline]
    fn species_of(&self, _tag: Self::Tag) -> u32 {
        0
    }
    /// Returns the number of the block of equal particles in the state to which a particle belongs;
    /// in a repeated mixture, each copy of a species is one block.
    #[inline]
    fn block_of(&self, tag: Self::Tag) -> u32 {
        self.species_of(tag)
    }
}

/// Sizes of equal particles: one radius and one mass for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monodisperse {
    /// Radius of every particle \[length\].
    pub radius: f64,
    /// Mass of every particle \[mass\].
    pub mass: f64,
}

impl Sizes for Monodisperse {
    const UNIFORM: bool = true;
    const INDIVIDUAL: bool = false;
    type Tag = ();

    #[inline]
    fn tag_of(&self, _index: usize) {}
    #[inline]
    fn index_of((): (), order: usize) -> usize {
        order
    }
    fn repeat_sizes(&self, _times: usize) -> Self {
        *self
    }
    #[inline]
    fn radius(&self, (): ()) -> f64 {
        self.radius
    }
    #[inline]
    fn mass(&self, (): ()) -> f64 {
        self.mass
    }
    fn largest_radius(&self) -> f64 {
        self.radius
    }
}

/// Sizes of individual particles: a radius and mass for each; cheap to clone, as replicas share the
/// arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Polydisperse {
    sizes: Arc<[(f64, f64)]>,
    /// Species number of each particle; `None` if all are of one species.
    kinds: Option<Arc<[u32]>>,
    largest: f64,
    /// True if all particles have the same radius and mass.
    equal: bool,
}

impl Polydisperse {
    /// Creates individual sizes from radius and mass of each particle, in the order of the state.
    ///
    /// # Errors
    /// [`InvalidValue`] if a value is not positive and finite, or there is none.
    pub fn new(sizes: Vec<(f64, f64)>) -> Result<Self, InvalidValue> {
        InvalidValue::require(!sizes.is_empty(), "number of sizes", 0.0, "at least 1")?;
        for &(radius, mass) in &sizes {
            InvalidValue::unless_positive("radius", radius)?;
            InvalidValue::unless_positive("mass", mass)?;
        }
        let largest = sizes.iter().map(|size| size.0).fold(0.0, f64::max);
        let equal = sizes.iter().all(|size| *size == sizes[0]);
        Ok(Self {
            equal,
            sizes: sizes.into(),
            kinds: None,
            largest,
        })
    }

    /// Returns these sizes with a species number for each particle.
    ///
    /// # Errors
    /// [`InvalidValue`] unless there is one for each particle.
    pub fn of_kinds(self, kinds: Vec<u32>) -> Result<Self, InvalidValue> {
        let (found, complete) = (kinds.len() as f64, kinds.len() == self.sizes.len());
        let allowed = "one for each particle";
        InvalidValue::require(complete, "number of species of particles", found, allowed)?;
        Ok(Self {
            kinds: Some(kinds.into()),
            ..self
        })
    }
}

impl Polydisperse {
    /// Returns the radius \[length\] and mass \[mass\] of each particle, in the order of the state.
    pub fn pairs(&self) -> &[(f64, f64)] {
        &self.sizes
    }
}

impl Sizes for Polydisperse {
    const UNIFORM: bool = false;
    const INDIVIDUAL: bool = true;
    type Tag = u32;

    #[inline]
    fn tag_of(&self, index: usize) -> u32 {
        index as u32
    }
    #[inline]
    fn index_of(tag: u32, _order: usize) -> usize {
        tag as usize
    }
    fn repeat_sizes(&self, times: usize) -> Self {
        Self {
            sizes: self.sizes.repeat(times).into(),
            kinds: (self.kinds.as_ref()).map(|kinds| kinds.repeat(times).into()),
            largest: self.largest,
            equal: self.equal,
        }
    }
    #[inline]
    fn radius(&self, tag: u32) -> f64 {
        self.sizes[tag as usize].0
    }
    #[inline]
    fn mass(&self, tag: u32) -> f64 {
        self.sizes[tag as usize].1
    }
    fn largest_radius(&self) -> f64 {
        self.largest
    }
    #[inline]
    fn are_equal(&self) -> bool {
        self.equal
    }
    #[inline]
    fn species_of(&self, tag: u32) -> u32 {
        match &self.kinds {
            Some(kinds) => kinds[tag as usize],
            None => 0,
        }
    }
}
