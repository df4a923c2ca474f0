//! Cell lists: a regular grid over the box, each cell with the linked list of its disks. Beyond a
//! wall there is one more column or row of cells, which stays empty.

use nalgebra::{Vector2, vector};
use stosszahl_model::{images, memory};

/// Disk number that means no disk: end of a linked list, or no partner.
pub(crate) const NONE: u32 = u32::MAX;

/// Returns the array index at which to prefetch the record of a disk. For [`NONE`] it is an address
/// just before the first record, usually on the same page.
#[inline(always)]
pub(crate) fn line_of(disk: u32) -> usize {
    disk as i32 as usize
}

/// Column and row of a cell in the grid, from 0.
pub(crate) type CellCoordinates = [u16; 2];

/// Binary logarithm of the side of a square tile of cells stored together: cells near each other in
/// the box are near in memory.
const TILE: u32 = 3;

/// Mean number of disks in a cell of a dilute gas: with more, too many candidates are tested; with
/// fewer, too many boundaries are crossed.
const OCCUPANCY: f64 = 0.45;

/// Largest width of ordinary cells, in diameters, unless the number of cells then exceeds memory.
/// The square of a contact distance is a difference of squares of separations, with an error of
/// 1e-16 of these.
const WIDEST: f64 = 64.0;

/// Largest mean number of other disks in the cell of a disk for which the wide cells of a dilute
/// gas are used. A uniform gas has [`OCCUPANCY`]; a gas with dense regions gets narrower cells.
const CROWDED: f64 = 2.0;

/// Least number of columns and of rows in a grid of the wide cells of a dilute gas.
const LEAST_COUNT: f64 = 4.0;

/// Number of cells that a disk enters while it flies the width of a cell, on average over all
/// directions: 4/π.
const ENTERED: f64 = 4.0 / std::f64::consts::PI;

/// Estimates the number of cell boundaries that disks cross per collision, in a uniform gas with
/// the given mean free path \[length\]. Around obstacles cells are narrower.
///
/// A gas in which more than 1e7 of them come between two collisions is given up
/// ([`crate::EventDrivenError::NoCollisions`]).
pub fn crossings_per_collision(
    lengths: [f64; 2],
    disks: usize,
    largest_diameter: f64,
    mean_free_path: f64,
    has_obstacles: bool,
) -> f64 {
    let lengths = Vector2::from(lengths);
    let narrow = CellLists::least_width(lengths, largest_diameter, disks);
    let wide = CellLists::wide_width(lengths, disks);
    let width = if has_obstacles || wide < 2.0 * narrow {
        narrow
    } else {
        wide
    };
    2.0 * ENTERED * mean_free_path / width
}

/// Cell lists of a box: a grid of cells, each with the first disk of its linked list.
#[derive(Debug)]
pub(crate) struct CellLists {
    counts: [u16; 2],
    periodic: [bool; 2],
    /// Number of columns and of rows along each periodic axis, for the minimum image: a step of
    /// more than half of them is shorter the other way round. Larger than any step along an axis
    /// with walls.
    around: [i32; 2],
    width: Vector2<f64>,
    lengths: Vector2<f64>,
    narrow: bool,
    /// True if cells are wider than the limit up to which differences of squared separations are
    /// accurate; contact times then use another formula.
    wide: bool,
    /// Contribution of each column to the memory index of a cell, which is the sum of two. Two
    /// entries before the first column and two after the last are its periodic images, or the empty
    /// column beyond a wall.
    columns: Vec<u32>,
    /// Contribution of each row to the memory index of a cell, which is the sum of two. Two entries
    /// before the first row and two after the last are its periodic images, or the empty row beyond
    /// a wall.
    rows: Vec<u32>,
    firsts: Vec<u32>,
}

impl CellLists {
    /// Returns the width of cells that is best for the speed of the event loop at this number of
    /// disks \[length\], if larger than all diameters.
    pub(crate) fn ideal(lengths: Vector2<f64>, disks: usize) -> f64 {
        (OCCUPANCY * lengths[0] * lengths[1] / disks.max(1) as f64).sqrt()
    }

    /// Creates empty cell lists. Cells are at least as wide as the largest diameter, and otherwise
    /// as wide as is best for this number of disks.
    pub(crate) fn new(
        lengths: Vector2<f64>,
        periodic: [bool; 2],
        largest_diameter: f64,
        disks: usize,
    ) -> Self {
        let least = Self::least_width(lengths, largest_diameter, disks);
        let count = |length: f64| (length / least).floor().clamp(1.0, 65_535.0) as u16;
        let counts = [count(lengths[0]), count(lengths[1])];
        let narrow = [0, 1].map(|axis| periodic[axis] && counts[axis] < 3);
        Self::with_counts(lengths, periodic, counts, narrow[0] || narrow[1])
    }

