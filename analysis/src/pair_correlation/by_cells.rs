//! Pair counting by cell lists: pairs of points in range, by distance.
//!
//! The box is cut into cells that hold a few points each, and points are sorted by cell. Each
//! centre is compared with the points of the cells that may hold some in range; where all points
//! are centres, each pair of cells once (R. W. Hockney & J. W. Eastwood, *Computer Simulation Using
//! Particles*, chapter 8). Cells of a line along the first axis lie side by side in memory, so that
//! distances are computed several at once. The cost is O(N) at fixed range and density, rising to
//! all N (N - 1) / 2 pairs as the range nears half the box; trees pay only for inhomogeneity far
//! beyond what clusters of hard disks reach.

use std::ops::Range;

use nalgebra::SVector;
use stosszahl_model::{Interrupt, images};

use crate::Error;

/// Relative margin of the range in the choice of neighbouring cells. It covers the rounding errors
/// of positions in cells.
const CELL_MARGIN: f64 = 1e-9;

/// Smallest mean number of points in a cell.
const LEAST_IN_CELL: f64 = 2.0;
/// Largest number of cells along the range.
const CELLS_IN_RANGE: f64 = 8.0;

/// Number of pair distances computed in one block, for SIMD.
const TOGETHER: usize = 64;

/// Histogram of pairs by the distance to the nearest periodic image.
pub(super) struct Histogram<const D: usize> {
    lengths: [f64; D],
    range: f64,
    bins_per_length: f64,
    /// Number of neighbours of all centres, by bin; a pair of centres counts twice. The last entry
    /// counts pairs beyond the range.
    neighbours: Vec<u64>,
}

impl<const D: usize> Histogram<D> {
    pub(super) fn new(lengths: [f64; D], range: f64, bins: usize) -> Self {
        Self {
            lengths,
            range,
            bins_per_length: bins as f64 / range,
            neighbours: vec![0; bins + 1],
        }
    }

    /// Returns the number of neighbours in each bin, without those beyond the range.
    pub(super) fn bins(&self) -> &[u64] {
        &self.neighbours[..self.neighbours.len() - 1]
    }

    /// Counts the pairs of point `one` with the points `run`, each `count` times. The distance has
    /// the same bits from either point: rounding is symmetric in sign.
    #[inline(always)]
    fn add(&mut self, points: &ByCell<D>, one: usize, run: Range<usize>, count: u64) {
        let (beyond, squared_range) = ((self.neighbours.len() - 1) as f64, self.range * self.range);
        for from in run.clone().step_by(TOGETHER) {
            let to = run.end.min(from + TOGETHER);
            let mut squares = [0.0; TOGETHER];
            let squares = &mut squares[..to - from];
            for axis in 0..D {
                let (length, half) = (self.lengths[axis], 0.5 * self.lengths[axis]);
                let here = points.places[axis][one];
                for (square, there) in squares.iter_mut().zip(&points.places[axis][from..to]) {
                    let apart = here - there;
                    let nearest = images::nearest_inside(apart, length, half);
                    *square += nearest * nearest;
                }
            }
            let mut bins = [0; TOGETHER];
            let bins = &mut bins[..to - from];
            for (bin, &square) in bins.iter_mut().zip(&*squares) {
                // Rounding may take a distance just below the range into a bin beyond the last.
                let within = (square.sqrt() * self.bins_per_length).min(beyond - 1.0);
                let place = if square < squared_range {
                    within
                } else {
                    beyond
                };
                #[allow(
                    unsafe_code,
                    reason = "a cast that saturates is not done several at once"
                )]
                // SAFETY: it is from 0 to the number of bins, which is an i32, and never NaN: `min`
                // passes over that, and no comparison with it holds.
                let number = unsafe { place.to_int_unchecked::<i32>() };
                *bin = number;
            }
            for &bin in &*bins {
                self.neighbours[bin as usize] += count;
            }
        }
    }
}

/// Points sorted by cell, the first axis running fastest.
struct ByCell<const D: usize> {
    /// Number of cells along each axis.
    sides: [usize; 3],
    /// Index of the first point of each cell; a last entry holds the number of points.
    starts: Vec<usize>,
    /// Coordinates of the points, one array for each axis, within the box or at its upper edge
    /// \[length\].
    places: [Vec<f64>; D],
    /// True for points that are centres, whose neighbours are counted.
    is_centre: Vec<bool>,
}

