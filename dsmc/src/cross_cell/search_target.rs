//! Places at which partners are sought.

use stosszahl_model::Space;

/// Where a partner is sought: around the point at which one of the mean radius would be, and as much farther along the line
/// of centres as it is larger.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim<V> {
    pub(super) point: V,
    /// How much farther for each unit of the radius.
    pub(super) along: V,
}

/// Cells side by side: the first, and how many along each axis.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) sides: [usize; 3],
}

impl Block {
    /// A cell and `cells` around it on each side, in a block of cells with these strides.
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
