//! How fast partners can be: the bound of trials.
//!
//! A hot simulator anywhere raises the bound of all that may meet it, and in a gas of clusters that is most of the cost. So
//! the bound of a cell is taken over no more than the cells that its partners can be in, follows every collision, and is one
//! of speeds relative to the flow of a patch of few cells.

use stosszahl_model::{Physics, Space, Vector};

use super::shared::Around;
use crate::grid::{Grid, Place};
use crate::simulator::Follow;
use crate::tally::{larger, smaller};

/// Cells of a patch along each axis, at most. The fewer, the less flow there is within it; the more, the less often the cells
/// around it are looked at.
const SIDE: u32 = 16;

/// A block of cells of a tile.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    first: [u32; 3],
    sides: [u32; 3],
}

impl Patch {
    /// Its cells, by their coordinates.
    pub(super) fn cells(self) -> impl Iterator<Item = [u32; 3]> {
        let [columns, rows, layers] = self.sides;
        (0..columns * rows * layers).map(move |number| {
            let within = [
                number % columns,
                number / columns % rows,
                number / columns / rows,
            ];
            [0, 1, 2].map(|axis| self.first[axis] + within[axis])
        })
    }
}

/// The patches of a tile.
pub(super) fn patches<S: Space>(place: &Place<S>) -> Vec<Patch> {
    let along = [0, 1, 2].map(|axis| {
        let (first, side) = (place.first[axis], place.sides[axis]);
        let count = side.div_ceil(SIDE);
        let begin = move |number: u32| first + side * number / count;
        (0..count).map(move |number| [begin(number), begin(number + 1) - begin(number)])
    });
    let [columns, rows, layers] = along;
    let rows = layers.flat_map(|z| rows.clone().map(move |y| [y, z]));
    rows.flat_map(|[y, z]| {
        columns.clone().map(move |x| Patch {
            first: [x[0], y[0], z[0]],
            sides: [x[1], y[1], z[1]],
        })
    })
    .collect()
}

/// Largest speeds in and around the cells of a patch of a tile, relative to one velocity.
pub(super) struct Speeds<S: Space> {
    middle: S::Vector,
    counts: [u32; 3],
    first: [u32; 3],
    sides: [u32; 3],
    /// How many cells away partners can be, along each axis.
    reach: [u32; 3],
    /// Largest square of speed in each cell of the patch and of the margin that is as wide as the reach.
    squares: Vec<f64>,
    /// Largest speed in reach of each cell of the patch.
    spreads: Vec<f64>,
}

impl<S: Space> Speeds<S> {
    /// Of nobody, where bounds are not asked for.
    pub(super) fn unknown() -> Self {
        Self {
            middle: S::Vector::default(),
            counts: [1; 3],
            first: [0; 3],
            sides: [0; 3],
            reach: [0; 3],
            squares: Vec::new(),
            spreads: Vec::new(),
        }
    }

    /// Looks at the simulators in a patch of the tile in the middle, from its first cell on, and within its reach.
    pub(super) fn new<P: Physics<Space = S>, F: Follow<S>>(
        grid: &Grid<S>,
        around: &Around<'_, '_, P, F>,
        Patch { first, sides }: Patch,
    ) -> Self {
        let width = grid.width();
        let counts = grid.counts();
        let mut reach = [0; 3];
        for axis in 0..S::DIMENSION {
            // Half the way around the box is as far as it goes.
            let cells = (grid.reach() / width[axis]).ceil() as u32;
            reach[axis] = cells.min(counts[axis].div_ceil(2));
        }
        let mut speeds = Self {
            middle: S::Vector::default(),
            counts,
            first,
            sides,
            reach,
            squares: Vec::new(),
            spreads: Vec::new(),
        };
        speeds.choose_middle(around);
        speeds.look(around);
        speeds.widen();
        speeds
    }

