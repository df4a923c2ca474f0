//! Rows of cells that slide over each other with a uniform shear flow.
//!
//! Each row of cells moves with the flow at half its height, and velocities of disks are relative
//! to their row: close to the peculiar velocities, however high the box is. Within its row a disk
//! flies straight. The next row above is another frame: its corner is ahead by a displacement that
//! grows with time, and it moves faster by the slip, the shear rate times the height of a row. So
//! every boundary between two rows is a Lees-Edwards boundary; the periodic boundary of the box has
//! an additional offset.
//!
//! A cell can be touched from four cells of the row above and from four below, instead of three for
//! rows at rest. The four change when the displacement reaches a whole number of cells. That is one
//! event for all boundaries of a kind, in which each cell searches the cell that is new in its
//! reach.

use crate::cells::{CellCoordinates, CellLists};

/// Kind of the boundaries between rows, which slide alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seam {
    /// Boundary between two rows of the box.
    Inside,
    /// Periodic boundary between the last row and the image of the first.
    Around,
}

/// State of the rows. Times and speeds are in the engine's own units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlidingRows {
    /// Shear rate of the flow in engine units.
    rate: f64,
    /// Sides of a cell.
    width: [f64; 2],
    columns: i32,
    rows: u16,
    /// Displacement of the next row at engine time 0: zero inside the box; over the top edge, the
    /// displacement of the periodic image above.
    offsets: [f64; 2],
    /// Number of whole cells that the displacement has passed: inside the box, and around it.
    steps: [i64; 2],
    /// Whole cells of displacement modulo the number of columns, inside the box and around it: kept
    /// beside `steps`, as a division for each search is slow.
    turned: [i32; 2],
}

impl SlidingRows {
    /// Creates the rows of a grid in a flow with this shear rate in engine units, at engine time 0.
    pub(crate) fn new(cells: &CellLists, rate: f64, offset: f64) -> Self {
        let [columns, rows] = cells.counts();
        let width = [cells.width()[0], cells.width()[1]];
        let offsets = [0.0, offset];
        let steps = offsets.map(|offset| {
            let steps = (offset / width[0]).floor();
            // With a negative rate, a displacement on the boundary of a cell belongs to the step
            // before.
            let is_end = rate < 0.0 && steps * width[0] == offset;
            steps as i64 - i64::from(is_end)
        });
        let columns = i32::from(columns);
        Self {
            rate,
            width,
            columns,
            rows,
            offsets,
            steps,
            turned: steps.map(|steps| steps.rem_euclid(i64::from(columns)) as i32),
        }
    }

    /// Returns rows without a flow.
    pub(crate) fn none() -> Self {
        Self {
            rate: 0.0,
            width: [0.0; 2],
            columns: 1,
            rows: 1,
            offsets: [0.0; 2],
            steps: [0; 2],
            turned: [0; 2],
        }
    }

    /// Shear rate of the flow in engine units.
    #[inline(always)]
    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// Velocity of a row less the velocity of the row below.
    #[inline(always)]
    pub(crate) fn slip(&self) -> f64 {
        self.rate * self.width[1]
    }

    /// Velocity of the flow at a height in a row, relative to the row.
    #[inline(always)]
    pub(crate) fn flow(&self, height: f64) -> f64 {
        self.rate * (height - 0.5 * self.width[1])
    }

    /// Displacement of a row since engine time 0 in the frame of the box.
    pub(crate) fn way(&self, row: u16, now: f64) -> f64 {
        self.rate * ((f64::from(row) + 0.5) * self.width[1]) * now
    }

    /// Returns the index, into `offsets`, `steps` and `turned`, of the boundary above a row: 0
    /// inside the box, 1 for the periodic boundary over the last row.
    #[inline(always)]
    fn above(&self, row: u16) -> usize {
        usize::from(row + 1 == self.rows)
    }

    /// Returns the index, into `offsets`, `steps` and `turned`, of the boundary below a row: 0
    /// inside the box, 1 for the periodic boundary under row 0.
    #[inline(always)]
    fn below(row: u16) -> usize {
        usize::from(row == 0)
    }

    /// Displacement of the row above a boundary beyond whole cells, from 0 to the width of a cell,
    /// and at most rounding more.
    #[inline(always)]
    fn remainder(&self, seam: usize, now: f64) -> f64 {
        self.offsets[seam] + self.slip() * now - self.steps[seam] as f64 * self.width[0]
    }

    /// Returns the number in the box of a column at most two boxes to its left, or one to its
    /// right.
    #[inline(always)]
    fn column(&self, column: i32) -> i32 {
        let columns = self.columns;
        let after = |column: i32| column + if column < 0 { columns } else { 0 };
        let inside = after(after(column));
        inside - if inside >= columns { columns } else { 0 }
    }

    /// Returns the first of the four columns of the row above that a cell can be touched from, and
    /// the distance between the corners of this column and the cell along the flow.
    #[inline(always)]
    pub(crate) fn first_above(&self, [column, row]: CellCoordinates, now: f64) -> (i32, f64) {
        let seam = self.above(row);
        let first = self.column(i32::from(column) - 2 - self.turned[seam]);
        (first, self.remainder(seam, now) - 2.0 * self.width[0])
    }

