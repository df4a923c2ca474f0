//! Grid of cells of the box, numbering of cells, and tiles that group adjacent cells.

use stosszahl_model::{Domain, Space};

/// Largest number of cells in a tile: cell numbers within a tile have 16 bits.
const MOST_CELLS: usize = 1 << 16;

/// Floating-point rounding constant: added to a number below 2^31, it leaves the nearest integer in
/// the low 32 bits.
pub(crate) const ROUNDER: f64 = 1.5 * (1_u64 << 52) as f64;

/// Number of offsets from a tile to its adjacent tiles and itself, in three dimensions.
pub(crate) const OFFSETS: usize = 27;

/// Grid of equal rectangular cells, numbered with the first axis running fastest, grouped in tiles
/// of nearly equal numbers of cells along each axis. There are always three axes, with one cell
/// beyond the dimension.
#[derive(Clone, Debug)]
pub struct Grid<S: Space> {
    domain: Domain<S>,
    /// Largest distance beyond a tile at which its collisions read simulators \[length\].
    reach: f64,
    /// Distance between periodic images of the box along each axis \[length\]: the box side, or
    /// infinite along axes with faces.
    images: S::Vector,
    /// Number of cells of the box along each axis; 1 beyond the dimension.
    counts: [u32; 3],
    /// Inverse sides of a cell \[1/length\], to find the cell of a position.
    scale: S::Vector,
    /// Number of tiles along each axis; 1 beyond the dimension.
    tiles: [u32; 3],
    /// Coordinate of the first cell of each tile along each axis, with the number of cells at the
    /// end.
    firsts: [Vec<u32>; 3],
    /// Smallest position in each tile along each axis, with the box side at the end \[length\].
    edges: [Vec<f64>; 3],
    /// Coordinate of the tile that contains each column, row or layer of cells, along each axis.
    owners: [Vec<u32>; 3],
}

/// Location of a tile in the grid: its cells, and its corners in the box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TilePlace<S: Space> {
    /// Column, row and layer of the tile among all tiles.
    pub(crate) tile: [u32; 3],
    /// Column, row and layer of the tile's first cell in the grid.
    pub(crate) first: [u32; 3],
    /// Number of cells in the tile along each axis.
    pub(crate) sides: [u32; 3],
    /// Lower corner of the tile, the smallest position in it \[length\].
    pub(crate) low: S::Vector,
    /// Upper corner of the tile, the limit of positions in it \[length\].
    pub(crate) high: S::Vector,
}

impl<S: Space> Grid<S> {
    /// Creates a grid of `counts` cells along each axis, grouped in tiles of about `per_tile` of
    /// all `simulators`. Tiles are at least as wide as `reach` \[length\].
    pub(crate) fn new(
        domain: Domain<S>,
        counts: [usize; 3],
        simulators: usize,
        per_tile: usize,
        reach: f64,
    ) -> Self {
        let cells: usize = counts.iter().product();
        let each = (simulators.max(1) as f64 / cells as f64).max(1.0 / 16.0);
        let volume = (per_tile as f64 / each).clamp(1.0, MOST_CELLS as f64);
        let side = volume.powf(1.0 / S::DIMENSION as f64).max(1.0);
        // Slightly below what the number of bits allows, as sides are rounded.
        let most = if S::DIMENSION == 2 { 255 } else { 40 };
        let counts = counts.map(|count| count.max(1) as u32);
        let tiles = [0, 1, 2].map(|axis| {
            let count = counts[axis];
            let wanted = (f64::from(count) / side).round().max(1.0) as u32;
            let length = if axis < S::DIMENSION {
                domain.lengths()[axis]
            } else {
                1.0
            };
            let cells_in_reach = (reach / length * f64::from(count)).ceil().max(1.0);
            let widest = ((f64::from(count) / cells_in_reach) as u32).max(1);
            wanted.min(widest).max(count.div_ceil(most)).min(count)
        });
        let mut scale = S::Vector::default();
        for axis in 0..S::DIMENSION {
            // Slightly less, so that no position below the box side gets a cell beyond it.
            let exact = f64::from(counts[axis]) / domain.lengths()[axis];
            scale[axis] = exact * (1.0 - 4.0 * f64::EPSILON);
        }
        let images = S::from_components(|axis| {
            if domain.is_periodic(axis) {
                domain.lengths()[axis]
            } else {
                f64::INFINITY
            }
        });
        let axes = [0, 1, 2];
        let firsts = axes.map(|axis| {
            let [count, tiles] = [counts[axis], tiles[axis]].map(u64::from);
            (0..=tiles)
                .map(|tile| (tile * count / tiles) as u32)
                .collect::<Vec<_>>()
        });
        let mut grid = Self {
            domain,
            reach,
            images,
            counts,
            scale,
            tiles,
            owners: axes.map(|axis| {
                let ends = firsts[axis].windows(2).enumerate();
                ends.flat_map(|(tile, ends)| (ends[0]..ends[1]).map(move |_| tile as u32))
                    .collect()
            }),
            firsts,
            edges: [const { Vec::new() }; 3],
        };
        for axis in 0..S::DIMENSION {
            grid.edges[axis] = grid.firsts[axis]
                .iter()
                .map(|&first| grid.edge(axis, first))
                .collect();
        }
        grid
    }

