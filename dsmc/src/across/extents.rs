//! How fast partners can be: the bound of trials.
//!
//! A hot simulator anywhere raises the bound of all that may meet it, and in a gas of clusters that is most of the cost. So
//! bounds are local, and they know directions: each cell has the box that holds the velocities in it, and a partner of
//! velocity u is met along k no faster than the corner of a box of its neighbourhood that is farthest against k.

use stosszahl_model::{Physics, Space};

use super::shared::Around;
use crate::grid::Grid;
use crate::simulator::Follow;
use crate::tally::{larger, smaller};

/// The smallest box that holds some velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent<S: Space> {
    low: S::Vector,
    high: S::Vector,
}

impl<S: Space> Extent<S> {
    /// Of nobody.
    #[inline]
    pub(crate) fn nobody() -> Self {
        Self {
            low: S::vector(|_| f64::MAX),
            high: S::vector(|_| f64::MIN),
        }
    }

    /// Takes a velocity in.
    #[inline(always)]
    pub(crate) fn note(&mut self, velocity: S::Vector) {
        self.join(&Self {
            low: velocity,
            high: velocity,
        });
    }

    #[inline(always)]
    fn join(&mut self, other: &Self) {
        let (low, high) = (self.low, self.high);
        self.low = S::vector(|axis| smaller(low[axis], other.low[axis]));
        self.high = S::vector(|axis| larger(high[axis], other.high[axis]));
    }

    /// The largest size of each component.
    #[inline(always)]
    pub(super) fn fastest(&self) -> S::Vector {
        let is_empty = self.low[0] > self.high[0];
        S::vector(|axis| {
            let fastest = larger(self.high[axis], -self.low[axis]);
            if is_empty { 0.0 } else { fastest }
        })
    }

    /// Its sides; zero if there is nobody.
    pub(super) fn sides(&self) -> S::Vector {
        S::vector(|axis| larger(self.high[axis] - self.low[axis], 0.0))
    }

    /// How fast a simulator of the box can come along `-k`, at most: the largest `-u . k`.
    #[inline(always)]
    pub(super) fn against(&self, k: S::Vector) -> f64 {
        (0..S::DIMENSION)
            .map(|axis| larger(-self.low[axis] * k[axis], -self.high[axis] * k[axis]))
            .sum()
    }

    /// Whether it holds one velocity, or none.
    fn is_a_point(&self) -> bool {
        (0..S::DIMENSION).all(|axis| self.low[axis] >= self.high[axis])
    }
}

/// How far from a simulator its partners are sought, in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ranges {
    /// The cell of the point around which they are sought.
    pub(super) point: usize,
    /// Cells around that one, where there are others than the simulator itself.
    pub(super) near: usize,
    /// Cells around it, where nobody is nearer.
    pub(super) far: usize,
    /// As many more in both cases, where particles differ in size.
    pub(super) shift: usize,
}

/// Velocities around each cell where a simulator of a tile may look for partners.
pub(super) struct Extents<S: Space> {
    ranges: Ranges,
    /// The first cell, which may be beyond an edge of the box, and the number along each axis.
    first: [i64; 3],
    sides: [usize; 3],
    /// Cells along each axis of the whole box.
    counts: [i64; 3],
    /// Velocities in the cell and the near ones; if partners may be beyond them, also in the far ones.
    around: Vec<Extent<S>>,
    /// Whether partners may be beyond the near cells.
    lonely: Vec<bool>,
}

impl<S: Space> Extents<S> {
    /// Where nobody asks.
    pub(super) fn unknown() -> Self {
        Self {
            ranges: Ranges::default(),
            first: [0; 3],
            sides: [0; 3],
            counts: [1; 3],
            around: Vec::new(),
            lonely: Vec::new(),
        }
    }

