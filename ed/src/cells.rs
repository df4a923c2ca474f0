//! The grid of cells and the lists of the disks in them.

use nalgebra::{Vector2, vector};

/// No disk.
pub(crate) const NONE: u32 = u32::MAX;

/// Coordinates of a cell.
pub(crate) type Cell = [u16; 2];

/// Cells of a tile along one side, as a power of two: cells and disks that are near each other in the plane
/// are near in memory.
const TILE: u32 = 3;

/// Periodic grid; each cell has a singly linked list of its disks (cells hold about one).
#[derive(Debug)]
pub(crate) struct Cells {
    counts: [u16; 2],
    tiles: usize,
    width: Vector2<f64>,
    lengths: Vector2<f64>,
    heads: Vec<u32>,
    next: Vec<u32>,
}

impl Cells {
    /// The finest useful grid: cells no narrower than the largest diameter, and about two cells a disk.
    pub(crate) fn new(lengths: Vector2<f64>, largest_diameter: f64, disks: usize) -> Self {
        // Wider than a diameter by more than positions are rounded.
        let narrowest = largest_diameter * (1.0 + 1e-9);
        let ideal = 0.68 * (lengths[0] * lengths[1] / disks.max(1) as f64).sqrt();
        let count =
            |length: f64| (length / narrowest.max(ideal)).floor().clamp(1.0, 65_535.0) as u16;
        let counts = [count(lengths[0]), count(lengths[1])];
        let width = vector![
            lengths[0] / f64::from(counts[0]),
            lengths[1] / f64::from(counts[1])
        ];
        let tiles = |count: u16| usize::from(count).div_ceil(1 << TILE);
        let total = (tiles(counts[0]) * tiles(counts[1])) << (2 * TILE);
        Self {
            counts,
            tiles: tiles(counts[0]),
            width,
            lengths,
            heads: vec![NONE; total],
            next: vec![NONE; disks],
        }
    }

    /// Sides of a cell.
    #[inline]
    pub(crate) fn width(&self) -> Vector2<f64> {
        self.width
    }

    /// Place of a cell in memory: by tiles, and by rows within a tile.
    #[inline]
    pub(crate) fn index(&self, cell: Cell) -> usize {
        let [x, y] = cell.map(usize::from);
        let inside = (1 << TILE) - 1;
        let tile = (y >> TILE) * self.tiles + (x >> TILE);
        tile << (2 * TILE) | (y & inside) << TILE | (x & inside)
    }

    /// The cell of a position inside the box, and the position relative to its corner.
    pub(crate) fn locate(&self, position: Vector2<f64>) -> (Cell, Vector2<f64>) {
        let mut cell = [0; 2];
        let mut offset = position;
        for axis in 0..2 {
            let number = (position[axis] / self.width[axis]).floor().max(0.0) as u16;
            cell[axis] = number.min(self.counts[axis] - 1);
            offset[axis] = position[axis] - f64::from(cell[axis]) * self.width[axis];
        }
        (cell, offset)
    }

    /// The corner of a cell.
    pub(crate) fn corner(&self, cell: Cell) -> Vector2<f64> {
        vector![
            f64::from(cell[0]) * self.width[0],
            f64::from(cell[1]) * self.width[1]
        ]
    }

    /// The cell `step` (-1, 0 or 1) further along an axis.
    #[inline]
    pub(crate) fn shifted(&self, number: u16, axis: usize, step: i32) -> u16 {
        let count = self.counts[axis];
        match step {
            0 => number,
            1 if number + 1 == count => 0,
            1 => number + 1,
            _ if number == 0 => count - 1,
            _ => number - 1,
        }
    }

    /// Vector from the corner of the second cell to that of the first, over the nearest image.
    pub(crate) fn between(&self, first: Cell, second: Cell) -> Vector2<f64> {
        let mut shift = Vector2::zeros();
        for axis in 0..2 {
            let count = i32::from(self.counts[axis]);
            let mut steps = i32::from(first[axis]) - i32::from(second[axis]);
            if 2 * steps > count {
                steps -= count;
            } else if 2 * steps < -count {
                steps += count;
            }
            shift[axis] = f64::from(steps) * self.width[axis];
        }
        shift
    }

    /// The nearest image of a separation, where the grid is too small for cells to tell images apart.
    #[inline]
    pub(crate) fn nearest(&self, mut separation: Vector2<f64>) -> Vector2<f64> {
        for axis in 0..2 {
            if self.counts[axis] < 3 {
                separation[axis] -=
                    self.lengths[axis] * (separation[axis] / self.lengths[axis]).round();
            }
        }
        separation
    }

    /// First disk of a cell, or [`NONE`].
    #[inline]
    pub(crate) fn first(&self, cell: usize) -> u32 {
        self.heads[cell]
    }

    /// The disk after `disk` in its cell, or [`NONE`].
    #[inline]
    pub(crate) fn after(&self, disk: u32) -> u32 {
        self.next[disk as usize]
    }

    pub(crate) fn insert(&mut self, disk: u32, cell: Cell) {
        let index = self.index(cell);
        self.next[disk as usize] = self.heads[index];
        self.heads[index] = disk;
    }

    pub(crate) fn remove(&mut self, disk: u32, cell: Cell) {
        let index = self.index(cell);
        let after = self.next[disk as usize];
        if self.heads[index] == disk {
            self.heads[index] = after;
            return;
        }
        let mut before = self.heads[index];
        while self.next[before as usize] != disk {
            before = self.next[before as usize];
        }
        self.next[before as usize] = after;
    }

    /// Memory held \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        4 * (self.heads.capacity() + self.next.capacity())
    }
}