    /// Returns the lower limit for the width of cells \[length\]: at least a diameter, and such
    /// that squared separations are accurate and all cells fit into memory. Actual cells are a
    /// little wider.
    fn least_width(lengths: Vector2<f64>, largest_diameter: f64, disks: usize) -> f64 {
        // Wider than a diameter by more than positions are rounded.
        let narrowest = largest_diameter * (1.0 + 1e-9);
        let many = (lengths[0] * lengths[1] / (16.0 * disks as f64 + 1e6)).sqrt();
        let widest = (WIDEST * largest_diameter).max(many);
        narrowest.max(Self::ideal(lengths, disks).min(widest))
    }

    /// Creates cell lists of a dilute gas with cells as wide as its density asks for, beyond
    /// [`WIDEST`]. A disk of a dilute gas crosses many cells per collision; wide cells make these
    /// fewer. `None` where [`Self::new`] gives such cells, or where disks are crowded. `places` are
    /// the positions of all disks.
    ///
    /// Contact times in such cells need [`crate::contact::Candidates::add_far`].
    pub(crate) fn wide_ones(
        lengths: Vector2<f64>,
        periodic: [bool; 2],
        largest_diameter: f64,
        places: &[Vector2<f64>],
    ) -> Option<Self> {
        let narrow = Self::least_width(lengths, largest_diameter, places.len());
        let mut width = Self::wide_width(lengths, places.len());
        while width >= 2.0 * narrow {
            let counts = [0, 1].map(|axis| (lengths[axis] / width).floor() as u16);
            let mut cells = Self::with_counts(lengths, periodic, counts, false);
            cells.wide = true;
            if cells.crowding(places) <= CROWDED {
                return Some(cells);
            }
            width *= 0.5;
        }
        None
    }

    /// Returns true if the gas may be dilute enough for wide cells ([`Self::wide_ones`]), as far as
    /// number and diameter of its disks tell.
    pub(crate) fn may_be_wide(lengths: Vector2<f64>, largest_diameter: f64, disks: usize) -> bool {
        let narrow = Self::least_width(lengths, largest_diameter, disks);
        Self::wide_width(lengths, disks) >= 2.0 * narrow
    }

    fn wide_width(lengths: Vector2<f64>, disks: usize) -> f64 {
        Self::ideal(lengths, disks).min(lengths.min() / LEAST_COUNT)
    }

    /// Returns the mean number of other disks in the cell of a disk, over disks at the positions
    /// `places`.
    fn crowding(&self, places: &[Vector2<f64>]) -> f64 {
        let mut counts = vec![0_u32; self.firsts.len()];
        let mut others = 0_u64;
        for &place in places {
            let count = &mut counts[self.place(self.locate(place).0, 1, 1)];
            // Twice as many ordered pairs as there were disks before.
            others += 2 * u64::from(*count);
            *count += 1;
        }
        others as f64 / places.len().max(1) as f64
    }

    /// Returns true if cells are so wide that contact times need the formula of
    /// [`crate::contact::Candidates::add_far`].
    #[inline(always)]
    pub(crate) fn wide(&self) -> bool {
        self.wide
    }

    /// Creates empty cell lists with the given numbers of columns and rows. `narrow` is true if two
    /// periodic images of a disk may touch the same disk.
    pub(crate) fn with_counts(
        lengths: Vector2<f64>,
        periodic: [bool; 2],
        counts: [u16; 2],
        narrow: bool,
    ) -> Self {
        let width = vector![
            lengths[0] / f64::from(counts[0]),
            lengths[1] / f64::from(counts[1])
        ];
        let columns = [0, 1].map(|axis| u32::from(counts[axis]) + u32::from(!periodic[axis]));
        let tiles = |count: u32| count.div_ceil(1 << TILE);
        let inside = (1 << TILE) - 1;
        let across = tiles(columns[0]);
        let column = |x: u32| (x >> TILE) << (2 * TILE) | (x & inside);
        let row = |y: u32| ((y >> TILE) * across) << (2 * TILE) | (y & inside) << TILE;
        let around = |axis: usize, part: &dyn Fn(u32) -> u32| {
            let last = u32::from(counts[axis]) - 1;
            let (before, after) = if periodic[axis] {
                ([last.saturating_sub(1), last], [0, 1.min(last)])
            } else {
                ([last + 1; 2], [last + 1; 2])
            };
            (before.into_iter())
                .chain(0..=last)
                .chain(after)
                .map(part)
                .collect()
        };
        let total = ((across * tiles(columns[1])) as usize) << (2 * TILE);
        let around_box = |axis: usize| {
            if periodic[axis] {
                i32::from(counts[axis])
            } else {
                i32::MAX
            }
        };
        Self {
            counts,
            periodic,
            around: [around_box(0), around_box(1)],
            width,
            lengths,
            narrow,
            wide: false,
            columns: around(0, &column),
            rows: around(1, &row),
            firsts: memory::filled(NONE, total),
        }
    }

