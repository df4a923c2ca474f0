//! Hierarchy of grids with cells of doubling widths, for the search for contacts between disks of
//! very different sizes.
//!
//! All disks are placed by the cells of the finest grid, and cross from one of these into the next.
//! A disk that is larger than such a cell is listed in the first coarser grid, each of twice the
//! width, whose cells hold it. A disk finds those of its own size and larger ones in the nine cells
//! around in their grids. The many small disks around a large one are found by the large one, in
//! the ring of their cells that its edge can reach from within its own cell of the finest grid.
//! These are far fewer than all that lie under the nine cells of its own size.
//!
//! No contact is missed. Two disks are known to each other when one of them looks while their cells
//! of the finest grid are within reach. Reach begins only when one of them crosses, and the disk
//! that crosses looks: the larger one into its ring, the smaller one into the nine coarse cells,
//! which cover that ring.
//!
//! Hierarchical grids for unequal particles: Ogarko & Luding, Comput. Phys. Commun. 183, 931
//! (2012), doi:10.1016/j.cpc.2011.12.019; the rings and the exactness under crossings are this
//! engine's.

use std::ops::Range;

use nalgebra::{Vector2, vector};

use crate::cells::{CellCoordinates, CellLists};

/// Largest number of coarser grids: the binary logarithm of the ratio of largest to finest cell
/// width.
const MOST_LEVELS: u32 = 12;

/// Ratio of the largest diameter to the best single width of cells above which a hierarchy of
/// several grids is used.
const WORTH: f64 = 2.5;

/// Hierarchy of coarser grids for larger disks, and the level of each disk.
#[derive(Debug)]
pub(crate) struct GridHierarchy {
    /// Cell lists of the coarser grids, with cells 2, 4, 8, ... times as wide as those of the
    /// finest.
    grids: Vec<CellLists>,
    /// Level of each disk in the hierarchy: 0 for the finest grid.
    of: Vec<u8>,
    /// Least and largest radius of the disks at each level \[length\]; `None` for a level without
    /// disks.
    radii: Vec<Option<(f64, f64)>>,
}

/// Cell of a grid in the hierarchy: its level, its memory index in that grid, and how many boxes
/// away along each axis it is.
pub(crate) struct Nearby {
    pub(crate) level: usize,
    pub(crate) place: usize,
    pub(crate) boxes: [i32; 2],
}

impl GridHierarchy {
    /// Creates the cell lists of the finest grid, and those of coarser grids if diameters differ so
    /// much that several grids are faster.
    pub(crate) fn grids(
        lengths: Vector2<f64>,
        periodic: [bool; 2],
        largest_diameter: f64,
        disks: usize,
        unequal: bool,
    ) -> (CellLists, Vec<CellLists>) {
        let single = CellLists::new(lengths, periodic, largest_diameter, disks);
        let ratio = largest_diameter / CellLists::ideal(lengths, disks);
        if !unequal || ratio < WORTH {
            return (single, Vec::new());
        }
        let top = single.counts();
        let room = u32::from(u16::MAX / top[0].max(top[1])).ilog2();
        let most = (ratio.log2().floor() as u32).min(MOST_LEVELS).min(room);
        let grid = |level: u32| {
            let counts = top.map(|count| count << (most - level));
            CellLists::with_counts(lengths, periodic, counts, single.narrow())
        };
        (grid(0), (1..=most).map(grid).collect())
    }

    /// Creates the hierarchy from its grids and the radii of all disks, which determine their
    /// levels.
    pub(crate) fn new(
        grids: Vec<CellLists>,
        finest: &CellLists,
        radii: impl Iterator<Item = f64>,
    ) -> Self {
        let mut levels = Self {
            radii: vec![None; grids.len() + 1],
            grids,
            of: Vec::new(),
        };
        for radius in radii {
            let widths = std::iter::once(finest).chain(&levels.grids);
            let fits = |cells: &CellLists| 2.0 * radius * (1.0 + 1e-9) <= cells.width().min();
            let level = widths.map(fits).position(|fits| fits);
            let level = level.unwrap_or(levels.grids.len());
            levels.of.push(level as u8);
            let (least, most) = levels.radii[level].get_or_insert((radius, radius));
            *least = least.min(radius);
            *most = most.max(radius);
        }
        levels
    }

    /// Returns the level of a disk in the hierarchy: 0 for the finest grid.
    #[inline]
    pub(crate) fn level_of(&self, disk: u32) -> usize {
        usize::from(self.of[disk as usize])
    }

    /// Returns the levels coarser than `level` that contain disks.
    pub(crate) fn above(&self, level: usize) -> impl Iterator<Item = usize> {
        (level + 1..self.radii.len()).filter(|&level| self.radii[level].is_some())
    }

