//! Prediction of the next contacts of two disks that have just collided, for both at once, in rows
//! of cells that slide with a shear flow.

use std::ops::Range;

use stosszahl_model::{Field, Plane, Sizes};
use wide::f64x2;

use crate::cell_list_walk::CellListWalk;
use crate::disk::DiskSystem;
use crate::pair_prediction::PairFrames;

/// Number of rows in the block of cells around two disks in adjacent rows.
const ROWS: usize = 4;
/// Number of column positions for which cells are numbered in each row around a pair.
const COLUMNS: usize = 8;

/// Least numbers of columns and rows of the box for the joint prediction of a pair: the cells
/// around both are then all different.
const LEAST: [u16; 2] = [8, 5];

/// Reference frames of the cells around two disks in sliding rows: position of each disk relative
/// to the corners of columns and of rows \[length\], and velocity of its own row less that of each
/// row.
struct SlidingPair {
    x: [[f64; 2]; ROWS * COLUMNS],
    y: [[f64; 2]; ROWS],
    slip: [[f64; 2]; ROWS],
}

impl PairFrames for SlidingPair {
    #[inline(always)]
    fn corners(&self, cell: usize) -> [f64x2; 2] {
        let x = self.x[cell % (ROWS * COLUMNS)];
        [f64x2::new(x), f64x2::new(self.y[cell / COLUMNS % ROWS])]
    }

    #[inline(always)]
    fn along(&self, cell: usize, difference: f64x2) -> f64x2 {
        difference + f64x2::new(self.slip[cell / COLUMNS % ROWS])
    }
}

impl<F: Field<Plane>> DiskSystem<F> {
    /// Predicts the next contacts of two disks that have just collided, in rows that slide with a
    /// shear flow. Returns the number of candidates tested, or `None` if the disks must be
    /// predicted separately.
    #[inline(always)]
    pub(crate) fn predict_sliding_pair<S: Sizes>(
        &mut self,
        first: u32,
        second: u32,
        sizes: &S,
        tags: &[S::Tag],
    ) -> Option<u64> {
        let [columns, rows] = self.cells.counts();
        if columns < LEAST[0] || rows < LEAST[1] {
            return None;
        }
        let pair = [first, second];
        let homes = pair.map(|disk| self.home(disk));
        let mut step = i32::from(homes[1][1]) - i32::from(homes[0][1]);
        if step.abs() > 1 {
            step -= step.signum() * i32::from(rows);
        }
        if step.abs() > 1 {
            return None;
        }
        // The row before its own, among those around both.
        let begin = [usize::from(step < 0), usize::from(step > 0)];
        let (width, slip) = (self.cells.width(), self.rows.slip());
        let mut frames = SlidingPair {
            x: [[f64::NAN; 2]; ROWS * COLUMNS],
            y: [[f64::NAN; 2]; ROWS],
            slip: [[0.0; 2]; ROWS],
        };
        // First column, number of columns, and where the corner of the first is; for each row and
        // disk.
        let mut spans = [[(0, 0, 0.0); 2]; ROWS];
        for of in 0..2 {
            let disk = &self.all[pair[of] as usize];
            let (below, corner_below) = self.rows.first_below(disk.home, disk.clock);
            let (above, corner_above) = self.rows.first_above(disk.home, disk.clock);
            let own = i32::from(disk.home[0]) - 1;
            let three = [
                (below, 4, corner_below),
                (own, 3, -width[0]),
                (above, 4, corner_above),
            ];
            for (row, span) in three.into_iter().enumerate() {
                let up = row as f64 - 1.0;
                spans[begin[of] + row][of] = span;
                frames.y[begin[of] + row][of] = disk.position[1] - up * width[1];
                frames.slip[begin[of] + row][of] = -up * slip;
            }
        }
        // A column, and those from it on in which cells are around one of the two.
        let mut cells = [(0, 0, 0); ROWS];
        let mut shared = 0_u32;
        for (row, spans) in spans.iter().enumerate() {
            let [(one, count, _), (other, others, _)] = *spans;
            let ranges = column_ranges([(one, count), (other, others)], i32::from(columns));
            let start = ranges[0].start.min(ranges[1].start);
            let end = ranges[0].end.max(ranges[1].end);
            if end - start > COLUMNS as i32 {
                return None;
            }
            for of in 0..2 {
                let place = self.all[pair[of] as usize].position[0];
                for column in ranges[of].clone() {
                    let step = f64::from(column - ranges[of].start);
                    let cell = COLUMNS * row + (column - start) as usize;
                    frames.x[cell][of] = place - (spans[of].2 + step * width[0]);
                    if of == 1 && ranges[0].contains(&column) {
                        shared |= 1 << cell;
                    }
                }
            }
            let base = if count > 0 { one } else { other };
            cells[row] = (base, start, end);
        }
        let hidden = pair.map(|disk| self.hide(disk));
        let mut lists = CellListWalk::<{ ROWS * COLUMNS }>::new();
        let lowest = if step < 0 { homes[1] } else { homes[0] };
        let (_, around) = self.cells.cells_around(lowest);
        let highest = if step > 0 { homes[1] } else { homes[0] };
        let (_, around_highest) = self.cells.cells_around(highest);
        let places = [around[0], around[1], around[2], around_highest[2]];
        for (row, (base, start, end)) in cells.into_iter().enumerate() {
            for (number, column) in (start..end).enumerate() {
                let right = self.cells.column_around(base + column);
                let first = self.cells.first((right + places[row]) as usize);
                lists.open(first, COLUMNS * row + number, true);
            }
        }
        for (place, first) in hidden.into_iter().rev() {
            self.cells.set_first(place, first);
        }
        self.earliest_of_pair(lists, &frames, shared, pair, sizes, tags)
    }
}

/// Returns the column ranges of two spans, each given by first column and length, counted from the
/// begin of the first span that is not empty. `columns` is the number of columns in the periodic
/// box.
#[inline(always)]
fn column_ranges(
    [(one, count), (other, others)]: [(i32, i32); 2],
    columns: i32,
) -> [Range<i32>; 2] {
    if count == 0 || others == 0 {
        return [0..count, 0..others];
    }
    let apart = other - one;
    let around = if 2 * apart.abs() > columns {
        apart.signum() * columns
    } else {
        0
    };
    [0..count, apart - around..apart - around + others]
}