    /// Returns cell lists with the same grid but without disks.
    pub(crate) fn emptied(&self) -> Self {
        Self {
            columns: self.columns.clone(),
            rows: self.rows.clone(),
            firsts: memory::filled(NONE, self.firsts.len()),
            ..*self
        }
    }

    /// Copies the first disk of each cell in some rows from other cell lists with the same grid.
    pub(crate) fn copy_rows(&mut self, from: &Self, rows: impl Iterator<Item = u16>) {
        // Tile by tile, as they are in memory.
        let side = 1 << TILE;
        let rows: Vec<u16> = rows.collect();
        for rows in rows.chunks(side) {
            for begin in (0..self.counts[0]).step_by(side) {
                let end = self.counts[0].min(begin.saturating_add(side as u16));
                for &row in rows {
                    for column in begin..end {
                        let place = self.place([column, row], 1, 1);
                        self.firsts[place] = from.firsts[place];
                    }
                }
            }
        }
    }

    /// Returns the sides of a cell along x and y \[length\].
    #[inline]
    pub(crate) fn width(&self) -> Vector2<f64> {
        self.width
    }

    /// Returns the memory index of a cell or one of its eight neighbours. `right` and `up` are 0
    /// for the column to the left or row below, 1 for the cell's own, and 2 for the next.
    #[inline]
    pub(crate) fn place(&self, cell: CellCoordinates, right: usize, up: usize) -> usize {
        let [x, y] = cell.map(usize::from);
        (self.columns[x + right + 1] + self.rows[y + up + 1]) as usize
    }

    /// Returns the contributions of three columns and of three rows to the memory indices of a cell
    /// and its eight neighbours: each index is the sum of two of them.
    #[inline(always)]
    pub(crate) fn cells_around(&self, cell: CellCoordinates) -> ([u32; 3], [u32; 3]) {
        let [x, y] = cell.map(usize::from);
        let (columns, rows) = (&self.columns[x + 1..x + 4], &self.rows[y + 1..y + 4]);
        (
            [columns[0], columns[1], columns[2]],
            [rows[0], rows[1], rows[2]],
        )
    }

    /// Returns the memory indices of three cells in a line perpendicular to `axis`. The middle one
    /// is `steps` cells, at most two, from `cell` along the axis, forward or backward.
    #[inline(always)]
    pub(crate) fn across(
        &self,
        cell: CellCoordinates,
        axis: usize,
        steps: usize,
        forward: bool,
    ) -> [u32; 3] {
        let parts = [&self.columns, &self.rows];
        let (along, across) = (parts[axis % 2], parts[1 - axis % 2]);
        let [along_its, across_its] = [cell[axis % 2], cell[1 - axis % 2]].map(usize::from);
        let step = 2 + 2 * steps * usize::from(forward) - steps;
        let place = along[along_its + step];
        let across = &across[across_its + 1..across_its + 4];
        [place + across[0], place + across[1], place + across[2]]
    }

    /// Returns, along one axis, the contributions to memory indices of the four columns or rows
    /// around two adjacent cells, and for each cell the first of its three among them. `None` if
    /// the cells are not adjacent or the grid is too small.
    #[inline(always)]
    pub(crate) fn around_both(
        &self,
        first: CellCoordinates,
        second: CellCoordinates,
        axis: usize,
    ) -> Option<([u32; 4], [usize; 2])> {
        let count = i32::from(self.counts[axis]);
        let mut step = i32::from(second[axis]) - i32::from(first[axis]);
        if step.abs() > 1 {
            step -= step.signum() * count;
        }
        if step.abs() > 1 || count < 3 {
            return None;
        }
        let begin = [usize::from(step < 0), usize::from(step > 0)];
        let least = usize::from(if step < 0 { second[axis] } else { first[axis] });
        let parts = if axis == 0 { &self.columns } else { &self.rows };
        let parts = &parts[least + 1..least + 5];
        Some(([parts[0], parts[1], parts[2], parts[3]], begin))
    }