    /// Returns the cell lists of a level of the hierarchy; `finest` is level 0.
    #[inline]
    pub(crate) fn grid<'a>(&'a self, finest: &'a CellLists, level: usize) -> &'a CellLists {
        match level {
            0 => finest,
            _ => &self.grids[level - 1],
        }
    }

    /// Returns the cell lists of a level above the finest, for changes.
    #[inline]
    pub(crate) fn coarse_mut(&mut self, level: usize) -> &mut CellLists {
        &mut self.grids[level - 1]
    }

    /// Returns the cell at a coarser level that contains the given cell of the finest grid.
    #[inline]
    pub(crate) fn parent(cell: CellCoordinates, level: usize) -> CellCoordinates {
        cell.map(|number| number >> level)
    }

    /// Calls `visit` for each of the 3 by 3 cells of a level around the one that contains the cell
    /// `home` of the finest grid.
    #[inline]
    pub(crate) fn nine(
        &self,
        finest: &CellLists,
        home: CellCoordinates,
        level: usize,
        mut visit: impl FnMut(Nearby),
    ) {
        let grid = self.grid(finest, level);
        let parent = Self::parent(home, level).map(i32::from);
        for up in -1..=1 {
            for right in -1..=1 {
                let (place, boxes) = grid.place_beyond([parent[0] + right, parent[1] + up]);
                visit(Nearby {
                    level,
                    place,
                    boxes,
                });
            }
        }
    }

    /// Calls `visit` for the cells of all finer levels whose disks can be touched by a disk of the
    /// given radius and `level` from within its cell `home` of the finest grid.
    pub(crate) fn ring(
        &self,
        finest: &CellLists,
        home: CellCoordinates,
        level: usize,
        radius: f64,
        mut visit: impl FnMut(Nearby),
    ) {
        for below in 0..level {
            let Some((least, most)) = self.radii[below] else {
                continue;
            };
            let grid = self.grid(finest, below);
            // Reach with a margin for rounding, up and down.
            let (reach, inner) = (
                (radius + most) * (1.0 + 1e-9),
                (radius + least) * (1.0 - 1e-6),
            );
            let parent = Self::parent(home, below);
            // The own cell within its parent.
            let own = [0, 1].map(|axis| {
                let begin = f64::from(home[axis] - (parent[axis] << below)) * finest.width()[axis];
                begin..begin + finest.width()[axis]
            });
            let width = grid.width();
            let [x, y] = parent.map(i32::from);
            let rows = (reach / width[1]).ceil() as i32 + 1;
            for row in -rows..=rows {
                let (near, far) = distances(&own[1], row, width[1]);
                if near >= reach {
                    continue;
                }
                let across = (reach * reach - near * near).sqrt();
                let hole = (inner * inner - far * far).max(0.0).sqrt();
                let columns = (across / width[0]).ceil() as i32 + 1;
                let mut column = -columns;
                while column <= columns {
                    let (near, far) = distances(&own[0], column, width[0]);
                    if far < hole && column < 0 {
                        // No centre can be there: on to the other side, or what is nearest to it.
                        column = (-column - 2).max(column + 1);
                        continue;
                    }
                    if near < across && far >= hole {
                        let (place, boxes) = grid.place_beyond([x + column, y + row]);
                        visit(Nearby {
                            level: below,
                            place,
                            boxes,
                        });
                    }
                    column += 1;
                }
            }
        }
    }

    /// Returns the memory that the coarser grids and the levels of disks occupy \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        self.of.capacity()
            + self
                .grids
                .iter()
                .map(CellLists::memory_bytes)
                .sum::<usize>()
    }
}

/// Returns the least and largest distance along one axis between a point of a cell, in the interval
/// `own`, and any point of the cell `steps` cells further \[length\].
fn distances(own: &Range<f64>, steps: i32, width: f64) -> (f64, f64) {
    let begin = f64::from(steps) * width;
    let end = begin + width;
    let near = (begin - own.end).max(own.start - end).max(0.0);
    let far = (end - own.start).max(own.end - begin);
    (near, far)
}

/// Returns the vector from the corner of the cell `from` of the finest grid to the corner of the
/// cell `to`, in the periodic image `boxes` away \[length\].
pub(crate) fn shift(
    finest: &CellLists,
    from: CellCoordinates,
    to: CellCoordinates,
    boxes: [i32; 2],
) -> Vector2<f64> {
    let steps = [0, 1].map(|axis| {
        let across = boxes[axis] * i32::from(finest.counts()[axis]);
        f64::from(i32::from(to[axis]) - i32::from(from[axis]) + across)
    });
    vector![steps[0], steps[1]].component_mul(&finest.width())
}