    /// The middle of the range of velocities in the patch.
    fn choose_middle<P: Physics<Space = S>, F: Follow<S>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
    ) {
        let tile = around.tile(around.middle());
        let mut range: Option<[S::Vector; 2]> = None;
        for line in 0..self.sides[1] * self.sides[2] {
            let (y, z) = (line % self.sides[1], line / self.sides[1]);
            let cell = [self.first[0], self.first[1] + y, self.first[2] + z];
            let local = tile.number(cell);
            let cells = local..local + self.sides[0] as usize;
            for member in
                &tile.simulators[tile.starts[cells.start] as usize..tile.starts[cells.end] as usize]
            {
                let [low, high] = range.get_or_insert([member.velocity; 2]);
                for axis in 0..S::DIMENSION {
                    low[axis] = smaller(member.velocity[axis], low[axis]);
                    high[axis] = larger(member.velocity[axis], high[axis]);
                }
            }
        }
        if let Some([low, high]) = range {
            self.middle = (low + high) * 0.5;
        }
    }

    /// Finds the fastest of each cell of the patch with its margin.
    fn look<P: Physics<Space = S>, F: Follow<S>>(&mut self, around: &Around<'_, '_, P, F>) {
        let wide = self.wide();
        self.squares = vec![0.0; volume(wide)];
        for line in 0..wide[1] * wide[2] {
            let (y, z) = (line % wide[1], line / wide[1]);
            let mut x = 0;
            while x < wide[0] {
                let cell = self.cell([x, y, z]);
                let Some((tile, local)) = around.find(cell) else {
                    x += 1;
                    continue;
                };
                // As far as this row of cells goes in that tile.
                let tile = around.tile(tile);
                let left = tile.place.first[0] + tile.place.sides[0] - cell[0];
                let cells = left.min(wide[0] - x) as usize;
                let begin = (x + wide[0] * line) as usize;
                let ends = &tile.starts[local..=local + cells];
                for (square, ends) in self.squares[begin..].iter_mut().zip(ends.windows(2)) {
                    for member in &tile.simulators[ends[0] as usize..ends[1] as usize] {
                        let speed = member.velocity - self.middle;
                        *square = larger(*square, speed.square());
                    }
                }
                x += cells as u32;
            }
        }
    }

    /// From the fastest of each cell to the fastest in reach.
    fn widen(&mut self) {
        let wide = self.wide();
        let mut spreads = self.squares.clone();
        let mut stride = 1;
        // Along an axis beyond the dimension there is one cell, and no reach.
        for (reach, side) in self.reach.into_iter().zip(wide) {
            largest_of_windows(&mut spreads, stride, 2 * reach as usize + 1);
            stride *= side as usize;
        }
        for z in 0..self.sides[2] {
            for y in 0..self.sides[1] {
                let line = (wide[0] * (y + wide[1] * z)) as usize;
                let line = &spreads[line..line + self.sides[0] as usize];
                self.spreads.extend(line.iter().map(|square| square.sqrt()));
            }
        }
    }

    /// The velocity that speeds are relative to.
    #[inline]
    pub(super) fn middle(&self) -> S::Vector {
        self.middle
    }

    /// Square of the speed of a velocity.
    #[inline]
    pub(super) fn square(&self, velocity: S::Vector) -> f64 {
        (velocity - self.middle).square()
    }

    /// No simulator in reach of a cell of the patch is faster.
    #[inline]
    pub(super) fn spread(&self, cell: [u32; 3]) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] - self.first[axis]);
        self.spreads[(x + self.sides[0] * (y + self.sides[1] * z)) as usize]
    }

    /// A simulator in a cell within reach has another velocity from now on.
    pub(super) fn note(&mut self, cell: [u32; 3], velocity: S::Vector) {
        let square = self.square(velocity);
        let wide = self.wide();
        // Where it lies in the patch with its margin; in a small box in several places.
        let mut places = [[0; 3]; 3];
        for axis in 0..3 {
            let count = self.counts[axis];
            let place = (cell[axis] + count - self.edge(axis)) % count;
            places[axis] = [place, count, wide[axis]];
        }
        let along = |axis: usize| {
            let [place, count, wide] = places[axis];
            (place..wide).step_by(count as usize)
        };
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    let at = (x + wide[0] * (y + wide[1] * z)) as usize;
                    if square > self.squares[at] {
                        self.squares[at] = square;
                        self.raise([x, y, z], square.sqrt());
                    }
                }
            }
        }
    }

    /// Raises the bounds of all cells of the patch that reach a cell of the patch with its margin.
    fn raise(&mut self, place: [u32; 3], speed: f64) {
        let range = |axis: usize| {
            let last = place[axis].min(self.sides[axis] - 1);
            place[axis].saturating_sub(2 * self.reach[axis])..=last
        };
        let [columns, rows, layers] = [range(0), range(1), range(2)];
        for z in layers {
            for y in rows.clone() {
                let line = self.sides[0] * (y + self.sides[1] * z);
                let (begin, end) = (line + columns.start(), line + columns.end());
                for spread in &mut self.spreads[begin as usize..=end as usize] {
                    *spread = spread.max(speed);
                }
            }
        }
    }

    /// Cells along each axis with the margin.
    fn wide(&self) -> [u32; 3] {
        [0, 1, 2].map(|axis| self.sides[axis] + 2 * self.reach[axis])
    }

    /// Where the margin begins in the box.
    fn edge(&self, axis: usize) -> u32 {
        let count = self.counts[axis];
        (self.first[axis] + count - self.reach[axis] % count) % count
    }

    /// The cell of the box at a place in the patch with its margin.
    fn cell(&self, place: [u32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|axis| (self.edge(axis) + place[axis]) % self.counts[axis])
    }
}

fn volume(shape: [u32; 3]) -> usize {
    shape.iter().map(|&side| side as usize).product()
}

/// Makes each value the largest of a window that begins with it, of values `stride` apart. What a window would take from
/// beyond the end of its row is wrong, and not asked for.
fn largest_of_windows(values: &mut [f64], stride: usize, window: usize) {
    let mut covered = 1;
    while covered < window {
        let step = covered.min(window - covered);
        for at in 0..values.len().saturating_sub(step * stride) {
            values[at] = larger(values[at], values[at + step * stride]);
        }
        covered += step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all values of each window.
    #[test]
    fn largest_of_windows_of_any_width() {
        let values: Vec<f64> = (0..60).map(|n: u32| f64::from(n * 37 % 61)).collect();
        for (stride, window) in [(1, 1), (1, 2), (1, 7), (10, 3), (10, 6)] {
            let mut found = values.clone();
            largest_of_windows(&mut found, stride, window);
            for at in 0..60 - stride * (window - 1) {
                let all = (0..window).map(|step| values[at + step * stride]);
                assert_eq!(found[at], all.fold(0.0, f64::max));
            }
        }
    }
}