    /// Returns the cell that contains a position in the box, and the position relative to the lower
    /// left corner of that cell \[length\].
    pub(crate) fn locate(&self, position: Vector2<f64>) -> (CellCoordinates, Vector2<f64>) {
        let mut cell = [0; 2];
        let mut offset = position;
        for axis in 0..2 {
            let number = (position[axis] / self.width[axis]).floor().max(0.0) as u16;
            cell[axis] = number.min(self.counts[axis] - 1);
            offset[axis] = position[axis] - f64::from(cell[axis]) * self.width[axis];
        }
        (cell, offset)
    }

    /// Returns the coordinates of the lower left corner of a cell \[length\].
    pub(crate) fn corner(&self, cell: CellCoordinates) -> Vector2<f64> {
        vector![
            f64::from(cell[0]) * self.width[0],
            f64::from(cell[1]) * self.width[1]
        ]
    }

    /// Returns true if the box is periodic along an axis.
    #[inline]
    pub(crate) fn is_periodic(&self, axis: usize) -> bool {
        self.periodic[axis]
    }

    /// Returns the adjacent column (axis 0) or row (axis 1), forward or backward, and true if the
    /// step wraps around the box.
    #[inline]
    pub(crate) fn beyond(&self, number: u16, axis: usize, forward: bool) -> (u16, bool) {
        let last = self.counts[axis] - 1;
        let next = number.wrapping_add(2 * u16::from(forward)).wrapping_sub(1);
        if next > last {
            (if forward { 0 } else { last }, true)
        } else {
            (next, false)
        }
    }

    /// Returns the vector from the corner of the cell `second` to the nearest periodic image of the
    /// corner of the cell `first` \[length\].
    #[inline(always)]
    pub(crate) fn corner_offset(
        &self,
        first: CellCoordinates,
        second: CellCoordinates,
    ) -> Vector2<f64> {
        let mut shift = Vector2::zeros();
        for axis in 0..2 {
            let count = self.around[axis];
            let steps = i32::from(first[axis]) - i32::from(second[axis]);
            let around = i32::from(2 * steps < -count) - i32::from(2 * steps > count);
            let steps = steps + around * count;
            shift[axis] = f64::from(steps) * self.width[axis];
        }
        shift
    }

    /// Returns true if the box is so narrow that two periodic images of one disk may touch the same
    /// other disk.
    #[inline]
    pub(crate) fn narrow(&self) -> bool {
        self.narrow
    }

    /// Returns the number of cells in memory, including those beyond walls and unused ones of
    /// tiles.
    pub(crate) fn places(&self) -> usize {
        self.firsts.len()
    }

    /// Returns the numbers of columns and of rows of cells in the box.
    pub(crate) fn counts(&self) -> [u16; 2] {
        self.counts
    }

    /// Returns the memory index of a cell whose column and row may lie beyond the box, in a
    /// periodic image or behind a wall, and how many boxes away along each axis it is.
    #[inline]
    pub(crate) fn place_beyond(&self, numbers: [i32; 2]) -> (usize, [i32; 2]) {
        let counts = self.counts.map(i32::from);
        let boxes = [0, 1].map(|axis| numbers[axis].div_euclid(counts[axis]));
        let cell = [0, 1].map(|axis| {
            if boxes[axis] != 0 && !self.periodic[axis] {
                self.counts[axis]
            } else {
                (numbers[axis] - boxes[axis] * counts[axis]) as u16
            }
        });
        (self.place(cell, 1, 1), boxes)
    }

    /// Returns the nearest periodic image of a separation vector, and the images one box from it
    /// along each periodic axis \[length\].
    pub(crate) fn images_of(&self, separation: Vector2<f64>) -> impl Iterator<Item = Vector2<f64>> {
        let mut nearest = separation;
        for axis in 0..2 {
            if self.periodic[axis] {
                nearest[axis] = images::nearest(separation[axis], self.lengths[axis]);
            }
        }
        let lengths = self.lengths;
        let [right, up] = self.periodic.map(|around| {
            let steps: &[f64] = if around { &[-1.0, 0.0, 1.0] } else { &[0.0] };
            steps
        });
        right
            .iter()
            .flat_map(|&right| up.iter().map(move |&up| vector![right, up]))
            .map(move |image| nearest + image.component_mul(&lengths))
    }

    /// Returns the nearest periodic image of a separation vector along the first axis only
    /// \[length\].
    #[inline(always)]
    pub(crate) fn nearest_along(&self, separation: Vector2<f64>) -> Vector2<f64> {
        let nearest = images::nearest(separation[0], self.lengths[0]);
        vector![nearest, separation[1]]
    }

