//! Placed disks, or the reason why they cannot be placed.

use nalgebra::Vector2;

use crate::format_short;

/// Positions of placed disks, and the lattice they came from, if any.
#[derive(Clone, Debug)]
pub struct PlacedDisks {
    /// Centres of the disks \[length\].
    pub positions: Vec<Vector2<f64>>,
    /// Reciprocal vectors whose Bragg peaks show whether the lattice is forgotten; empty without
    /// one.
    pub reciprocal: Vec<[i32; 2]>,
}

/// Failure to place disks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementError {
    /// Disks of several sizes do not fit.
    #[error(
        "{count} disks of several sizes do not fit into a box of {} x {} when placed at random one by one, the large \
         ones first; a lower packing fraction or a larger box may do",
        format_short(lengths[0]), format_short(lengths[1])
    )]
    Jammed {
        /// Number of disks.
        count: usize,
        /// Sides of the box \[length\].
        lengths: [f64; 2],
    },
    /// The lattice that fits into the box is too tight.
    #[error(
        "{count} disks of diameter {diameter} do not fit as a {lattice} lattice into a box of {} x {}: \
         the closest lattice sites are {spacing} apart; allowed at this number and box: packing fractions up to {allowed:.4}",
        format_short(lengths[0]), format_short(lengths[1]), diameter = format_short(*diameter), spacing = format_short(*spacing))]
    TooDense {
        /// Name of the lattice: `square` or `hexagonal`.
        lattice: &'static str,
        /// Number of disks.
        count: usize,
        /// Diameter of the disks \[length\].
        diameter: f64,
        /// Sides of the box \[length\].
        lengths: [f64; 2],
        /// Shortest distance of two sites \[length\].
        spacing: f64,
        /// Largest packing fraction that this lattice holds.
        allowed: f64,
    },
    /// The placement was asked to end.
    #[error("stopped")]
    Interrupted,
}

impl PlacementError {
    /// Scales all lengths of the error by `unit`.
    #[must_use]
    pub fn in_units(mut self, unit: f64) -> Self {
        match &mut self {
            Self::Jammed { lengths, .. } => *lengths = lengths.map(|side| side * unit),
            Self::TooDense {
                diameter,
                lengths,
                spacing,
                ..
            } => {
                *lengths = lengths.map(|side| side * unit);
                *diameter *= unit;
                *spacing *= unit;
            }
            Self::Interrupted => {}
        }
        self
    }
}
