//! Impact parameters by the kind of pair, in a gas of unlike disks.

use serde::{Deserialize, Serialize};
use stosszahl_model::Collision;

/// What two disks of given species have in common wherever they meet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairKind {
    /// Numbers of the two species, from 0.
    pub species: [usize; 2],
    /// Distance of their centres at contact \[length\].
    pub distance: f64,
    /// Reduced mass m1 m2/(m1 + m2).
    pub reduced_mass: f64,
}

/// Collisions by |b|/d, for each window of time and kind of pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairBins {
    kinds: Vec<PairKind>,
    bins: usize,
    /// By window, kind of pair and bin.
    counts: Vec<u64>,
}

impl PairBins {
    /// Empty bins of all pairs of the species, given by the radius and the mass of their disks.
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

    /// The kinds of pairs.
    pub fn kinds(&self) -> &[PairKind] {
        &self.kinds
    }

    /// Collisions of one kind of pair in one window, by |b|/d.
    pub fn counts(&self, window: usize, kind: usize) -> &[u64] {
        let start = (window * self.kinds.len() + kind) * self.bins;
        &self.counts[start..start + self.bins]
    }

    /// Counts a collision in a window: of the kind that its species say, or, where an engine knows no species, of the one
    /// that is nearest in distance and reduced mass.
    pub(super) fn count(&mut self, window: usize, collision: &Collision, impact: f64) {
        /// Rounding of a contact distance.
        const ALIKE: f64 = 1e-6;
        let distance = collision.line.norm();
        let away = |kind: &PairKind| {
            (distance / kind.distance).ln().abs()
                + (collision.reduced_mass / kind.reduced_mass).ln().abs()
        };
        let [a, b] = collision.species.map(|species| species as usize);
        let known = [a.min(b), a.max(b)];
        let mut kinds = self.kinds.iter();
        let named = kinds.position(|kind| kind.species == known && away(kind) < ALIKE);
        let nearest = || {
            let all = self.kinds.iter().enumerate();
            let (kind, _) = all.min_by(|a, b| away(a.1).total_cmp(&away(b.1)))?;
            Some(kind)
        };
        let Some(kind) = named.or_else(nearest) else {
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

    /// Species that differ in nothing but their restitution are told apart by their names.
    #[test]
    fn species_tell_alike_pairs_apart() {
        let mut bins = PairBins::new(&[(0.5, 1.0), (0.5, 1.0)], 1, 2);
        let collision = Collision {
            time: 0.0,
            position: Vector3::zeros(),
            relative: -Vector3::x(),
            line: vector![1.0, 0.0, 0.0],
            reduced_mass: 0.5,
            restitution: 1.0,
            weight: 1.0,
            pair: [0, 1],
            species: [1, 0],
        };
        bins.count(0, &collision, 0.9);
        let kind = bins.kinds().iter().position(|kind| kind.species == [0, 1]);
        assert_eq!(bins.counts(0, kind.expect("a kind")), [0, 1]);
    }

    #[test]
    fn pairs_are_known_by_distance_and_mass() {
        let mut bins = PairBins::new(&[(0.5, 1.0), (0.5, 3.0), (1.0, 3.0)], 2, 4);
        assert_eq!(bins.kinds().len(), 6);
        let collision = |distance: f64, reduced_mass: f64| Collision {
            time: 0.0,
            position: Vector3::zeros(),
            relative: -Vector3::x(),
            line: vector![distance, 0.0, 0.0],
            reduced_mass,
            restitution: 1.0,
            weight: 1.0,
            pair: [0, 1],
            species: [0; 2],
        };
        // Species 0 and 1 differ by mass only, 1 and 2 by size only; a rounding of the distance changes nothing.
        for (distance, mass, species) in [
            (1.0 + 1e-12, 0.5, [0, 0]),
            (1.0, 0.75, [0, 1]),
            (1.0, 1.5, [1, 1]),
            (1.5, 0.75, [0, 2]),
            (1.5, 1.5, [1, 2]),
            (2.0, 1.5, [2, 2]),
        ] {
            bins.count(1, &collision(distance, mass), 0.3);
            let kind = bins.kinds().iter().position(|kind| kind.species == species);
            let kind = kind.expect("a kind");
            assert_eq!(bins.counts(1, kind), [0, 1, 0, 0], "{species:?}");
            assert_eq!(bins.counts(0, kind), [0; 4]);
        }
    }
}
