//! Mixture of a few or some hundred species: sizes of the particles, and the map of species
//! numbers.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::invalid::InvalidValue;
use crate::sizes::Sizes;

/// Radius, mass and number of the particles of one species in a mixture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeciesProperties {
    /// Radius of the particles of the species \[length\].
    pub radius: f64,
    /// Mass of one particle of the species \[mass\].
    pub mass: f64,
    /// Number of particles of the species; may be 0.
    pub count: usize,
}

/// Sizes of a mixture, whose species follow one another in the state. A particle carries only the
/// number of its species, so the table stays in the fastest cache for any number of particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    kinds: Arc<[SpeciesProperties]>,
    /// Index in the state of the first particle of each species, and the total number of particles
    /// at the end.
    first: Arc<[usize]>,
    /// Largest radius of any species \[length\].
    largest: f64,
    /// True if all particles have the same radius and mass.
    equal: bool,
    /// Species number of each entry of `kinds`, as [`Sizes::species_of`] returns it: its index,
    /// unless several entries are of one species.
    numbers: Arc<[u32]>,
}

impl Species {
    /// Creates a mixture of the given species.
    ///
    /// # Errors
    /// [`InvalidValue`] if there is none, or 2^32 or more, if a radius or mass is not positive and
    /// finite, or if there are 2^32 particles or more.
    pub fn new(kinds: Vec<SpeciesProperties>) -> Result<Self, InvalidValue> {
        let some = !kinds.is_empty() && u32::try_from(kinds.len()).is_ok();
        let found = kinds.len() as f64;
        InvalidValue::require(some, "number of species", found, "1 to 4294967295")?;
        let mut first = vec![0_usize];
        let mut total = 0_usize;
        for kind in &kinds {
            InvalidValue::unless_positive("radius", kind.radius)?;
            InvalidValue::unless_positive("mass", kind.mass)?;
            total = total.saturating_add(kind.count);
            first.push(total);
        }
        let few = u32::try_from(total).is_ok();
        InvalidValue::require(
            few,
            "number of particles",
            total as f64,
            "at most 4294967295",
        )?;
        let largest = kinds.iter().map(|kind| kind.radius).fold(0.0, f64::max);
        let size = |kind: &SpeciesProperties| (kind.radius, kind.mass);
        let equal = kinds.iter().all(|kind| size(kind) == size(&kinds[0]));
        Ok(Self {
            numbers: (0..kinds.len() as u32).collect(),
            kinds: kinds.into(),
            first: first.into(),
            largest,
            equal,
        })
    }

    /// Returns this mixture with a species number for each entry of its list.
    ///
    /// # Errors
    /// [`InvalidValue`] unless there is one for each entry.
    pub fn of_kinds(self, numbers: Vec<u32>) -> Result<Self, InvalidValue> {
        let (found, complete) = (numbers.len() as f64, numbers.len() == self.kinds.len());
        let allowed = "one for each entry";
        InvalidValue::require(complete, "number of species of entries", found, allowed)?;
        Ok(Self {
            numbers: numbers.into(),
            ..self
        })
    }

    /// Returns the species of the mixture in their order; a repeated gas has them copy after copy.
    pub fn kinds(&self) -> &[SpeciesProperties] {
        &self.kinds
    }

    /// Returns the number of particles of all species together.
    pub fn count(&self) -> usize {
        self.first[self.kinds.len()]
    }
}

impl Sizes for Species {
    const UNIFORM: bool = false;
    const INDIVIDUAL: bool = false;
    type Tag = u32;

    fn tag_of(&self, index: usize) -> u32 {
        let after = self.first.partition_point(|&first| first <= index);
        (after.min(self.kinds.len()) - 1) as u32
    }
    #[inline]
    fn index_of(_tag: u32, order: usize) -> usize {
        order
    }
    fn repeat_sizes(&self, times: usize) -> Self {
        let kinds: Vec<SpeciesProperties> = (0..times)
            .flat_map(|_| self.kinds.iter().copied())
            .collect();
        let mut first = vec![0];
        for kind in &kinds {
            first.push(first[first.len() - 1] + kind.count);
        }
        Self {
            kinds: kinds.into(),
            first: first.into(),
            largest: self.largest,
            equal: self.equal,
            numbers: self.numbers.repeat(times).into(),
        }
    }
    #[inline]
    fn radius(&self, tag: u32) -> f64 {
        self.kinds[tag as usize].radius
    }
    #[inline]
    fn mass(&self, tag: u32) -> f64 {
        self.kinds[tag as usize].mass
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
        self.numbers[tag as usize]
    }
    #[inline]
    fn block_of(&self, tag: u32) -> u32 {
        tag
    }
}

/// Map from an engine's species numbers to the species of the case. Copies of a gas have species
/// numbers of their own, and in a gas of continuous sizes each particle has one, in the order of
/// sizes.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Grouping {
    groups: usize,
    kinds: Option<usize>,
}

impl Grouping {
    /// Creates the map of an engine's species numbers to `groups` species of the case. `kinds` is
    /// the number of engine species in a gas of continuous sizes, `None` otherwise.
    pub fn new(groups: usize, kinds: Option<usize>) -> Self {
        Self {
            groups: groups.max(1),
            kinds,
        }
    }

    /// Returns the number of species of the case.
    pub fn groups(self) -> usize {
        self.groups
    }

    /// Returns the species of the case for an engine's species number.
    #[inline]
    pub fn group(self, kind: u32) -> usize {
        match self.kinds {
            Some(kinds) => kind as usize * self.groups / kinds,
            None => kind as usize % self.groups,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn species_are_found_by_the_index_also_around_empty_ones() {
        let kind = |radius, count| SpeciesProperties {
            radius,
            mass: 1.0,
            count,
        };
        let species = Species::new(vec![kind(1.0, 0), kind(2.0, 2), kind(3.0, 0), kind(4.0, 1)])
            .expect("a mixture");
        assert_eq!(species.count(), 3);
        let tags: Vec<u32> = (0..3).map(|index| species.tag_of(index)).collect();
        assert_eq!(tags, [1, 1, 3]);
        assert_eq!(species.radius(3), 4.0);
        assert_eq!(species.largest_radius(), 4.0);
        let twice = species.repeat_sizes(2);
        let tags: Vec<u32> = (0..6).map(|index| twice.tag_of(index)).collect();
        assert_eq!(tags, [1, 1, 3, 5, 5, 7]);
        let kinds = tags.iter().map(|&tag| twice.species_of(tag));
        assert!(kinds.eq([1, 1, 3, 1, 1, 3]));
        assert_eq!((twice.radius(7), twice.block_of(7)), (4.0, 7));
        assert!(Species::new(vec![kind(-1.0, 1)]).is_err());
        assert!(Species::new(Vec::new()).is_err());
    }
}
