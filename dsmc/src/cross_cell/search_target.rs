//! Search targets: points and blocks of cells where partners are sought.

use stosszahl_model::Space;

/// Target of a partner search: the point for a partner of the mean radius, moved along the line of
/// centres in proportion to the excess of its radius.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim<V> {
    pub(super) point: V,
    /// Displacement of the target per unit of excess radius.
    pub(super) along: V,
}

/// Block of adjacent cells: index of the first, and number along each axis.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) sides: [usize; 3],
}

impl Block {
    /// Creates the block of cells within `cells` of a cell, for the strides of a halo copy.
    #[inline(always)]
    pub(super) fn around<S: Space>(strides: [usize; 3], cell: usize, cells: usize) -> Self {
        let [_, column, layer] = strides;
        let side = 2 * cells + 1;
        if S::DIMENSION == 2 {
            Self {
                first: cell - cells * (1 + column),
                sides: [side, side, 1],
            }
        } else {
            Self {
                first: cell - cells * (1 + column + layer),
                sides: [side; 3],
            }
        }
    }
}
