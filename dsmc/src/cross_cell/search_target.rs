//! Target of a partner search: the point where the centre of a partner must be, and blocks of cells
//! around it.

use stosszahl_model::Space;

/// Target of a partner search: the point for a partner of the mean radius, moved along the line of
/// centres in proportion to radius minus mean radius.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim<V> {
    pub(super) point: V,
    /// Displacement of the target point per unit of radius minus mean radius.
    pub(super) along: V,
}

/// Block of adjacent cells of a halo copy: index of the first, and number of cells along each axis.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) sides: [usize; 3],
}

impl Block {
    /// Creates the block of all cells within `cells` cells of a cell; `strides` are the index
    /// differences of the halo copy for one step along each axis.
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
