//! The search for a partner around a point.

use rand::{Rng, RngExt};
use stosszahl_model::{Physics, Sizes, Space, Vector, VectorOf};

use super::extents::Ranges;
use super::shared::{Around, At};
use crate::grid::Grid;
use crate::simulator::{Follow, SimulatorOf};
use crate::tally::smaller;
use crate::tile::Tile;

/// Simulators that lie next to each other in one tile.
#[derive(Clone, Copy, Debug)]
struct Run {
    tile: u32,
    begin: u32,
    end: u32,
}

/// Draws before all simulators around are looked at one by one, and the number of them up to which none is drawn.
const DRAWS: u32 = 12;

/// Simulators around that are looked at once, for one within the radius and for the nearest: their numbers have six bits.
const FEW: u64 = 64;

/// Widest search for the nearest, in cells on each side.
pub(super) const WIDEST: i64 = 3;

/// Where a partner is sought: around the point at which one of the mean radius would be, and as much farther along the line
/// of centres as it is larger.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim<V> {
    pub(super) point: V,
    /// How much farther for each unit of the radius.
    pub(super) along: V,
}

/// Finds partners around a tile.
pub(super) struct Search<'a, P: Physics> {
    grid: &'a Grid<P::Space>,
    radius: f64,
    sizes: &'a P::Sizes,
    mean_radius: f64,
    /// How many cells on each side hold all within the radius, at least one, and how many more do where sizes differ.
    near: i64,
    shift: i64,
    /// Narrowest side of a cell, and cells for each unit of length along each axis.
    narrowest: f64,
    widths: VectorOf<P>,
    scale: VectorOf<P>,
    runs: Vec<Run>,
}

impl<'a, P: Physics> Search<'a, P> {
    /// `radius`: within which all simulators are equally likely.
    pub(super) fn new(
        grid: &'a Grid<P::Space>,
        radius: f64,
        sizes: &'a P::Sizes,
        mean_radius: f64,
        ranges: Ranges,
    ) -> Self {
        Self {
            grid,
            radius,
            sizes,
            mean_radius,
            near: ranges.near as i64,
            shift: ranges.shift as i64,
            narrowest: grid.narrowest(),
            widths: grid.width(),
            scale: P::Space::vector(|axis| 1.0 / grid.width()[axis]),
            runs: Vec::new(),
        }
    }

