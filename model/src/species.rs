//! Mixtures of a few or some hundred species.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::sizes::Sizes;

/// One species of a mixture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kind {
    /// Radius \[length\].
    pub radius: f64,
    /// Mass of one particle.
    pub mass: f64,
    /// How many particles there are; none is allowed.
    pub count: usize,
}

/// Species, one after the other in the order of the state; a particle carries the number of its species only, so the
/// table stays in the fastest memory however many particles there are.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    kinds: Arc<[Kind]>,
    /// First index of each species in the state, and the number of all particles.
    first: Arc<[usize]>,
    largest: f64,
}

impl Species {
    /// The mixture of the given species. `None` if there is none, or more than 2^32, if a radius or mass is not positive
    /// and finite, or if there are 2^32 particles or more.
    pub fn new(kinds: Vec<Kind>) -> Option<Self> {
        let good = |x: f64| x > 0.0 && x.is_finite();
        if kinds.is_empty()
            || u32::try_from(kinds.len()).is_err()
            || !kinds
                .iter()
                .all(|kind| good(kind.radius) && good(kind.mass))
        {
            return None;
        }
        let mut first = vec![0_usize];
        let mut total = 0_usize;
        for kind in &kinds {
            total = total.checked_add(kind.count)?;
            first.push(total);
        }
        if u32::try_from(total).is_err() {
            return None;
        }
        let largest = kinds.iter().map(|kind| kind.radius).fold(0.0, f64::max);
        Some(Self {
            kinds: kinds.into(),
            first: first.into(),
            largest,
        })
    }

    /// The species in their order.
    pub fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    /// Number of all particles.
    pub fn count(&self) -> usize {
        self.first[self.kinds.len()]
    }
}

impl Sizes for Species {
    const UNIFORM: bool = false;
    const INDIVIDUAL: bool = false;
    type Tag = u32;

    fn tag(&self, index: usize) -> u32 {
        let after = self.first.partition_point(|&first| first <= index);
        (after.min(self.kinds.len()) - 1) as u32
    }
    #[inline]
    fn index(_tag: u32, order: usize) -> usize {
        order
    }
    fn repeated(&self, times: usize) -> Self {
        let repeated = (0..times).flat_map(|_| self.kinds.iter().copied());
        Self::new(repeated.collect()).unwrap_or_else(|| self.clone())
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
    fn kind(&self, tag: u32) -> u32 {
        tag
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn species_are_found_by_the_index_also_around_empty_ones() {
        let kind = |radius, count| Kind {
            radius,
            mass: 1.0,
            count,
        };
        let species = Species::new(vec![kind(1.0, 0), kind(2.0, 2), kind(3.0, 0), kind(4.0, 1)])
            .expect("a mixture");
        assert_eq!(species.count(), 3);
        let tags: Vec<u32> = (0..3).map(|index| species.tag(index)).collect();
        assert_eq!(tags, [1, 1, 3]);
        assert_eq!(species.radius(3), 4.0);
        assert_eq!(species.largest_radius(), 4.0);
        assert!(Species::new(vec![kind(-1.0, 1)]).is_none());
        assert!(Species::new(Vec::new()).is_none());
    }
}