    /// Returns the nearest periodic image of a separation vector along the first axis, and its two
    /// neighbours one box to either side \[length\].
    pub(crate) fn images_along(
        &self,
        separation: Vector2<f64>,
    ) -> impl Iterator<Item = Vector2<f64>> {
        let length = self.lengths[0];
        let nearest = self.nearest_along(separation)[0];
        let steps = [-1.0, 0.0, 1.0].into_iter();
        steps.map(move |step| vector![nearest + step * length, separation[1]])
    }

    /// Returns the contribution to memory indices of a column whose number may be up to one box
    /// beyond either edge.
    #[inline(always)]
    pub(crate) fn column_around(&self, column: i32) -> u32 {
        let columns = i32::from(self.counts[0]);
        let below = if column < 0 { columns } else { 0 };
        let above = if column >= columns { columns } else { 0 };
        self.columns[(column + below - above + 2) as usize]
    }

    /// Returns the contributions to memory indices of four adjacent columns, starting at the column
    /// `first`.
    #[inline(always)]
    pub(crate) fn four_columns(&self, first: i32) -> [u32; 4] {
        // The table repeats the last two columns before the first.
        let columns = i32::from(self.counts[0]);
        let first = if first > columns - 3 {
            first - columns
        } else {
            first
        };
        let from = (first + 2) as usize;
        let four = &self.columns[from..from + 4];
        [four[0], four[1], four[2], four[3]]
    }

    /// Returns the first disk in the linked list of the cell at a memory index, or [`NONE`].
    #[inline]
    pub(crate) fn first(&self, place: usize) -> u32 {
        self.firsts[place]
    }

    /// Makes a disk the first in the linked list of the cell at a memory index; returns the
    /// previous first disk.
    #[inline]
    pub(crate) fn set_first(&mut self, place: usize, disk: u32) -> u32 {
        std::mem::replace(&mut self.firsts[place], disk)
    }

    /// Prefetches the head of the linked list of the cell at a memory index.
    #[inline]
    pub(crate) fn prefetch(&self, place: usize) {
        memory::prefetch(&self.firsts, place);
    }

    /// Returns the memory that the cell lists occupy \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        4 * (self.firsts.capacity() + self.columns.capacity() + self.rows.capacity())
    }
}

/// Periodic image of a separation vector between two disks, the relative velocity of this image,
/// and the velocity of the first disk's sliding row less that of the second's.
pub(crate) type SeparationImage = (Vector2<f64>, Vector2<f64>, f64);

/// Returns, of the periodic images of a pair that touch within rounding at the contact distance
/// `distance`, the one that approaches fastest; the nearest image if none touches.
pub(crate) fn approached(
    images: impl Iterator<Item = SeparationImage>,
    distance: f64,
) -> SeparationImage {
    let approach = |image: &SeparationImage| image.1.dot(&image.0) / image.0.norm();
    let mut nearest = (Vector2::repeat(f64::INFINITY), Vector2::zeros(), 0.0);
    let mut best: Option<SeparationImage> = None;
    for image in images {
        if image.0.norm() < nearest.0.norm() {
            nearest = image;
        }
        let touches = image.0.norm() <= distance * (1.0 + 1e-9);
        if touches && best.is_none_or(|best| approach(&image) < approach(&best)) {
            best = Some(image);
        }
    }
    best.unwrap_or(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of a dilute gas hold 0.45 disks; those of a gas in a corner are as narrow as its own
    /// density asks for, or as [`CellLists::new`] makes them.
    #[test]
    fn cells_of_a_thin_gas_follow_its_density() {
        const SIDE: f64 = 1e5;
        for (count, part, width) in [
            (10_000, 1.0, Some(670.8)),
            (1000, 1.0, Some(2121.3)),
            (5, 1.0, Some(25_000.0)),
            (10_000, 0.25, Some(670.8 / 2.0)),
            (10_000, 0.01, None),
            (1_000_000, 1.0, None),
        ] {
            let places = (0..count).map(|index| {
                let number = f64::from(index) + 0.5;
                vector![0.618 * number % 1.0, number / f64::from(count)] * (part * SIDE)
            });
            let places: Vec<_> = places.collect();
            let found = CellLists::wide_ones(vector![SIDE, SIDE], [true; 2], 1.0, &places);
            let its = found.map(|cells| {
                assert!(cells.wide() && cells.crowding(&places) <= CROWDED);
                cells.width()[0]
            });
            let near = |its: f64, width: f64| its > 0.9 * width && its < 1.1 * width;
            assert!(
                its.is_some() == width.is_some()
                    && its.zip(width).is_none_or(|(its, width)| near(its, width)),
                "{count} in {part}: {its:?}, not {width:?}"
            );
        }
    }
}
