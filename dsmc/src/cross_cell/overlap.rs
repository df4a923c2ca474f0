//! Scheme of stochastic hard disks: overlapping pairs collide along their line of centres at a rate
//! proportional to their approach speed.

use std::ops::Range;

use rand::{Rng, RngExt};
use stosszahl_model::{ParticleModel, Sizes, Space, Vector, VectorOf};

use super::lanes::LANES;
use super::search_target::Aim;
use super::tile_collider::TileCollider;
use crate::extrema::larger;
use crate::particle::DisplacementTracking;

impl<P, F> TileCollider<'_, '_, '_, P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Collides overlapping pairs that approach each other, in a cell and half of its neighbours.
    /// The rate of a pair closer than its contact distance d is `stiffness` w D chi `g_n`/d, for
    /// simulators of weight w and normal approach speed `g_n`.
    #[inline(always)]
    pub(super) fn overlapping(
        &mut self,
        at: [u32; 3],
        members: Range<usize>,
        stiffness: f64,
        stream: &mut impl Rng,
    ) {
        let kernel = self.kernel;
        let counts = kernel.grid.counts();
        let here = self.patch.cell_of_member(members.start);
        let (chi, ..) = kernel.density.contact_value(at, 1.0);
        let dimension = P::Space::DIMENSION as f64;
        let rate = stiffness * kernel.weight * dimension * chi * kernel.step;
        let sizes = kernel.scene.sizes();
        for first in members.clone() {
            if kernel.stop.is_raised() {
                return;
            }
            let aim = Aim {
                point: self.patch.position(first),
                along: VectorOf::<P>::default(),
            };
            let farthest = sizes.radius(self.patch.tag(first)) + sizes.largest_radius();
            let limit = farthest * farthest;
            for (lines, [low, high]) in forward_lines(P::Space::DIMENSION) {
                // In a box of two cells each pair would be found twice.
                if (1..3).any(|axis| lines[axis] != 0 && counts[axis] < 3) {
                    continue;
                }
                let [low, high] = if counts[0] < 3 { [0; 2] } else { [low, high] };
                let begin = self.patch.step_from(here, [low, lines[1], lines[2]]);
                let others = self.patch.members(begin, (high - low + 1) as usize);
                // Pairs within the cell are counted once.
                let is_own = lines == [0; 3];
                let mut begin = if is_own { first + 1 } else { others.start };
                while begin < others.end {
                    let squares = self.patch.squares(aim, begin, others.end);
                    let mut near = 0_u32;
                    for (lane, square) in squares.into_iter().enumerate() {
                        near |= u32::from(square < limit) << lane;
                    }
                    while near != 0 {
                        let second = begin + near.trailing_zeros() as usize;
                        near &= near - 1;
                        self.try_overlap([first, second], rate, stream);
                    }
                    begin += LANES;
                }
            }
        }
    }

    /// Tests if an overlapping pair collides in this time step, and executes the collision. `rate`
    /// is the expected number of events per unit of approach speed and inverse contact distance.
    #[inline(always)]
    fn try_overlap(&mut self, pair: [usize; 2], rate: f64, stream: &mut impl Rng) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let [one, other] = pair.map(|who| self.patch.position(who));
        let apart = kernel.grid.nearest_image(one - other);
        let [one, other] = pair.map(|who| sizes.radius(self.patch.tag(who)));
        let contact = one + other;
        let square = apart.square();
        if square >= contact * contact || square == 0.0 {
            return;
        }
        let [one, other] = pair.map(|who| self.patch.velocities[who]);
        let mut relative = one - other;
        relative[0] += kernel.flow.rate * apart[1];
        let approach = -relative.inner(&apart);
        if approach <= 0.0 {
            return;
        }
        self.report.tally.trials += 1;
        let distance = square.sqrt();
        // Chance of at least one event; afterwards the pair separates. The expected number is
        // recorded: above one, the step is too long.
        let events = rate * approach / (distance * contact);
        let tally = &mut self.report.tally;
        tally.busiest_cell = larger(tally.busiest_cell, events);
        let number: f64 = stream.random();
        // The exponential function is computed only where the pair may collide.
        if number < events && number < -(-events).exp_m1() {
            self.strike(pair, -apart * (1.0 / distance), contact);
        }
    }
}

/// Returns the offsets of the lines of cells that hold half of a cell's neighbours, so that each
/// pair of cells is found once: row and layer, with first and last column. The first line starts
/// with the cell itself.
fn forward_lines(dimension: usize) -> impl Iterator<Item = ([i32; 3], [i32; 2])> {
    let layers = if dimension == 3 { 0..=1 } else { 0..=0 };
    let lines = layers.flat_map(|z| (-1..=1).map(move |y| [0, y, z]));
    lines
        .filter(|&[_, y, z]| z > 0 || y >= 0)
        .map(|line| (line, if line == [0; 3] { [0, 1] } else { [-1, 1] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_neighbours_are_forward() {
        for (dimension, count) in [(2, 5), (3, 14)] {
            let steps: Vec<_> = forward_lines(dimension)
                .flat_map(|([_, y, z], [low, high])| (low..=high).map(move |x| [x, y, z]))
                .collect();
            assert_eq!(steps.len(), count);
            assert_eq!(steps[0], [0; 3]);
            for step in &steps[1..] {
                assert!(!steps.contains(&step.map(|x| -x)));
            }
        }
    }
}
