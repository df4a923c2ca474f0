//! The search for a partner around a point.

use rand::{Rng, RngExt};
use stosszahl_model::{Physics, Sizes, Space, Vector, VectorOf};

use super::shared::{Around, At};
use crate::grid::Grid;
use crate::simulator::Follow;

/// Simulators that lie next to each other in one tile.
#[derive(Clone, Copy, Debug)]
struct Run {
    tile: u32,
    begin: u32,
    end: u32,
}

/// Draws before all simulators around are looked at one by one, and the number of them up to which none is drawn.
const DRAWS: u32 = 12;

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
            point: self.grid.domain().wrap(aim.point),
            ..aim
        };
        if self.radius > 0.0 {
            let total = self.gather(around, aim, self.radius);
            if total > 0
                && let Some(found) = self.draw(around, aim, who, total, stream)
            {
                return Some(found);
            }
        }
        self.nearest(around, aim, who)
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
        let is_near = |at: At| at != who && self.distance_square(around, aim, at) < square;
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

    /// The nearest simulator to its point of the aim.
    fn nearest<F: Follow<P::Space>>(
        &mut self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        who: At,
    ) -> Option<At> {
        let width = self.grid.width();
        let narrowest = (0..P::Space::DIMENSION)
            .map(|axis| width[axis])
            .fold(f64::MAX, f64::min);
        for cells in 1..=WIDEST {
            let reach = cells as f64 * narrowest;
            let total = self.gather(around, aim, reach);
            let mut best = (f64::MAX, None);
            for number in 0..total {
                let at = self.nth(number);
                let square = self.distance_square(around, aim, at);
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

    fn distance_square<F: Follow<P::Space>>(
        &self,
        around: &Around<'_, '_, P, F>,
        aim: Aim<VectorOf<P>>,
        at: At,
    ) -> f64 {
        let simulator = &around.tile(at.tile).simulators[at.index as usize];
        let position = simulator.position;
        let mut point = aim.point;
        if !P::Sizes::UNIFORM {
            point += aim.along * (self.sizes.radius(simulator.tag) - self.mean_radius);
        }
        let lengths = self.grid.images();
        let mut square = 0.0;
        for axis in 0..P::Space::DIMENSION {
            // Both are in the box, or the point a little outside.
            let apart = (position[axis] - point[axis]).abs();
            let apart = if apart > 0.5 * lengths[axis] {
                lengths[axis] - apart
            } else {
                apart
            };
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
        self.runs.clear();
        let point = aim.point;
        let radius = if P::Sizes::UNIFORM {
            radius
        } else {
            radius + self.spread * aim.along.square().sqrt()
        };
        let counts = self.grid.counts();
        let width = self.grid.width();
        let (mut low, mut span) = ([0_u32; 3], [1_u32; 3]);
        for axis in 0..P::Space::DIMENSION {
            let scale = 1.0 / width[axis];
            let first = floor((point[axis] - radius) * scale);
            let last = floor((point[axis] + radius) * scale);
            let count = i64::from(counts[axis]);
            // Around a narrow box no cell is counted twice.
            span[axis] = (last - first + 1).min(count) as u32;
            low[axis] = if (0..count).contains(&first) {
                first
            } else {
                first.rem_euclid(count)
            } as u32;
        }
        let around_ring = |axis: usize, step: u32| {
            let at = low[axis] + step;
            if at >= counts[axis] {
                at - counts[axis]
            } else {
                at
            }
        };
        let mut total = 0;
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