    /// A simulator other than `who` around its point of the aim, in the box or a little outside: any within the radius, all
    /// equally likely; if there is none, the nearest in the cells around; none if nobody is within a few cells.
    #[inline]
    pub(super) fn partner<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        stream: &mut impl Rng,
    ) -> Option<At> {
        // Nearly always: two cells along each axis, or three.
        if P::Sizes::UNIFORM && self.near == 1 {
            let home = around.home();
            let found = self.closest::<F, 2>(home, aim.point, who.index, stream);
            let found = found.or_else(|| self.closest::<F, 3>(home, aim.point, who.index, stream));
            if let Some(index) = found {
                return Some(At {
                    tile: around.middle(),
                    index,
                });
            }
        }
        self.partner_around(around, aim, who, stream)
    }

    /// The same among equal ones in the few cells along each axis that are nearest to the point, if these are in the tile and
    /// show who it is.
    #[inline]
    fn closest<F: Follow<P::Space>, const CELLS: u64>(
        &self,
        home: &Tile<P, F>,
        point: VectorOf<P>,
        own: u32,
        stream: &mut impl Rng,
    ) -> Option<u32> {
        let place = &home.place;
        let mut low = [0; 3];
        let mut reach = f64::MAX;
        for (axis, low) in low.iter_mut().enumerate().take(P::Space::DIMENSION) {
            let at = point[axis] * self.scale[axis];
            let first = floor(at - 0.5 * (CELLS - 1) as f64);
            let local = (first - i64::from(place.first[axis])) as u64;
            let most = u64::from(place.sides[axis]).checked_sub(CELLS)?;
            if local > most {
                return None;
            }
            *low = local as usize;
            if CELLS == 2 {
                let below = at - first as f64;
                reach = smaller(reach, smaller(below, 2.0 - below) * self.widths[axis]);
            }
        }
        if self.radius > reach {
            return None;
        }
        let [columns, rows, _] = place.sides.map(|side| side as usize);
        let first = low[0] + columns * (low[1] + rows * low[2]);
        let cells = CELLS as usize;
        let lines = if P::Space::DIMENSION == 2 {
            cells
        } else {
            cells * cells
        };
        let line = |number: usize| {
            let row = if P::Space::DIMENSION == 2 {
                number
            } else {
                number % cells + rows * (number / cells)
            };
            let cell = first + columns * row;
            let [begin, end] = [home.starts[cell], home.starts[cell + cells]];
            (begin, &home.simulators[begin as usize..end as usize])
        };
        let square = |simulator: &SimulatorOf<P, F>| (simulator.position - point).square();
        let limit = self.radius * self.radius;
        // Squares of distances and the numbers of simulators in one word each, so that the least is found without a branch:
        // squares are not negative, so that their bits have their order, and the last six are none that matter.
        let (mut best, mut near, mut number) = (u64::MAX, 0, 0_u64);
        for (begin, simulators) in (0..lines).map(line) {
            for (index, simulator) in (begin..).zip(simulators) {
                let square = square(simulator);
                let square = if index == own { f64::MAX } else { square };
                near += u32::from(square < limit);
                best = best.min((square.to_bits() & !(FEW - 1)) | number);
                number += 1;
            }
        }
        if number > FEW {
            return None;
        }
        // Itself is as far as a number can be; and if there is nobody at all, so is the word.
        let is_nobody = best >= f64::MAX.to_bits() & !(FEW - 1);
        let mut skip = if near > 1 {
            stream.random_range(0..near)
        } else if is_nobody || f64::from_bits(best) > reach * reach {
            return None;
        } else {
            // The one that is within the radius, or the nearest.
            let mut number = (best & (FEW - 1)) as u32;
            for (begin, simulators) in (0..lines).map(line) {
                let count = simulators.len() as u32;
                if number < count {
                    return Some(begin + number);
                }
                number -= count;
            }
            return None;
        };
        for (begin, simulators) in (0..lines).map(line) {
            for (index, simulator) in (begin..).zip(simulators) {
                if index != own && square(simulator) < limit {
                    if skip == 0 {
                        return Some(index);
                    }
                    skip -= 1;
                }
            }
        }
        None
    }

    #[inline(never)]
    fn partner_around<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        stream: &mut impl Rng,
    ) -> Option<At> {
        let aim = Aim {
            point: self.wrap(aim.point),
            ..aim
        };
        let total = self.gather(around, aim, self.near);
        if u64::from(total) <= FEW {
            let found = self.look(around, aim, who, stream);
            if found.is_some() {
                return found;
            }
        } else {
            if self.radius > 0.0
                && let Some(found) = self.draw(around, aim, who, total, stream)
            {
                return Some(found);
            }
            return self.nearest(around, aim, who, total, f64::INFINITY);
        }
        for cells in self.near + 1..=WIDEST {
            let total = self.gather(around, aim, cells);
            let reach = cells as f64 * self.narrowest;
            let found = self.nearest(around, aim, who, total, reach);
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// The cell of a point, which may be beyond an edge of the box.
    #[inline]
    pub(super) fn cell(&self, point: VectorOf<P>) -> [i64; 3] {
        let mut cell = [0; 3];
        for (axis, cell) in cell.iter_mut().enumerate().take(P::Space::DIMENSION) {
            *cell = floor(point[axis] * self.scale[axis]);
        }
        cell
    }

    /// A point in the box, or the same in it.
    #[inline]
    fn wrap(&self, point: VectorOf<P>) -> VectorOf<P> {
        let lengths = self.grid.domain().lengths();
        let inside = |axis: usize| point[axis] >= 0.0 && point[axis] < lengths[axis];
        if (0..P::Space::DIMENSION).all(inside) {
            point
        } else {
            self.grid.domain().wrap(point)
        }
    }

    /// Of what was gathered, any simulator within the radius, all equally likely; or else the nearest.
    fn look<F: Follow<P::Space>>(
        &self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        stream: &mut impl Rng,
    ) -> Option<At> {
        let limit = self.radius * self.radius;
        let (mut best, mut near) = ((f64::MAX, None), 0);
        for &Run { tile, begin, end } in &self.runs {
            let run = &around.tile(tile).simulators[begin as usize..end as usize];
            for (index, simulator) in (begin..).zip(run) {
                let at = At { tile, index };
                let square = self.distance_square::<F>(aim, simulator);
                let square = if at == who { f64::MAX } else { square };
                near += u32::from(square < limit);
                if square < best.0 {
                    best = (square, Some(at));
                }
            }
        }
        if near > 1 {
            return self.choose(around, aim, who, stream.random_range(0..near));
        }
        best.1
    }

    /// Of what was gathered, the simulator within the radius that comes after this number of others.
    fn choose<F: Follow<P::Space>>(
        &self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        mut skip: u32,
    ) -> Option<At> {
        let limit = self.radius * self.radius;
        for &Run { tile, begin, end } in &self.runs {
            let run = &around.tile(tile).simulators[begin as usize..end as usize];
            for (index, simulator) in (begin..).zip(run) {
                let at = At { tile, index };
                if at != who && self.distance_square::<F>(aim, simulator) < limit {
                    if skip == 0 {
                        return Some(at);
                    }
                    skip -= 1;
                }
            }
        }
        None
    }

    /// Any simulator within the radius, all equally likely.
    fn draw<F: Follow<P::Space>>(
        &self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        total: u32,
        stream: &mut impl Rng,
    ) -> Option<At> {
        let square = self.radius * self.radius;
        let is_near = |at: At| {
            let simulator = &around.tile(at.tile).simulators[at.index as usize];
            at != who && self.distance_square::<F>(aim, simulator) < square
        };
        let draws = if total > DRAWS { DRAWS } else { 0 };
        for _ in 0..draws {
            let at = self.nth(stream.random_range(0..total));
            if is_near(at) {
                return Some(at);
            }
        }
        // Few or none: one after the other replaces the one found before, so that all are equally likely.
        let (mut found, mut near) = (None, 0_u32);
        for number in 0..total {
            let at = self.nth(number);
            if is_near(at) {
                near += 1;
                if near == 1 || stream.random_range(0..near) == 0 {
                    found = Some(at);
                }
            }
        }
        found
    }

    /// Of what was gathered, the nearest to its point of the aim, if it is within reach.
    fn nearest<F: Follow<P::Space>>(
        &self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        total: u32,
        reach: f64,
    ) -> Option<At> {
        let mut best = (f64::MAX, None);
        for number in 0..total {
            let at = self.nth(number);
            let simulator = &around.tile(at.tile).simulators[at.index as usize];
            let square = self.distance_square::<F>(aim, simulator);
            if square < best.0 && at != who {
                best = (square, Some(at));
            }
        }
        best.1.filter(|_| best.0 <= reach * reach)
    }

    #[inline(always)]
    fn distance_square<F: Follow<P::Space>>(
        &self,
        aim: Aim<VectorOf<P>>,
        simulator: &SimulatorOf<P, F>,
    ) -> f64 {
        let position = simulator.position;
        let mut point = aim.point;
        if !P::Sizes::UNIFORM {
            point += aim.along * (self.sizes.radius(simulator.tag) - self.mean_radius);
        }
        let lengths = self.grid.images();
        let mut square = 0.0;
        for axis in 0..P::Space::DIMENSION {
            // Both are in the box, or the point a little outside: the nearer way around it.
            let apart = (position[axis] - point[axis]).abs();
            let apart = smaller(apart, (lengths[axis] - apart).abs());
            square += apart * apart;
        }
        square
    }

    /// The simulator with this number in the runs.
    #[inline]
    fn nth(&self, mut number: u32) -> At {
        for run in &self.runs {
            let length = run.end - run.begin;
            if number < length {
                return At {
                    tile: run.tile,
                    index: run.begin + number,
                };
            }
            number -= length;
        }
        // Not reached: the number is below the total length.
        At { tile: 0, index: 0 }
    }

    /// Gathers the runs of this many cells on each side of the point of an aim, and as many more as partners of other sizes
    /// need; returns how many simulators they hold.
    fn gather<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        cells: i64,
    ) -> u32 {
        let cells = cells + self.shift;
        let is_used = |axis: usize| i64::from(axis < P::Space::DIMENSION);
        let at = self.cell(aim.point);
        let first = [0, 1, 2].map(|axis| at[axis] - cells * is_used(axis));
        let span = [0, 1, 2].map(|axis| 1 + (2 * cells * is_used(axis)) as u32);
        self.collect(around, first, span)
    }

    /// Gathers the runs of a block of cells, from a first one on, around the box.
    #[inline]
    fn collect<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        first: [i64; 3],
        mut span: [u32; 3],
    ) -> u32 {
        self.runs.clear();
        let counts = self.grid.counts();
        let mut low = [0_u32; 3];
        for axis in 0..3 {
            let (first, count) = (first[axis], i64::from(counts[axis]));
            // Around a narrow box no cell is counted twice.
            span[axis] = span[axis].min(counts[axis]);
            low[axis] = if (0..count).contains(&first) {
                first
            } else {
                first.rem_euclid(count)
            } as u32;
        }
        let home = around.tile(around.middle());
        let place = &home.place;
        let is_home = (0..3).all(|axis| {
            low[axis] >= place.first[axis]
                && low[axis] + span[axis] <= place.first[axis] + place.sides[axis]
        });
        let mut total = 0;
        if is_home {
            // Nearly always: lines of cells of one tile.
            let [columns, rows, _] = place.sides;
            let first = home.number(low) as u32;
            for layer in 0..span[2] {
                for row in 0..span[1] {
                    let local = (first + columns * (row + rows * layer)) as usize;
                    let begin = home.starts[local];
                    let end = home.starts[local + span[0] as usize];
                    self.runs.push(Run {
                        tile: around.middle(),
                        begin,
                        end,
                    });
                    total += end - begin;
                }
            }
            return total;
        }
        let around_ring = |axis: usize, step: u32| {
            let at = low[axis] + step;
            if at >= counts[axis] {
                at - counts[axis]
            } else {
                at
            }
        };
        for layer in 0..span[2] {
            let z = around_ring(2, layer);
            for row in 0..span[1] {
                let y = around_ring(1, row);
                let mut done = 0;
                while done < span[0] {
                    let cell = [around_ring(0, done), y, z];
                    // Beyond the next tiles there is nobody to be found: tiles are wide enough.
                    let Some((slot, local)) = around.find(cell) else {
                        done += 1;
                        continue;
                    };
                    let tile = around.tile(slot);
                    // As far as the line goes on in this tile.
                    let left = tile.place.first[0] + tile.place.sides[0] - cell[0];
                    let length = left.min(span[0] - done);
                    let begin = tile.starts[local];
                    let end = tile.starts[local + length as usize];
                    if end > begin {
                        self.runs.push(Run {
                            tile: slot,
                            begin,
                            end,
                        });
                        total += end - begin;
                    }
                    done += length;
                }
            }
        }
        total
    }
}

/// The largest whole number that is not above `x`, of moderate size.
#[inline]
pub(super) fn floor(x: f64) -> i64 {
    let whole = x as i64;
    whole - i64::from((whole as f64) > x)
}