    /// Returns the smallest coordinate along an axis that is in a column of cells from `first` on
    /// \[length\]; the box side beyond the last cell.
    fn edge(&self, axis: usize, first: u32) -> f64 {
        if first == 0 {
            return 0.0;
        }
        if first >= self.counts[axis] {
            return self.domain.lengths()[axis];
        }
        let mut edge = f64::from(first) / self.scale[axis];
        while self.column(axis, edge) >= first {
            edge = edge.next_down();
        }
        while self.column(axis, edge) < first {
            edge = edge.next_up();
        }
        edge
    }

    /// Returns the column (row, layer) of cells along an axis that contains a coordinate inside the
    /// box: round(x scale - 1/2), which is monotonic and fast.
    #[inline(always)]
    pub(crate) fn column(&self, axis: usize, x: f64) -> u32 {
        ((x * self.scale[axis] - 0.5) + ROUNDER).to_bits() as u32
    }

    /// Returns column, row and layer of the cell that contains a position inside the box.
    #[inline]
    pub fn cell_at(&self, position: S::Vector) -> [u32; 3] {
        let mut cell = [0; 3];
        for axis in 0..S::DIMENSION {
            cell[axis] = self.column(axis, position[axis]);
        }
        cell
    }

    /// Returns the number of a cell, given its column, row and layer; the first axis runs fastest.
    #[inline]
    pub fn number(&self, cell: [u32; 3]) -> u32 {
        cell[0] + self.counts[0] * (cell[1] + self.counts[1] * cell[2])
    }

    /// Returns the number of cells along each axis; 1 beyond the dimension.
    pub fn counts(&self) -> [u32; 3] {
        self.counts
    }

    /// Returns the number of cells of the grid.
    pub fn cells(&self) -> usize {
        self.counts.iter().map(|&count| count as usize).product()
    }

    /// Returns the sides of a cell \[length\].
    pub fn width(&self) -> S::Vector {
        let mut width = self.domain.lengths();
        for axis in 0..S::DIMENSION {
            width[axis] /= f64::from(self.counts[axis]);
        }
        width
    }

    /// Returns the least side of a cell \[length\].
    pub(crate) fn narrowest(&self) -> f64 {
        let width = self.width();
        (0..S::DIMENSION)
            .map(|axis| width[axis])
            .fold(f64::MAX, f64::min)
    }

    /// Returns the area or volume of a cell \[length^D\].
    pub fn cell_volume(&self) -> f64 {
        (0..S::DIMENSION).map(|axis| self.width()[axis]).product()
    }

    /// Returns the box that the grid divides.
    pub fn domain(&self) -> &Domain<S> {
        &self.domain
    }

    /// Returns the distance between periodic images of the box along each axis \[length\]: the box
    /// side, or infinite along axes with faces.
    #[inline]
    pub(crate) fn images(&self) -> S::Vector {
        self.images
    }

    /// Returns the displacement of the periodic image above in a shear flow \[length\]; 0 without
    /// shear.
    pub(crate) fn offset(&self) -> f64 {
        let shear = self.domain.images().shear();
        shear.map_or(0.0, |shear| shear.offset)
    }

    /// Advances a shear flow by a time \[time\]: the periodic images above and below slide.
    pub(crate) fn slide(&mut self, duration: f64) {
        self.domain.advance(duration);
    }

    /// Returns the displacement of the periodic image above in a shear flow, rounded to whole
    /// columns of cells.
    pub(crate) fn offset_columns(&self) -> usize {
        let columns = (self.offset() * self.scale[0]).round() as usize;
        columns % self.counts[0] as usize
    }

    /// Returns the shortest periodic image of a difference of two positions in the box or slightly
    /// outside \[length\].
    #[inline(always)]
    pub(crate) fn nearest_image(&self, difference: S::Vector) -> S::Vector {
        self.domain.images().nearest_of_near(difference)
    }

    /// Returns the number of tiles along each axis; 1 along axes beyond the dimension.
    pub fn tiles(&self) -> [u32; 3] {
        self.tiles
    }

    /// Returns the number of the tile that contains a cell, and the cell's number within that tile.
    #[inline]
    pub fn locate(&self, cell: [u32; 3]) -> (usize, usize) {
        let tile = [0, 1, 2].map(|axis| self.owners[axis][cell[axis] as usize]);
        let mut local = 0;
        for axis in (0..3).rev() {
            let first = &self.firsts[axis][tile[axis] as usize..];
            local = local * (first[1] - first[0]) + (cell[axis] - first[0]);
        }
        (self.tile_number(tile), local as usize)
    }

