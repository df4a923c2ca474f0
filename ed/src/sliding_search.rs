//! Search for contacts across rows of cells that slide with a shear flow, and lines of centres
//! across such rows.

use nalgebra::{Vector2, vector};
use stosszahl_model::{Field, Plane, Sizes};

use crate::cell_list_walk::CellListWalk;
use crate::cells::{self, CellCoordinates, NONE};
use crate::contact::Candidates;
use crate::disk::DiskSystem;
use crate::frames::Sliding;
use crate::record::DiskRecord;

impl<F: Field<Plane>> DiskSystem<F> {
    /// Opens the linked lists of the cells around the cell `home` in sliding rows. `wanted` selects
    /// the row below, the own row and the row above. A cell's number is four times its row plus its
    /// column: of four, or of three in the own row.
    #[inline(always)]
    pub(crate) fn open_sliding(
        &self,
        lists: &mut CellListWalk,
        home: CellCoordinates,
        time: f64,
        wanted: [bool; 3],
    ) {
        let (columns, rows) = self.cells.cells_around(home);
        if wanted[1] {
            for (column, right) in columns.into_iter().enumerate() {
                lists.open(
                    self.cells.first((right + rows[1]) as usize),
                    4 + column,
                    true,
                );
            }
        }
        let firsts = [
            self.rows.first_below(home, time).0,
            0,
            self.rows.first_above(home, time).0,
        ];
        for row in [0, 2] {
            if wanted[row] {
                let columns = self.cells.four_columns(firsts[row]);
                for (column, right) in columns.into_iter().enumerate() {
                    let first = self.cells.first((right + rows[row]) as usize);
                    lists.open(first, 4 * row + column, true);
                }
            }
        }
    }

    /// Opens the linked lists of cells that come into reach when a disk has entered `home` in
    /// sliding rows. Along the flow these are the outermost cell of each row. Across it all cells
    /// of the rows above and below are opened, though some were in reach before.
    #[inline(always)]
    pub(crate) fn open_beyond_sliding(
        &self,
        lists: &mut CellListWalk,
        home: CellCoordinates,
        (axis, forward): (usize, bool),
        time: f64,
    ) {
        if axis == 1 {
            self.open_sliding(lists, home, time, [true, false, true]);
            return;
        }
        let (columns, rows) = self.cells.cells_around(home);
        let own = 2 * usize::from(forward);
        let first = self.cells.first((columns[own] + rows[1]) as usize);
        lists.open(first, 4 + own, true);
        let firsts = [
            self.rows.first_below(home, time).0,
            self.rows.first_above(home, time).0,
        ];
        for (side, first) in firsts.into_iter().enumerate() {
            self.open_one_of_four(
                lists,
                [first as usize, 3 * usize::from(forward)],
                [side, rows[2 * side] as usize],
            );
        }
    }

    /// Opens the linked list of one of the four cells around a disk in the sliding row below, `side` 0, or
    /// above, `side` 1.
    #[inline(always)]
    fn open_one_of_four(
        &self,
        lists: &mut CellListWalk,
        [first, column]: [usize; 2],
        [side, row]: [usize; 2],
    ) {
        let right = self.cells.four_columns(first as i32)[column];
        let disk = self.cells.first(right as usize + row);
        lists.open(disk, 8 * side + column, true);
    }

    /// Searches the one cell above a disk that came into reach by the last step of sliding rows for
    /// an earlier contact than predicted. The disk must be advanced to the current time. Returns
    /// the number of candidates tested.
    pub(crate) fn search_newest<S: Sizes>(
        &mut self,
        candidates: &mut Candidates,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
    ) -> u64 {
        let (home, clock) = (self.home(who), self.all[who as usize].clock);
        let mut lists = CellListWalk::new();
        let first = self.rows.first_above(home, clock).0 as usize;
        let row = self.cells.cells_around(home).1[2] as usize;
        self.open_one_of_four(&mut lists, [first, self.rows.newest()], [1, row]);
        let (found, predictions) = self.earliest::<S, false>(lists, candidates, who, sizes, tags);
        self.expect_first(who, found);
        predictions
    }

    /// Returns true if the one cell above `home` that came into reach by the last step of sliding
    /// rows contains a disk.
    pub(crate) fn has_newest(&self, home: CellCoordinates, now: f64) -> bool {
        let first = self.rows.first_above(home, now).0;
        let right = self.cells.four_columns(first)[self.rows.newest()];
        let row = self.cells.cells_around(home).1[2];
        self.cells.first((right + row) as usize) != NONE
    }

    /// Returns the reference frames of the cells around the cell `home` in rows that slide, for a
    /// disk at `position` in it.
    #[inline(always)]
    pub(crate) fn sliding(
        &self,
        home: CellCoordinates,
        position: Vector2<f64>,
        time: f64,
    ) -> Sliding {
        let width = self.cells.width();
        let mut sliding = Sliding {
            x: [0.0; 12],
            y: [
                position[1] + width[1],
                position[1],
                position[1] - width[1],
                0.0,
            ],
            slip: [self.rows.slip(), 0.0, -self.rows.slip(), 0.0],
        };
        let below = self.rows.first_below(home, time).1;
        let above = self.rows.first_above(home, time).1;
        for (row, corner) in [below, -width[0], above].into_iter().enumerate() {
            for column in 0..4 {
                sliding.x[4 * row + column] = position[0] - (corner + column as f64 * width[0]);
            }
        }
        sliding
    }

    /// Returns the line of centres of two touching disks in sliding rows, from `other` to `one`
    /// \[length\], and the velocity of the first's row less that of the second's.
    #[inline(always)]
    pub(crate) fn sheared_line(
        &self,
        one: &DiskRecord,
        other: &DiskRecord,
        distance: f64,
    ) -> (Vector2<f64>, f64) {
        let apart = one.position - other.position;
        let (line, slip) = if self.cells.narrow() || self.cells.counts()[1] < 3 {
            let relative = one.velocity - other.velocity;
            let between = self.rows.corner_offsets(one.home, other.home, one.clock);
            let images = between.flat_map(|(shift, slip)| {
                let relative = relative + vector![slip, 0.0];
                self.cells
                    .images_along(apart + Vector2::from(shift))
                    .map(move |line| (line, relative, slip))
            });
            let (line, _, slip) = cells::approached(images, distance);
            (line, slip)
        } else {
            let (shift, slip) = self.rows.nearest_between(one.home, other.home, one.clock);
            let line = apart + Vector2::from(shift);
            (self.cells.nearest_along(line), slip)
        };
        debug_assert!(
            (line.norm() - distance).abs() <= 1e-6 * distance + 2e-9,
            "disks collide at a distance of {}, not {distance}",
            line.norm()
        );
        (line, slip)
    }
}
