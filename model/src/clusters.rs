//! Clusters of equal monomers as a size distribution, for particles that merge or break.

use std::sync::Arc;

use crate::invalid::InvalidValue;
use crate::sizes::Sizes;

/// Sizes of compact clusters of k equal monomers: mass `k m_1`, radius `R_1 k^(1/D)`. The size tag
/// is k itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    radius: f64,
    mass: f64,
    dimension: usize,
    /// Table of the radii of the smallest clusters, which collide most often, by number of monomers
    /// \[length\].
    radii: Arc<[f64]>,
    /// Number of monomers in each cluster of the initial state; one where the list ends.
    start: Arc<[u32]>,
}

/// Largest number of monomers whose cluster radius is kept in a table.
const TABLE: u32 = 4096;

impl Clusters {
    /// Creates clusters of monomers with the given radius and mass in two or three dimensions.
    /// `start` lists how many monomers each cluster has at first; clusters beyond its end are
    /// monomers.
    ///
    /// # Errors
    /// [`InvalidValue`] if radius or mass is not positive and finite, the dimension another, or a
    /// cluster empty.
    pub fn new(
        radius: f64,
        mass: f64,
        dimension: usize,
        start: Vec<u32>,
    ) -> Result<Self, InvalidValue> {
        InvalidValue::unless_positive("radius of a monomer", radius)?;
        InvalidValue::unless_positive("mass of a monomer", mass)?;
        let dimensions = (2..=3).contains(&dimension);
        InvalidValue::require(dimensions, "dimension", dimension as f64, "2 or 3")?;
        let occupied = !start.contains(&0);
        InvalidValue::require(
            occupied,
            "number of monomers of a cluster",
            0.0,
            "at least 1",
        )?;
        let radii = (0..TABLE)
            .map(|k| cluster_radius(radius, dimension, k))
            .collect();
        Ok(Self {
            radius,
            mass,
            dimension,
            radii,
            start: start.into(),
        })
    }
}

/// Returns the radius of a compact cluster of k monomers, `R_1 k^(1/D)` \[length\].
fn cluster_radius(radius: f64, dimension: usize, k: u32) -> f64 {
    let k = f64::from(k);
    radius * if dimension == 2 { k.sqrt() } else { k.cbrt() }
}

impl Sizes for Clusters {
    const UNIFORM: bool = false;
    const INDIVIDUAL: bool = false;
    type Tag = u32;

    #[inline]
    fn tag_of(&self, index: usize) -> u32 {
        self.start.get(index).copied().unwrap_or(1)
    }
    #[inline]
    fn index_of(_tag: u32, order: usize) -> usize {
        order
    }
    fn repeat_sizes(&self, times: usize) -> Self {
        Self {
            start: self.start.repeat(times).into(),
            ..self.clone()
        }
    }
    #[inline]
    fn radius(&self, tag: u32) -> f64 {
        self.radii
            .get(tag as usize)
            .copied()
            .unwrap_or_else(|| cluster_radius(self.radius, self.dimension, tag))
    }
    #[inline]
    fn mass(&self, tag: u32) -> f64 {
        self.mass * f64::from(tag)
    }
    fn largest_radius(&self) -> f64 {
        self.radius(self.start.iter().copied().max().unwrap_or(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_are_compact_below_and_above_the_table() {
        for (dimension, k, radius) in [
            (2, 4, 1.0),
            (3, 8, 1.0),
            (3, 1_000_000, 50.0),
            (2, 1_000_000, 500.0),
        ] {
            let clusters = Clusters::new(0.5, 2.0, dimension, vec![3]).expect("clusters");
            // Square and cube roots round once.
            assert!((clusters.radius(k) / radius - 1.0).abs() < 4e-16);
            assert_eq!(clusters.mass(k), 2.0 * f64::from(k));
            assert_eq!((clusters.tag_of(0), clusters.tag_of(1)), (3, 1));
        }
        assert!(Clusters::new(0.5, 1.0, 4, Vec::new()).is_err());
        assert!(Clusters::new(0.5, 1.0, 3, vec![0]).is_err());
    }
}