    /// Returns the number of a tile, given its column, row and layer; the first axis runs fastest.
    #[inline]
    pub(crate) fn tile_number(&self, tile: [u32; 3]) -> usize {
        (tile[0] + self.tiles[0] * (tile[1] + self.tiles[1] * tile[2])) as usize
    }

    /// Returns the largest distance beyond a tile at which its collisions read simulators
    /// \[length\].
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// Returns column, row and layer of a tile, given its number.
    pub(crate) fn place_of(&self, number: usize) -> [u32; 3] {
        let (number, [columns, rows, _]) = (number as u32, self.tiles);
        [
            number % columns,
            number / columns % rows,
            number / columns / rows,
        ]
    }

    /// Returns column, row and layer of the tile that contains a cell.
    #[inline]
    pub(crate) fn owner(&self, cell: [u32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|axis| self.owners[axis][cell[axis] as usize])
    }

    /// Returns column, row and layer of the tile at an offset of -1, 0 or 1 along each axis, across
    /// periodic faces.
    pub(crate) fn neighbour(&self, tile: [u32; 3], offset: [i32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|axis| {
            let count = self.tiles[axis];
            (tile[axis] + count).wrapping_add_signed(offset[axis]) % count
        })
    }

    /// Returns the numbers of a tile and of all adjacent tiles, sorted, each once. In a shear flow
    /// every tile of the row beyond the edge is adjacent, as rows slide past each other.
    pub(crate) fn touching(&self, tile: [u32; 3]) -> Vec<usize> {
        let is_sheared = self.domain.images().shear().is_some();
        let mut numbers = Vec::with_capacity(OFFSETS);
        for step in (0..OFFSETS).map(offset) {
            let [x, y, z] = self.neighbour(tile, step);
            let columns = if is_sheared && tile[1].checked_add_signed(step[1]) != Some(y) {
                0..self.tiles[0]
            } else {
                x..x + 1
            };
            numbers.extend(columns.map(|x| self.tile_number([x, y, z])));
        }
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Returns the locations in the grid of all tiles, in the order of their numbers.
    pub(crate) fn places(&self) -> Vec<TilePlace<S>> {
        let [columns, rows, layers] = self.tiles;
        let mut places = Vec::with_capacity((columns * rows * layers) as usize);
        for layer in 0..layers {
            for row in 0..rows {
                for column in 0..columns {
                    places.push(self.tile_place([column, row, layer]));
                }
            }
        }
        places
    }

    /// Returns the location in the grid of a tile: its cells, and its corners in the box.
    pub(crate) fn tile_place(&self, tile: [u32; 3]) -> TilePlace<S> {
        let first = |axis: usize, more: usize| self.firsts[axis][tile[axis] as usize + more];
        let (mut low, mut high) = (S::Vector::default(), S::Vector::default());
        for axis in 0..S::DIMENSION {
            let edges = &self.edges[axis][tile[axis] as usize..];
            (low[axis], high[axis]) = (edges[0], edges[1]);
        }
        TilePlace {
            tile,
            first: [0, 1, 2].map(|axis| first(axis, 0)),
            sides: [0, 1, 2].map(|axis| first(axis, 1) - first(axis, 0)),
            low,
            high,
        }
    }

    /// Returns the memory that the tables of the grid occupy \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        let tables = |axis: usize| {
            4 * (self.firsts[axis].capacity() + self.owners[axis].capacity())
                + 8 * self.edges[axis].capacity()
        };
        (0..3).map(tables).sum()
    }
}

/// Returns the offset between adjacent tiles with a number below [`OFFSETS`]: -1, 0 or 1 along each
/// axis.
pub(crate) fn offset(number: usize) -> [i32; 3] {
    let number = number as i32;
    [number % 3 - 1, number / 3 % 3 - 1, number / 9 - 1]
}

/// Returns the number of the offset from one tile to another, for `tiles` tiles along each axis;
/// `None` if they are not adjacent. If several offsets connect them, the choice is fixed.
pub(crate) fn offset_number(tiles: [u32; 3], from: [u32; 3], to: [u32; 3]) -> Option<usize> {
    let mut number = 0;
    for axis in (0..3).rev() {
        let (count, from, to) = (tiles[axis], from[axis], to[axis]);
        // In a ring of two tiles, the next is also the previous; it counts as the next.
        let digit = if to == from {
            1
        } else if to == from + 1 || (to == 0 && from + 1 == count) {
            2
        } else if from == to + 1 || (from == 0 && to + 1 == count) {
            0
        } else {
            return None;
        };
        number = 3 * number + digit;
    }
    Some(number)
}
