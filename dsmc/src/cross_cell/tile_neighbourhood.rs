//! A tile and its neighbours, locked for the work around it.

use std::sync::{Mutex, MutexGuard, PoisonError};

use stosszahl_model::{Collision, Physics, SpinOf, VectorOf};

use super::change::{Change, ChangeOf};
use super::peers::TilePeers;
use crate::grid::{Grid, OFFSETS, offset, offset_number};
use crate::particle::{Follow, SimulatorOf};
use crate::tile::Tile;

/// A tile, and those next to it.
pub(super) struct TileNeighbourhood<'a, 'b, P: Physics, F: Follow<P::Space>> {
    grid: &'a Grid<P::Space>,
    /// Coordinates of the tile in the middle.
    middle: [u32; 3],
    /// Each once.
    tiles: Vec<MutexGuard<'a, &'b mut Tile<P, F>>>,
    /// Which of them is at each offset.
    slots: [u8; OFFSETS],
    /// Their numbers among all tiles, and whether other processes see them.
    numbers: Vec<u32>,
    seen: Vec<bool>,
    /// What other processes are to know of those.
    changes: Vec<ChangeOf<P>>,
}

/// Where a simulator is: which of the tiles at hand, and its place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct At {
    pub(super) tile: u32,
    pub(super) index: u32,
}

impl<'a, 'b, P: Physics, F: Follow<P::Space>> TileNeighbourhood<'a, 'b, P, F> {
    pub(super) fn new(
        grid: &'a Grid<P::Space>,
        locks: &'a [Mutex<&'b mut Tile<P, F>>],
        middle: [u32; 3],
        peers: Option<&dyn TilePeers<P, F>>,
    ) -> Self {
        let number = |step: usize| grid.tile_number(grid.neighbour(middle, offset(step)));
        let mut numbers: Vec<usize> = (0..OFFSETS).map(number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut slots = [0; OFFSETS];
        for (step, slot) in slots.iter_mut().enumerate() {
            *slot = numbers.partition_point(|&other| other < number(step)) as u8;
        }
        let seen = |&number: &usize| peers.is_some_and(|peers| peers.is_seen(number));
        Self {
            grid,
            middle,
            slots,
            seen: numbers.iter().map(seen).collect(),
            numbers: numbers.iter().map(|&number| number as u32).collect(),
            tiles: numbers
                .into_iter()
                .map(|number| lock(&locks[number]))
                .collect(),
            changes: Vec::new(),
        }
    }

    /// What other processes are to know.
    pub(super) fn changes(self) -> Vec<ChangeOf<P>> {
        self.changes
    }

    /// The log of the tile in the middle, which is empty.
    pub(super) fn take_log(&mut self) -> Vec<Collision> {
        let middle = self.middle() as usize;
        std::mem::take(&mut self.tiles[middle].log)
    }

    /// The tile in the middle, as one of those at hand.
    pub(super) fn middle(&self) -> u32 {
        u32::from(self.slots[OFFSETS / 2])
    }

    /// The tile in the middle.
    #[inline(always)]
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
    #[inline(always)]
    pub(super) fn tile(&self, slot: u32) -> &Tile<P, F> {
        &self.tiles[slot as usize]
    }

    /// A copy of a simulator.
    #[inline(always)]
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

    /// Gives a simulator another velocity and spin.
    #[inline(always)]
    pub(super) fn set(&mut self, at: At, velocity: VectorOf<P>, spin: SpinOf<P>) {
        let slot = at.tile as usize;
        let simulator = &mut self.tiles[slot].simulators[at.index as usize];
        (simulator.velocity, simulator.spin) = (velocity, spin);
        if self.seen[slot] {
            let cell = self.grid.cell_at(simulator.position);
            let tile = &self.tiles[slot];
            let cell = tile.number(cell);
            self.changes.push(Change {
                tile: self.numbers[slot],
                cell: cell as u32,
                place: at.index - tile.starts[cell],
                velocity,
                spin,
            });
        }
    }
}

/// Locks a tile, which the colouring leaves free.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
