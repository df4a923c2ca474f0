//! Ranges of the partner search around a simulator, in cells, and the resulting width of the ghost
//! layer of a tile.

use stosszahl_model::{ParticleModel, Sizes};

use super::arm::ContactDistance;
use crate::extrema::larger;
use crate::grid::Grid;
use crate::scheme::{PartnerSelection, Scheme};

/// Largest range of the search for the nearest partner, in cells on each side.
pub(super) const WIDEST: i64 = 3;

/// Returns the largest distance beyond a tile at which its collisions read simulators \[length\];
/// zero for pairs within cells. `cell` is the longest side of a cell.
pub(crate) fn reach(scheme: Scheme, diameter: f64, radius: f64, cell: f64) -> f64 {
    match scheme.partners() {
        PartnerSelection::AroundContact => {
            ContactDistance::LONGEST * diameter + radius.max(WIDEST as f64 * cell) + cell
        }
        PartnerSelection::ContactCell | PartnerSelection::Overlap => diameter + cell,
        PartnerSelection::None | PartnerSelection::WithinCell => 0.0,
    }
}

/// Returns the number of ghost cells that collisions need on each side of a tile. Partners within
/// `radius` of the contact point are equally likely \[length\].
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

/// Returns the ranges of the partner search of a scheme. Partners within `radius` of the search
/// point are equally likely \[length\]; `arm` is the distance to that point \[contact distances\].
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

/// Returns the largest difference of a radius from the mean one, or a bound of it \[length\]; zero
/// for equal sizes.
pub(super) fn radius_spread(sizes: &impl Sizes, mean_radius: f64) -> f64 {
    if sizes.are_equal() {
        0.0
    } else {
        larger(mean_radius, sizes.largest_radius() - mean_radius)
    }
}

/// Ranges of the partner search around a simulator, all in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ranges {
    /// Largest distance from a simulator to the point around which its partner is sought, in cells.
    pub(super) point: usize,
    /// Range of the first partner search around the point, in cells on each side.
    pub(super) near: usize,
    /// Range of the second search around the point if the first finds no partner, in cells on each
    /// side.
    pub(super) far: usize,
    /// Further cells on each side in both searches, because sizes are unequal.
    pub(super) shift: usize,
}

impl Ranges {
    /// Returns the range of the first partner search around a point for partners of all sizes, in
    /// cells.
    pub(super) fn block(self) -> usize {
        self.near + self.shift
    }

    /// Returns the range around a simulator that contains its partners unless the first search
    /// fails, in cells.
    pub(super) fn reach(self) -> usize {
        self.point + self.block()
    }

    /// Returns the number of ghost cells on each side of a tile. It is one more than the ranges
    /// need, because rounding may put a coordinate at the edge of a cell to either side.
    pub(super) fn margin(self) -> usize {
        self.point + self.shift + self.far.max(self.near) + 1
    }
}
