//! Result of placing disks in a box: their positions, or the error that they do not fit.

use nalgebra::Vector2;

use crate::format_short;

/// Positions of placed disks, and the reciprocal vectors of the lattice they are on, if any.
#[derive(Clone, Debug)]
pub struct PlacedDisks {
    /// Centre of each placed disk \[length\].
    pub positions: Vec<Vector2<f64>>,
    /// Reciprocal lattice vectors, as mode numbers, whose Bragg peaks show whether the lattice is
    /// forgotten; empty without a lattice.
    pub reciprocal: Vec<[i32; 2]>,
}

/// Error why disks could not be placed in a box.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementError {
    /// Disks of several sizes do not fit into the box at random.
    #[error(
        "{count} disks of several sizes do not fit into a box of {} x {} when placed at random one by one, the large \
         ones first; a lower packing fraction or a larger box may do",
        format_short(lengths[0]), format_short(lengths[1])
    )]
    Jammed {
        /// Number of disks that do not fit.
        count: usize,
        /// Sides of the box into which the disks do not fit \[length\].
        lengths: [f64; 2],
    },
    /// The sites of the lattice that fits into the box are closer than a diameter.
    #[error(
        "{count} disks of diameter {diameter} do not fit as a {lattice} lattice into a box of {} x {}: \
         the closest lattice sites are {spacing} apart; allowed at this number and box: packing fractions up to {allowed:.4}",
        format_short(lengths[0]), format_short(lengths[1]), diameter = format_short(*diameter), spacing = format_short(*spacing))]
    TooDense {
        /// Name of the lattice: `square` or `hexagonal`.
        lattice: &'static str,
        /// Number of disks for which the lattice has sites.
        count: usize,
        /// Diameter of the disks that do not fit on the lattice \[length\].
        diameter: f64,
        /// Sides of the box into which the lattice fits \[length\].
        lengths: [f64; 2],
        /// Shortest distance between two sites of the lattice \[length\].
        spacing: f64,
        /// Largest packing fraction of disks that this lattice can hold.
        allowed: f64,
    },
    /// The placement of disks was interrupted.
    #[error("stopped")]
    Interrupted,
}

impl PlacementError {
    /// Converts the lengths of the error to the units of a case; `unit` is the engine's unit of
    /// length in these.
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
