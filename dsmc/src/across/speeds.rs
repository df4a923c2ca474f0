//! How fast partners can be: the bound of trials.
//!
//! A hot simulator anywhere raises the bound of all that may meet it, and in a gas of clusters that is most of the cost. So
//! the bound is a local one. Each tile is cut into blocks that are as wide as partners can be away, and each block knows its
//! mean velocity and the largest speed against it; partners of its simulators are in the block and in those next to it. So
//! each velocity is looked at once a step, and a collision raises the bound of one block.

use stosszahl_model::{Physics, Space, Vector};

use super::shared::{Around, At};
use crate::grid::{Grid, Place};
use crate::simulator::{Follow, SimulatorOf};
use crate::tally::larger;

/// Speeds in the blocks of a tile.
pub(crate) struct Speeds<S: Space> {
    /// Blocks along each axis.
    counts: [u32; 3],
    bounds: Vec<Bound<S::Vector>>,
}

/// Speeds in a block.
#[derive(Clone, Copy)]
struct Bound<V> {
    /// Mean velocity.
    middle: V,
    /// Largest speed against it; below zero if there is nobody.
    spread: f64,
}

/// A block of cells of a tile.
#[derive(Clone, Copy)]
pub(super) struct Block {
    /// Which of the tile, along each axis.
    at: [u32; 3],
    /// Its first cell within the tile, and its sides.
    first: [u32; 3],
    sides: [u32; 3],
}

impl<S: Space> Default for Speeds<S> {
    fn default() -> Self {
        Self {
            counts: [0; 3],
            bounds: Vec::new(),
        }
    }
}

impl<S: Space> Speeds<S> {
    /// Looks at the simulators of a tile, which begin in its cells at `starts`.
    pub(super) fn look<P: Physics<Space = S>, F: Follow<S>>(
        &mut self,
        grid: &Grid<S>,
        place: &Place<S>,
        starts: &[u32],
        simulators: &[SimulatorOf<P, F>],
    ) {
        let width = grid.width();
        self.counts = [0, 1, 2].map(|axis| {
            if axis >= S::DIMENSION {
                return 1;
            }
            let reach = (grid.reach() / width[axis]).ceil().max(1.0) as u32;
            (place.sides[axis] / reach).max(1)
        });
        self.bounds.clear();
        for block in self.blocks(place) {
            let lines = || {
                block
                    .lines(place)
                    .map(|[begin, end]| &simulators[starts[begin] as usize..starts[end] as usize])
            };
            let (mut sum, mut count) = (S::Vector::default(), 0);
            for line in lines() {
                count += line.len();
                for member in line {
                    sum += member.velocity;
                }
            }
            let middle = sum * (1.0 / count.max(1) as f64);
            let mut square = -1.0;
            for line in lines() {
                for member in line {
                    square = larger(square, (member.velocity - middle).square());
                }
            }
            let spread = if count == 0 { -1.0 } else { square.sqrt() };
            self.bounds.push(Bound { middle, spread });
        }
    }

    /// The blocks of a tile.
    pub(super) fn blocks(&self, place: &Place<S>) -> impl Iterator<Item = Block> + use<S> {
        let (counts, all) = (self.counts, place.sides);
        let [columns, rows, layers] = counts;
        (0..columns * rows * layers).map(move |number| {
            let at = [
                number % columns,
                number / columns % rows,
                number / columns / rows,
            ];
            let begin = |axis: usize, at: u32| all[axis] * at / counts[axis];
            Block {
                at,
                first: [0, 1, 2].map(|axis| begin(axis, at[axis])),
                sides: [0, 1, 2].map(|axis| begin(axis, at[axis] + 1) - begin(axis, at[axis])),
            }
        })
    }

    fn number(&self, [x, y, z]: [u32; 3]) -> usize {
        (x + self.counts[0] * (y + self.counts[1] * z)) as usize
    }

    /// A simulator of a cell has another velocity from now on.
    pub(super) fn note(&mut self, place: &Place<S>, cell: [u32; 3], velocity: S::Vector) {
        // The inverse of where blocks begin.
        let at = [0, 1, 2].map(|axis| {
            let within = cell[axis] - place.first[axis];
            ((within + 1) * self.counts[axis] - 1) / place.sides[axis]
        });
        let number = self.number(at);
        let bound = &mut self.bounds[number];
        bound.spread = larger(bound.spread, (velocity - bound.middle).square().sqrt());
    }

    /// Memory \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        self.bounds.capacity() * size_of::<Bound<S::Vector>>()
    }
}

impl Block {
    /// Its lines of cells along the first axis: the numbers of their first cells in the tile, and of those after their last.
    pub(super) fn lines<S: Space>(self, place: &Place<S>) -> impl Iterator<Item = [usize; 2]> {
        let [columns, rows, _] = place.sides;
        let [x, y, z] = self.first;
        (0..self.sides[2]).flat_map(move |layer| {
            (0..self.sides[1]).map(move |row| {
                let begin = (x + columns * (y + row + rows * (z + layer))) as usize;
                [begin, begin + self.sides[0] as usize]
            })
        })
    }
}

/// A bound of the speeds of all that simulators of a block may meet, and of themselves.
#[derive(Clone, Copy)]
pub(super) struct Near<V> {
    /// The velocity that speeds are relative to.
    pub(super) middle: V,
    /// No simulator in reach is faster.
    pub(super) spread: f64,
}

impl<V: Vector> Near<V> {
    /// Of nobody.
    pub(super) fn nobody() -> Self {
        Self {
            middle: V::default(),
            spread: 0.0,
        }
    }

    /// Of a block of the tile in the middle, and those next to it.
    pub(super) fn new<P: Physics, F: Follow<P::Space>>(
        around: &Around<'_, '_, P, F>,
        block: Block,
    ) -> Self
    where
        P::Space: Space<Vector = V>,
    {
        let home = &around.tile(around.middle()).speeds;
        let middle = home.bounds[home.number(block.at)].middle;
        let mut near = Self {
            middle,
            spread: 0.0,
        };
        let steps = |axis: usize| {
            if axis < P::Space::DIMENSION {
                -1..=1
            } else {
                0..=0
            }
        };
        for z in steps(2) {
            for y in steps(1) {
                for x in steps(0) {
                    let mut step = [x, y, z];
                    let mut at = block.at;
                    for axis in 0..3 {
                        let next = block.at[axis].wrapping_add_signed(step[axis]);
                        if next < home.counts[axis] {
                            at[axis] = next;
                            step[axis] = 0;
                        }
                    }
                    let tile = &around.next(step).speeds;
                    for axis in 0..3 {
                        at[axis] = match step[axis] {
                            1 => 0,
                            -1 => tile.counts[axis] - 1,
                            _ => at[axis],
                        };
                    }
                    let bound = &tile.bounds[tile.number(at)];
                    if bound.spread >= 0.0 {
                        let apart = (bound.middle - middle).square().sqrt();
                        near.spread = larger(near.spread, apart + bound.spread);
                    }
                }
            }
        }
        near
    }

    /// A simulator in reach has another velocity from now on.
    pub(super) fn note(&mut self, velocity: V) {
        self.spread = larger(self.spread, (velocity - self.middle).square().sqrt());
    }
}

/// A simulator of one of the tiles at hand has another velocity from now on.
pub(super) fn note<P: Physics, F: Follow<P::Space>>(
    around: &mut Around<'_, '_, P, F>,
    at: At,
    cell: [u32; 3],
    velocity: stosszahl_model::VectorOf<P>,
) {
    let tile = around.tile_mut(at.tile);
    let place = tile.place;
    tile.speeds.note(&place, cell, velocity);
}
