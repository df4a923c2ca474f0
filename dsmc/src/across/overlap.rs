//! Collisions of overlapping disks along their line of centres.

use rand::{Rng, RngExt};
use stosszahl_model::{Physics, Sizes, Space, Vector};

use super::kernel::{Cell, Worker};
use super::shared::At;
use crate::collide::nearest_image;
use crate::simulator::Follow;

impl<P, F> Worker<'_, '_, '_, P, F>
where
    P: Physics,
    F: Follow<P::Space>,
{
    /// Pairs of the cell, and of the cell with half of those next to it, that are nearer than their contact distance d and
    /// approach collide with the rate `stiffness` w D chi `g_n`/d, for simulators of weight w.
    pub(super) fn overlapping(&mut self, cell: Cell, stiffness: f64, stream: &mut impl Rng) {
        for (step, forward) in forward_steps(P::Space::DIMENSION).enumerate() {
            let Some(other) = self.step_from(cell.at, forward) else {
                continue;
            };
            let Some((tile, local)) = self.around.find(other) else {
                continue;
            };
            let starts = &self.around.tile(tile).starts;
            let range = starts[local]..starts[local + 1];
            let home = self.around.middle();
            for (done, first) in cell.places(home).enumerate() {
                if self.kernel.stop.is_raised() {
                    return;
                }
                // Each pair of the cell itself once.
                let begin = if step == 0 {
                    range.start + done as u32 + 1
                } else {
                    range.start
                };
                for index in begin..range.end {
                    let second = At { tile, index };
                    self.try_overlap([first, second], stiffness, stream);
                }
            }
        }
    }

    /// The cell at a step, unless it is reached by another step too, as around a box of two cells.
    fn step_from(&self, cell: [u32; 3], forward: [i32; 3]) -> Option<[u32; 3]> {
        let counts = self.kernel.grid.counts();
        let mut other = cell;
        for axis in 0..P::Space::DIMENSION {
            let count = counts[axis];
            if forward[axis] != 0 && count < 3 {
                return None;
            }
            other[axis] = (cell[axis] + count).wrapping_add_signed(forward[axis]) % count;
        }
        Some(other)
    }

    fn try_overlap(&mut self, places: [At; 2], stiffness: f64, stream: &mut impl Rng) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let pair = places.map(|at| self.around.read(at));
        let apart = nearest_image::<P>(kernel.grid, pair[0].position - pair[1].position);
        let contact = sizes.radius(pair[0].tag) + sizes.radius(pair[1].tag);
        let square = apart.square();
        if square >= contact * contact || square == 0.0 {
            return;
        }
        let normal = -apart * (1.0 / square.sqrt());
        let speed = (pair[0].velocity - pair[1].velocity).inner(&normal);
        if speed <= 0.0 {
            return;
        }
        self.report.tally.trials += 1;
        let cell = kernel.grid.cell_at(pair[0].position);
        let (chi, ..) = kernel.density.contact_value(cell, 1.0);
        let dimension = P::Space::DIMENSION as f64;
        let rate = stiffness * kernel.weight * dimension * chi * speed / contact;
        // The chance of at least one event in the step; after the first they part. What they had if they did not is
        // noted: more than one says that the step is too long.
        let events = rate * kernel.step;
        let tally = &mut self.report.tally;
        tally.busiest_cell = tally.busiest_cell.max(events);
        if stream.random::<f64>() < -(-events).exp_m1() {
            self.strike(places, &pair, normal, contact);
        }
    }
}

/// Steps to the cell itself and to half of its neighbours, so that each pair of cells is met once.
fn forward_steps(dimension: usize) -> impl Iterator<Item = [i32; 3]> {
    let layers = if dimension == 3 { 0..=1 } else { 0..=0 };
    layers.flat_map(|z| {
        (-1..=1)
            .flat_map(move |y| (-1..=1).map(move |x| [x, y, z]))
            .filter(|&[x, y, z]| z > 0 || y > 0 || (y == 0 && x >= 0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_neighbours_are_forward() {
        for (dimension, count) in [(2, 5), (3, 14)] {
            let steps: Vec<_> = forward_steps(dimension).collect();
            assert_eq!(steps.len(), count);
            assert_eq!(steps[0], [0; 3]);
            for step in &steps[1..] {
                assert!(!steps.contains(&step.map(|x| -x)));
            }
        }
    }
}