impl<const D: usize> ByCell<D> {
    fn new(points: &[(SVector<f64, D>, bool)], lengths: [f64; D], range: f64) -> Self {
        let sides = sides(points.len(), lengths, range);
        let cell_of = |place: &SVector<f64, D>| {
            (0..D).rev().fold(0, |cell, axis| {
                let at = images::wrapped_or_edge(place[axis], lengths[axis]) / lengths[axis]
                    * sides[axis] as f64;
                // The last cell for positions at the far edge, which is the near one.
                cell * sides[axis] + at as usize % sides[axis]
            })
        };
        let cells: Vec<usize> = points.iter().map(|(place, _)| cell_of(place)).collect();
        // Counting sort.
        let mut starts = vec![0; sides.iter().product::<usize>() + 1];
        for cell in &cells {
            starts[cell + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        let mut places = [const { Vec::new() }; D].map(|_: Vec<f64>| vec![0.0; points.len()]);
        let mut are_centres = vec![false; points.len()];
        for (&cell, &(place, is_centre)) in cells.iter().zip(points) {
            let next = &mut next[cell];
            for axis in 0..D {
                places[axis][*next] = images::wrapped_or_edge(place[axis], lengths[axis]);
            }
            are_centres[*next] = is_centre;
            *next += 1;
        }
        Self {
            sides,
            starts,
            places,
            is_centre: are_centres,
        }
    }

    /// Returns the index range of the points in consecutive cells of one line of cells.
    fn index_range(&self, line: usize, cells: Range<usize>) -> Range<usize> {
        let begin = line * self.sides[0];
        self.starts[begin + cells.start]..self.starts[begin + cells.end]
    }
}

/// Chooses the number of cells along each axis for `points` points in a box, from their density and
/// the range.
pub(super) fn sides<const D: usize>(points: usize, lengths: [f64; D], range: f64) -> [usize; 3] {
    let points = points.max(1) as f64;
    let spacing = (lengths.iter().product::<f64>() * LEAST_IN_CELL / points).powf(1.0 / D as f64);
    let mut width = spacing.max(range / CELLS_IN_RANGE).max(f64::MIN_POSITIVE);
    loop {
        let sides = [0, 1, 2].map(|axis| {
            lengths
                .get(axis)
                .map_or(1.0, |length| (length / width).max(1.0))
        });
        // A box that is narrower than a cell has more of them than its area says.
        if sides.iter().product::<f64>() <= points.max(8.0) {
            return sides.map(|side| side as usize);
        }
        width *= 2.0;
    }
}

/// Line of cells that may hold neighbours of another line: its offset in rows and layers, and the
/// number of cells on each side in range.
struct Near {
    steps: [usize; 2],
    reach: usize,
}

/// Lists the lines of cells that may hold neighbours of a line, for given cell widths \[length\]
/// and range \[length\].
fn lines_around(sides: [usize; 3], widths: [f64; 3], range: f64) -> Vec<Near> {
    let range = range * (1.0 + CELL_MARGIN);
    // Between points of cells that are so many apart, at least.
    let gap = |axis: usize, apart: usize| apart.saturating_sub(1) as f64 * widths[axis];
    let around = |step: usize, side: usize| step.min(side - step);
    let steps = (0..sides[2]).flat_map(|layer| (0..sides[1]).map(move |row| [row, layer]));
    let near = steps.filter_map(|steps| {
        let gaps = [0, 1].map(|one| gap(one + 1, around(steps[one], sides[one + 1])));
        let left = range * range - gaps[0] * gaps[0] - gaps[1] * gaps[1];
        let reach = (left.max(0.0).sqrt() / widths[0]) as usize + 1;
        (left >= 0.0).then_some(Near { steps, reach })
    });
    near.collect()
}

/// Adds the neighbours of all centres in range to the histogram, cell by cell. The result has the
/// same bits on every processor: no fused multiply-add is used.
pub(super) fn count_by_cells<const D: usize>(
    points: &[(SVector<f64, D>, bool)],
    histogram: &mut Histogram<D>,
    interrupt: &Interrupt,
) -> Result<(), Error> {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[allow(unsafe_code, reason = "the compiler does not see the question before")]
        // SAFETY: the processor has these instructions, as was tested.
        return unsafe { count_with_avx2(points, histogram, interrupt) };
    }
    count(points, histogram, interrupt)
}

/// Runs [`count`] compiled for AVX2, four numbers at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn count_with_avx2<const D: usize>(
    points: &[(SVector<f64, D>, bool)],
    histogram: &mut Histogram<D>,
    interrupt: &Interrupt,
) -> Result<(), Error> {
    count(points, histogram, interrupt)
}

