//! Rows of cells that slide over each other with a uniform shear flow, joined by Lees-Edwards
//! boundaries.
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

/// Kind of boundary between two rows of cells that slide over each other: inside the box, or its
/// periodic boundary. All boundaries of a kind slide alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seam {
    /// Boundary between two rows of the box.
    Inside,
    /// Periodic boundary between the last row of the box and the image of the first.
    Around,
}

/// State of the rows of cells that slide with a shear flow. Times and speeds are in engine units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlidingRows {
    /// Shear rate of the flow in engine units; zero without a shear flow.
    rate: f64,
    /// Sides of a cell along x and y \[length\].
    width: [f64; 2],
    columns: i32,
    rows: u16,
    /// Displacement of the row above a boundary at engine time 0, along the flow \[length\]: zero
    /// inside the box; at the periodic boundary, that of the image of the box above.
    offsets: [f64; 2],
    /// Whole cells by which the row above a boundary is displaced along the flow: inside the box,
    /// and at its periodic boundary.
    steps: [i64; 2],
    /// Whole cells of displacement of the row above a boundary modulo the number of columns: inside
    /// the box, and at its periodic boundary. Stored in addition to `steps`, as a division for each
    /// search is slow.
    turned: [i32; 2],
}

impl SlidingRows {
    /// Creates the rows of a grid in a shear flow at engine time 0. `rate` is the shear rate in
    /// engine units; `offset` is the displacement of the periodic image above \[length\].
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

    /// Returns the rows of a gas without a shear flow, which do not slide.
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

    /// Returns the shear rate of the flow in engine units.
    #[inline(always)]
    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// Returns the velocity of a row less that of the row below, in engine units.
    #[inline(always)]
    pub(crate) fn slip(&self) -> f64 {
        self.rate * self.width[1]
    }

    /// Returns the flow velocity at a height above the lower edge of a row, relative to the row, in
    /// engine units.
    #[inline(always)]
    pub(crate) fn flow(&self, height: f64) -> f64 {
        self.rate * (height - 0.5 * self.width[1])
    }

    /// Returns the displacement of a row along the flow since engine time 0, in the frame of the
    /// box \[length\].
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

    /// Returns the displacement of the row above a boundary less its whole cells \[length\]: from 0
    /// to the width of a cell, apart from rounding.
    #[inline(always)]
    fn remainder(&self, seam: usize, now: f64) -> f64 {
        self.offsets[seam] + self.slip() * now - self.steps[seam] as f64 * self.width[0]
    }

    /// Returns a column number wrapped into the box, for columns up to two boxes to its left or one
    /// to its right.
    #[inline(always)]
    fn column(&self, column: i32) -> i32 {
        let columns = self.columns;
        let after = |column: i32| column + if column < 0 { columns } else { 0 };
        let inside = after(after(column));
        inside - if inside >= columns { columns } else { 0 }
    }

    /// Returns the first of the four columns in the row above whose disks can touch those of a
    /// cell, and how far its corner is from the cell's along the flow \[length\].
    #[inline(always)]
    pub(crate) fn first_above(&self, [column, row]: CellCoordinates, now: f64) -> (i32, f64) {
        let seam = self.above(row);
        let first = self.column(i32::from(column) - 2 - self.turned[seam]);
        (first, self.remainder(seam, now) - 2.0 * self.width[0])
    }

    /// Returns the first of the four columns in the row below whose disks can touch those of a
    /// cell, and how far its corner is from the cell's along the flow \[length\].
    #[inline(always)]
    pub(crate) fn first_below(&self, [column, row]: CellCoordinates, now: f64) -> (i32, f64) {
        let seam = Self::below(row);
        let first = self.column(i32::from(column) - 1 + self.turned[seam]);
        (first, -self.remainder(seam, now) - self.width[0])
    }

    /// Returns the new column of a disk that crosses into the sliding row above (`forward`) or
    /// below, and its position along the flow in that column \[length\].
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

    /// Returns vectors from the corner of the cell `second` to the corner of the cell `first`
    /// \[length\], one for each way around the box that leads to an adjacent row. Each comes with
    /// the velocity of the first's row less that of the second's.
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

    /// Returns the vector from the corner of the cell `second` to the corner of the cell `first`,
    /// in the same or an adjacent row \[length\], and the velocity of the first's row less that of
    /// the second's. The box must have at least three rows.
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

    /// Returns the vector from the corner of the cell `second` to the image of the corner of
    /// `first` that lies `step` rows above \[length\], and the velocity of the first's row less
    /// that of the second's.
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

    /// Returns the engine time at which sliding rows next reach a whole number of cells of
    /// displacement, and the kind of boundary where this happens.
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

    /// Advances the displacement of the rows at all boundaries of a kind by one whole cell, which
    /// changes which cells can touch.
    pub(crate) fn step(&mut self, seam: Seam) {
        let way = if self.rate > 0.0 { 1 } else { -1 };
        self.steps[seam as usize] += way;
        let turned = self.turned[seam as usize] + way as i32;
        self.turned[seam as usize] = self.column(turned);
    }

    /// Returns the rows of cells that have a boundary of the given kind on their upper side.
    pub(crate) fn rows_below(&self, seam: Seam) -> std::ops::Range<u16> {
        match seam {
            Seam::Inside => 0..self.rows - 1,
            Seam::Around => self.rows - 1..self.rows,
        }
    }

    /// Returns the index (0 or 3) of that one of the four columns above a cell whose disks have
    /// come into reach by the last step of the rows.
    #[inline(always)]
    pub(crate) fn newest(&self) -> usize {
        if self.rate > 0.0 { 0 } else { 3 }
    }
}
