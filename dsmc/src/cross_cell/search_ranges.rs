//! Distances at which partners are sought, in cells.

use stosszahl_model::{Physics, Sizes};

use super::arm::Arm;
use crate::grid::Grid;
use crate::scheme::Scheme;

/// Widest search for the nearest, in cells on each side.
pub(super) const WIDEST: i64 = 3;

/// How far beyond its own cells work on a tile reaches, at most \[length\]; zero for pairs within cells. `cell`: widest side
/// of a cell.
pub(crate) fn reach(scheme: Scheme, diameter: f64, radius: f64, cell: f64) -> f64 {
    match scheme {
        Scheme::ContactPoint { .. } => {
            Arm::LONGEST * diameter + radius.max(WIDEST as f64 * cell) + cell
        }
        Scheme::Esmc(_) | Scheme::StochasticDisks { .. } => diameter + cell,
        _ => 0.0,
    }
}

/// How many cells beyond those of a tile work on it looks at, at most, with the radius of partners that are equally likely.
pub(crate) fn margin<P: Physics>(
    scheme: Scheme,
    grid: &Grid<P::Space>,
    sizes: &P::Sizes,
    mean_radius: f64,
    radius: f64,
) -> usize {
    ranges::<P>(scheme, grid, sizes, mean_radius, radius, Arm::LONGEST).margin()
}

/// How far from a simulator its partners are, in cells; `radius`: within which all are equally likely \[length\]; `arm`: of where
/// they are sought, in contact distances.
pub(super) fn ranges<P: Physics>(
    scheme: Scheme,
    grid: &Grid<P::Space>,
    sizes: &P::Sizes,
    mean_radius: f64,
    radius: f64,
    arm: f64,
) -> Ranges {
    let narrowest = grid.narrowest();
    let cells = |distance: f64| (distance / narrowest).ceil() as usize;
    // More cells than all are not needed, however far: in an empty box partners may be anywhere.
    let all = grid.counts().into_iter().max().unwrap_or(1) as usize;
    let largest = sizes.largest_radius();
    let longest = largest + mean_radius;
    if let Scheme::ContactPoint { .. } = scheme {
        let spread = if sizes.are_equal() {
            0.0
        } else {
            mean_radius.max(largest - mean_radius)
        };
        Ranges {
            point: cells(arm * longest),
            near: cells(radius).clamp(1, all),
            far: WIDEST as usize,
            shift: cells(arm * spread).min(all),
        }
    } else {
        Ranges {
            point: cells(longest),
            ..Ranges::default()
        }
    }
}

/// How far from a simulator its partners are sought, in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ranges {
    /// The cell of the point around which they are sought.
    pub(super) point: usize,
    /// Cells around that one, where there are others than the simulator itself.
    pub(super) near: usize,
    /// Cells around it, where nobody is nearer.
    pub(super) far: usize,
    /// As many more in both cases, where particles differ in size.
    pub(super) shift: usize,
}

impl Ranges {
    /// Cells around a point that are looked at first.
    pub(super) fn block(self) -> usize {
        self.near + self.shift
    }

    /// Cells around a simulator in which its partners are, unless nobody is near.
    pub(super) fn reach(self) -> usize {
        self.point + self.block()
    }

    /// Cells around a tile that work on it may look at. One more, as a coordinate at the edge of a cell may be rounded to either
    /// side.
    pub(super) fn margin(self) -> usize {
        self.point + self.shift + self.far.max(self.near) + 1
    }
}
