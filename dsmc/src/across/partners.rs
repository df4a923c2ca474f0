//! The search for a partner around a point.

use rand::{Rng, RngExt};
use stosszahl_model::{Physics, Sizes, Space, Vector, VectorOf};

use super::shared::{Around, At};
use crate::grid::Grid;
use crate::simulator::{Follow, SimulatorOf};
use crate::tally::smaller;

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
const FEW: u32 = 64;

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
    /// How far the radius of a particle is from the mean, at most.
    spread: f64,
    /// Narrowest side of a cell, and cells for each unit of length along each axis.
    narrowest: f64,
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
    ) -> Self {
        let spread = if P::Sizes::UNIFORM {
            0.0
        } else {
            mean_radius.max(sizes.largest_radius() - mean_radius)
        };
        Self {
            grid,
            radius,
            sizes,
            mean_radius,
            spread,
            narrowest: grid.narrowest(),
            scale: P::Space::vector(|axis| 1.0 / grid.width()[axis]),
            runs: Vec::new(),
        }
    }

    /// A simulator other than `who` around its point of the aim, in the box or a little outside: any within the radius, all
    /// equally likely; if there is none, the nearest; none if that is farther than a few cells.
    pub(super) fn partner<F: Follow<P::Space>>(
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
        // Few: all of the next two cells along each axis are looked at once, and where nobody is near, of the next three.
        let (first, reach) = self.corner(aim);
        if self.radius <= reach {
            let total = self.collect(around, first, [2; 3]);
            if total <= FEW
                && let Some(found) = self.look(around, aim, who, reach, stream)
            {
                return Some(found);
            }
        }
        if self.radius <= self.narrowest {
            let total = self.gather(around, aim, self.narrowest);
            if total <= FEW {
                return match self.look(around, aim, who, self.narrowest, stream) {
                    None => self.nearest(around, aim, who, 2),
                    found => found,
                };
            }
        }
        if self.radius > 0.0 {
            let total = self.gather(around, aim, self.radius);
            if total > 0
                && let Some(found) = self.draw(around, aim, who, total, stream)
            {
                return Some(found);
            }
        }
        self.nearest(around, aim, who, 1)
    }

    /// The first of the two cells along each axis that are nearest to a point, and the distance within which they hold all
    /// that is there.
    #[inline]
    fn corner(&self, aim: Aim<VectorOf<P>>) -> ([i64; 3], f64) {
        let (mut first, mut reach) = ([0; 3], f64::MAX);
        for (axis, first) in first.iter_mut().enumerate().take(P::Space::DIMENSION) {
            let at = aim.point[axis] * self.scale[axis];
            let low = floor(at - 0.5);
            *first = low;
            let below = at - low as f64;
            reach = smaller(reach, smaller(below, 2.0 - below) / self.scale[axis]);
        }
        if !P::Sizes::UNIFORM {
            reach -= self.spread * aim.along.square().sqrt();
        }
        (first, reach)
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

    /// Of what was gathered, any simulator within the radius, all equally likely; or else the nearest, if it is within reach.
    fn look<F: Follow<P::Space>>(
        &self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        reach: f64,
        stream: &mut impl Rng,
    ) -> Option<At> {
        let limit = self.radius * self.radius;
        // Squares of distances and the numbers of simulators in one word each, so that the least is found without a branch:
        // squares are not negative, so that their bits have their order, and the last six are none that matter.
        let (mut best, mut near, mut number) = (u64::MAX, 0, 0);
        for &Run { tile, begin, end } in &self.runs {
            let run = &around.tile(tile).simulators[begin as usize..end as usize];
            let own = if tile == who.tile {
                who.index
            } else {
                u32::MAX
            };
            for (index, simulator) in (begin..).zip(run) {
                let square = self.distance_square::<F>(aim, simulator);
                let square = if index == own { f64::MAX } else { square };
                near += u32::from(square < limit);
                best = best.min((square.to_bits() & !63) | number);
                number += 1;
            }
        }
        if near > 1 {
            return self.choose(around, aim, who, stream.random_range(0..near));
        }
        if best > (reach * reach).to_bits() {
            return None;
        }
        Some(self.nth((best & 63) as u32))
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

    /// The nearest simulator to its point of the aim, sought in `first` cells on each side, and then in more.
    fn nearest<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
        first: i64,
    ) -> Option<At> {
        for cells in first..=WIDEST {
            let reach = cells as f64 * self.narrowest;
            let total = self.gather(around, aim, reach);
            let mut best = (f64::MAX, None);
            for number in 0..total {
                let at = self.nth(number);
                let simulator = &around.tile(at.tile).simulators[at.index as usize];
                let square = self.distance_square::<F>(aim, simulator);
                if square < best.0 && at != who {
                    best = (square, Some(at));
                }
            }
            if best.0 <= reach * reach {
                return best.1;
            }
        }
        None
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

    /// Gathers the runs of all cells that balls around the points of an aim touch, and returns how many simulators they hold.
    fn gather<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        radius: f64,
    ) -> u32 {
        let point = aim.point;
        let radius = if P::Sizes::UNIFORM {
            radius
        } else {
            radius + self.spread * aim.along.square().sqrt()
        };
        let (mut first, mut span) = ([0; 3], [1; 3]);
        for axis in 0..P::Space::DIMENSION {
            let scale = self.scale[axis];
            first[axis] = floor((point[axis] - radius) * scale);
            let last = floor((point[axis] + radius) * scale);
            span[axis] = (last - first[axis] + 1) as u32;
        }
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
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    whole - i64::from((whole as f64) > x)
}
