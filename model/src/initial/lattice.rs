//! Square and hexagonal lattices of disks that fit a periodic box.

use nalgebra::{Vector2, vector};
use rand::Rng;
use rand::seq::SliceRandom;

use super::placement::{PlacedDisks, PlacementError};
use crate::domain::Domain;
use crate::space::Plane;

/// Square-like or hexagon-like lattice commensurate with a periodic box, with at least as many
/// sites as disks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    name: &'static str,
    /// Number of columns and rows of the lattice.
    counts: [usize; 2],
    /// True for the hexagon-like lattice, whose odd rows are shifted by half a column.
    staggered: bool,
    lengths: [f64; 2],
}

/// Returns, of all square-like lattices in the box with sites for `count` disks, the one with the
/// widest spacing.
pub fn square(count: usize, domain: &Domain<Plane>) -> Lattice {
    best(count, domain, "square", false)
}

/// Returns, of all hexagon-like lattices in the box with sites for `count` disks, the one with the
/// widest spacing.
pub fn hexagonal(count: usize, domain: &Domain<Plane>) -> Lattice {
    best(count, domain, "hexagonal", true)
}

fn best(count: usize, domain: &Domain<Plane>, name: &'static str, staggered: bool) -> Lattice {
    let lengths = [domain.lengths()[0], domain.lengths()[1]];
    let candidate = |rows: usize| Lattice {
        name,
        counts: [count.div_ceil(rows).max(1), rows],
        staggered,
        lengths,
    };
    let step = if staggered { 2 } else { 1 };
    // The ideal number of rows, and a wide margin around it for strained boxes.
    let ideal = (count as f64 * lengths[1] / lengths[0]).sqrt();
    let most = (2.0 * ideal) as usize + 2 * step + 2;
    (step..=most)
        .step_by(step)
        .map(candidate)
        .max_by(|a, b| a.spacing().total_cmp(&b.spacing()))
        .unwrap_or_else(|| candidate(step))
}

impl Lattice {
    /// Returns the shortest distance between two sites of the lattice, periodic images of one site
    /// included \[length\].
    pub fn spacing(&self) -> f64 {
        let [a, h] = [0, 1].map(|axis| self.lengths[axis] / self.counts[axis] as f64);
        if self.staggered {
            a.min((0.25 * a * a + h * h).sqrt()).min(2.0 * h)
        } else {
            a.min(h)
        }
    }

    fn site(&self, index: usize) -> Vector2<f64> {
        let [columns, rows] = self.counts;
        let (row, column) = (index / columns, index % columns);
        let shift = if self.staggered && row % 2 == 1 {
            0.75
        } else {
            0.25
        };
        vector![
            (column as f64 + shift) * self.lengths[0] / columns as f64,
            (row as f64 + 0.5) * self.lengths[1] / rows as f64
        ]
    }

    /// Returns the shortest reciprocal lattice vectors, as mode numbers; half of them, as the
    /// others are their negatives.
    fn reciprocal(&self) -> Vec<[i32; 2]> {
        let [columns, rows] = self.counts.map(|count| count as i32);
        if self.staggered {
            vec![[columns, rows / 2], [columns, -rows / 2], [0, rows]]
        } else {
            vec![[columns, 0], [0, rows]]
        }
    }

    /// Checks that `count` disks of a diameter fit on the sites of the lattice without overlap.
    ///
    /// # Errors
    /// [`PlacementError::TooDense`] if it does not.
    pub(super) fn holds(
        self,
        count: usize,
        diameter: f64,
        domain: &Domain<Plane>,
    ) -> Result<(), PlacementError> {
        let spacing = self.spacing();
        if spacing < diameter {
            let packing = count as f64 * std::f64::consts::FRAC_PI_4 * spacing * spacing;
            return Err(PlacementError::TooDense {
                lattice: self.name,
                count,
                diameter,
                lengths: self.lengths,
                spacing,
                allowed: packing / domain.volume(),
            });
        }
        Ok(())
    }

    /// Puts disks on randomly chosen sites of the lattice; the sites left over are vacancies.
    pub(super) fn occupy(
        self,
        count: usize,
        diameter: f64,
        domain: &Domain<Plane>,
        stream: &mut impl Rng,
    ) -> Result<PlacedDisks, PlacementError> {
        self.holds(count, diameter, domain)?;
        let mut sites: Vec<usize> = (0..self.counts[0] * self.counts[1]).collect();
        sites.shuffle(stream);
        sites.truncate(count);
        let positions = sites.into_iter().map(|site| self.site(site)).collect();
        Ok(PlacedDisks {
            positions,
            reciprocal: self.reciprocal(),
        })
    }
}