    /// Around the tile in the middle.
    pub(super) fn new<P: Physics<Space = S>, F: Follow<S>>(
        tiles: &Around<'_, '_, P, F>,
        grid: &Grid<S>,
        ranges: Ranges,
    ) -> Self {
        let place = &tiles.tile(tiles.middle()).place;
        let margin = [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                ranges.point + ranges.shift + ranges.far.max(ranges.near)
            } else {
                0
            }
        });
        let counts = grid.counts().map(i64::from);
        let first = [0, 1, 2].map(|axis| i64::from(place.first[axis]) - margin[axis] as i64);
        let sides = [0, 1, 2].map(|axis| place.sides[axis] as usize + 2 * margin[axis]);
        let mut own = Vec::with_capacity(sides.iter().product());
        for z in 0..sides[2] {
            for y in 0..sides[1] {
                let mut x = 0;
                while x < sides[0] {
                    let at = [x, y, z];
                    let cell = [0, 1, 2].map(|axis| {
                        (first[axis] + at[axis] as i64).rem_euclid(counts[axis]) as u32
                    });
                    let Some((slot, local)) = tiles.find(cell) else {
                        own.push(Extent::nobody());
                        x += 1;
                        continue;
                    };
                    let tile = tiles.tile(slot);
                    let left = (tile.place.first[0] + tile.place.sides[0] - cell[0]) as usize;
                    let length = left.min(sides[0] - x);
                    own.extend_from_slice(&tile.extents[local..local + length]);
                    x += length;
                }
            }
        }
        let strides = [1, sides[0], sides[0] * sides[1]];
        // Axis after axis. At the edges of what is here, cells of other lines come in: no bound is too low for that.
        let near = ranges.near + ranges.shift;
        let mut around = own.clone();
        let mut source = Vec::new();
        for stride in &strides[..S::DIMENSION * usize::from(near > 0)] {
            source.clone_from(&around);
            let edge = near * stride;
            let all = source.len();
            for step in (0..=2 * near).filter(|step| *step != near) {
                let begin = step * stride;
                let others = &source[begin..begin + all - 2 * edge];
                for (one, other) in around[edge..all - edge].iter_mut().zip(others) {
                    one.join(other);
                }
            }
        }
        let mut extents = Self {
            ranges,
            first,
            sides,
            counts,
            lonely: vec![false; own.len()],
            around,
        };
        if ranges.far > ranges.near {
            extents.look_far(&own, margin);
        }
        extents
    }

    pub(super) fn ranges(&self) -> Ranges {
        self.ranges
    }

    /// Where nobody is near, the far ones count as well.
    fn look_far(&mut self, own: &[Extent<S>], margin: [usize; 3]) {
        let far = [0, 1, 2].map(|axis| margin[axis].min(self.ranges.far + self.ranges.shift));
        let inner = |axis: usize| far[axis]..self.sides[axis] - far[axis];
        let number = |x, y, z| x + self.sides[0] * (y + self.sides[1] * z);
        for z in inner(2) {
            for y in inner(1) {
                for x in inner(0) {
                    let here = number(x, y, z);
                    if !self.around[here].is_a_point() {
                        continue;
                    }
                    self.lonely[here] = true;
                    for z in z - far[2]..=z + far[2] {
                        for y in y - far[1]..=y + far[1] {
                            for one in &own[number(x - far[0], y, z)..=number(x + far[0], y, z)] {
                                self.around[here].join(one);
                            }
                        }
                    }
                }
            }
        }
    }

    #[inline]
    fn number(&self, cell: [i64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| (cell[axis] - self.first[axis]) as usize);
        x + self.sides[0] * (y + self.sides[1] * z)
    }

    /// Bounds of partners sought around a point in a cell, which may be beyond an edge of the box; none if none is known.
    #[inline]
    pub(super) fn at(&self, cell: [i64; 3]) -> Option<&Extent<S>> {
        let number = self.number(cell);
        (!self.lonely[number]).then(|| &self.around[number])
    }

    /// Velocities of all that simulators of a line of cells of the tile can meet.
    pub(super) fn along(&self, first: [u32; 3], length: usize) -> Extent<S> {
        let margin = [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                self.ranges.point as i64
            } else {
                0
            }
        });
        let [x, y, z] = first.map(i64::from);
        let mut all = Extent::nobody();
        for layer in z - margin[2]..=z + margin[2] {
            for row in y - margin[1]..=y + margin[1] {
                let begin = self.number([x - margin[0], row, layer]);
                for one in &self.around[begin..begin + length + 2 * self.ranges.point] {
                    all.join(one);
                }
            }
        }
        all
    }

    /// A simulator of a cell has another velocity from now on.
    #[inline]
    pub(super) fn note(&mut self, cell: [u32; 3], velocity: S::Vector) {
        let near = self.near();
        // The images of the cell around the box that are here: one, or several in a narrow box.
        let images = [0, 1, 2].map(|axis| {
            let (near, count) = (near[axis], self.counts[axis]);
            let mut at = i64::from(cell[axis]) - self.first[axis];
            while at + near < 0 {
                at += count;
            }
            while at - count >= -near {
                at -= count;
            }
            (at..self.sides[axis] as i64 + near).step_by(count as usize)
        });
        let [columns, rows, layers] = images;
        for z in layers {
            for y in rows.clone() {
                for x in columns.clone() {
                    self.note_at([x, y, z], velocity);
                }
            }
        }
    }

    /// Cells along each axis that see one.
    #[inline]
    fn near(&self) -> [i64; 3] {
        let near = (self.ranges.near + self.ranges.shift) as i64;
        [0, 1, 2].map(|axis| if axis < S::DIMENSION { near } else { 0 })
    }

    #[inline]
    fn note_at(&mut self, at: [i64; 3], velocity: S::Vector) {
        let near = self.near();
        let [columns, rows, layers] = [0, 1, 2].map(|axis| {
            let near = near[axis];
            let end = (at[axis] + near + 1).clamp(0, self.sides[axis] as i64);
            (at[axis] - near).clamp(0, end) as usize..end as usize
        });
        for z in layers {
            for y in rows.clone() {
                let begin = self.sides[0] * (y + self.sides[1] * z);
                for one in &mut self.around[begin + columns.start..begin + columns.end] {
                    one.note(velocity);
                }
            }
        }
    }
}