    /// Returns the first of the four columns of the row below that a cell can be touched from, and
    /// the distance between the corners of this column and the cell along the flow.
    #[inline(always)]
    pub(crate) fn first_below(&self, [column, row]: CellCoordinates, now: f64) -> (i32, f64) {
        let seam = Self::below(row);
        let first = self.column(i32::from(column) - 1 + self.turned[seam]);
        (first, -self.remainder(seam, now) - self.width[0])
    }

    /// Returns the column of a disk that goes into the row above, or below, and its position in
    /// that column.
    #[inline(always)]
    pub(crate) fn cross(
        &self,
        [column, row]: CellCoordinates,
        place: f64,
        forward: bool,
        now: f64,
    ) -> (u16, f64) {
        let seam = if forward {
            self.above(row)
        } else {
            Self::below(row)
        };
        let (turned, way) = (self.turned[seam], self.remainder(seam, now));
        let (column, mut place) = if forward {
            (i32::from(column) - turned, place - way)
        } else {
            (i32::from(column) + turned, place + way)
        };
        let mut beyond = 0;
        if place < 0.0 {
            (beyond, place) = (-1, place + self.width[0]);
        } else if place >= self.width[0] {
            (beyond, place) = (1, place - self.width[0]);
        }
        (self.column(column + beyond) as u16, place)
    }

    /// Returns the vectors from the corner of the second cell to the corner of the first over the
    /// images in adjacent rows, one for each way around the box. Each comes with the difference of
    /// the velocities of the two rows, first less second.
    pub(crate) fn corner_offsets(
        &self,
        first: CellCoordinates,
        second: CellCoordinates,
        now: f64,
    ) -> impl Iterator<Item = ([f64; 2], f64)> {
        let rows = i32::from(self.rows);
        let apart = i32::from(first[1]) - i32::from(second[1]);
        let is_image = move |&step: &i32| (step - apart) % rows == 0;
        let this = *self;
        (-1..=1)
            .filter(is_image)
            .map(move |step| this.in_row(first, second, step, now))
    }

    /// Returns the vector from the corner of the second cell to the corner of the first, in the
    /// same row or an adjacent one, and the difference of the velocities of the two rows, first
    /// less second. The box must have at least three rows.
    #[inline(always)]
    pub(crate) fn nearest_between(
        &self,
        first: CellCoordinates,
        second: CellCoordinates,
        now: f64,
    ) -> ([f64; 2], f64) {
        let rows = i32::from(self.rows);
        let apart = i32::from(first[1]) - i32::from(second[1]);
        let step = match apart {
            2.. => apart - rows,
            ..=-2 => apart + rows,
            _ => apart,
        };
        self.in_row(first, second, step, now)
    }

    /// Returns the vector from the corner of the second cell to the corner of the first over the
    /// image `step` rows above, and the difference of the velocities of the two rows, first less
    /// second.
    #[inline(always)]
    fn in_row(
        &self,
        first: CellCoordinates,
        second: CellCoordinates,
        step: i32,
        now: f64,
    ) -> ([f64; 2], f64) {
        let columns = i32::from(first[0]) - i32::from(second[0]);
        let way = |seam: usize| self.offsets[seam] + self.slip() * now;
        let way = match step {
            0 => 0.0,
            1 => way(self.above(second[1])),
            _ => -way(Self::below(second[1])),
        };
        let x = f64::from(columns) * self.width[0] + way;
        let step = f64::from(step);
        ([x, step * self.width[1]], step * self.slip())
    }

    /// Returns the engine time of the next step of rows, and the kind of boundary at which they
    /// step.
    pub(crate) fn next_step(&self) -> (f64, Seam) {
        if self.rate == 0.0 {
            return (f64::INFINITY, Seam::Inside);
        }
        let ahead = i64::from(self.rate > 0.0);
        let time = |seam: usize| {
            let end = (self.steps[seam] + ahead) as f64 * self.width[0];
            ((end - self.offsets[seam]) / self.slip()).max(0.0)
        };
        let (inside, around) = (time(0), time(1));
        // A single row has no boundary inside.
        if inside <= around && self.rows > 1 {
            (inside, Seam::Inside)
        } else {
            (around, Seam::Around)
        }
    }

    /// Advances rows by a step, which changes the cells within reach of each.
    pub(crate) fn step(&mut self, seam: Seam) {
        let way = if self.rate > 0.0 { 1 } else { -1 };
        self.steps[seam as usize] += way;
        let turned = self.turned[seam as usize] + way as i32;
        self.turned[seam as usize] = self.column(turned);
    }

    /// Returns the rows that have a boundary of a kind above them.
    pub(crate) fn rows_below(&self, seam: Seam) -> std::ops::Range<u16> {
        match seam {
            Seam::Inside => 0..self.rows - 1,
            Seam::Around => self.rows - 1..self.rows,
        }
    }

    /// Returns which of the four columns above a cell has come into reach with the last step.
    #[inline(always)]
    pub(crate) fn newest(&self) -> usize {
        if self.rate > 0.0 { 0 } else { 3 }
    }
}