/// Counts neighbours as [`count_by_cells`]; the common code of the versions for AVX2 and for any
/// processor.
#[inline(always)]
fn count<const D: usize>(
    points: &[(SVector<f64, D>, bool)],
    histogram: &mut Histogram<D>,
    interrupt: &Interrupt,
) -> Result<(), Error> {
    let points = ByCell::new(points, histogram.lengths, histogram.range);
    let sides = points.sides;
    let [columns, rows, layers] = sides;
    let mut widths = [1.0; 3];
    for axis in 0..D {
        widths[axis] = histogram.lengths[axis] / sides[axis] as f64;
    }
    let near = lines_around(sides, widths, histogram.range);
    // Each pair of centres is then met once.
    let are_all = points.is_centre.iter().all(|&is_centre| is_centre);
    let mut runs = Vec::new();
    for line in 0..rows * layers {
        for column in 0..columns {
            let members = points.index_range(line, column..column + 1);
            if !points.is_centre[members.clone()].contains(&true) {
                continue;
            }
            runs.clear();
            for Near { steps, reach } in &near {
                let row = (line % rows + steps[0]) % rows;
                let there = row + rows * ((line / rows + steps[1]) % layers);
                if are_all && there < line {
                    continue;
                }
                let is_own = are_all && there == line;
                let first = if is_own { column + 1 } else { 0 };
                for cells in cells_within(column, *reach, columns) {
                    let begin = cells.start.max(first);
                    if begin < cells.end {
                        runs.push(points.index_range(there, begin..cells.end));
                    }
                }
            }
            for one in members.clone().filter(|&one| points.is_centre[one]) {
                if interrupt.is_raised() {
                    return Err(Error::Interrupted);
                }
                if are_all {
                    histogram.add(&points, one, one + 1..members.end, 2);
                    for run in &runs {
                        histogram.add(&points, one, run.clone(), 2);
                    }
                    continue;
                }
                for run in &runs {
                    let (mut before, mut after) = (run.clone(), 0..0);
                    if run.contains(&one) {
                        (before, after) = (run.start..one, one + 1..run.end);
                    }
                    histogram.add(&points, one, before, 1);
                    histogram.add(&points, one, after, 1);
                }
            }
        }
    }
    Ok(())
}

/// Returns the columns within `reach` columns of `column`, periodic in `columns`: at most two
/// ranges.
fn cells_within(column: usize, reach: usize, columns: usize) -> [Range<usize>; 2] {
    let (low, high) = (column + columns - reach.min(columns), column + reach + 1);
    if 2 * reach + 1 >= columns {
        [0..columns, 0..0]
    } else if low < columns {
        [0..high, low..columns]
    } else if high > columns {
        [low - columns..columns, 0..high - columns]
    } else {
        [low - columns..high, 0..0]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Both implementations count the same, as far as the processor has both.
    #[test]
    fn both_ways_count_the_same() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut place = || vector![30.0 * stream.random::<f64>(), 20.0 * stream.random::<f64>()];
        let points: Vec<_> = (0..3000).map(|_| (place(), true)).collect();
        let of = |counts: fn(&[_], &mut Histogram<2>, &Interrupt) -> Result<(), Error>| {
            let mut histogram = Histogram::new([30.0, 20.0], 6.0, 120);
            counts(&points, &mut histogram, &Interrupt::default()).expect("counts");
            histogram.neighbours
        };
        let either = of(count_by_cells);
        assert!(either[..120].iter().sum::<u64>() > 100_000);
        assert_eq!(either, of(count));
    }
}
