//! Impact parameters of colliding pairs by pair of species, in a gas of several species.

use serde::{Deserialize, Serialize};
use stosszahl_model::Collision;

/// Pair of species with its contact distance and reduced mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairKind {
    /// Indices of the two species, from 0.
    pub species: [usize; 2],
    /// Contact distance: distance of the centres of two disks at contact \[length\].
    pub distance: f64,
    /// Reduced mass m1 m2/(m1 + m2) of the pair \[mass\].
    pub reduced_mass: f64,
}

/// Histograms of |b|/d over collisions, one for each time window and pair of species.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairBins {
    kinds: Vec<PairKind>,
    bins: usize,
    /// Numbers of collisions by time window, pair of species and bin.
    counts: Vec<u64>,
}

impl PairBins {
    /// Creates empty histograms for all pairs of species, given by radius and mass of their disks.
    pub fn new(species: &[(f64, f64)], windows: usize, bins: usize) -> Self {
        let mut kinds = Vec::new();
        for (first, a) in species.iter().enumerate() {
            for (second, b) in species.iter().enumerate().skip(first) {
                kinds.push(PairKind {
                    species: [first, second],
                    distance: a.0 + b.0,
                    reduced_mass: a.1 * b.1 / (a.1 + b.1),
                });
            }
        }
        Self {
            counts: vec![0; windows * kinds.len() * bins],
            kinds,
            bins,
        }
    }

    /// Returns all pairs of species, in the order of their histograms.
    pub fn kinds(&self) -> &[PairKind] {
        &self.kinds
    }

    /// Returns the histogram of |b|/d of one pair of species in one time window.
    pub fn counts(&self, window: usize, kind: usize) -> &[u64] {
        let start = (window * self.kinds.len() + kind) * self.bins;
        &self.counts[start..start + self.bins]
    }

    /// Adds a collision with |b|/d = `impact` to the histogram of its pair of species in a time
    /// window.
    pub(super) fn count(&mut self, window: usize, collision: &Collision, impact: f64) {
        let [a, b] = collision.species.map(|species| species as usize);
        let pair = [a.min(b), a.max(b)];
        let Some(kind) = self.kinds.iter().position(|kind| kind.species == pair) else {
            debug_assert!(
                false,
                "a collision of species {a} and {b}, which were not named"
            );
            return;
        };
        let bin = ((impact * self.bins as f64) as usize).min(self.bins - 1);
        self.counts[(window * self.kinds.len() + kind) * self.bins + bin] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, vector};

    /// Species are known by their numbers: also those that differ in nothing but their restitution.
    #[test]
    fn pairs_are_counted_by_their_species() {
        let mut bins = PairBins::new(&[(0.5, 1.0), (0.5, 1.0), (1.0, 3.0)], 2, 4);
        assert_eq!(bins.kinds().len(), 6);
        for species in [[0, 0], [1, 0], [1, 1], [0, 2], [2, 1], [2, 2]] {
            let collision = Collision {
                species,
                ..Collision::at_contact(-Vector3::x(), vector![1.0, 0.0, 0.0], 0.5, 1.0)
            };
            bins.count(1, &collision, 0.3);
            let pair = [species[0].min(species[1]), species[0].max(species[1])];
            let pair = pair.map(|one| one as usize);
            let kind = bins.kinds().iter().position(|kind| kind.species == pair);
            let kind = kind.expect("a kind");
            assert_eq!(bins.counts(1, kind), [0, 1, 0, 0], "{species:?}");
            assert_eq!(bins.counts(0, kind), [0; 4]);
        }
    }
}
