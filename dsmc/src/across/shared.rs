//! Sweeps in which each tile is worked on together with those next to it.
//!
//! Tiles are coloured so that no two of one colour share a neighbour; colours follow each other, and the tiles of
//! one are treated by all threads at once. Who collides with whom then does not depend on the number of threads. Each tile
//! is behind a lock that is always free, because the colouring says so.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use stosszahl_model::{Physics, SpinOf, VectorOf};

use crate::grid::{Grid, OFFSETS, offset, offset_number};
use crate::simulator::{Follow, SimulatorOf};
use crate::tile::Tile;

/// A tile, and those next to it.
pub(super) struct Around<'a, 'b, P: Physics, F: Follow<P::Space>> {
    grid: &'a Grid<P::Space>,
    /// Coordinates of the tile in the middle.
    middle: [u32; 3],
    /// Each once.
    tiles: Vec<MutexGuard<'a, &'b mut Tile<P, F>>>,
    /// Which of them is at each offset.
    slots: [u8; OFFSETS],
}

/// Where a simulator is: which of the tiles at hand, and its place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct At {
    pub(super) tile: u32,
    pub(super) index: u32,
}

impl<'a, 'b, P: Physics, F: Follow<P::Space>> Around<'a, 'b, P, F> {
    fn new(
        grid: &'a Grid<P::Space>,
        locks: &'a [Mutex<&'b mut Tile<P, F>>],
        middle: [u32; 3],
    ) -> Self {
        let number = |step: usize| grid.tile_number(grid.neighbour(middle, offset(step)));
        let mut numbers: Vec<usize> = (0..OFFSETS).map(number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut slots = [0; OFFSETS];
        for (step, slot) in slots.iter_mut().enumerate() {
            *slot = numbers.partition_point(|&other| other < number(step)) as u8;
        }
        let tiles = numbers
            .into_iter()
            .map(|number| locks[number].lock().unwrap_or_else(PoisonError::into_inner))
            .collect();
        Self {
            grid,
            middle,
            tiles,
            slots,
        }
    }

    /// The tile in the middle, as one of those at hand.
    pub(super) fn middle(&self) -> u32 {
        u32::from(self.slots[OFFSETS / 2])
    }

    /// The tile in the middle.
    #[inline]
    pub(super) fn home(&self) -> &Tile<P, F> {
        self.tile(self.middle())
    }

    /// Which of the tiles at hand a cell belongs to, and its number there. Cells beyond the next tiles belong to none.
    #[inline]
    pub(super) fn find(&self, cell: [u32; 3]) -> Option<(u32, usize)> {
        let owner = self.grid.owner(cell);
        let step = offset_number(self.grid.tiles(), self.middle, owner)?;
        let slot = u32::from(self.slots[step]);
        Some((slot, self.tiles[slot as usize].number(cell)))
    }

    /// One of the tiles at hand.
    #[inline]
    pub(super) fn tile(&self, slot: u32) -> &Tile<P, F> {
        &self.tiles[slot as usize]
    }

    /// A copy of a simulator.
    #[inline]
    pub(super) fn read(&self, at: At) -> SimulatorOf<P, F> {
        self.tile(at.tile).simulators[at.index as usize]
    }

    /// Notes collisions in a cell, and their virial, where somebody wants to know.
    pub(super) fn count(&mut self, tile: u32, cell: usize, collisions: f64, virial: f64) {
        if let Some(count) = self.tiles[tile as usize].counts.get_mut(cell) {
            count.collisions += collisions;
            count.virial += virial;
        }
    }

    /// A simulator of a cell has another velocity from now on: partners are bounded by it.
    #[inline]
    pub(super) fn note(&mut self, at: At, cell: [u32; 3], velocity: VectorOf<P>) {
        let tile = &mut self.tiles[at.tile as usize];
        let local = tile.number(cell);
        if let Some(extent) = tile.extents.get_mut(local) {
            extent.note(velocity);
        }
    }

    /// Gives a simulator another velocity and spin.
    #[inline]
    pub(super) fn set(&mut self, at: At, velocity: VectorOf<P>, spin: SpinOf<P>) {
        let simulator = &mut self.tiles[at.tile as usize].simulators[at.index as usize];
        (simulator.velocity, simulator.spin) = (velocity, spin);
    }
}

/// The colour of each tile along an axis: tiles of one colour are at least three apart around the box. Fewer than three
/// tiles get a colour each.
fn ring_colours(count: u32) -> Vec<usize> {
    let regular = if count < 3 { 0 } else { count - count % 3 };
    (0..count)
        .map(|tile| match tile {
            _ if tile < regular => tile % 3,
            _ if regular > 0 => 3 + tile - regular,
            _ => tile,
        } as usize)
        .collect()
}

/// The tiles of each colour, by their number among all.
fn colours<S: stosszahl_model::Space>(grid: &Grid<S>) -> Vec<Vec<u32>> {
    let counts = grid.tiles();
    let along = counts.map(ring_colours);
    let most = [0, 1, 2].map(|axis: usize| along[axis].iter().max().map_or(1, |most| most + 1));
    let mut groups = vec![Vec::new(); most.iter().product()];
    for number in 0..counts.iter().product::<u32>() {
        let at = grid.place_of(number as usize);
        let [x, y, z] = [0, 1, 2].map(|axis: usize| along[axis][at[axis] as usize]);
        groups[x + most[0] * (y + most[1] * z)].push(number);
    }
    groups
}

/// Works on every tile and around it, colour after colour, and returns what the work returned, in that order.
pub(super) fn sweep_around<P: Physics, F: Follow<P::Space>, R: Send>(
    parallel: bool,
    grid: &Grid<P::Space>,
    tiles: &mut [Tile<P, F>],
    work: impl Fn(usize, Around<'_, '_, P, F>) -> R + Sync,
) -> Vec<R> {
    let mut results = Vec::with_capacity(tiles.len());
    let locks: Vec<Mutex<&mut Tile<P, F>>> = tiles.iter_mut().map(Mutex::new).collect();
    let one = |number: &u32| {
        let middle = grid.place_of(*number as usize);
        work(*number as usize, Around::new(grid, &locks, middle))
    };
    for group in &colours(grid) {
        if parallel && group.len() > 1 {
            results.par_extend(group.par_iter().map(one));
        } else {
            results.extend(group.iter().map(one));
        }
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles of one colour have no neighbour in common, for any number of tiles.
    #[test]
    fn tiles_of_one_colour_share_no_neighbour() {
        for count in 1..40_u32 {
            let colours = ring_colours(count);
            assert!(colours.iter().all(|&colour| colour < 5));
            for one in 0..count {
                for other in 0..count {
                    if one == other || colours[one as usize] != colours[other as usize] {
                        continue;
                    }
                    let apart = (one + count - other) % count;
                    assert!(apart.min(count - apart) >= 3, "{count}: {one}, {other}");
                }
            }
        }
    }
}
