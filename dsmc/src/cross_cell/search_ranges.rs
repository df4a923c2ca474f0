//! Search ranges: distances at which partners are sought, in cells.

use stosszahl_model::{ParticleModel, Sizes};

use super::arm::ContactDistance;
use crate::extrema::larger;
use crate::grid::Grid;
use crate::scheme::{PartnerSelection, Scheme};

/// Largest range of the search for the nearest particle \[cells on each side\].
pub(super) const WIDEST: i64 = 3;

/// Largest distance beyond a tile at which its collisions read particles \[length\]; zero for pairs
/// within cells. `cell`: widest side of a cell.
pub(crate) fn reach(scheme: Scheme, diameter: f64, radius: f64, cell: f64) -> f64 {
    match scheme.partners() {
        PartnerSelection::AroundContact => {
            ContactDistance::LONGEST * diameter + radius.max(WIDEST as f64 * cell) + cell
        }
        PartnerSelection::ContactCell | PartnerSelection::Overlap => diameter + cell,
        PartnerSelection::None | PartnerSelection::WithinCell => 0.0,
    }
}

/// Number of ghost cells around a tile. `radius`: partners within it are equally likely.
pub(crate) fn margin<P: ParticleModel>(
    scheme: Scheme,
    grid: &Grid<P::Space>,
    sizes: &P::Sizes,
    mean_radius: f64,
    radius: f64,
) -> usize {
    ranges::<P>(
        scheme,
        grid,
        sizes,
        mean_radius,
        radius,
        ContactDistance::LONGEST,
    )
    .margin()
}

/// Search ranges of a scheme. `radius`: partners within it are equally likely \[length\]; `arm`:
/// distance of the search point \[contact distances\].
pub(super) fn ranges<P: ParticleModel>(
    scheme: Scheme,
    grid: &Grid<P::Space>,
    sizes: &P::Sizes,
    mean_radius: f64,
    radius: f64,
    arm: f64,
) -> Ranges {
    let narrowest = grid.narrowest();
    let cells = |distance: f64| (distance / narrowest).ceil() as usize;
    // More cells than the box has are not needed: in an empty box partners may be anywhere.
    let all = grid.counts().into_iter().max().unwrap_or(1) as usize;
    let largest = sizes.largest_radius();
    let longest = largest + mean_radius;
    if scheme.partners() == PartnerSelection::AroundContact {
        let spread = radius_spread(sizes, mean_radius);
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

/// Largest difference of a radius from the mean one, or a bound on it \[length\]; zero for equal
/// sizes.
pub(super) fn radius_spread(sizes: &impl Sizes, mean_radius: f64) -> f64 {
    if sizes.are_equal() {
        0.0
    } else {
        larger(mean_radius, sizes.largest_radius() - mean_radius)
    }
}

/// Search ranges of a partner around a simulator, in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ranges {
    /// Cells from a simulator to the point around which partners are sought.
    pub(super) point: usize,
    /// Cells around the point that are searched first.
    pub(super) near: usize,
    /// Cells around the point that are searched if the first search finds no partner.
    pub(super) far: usize,
    /// Additional cells in both searches for unequal sizes.
    pub(super) shift: usize,
}

impl Ranges {
    /// Cells around a point that are searched first, for all sizes.
    pub(super) fn block(self) -> usize {
        self.near + self.shift
    }

    /// Cells around a simulator that hold its partners, unless the first search fails.
    pub(super) fn reach(self) -> usize {
        self.point + self.block()
    }

    /// Number of ghost cells around a tile. One more than the ranges, because a coordinate at the
    /// edge of a cell may be rounded to either side.
    pub(super) fn margin(self) -> usize {
        self.point + self.shift + self.far.max(self.near) + 1
    }
}
