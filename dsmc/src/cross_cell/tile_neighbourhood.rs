//! Neighbourhood of a tile: the tile and its adjacent tiles, locked while the tile's simulators
//! collide.

use std::sync::{Mutex, MutexGuard, PoisonError};

use stosszahl_model::{Collision, ParticleModel, SpinOf, VectorOf};

use super::change::{Change, ChangeOf};
use super::peers::TilePeers;
use crate::grid::Grid;
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::tile::Tile;

/// Tile and its adjacent tiles, locked for the collisions of the central tile.
pub(super) struct TileNeighbourhood<'a, 'b, P: ParticleModel, F: DisplacementTracking<P::Space>> {
    grid: &'a Grid<P::Space>,
    /// Index in `tiles` of the central tile.
    middle: u32,
    /// Locked tiles of the neighbourhood, each once, in the order of their numbers.
    tiles: Vec<MutexGuard<'a, &'b mut Tile<P, F>>>,
    /// Numbers in the grid of the tiles in the neighbourhood, sorted.
    numbers: Vec<u32>,
    /// For each tile of the neighbourhood: true if other processes own it or hold ghost cells of
    /// it.
    seen: Vec<bool>,
    /// Velocity changes of simulators that other processes must be sent.
    changes: Vec<ChangeOf<P>>,
}

/// Location of a simulator: index of its tile in the neighbourhood, and its index in that tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct At {
    pub(super) tile: u32,
    pub(super) index: u32,
}

impl<'a, 'b, P: ParticleModel, F: DisplacementTracking<P::Space>> TileNeighbourhood<'a, 'b, P, F> {
    pub(super) fn new(
        grid: &'a Grid<P::Space>,
        locks: &'a [Mutex<&'b mut Tile<P, F>>],
        middle: [u32; 3],
        peers: Option<&dyn TilePeers<P, F>>,
    ) -> Self {
        let numbers = grid.touching(middle);
        let middle = grid.tile_number(middle);
        let seen = |&number: &usize| peers.is_some_and(|peers| peers.is_seen(number));
        Self {
            grid,
            middle: numbers.partition_point(|&number| number < middle) as u32,
            seen: numbers.iter().map(seen).collect(),
            numbers: numbers.iter().map(|&number| number as u32).collect(),
            tiles: numbers
                .into_iter()
                .map(|number| lock(&locks[number]))
                .collect(),
            changes: Vec::new(),
        }
    }

    /// Returns the velocity changes of simulators that other processes must be sent, and unlocks
    /// the tiles.
    pub(super) fn changes(self) -> Vec<ChangeOf<P>> {
        self.changes
    }

    /// Takes the collision log out of the central tile, so that its memory is reused. The log holds
    /// no collisions: each step clears it once observers have seen them.
    pub(super) fn take_log(&mut self) -> Vec<Collision> {
        std::mem::take(&mut self.tiles[self.middle as usize].log)
    }

    /// Returns the index of the central tile in the neighbourhood.
    pub(super) fn middle(&self) -> u32 {
        self.middle
    }

    /// Returns the central tile of the neighbourhood.
    #[inline(always)]
    pub(super) fn home(&self) -> &Tile<P, F> {
        self.tile(self.middle())
    }

    /// Returns the index in the neighbourhood of the tile that contains a cell, and the cell's
    /// number in that tile; `None` beyond the adjacent tiles.
    #[inline]
    pub(super) fn find(&self, cell: [u32; 3]) -> Option<(u32, usize)> {
        let number = self.grid.tile_number(self.grid.owner(cell)) as u32;
        let slot = self.numbers.binary_search(&number).ok()?;
        Some((slot as u32, self.tiles[slot].number(cell)))
    }

    /// Returns the tile with an index in the neighbourhood.
    #[inline(always)]
    pub(super) fn tile(&self, slot: u32) -> &Tile<P, F> {
        &self.tiles[slot as usize]
    }

    /// Returns the number of simulators in each tile of the neighbourhood.
    pub(super) fn lengths(&self) -> impl Iterator<Item = usize> + '_ {
        self.tiles.iter().map(|tile| tile.simulators.len())
    }

    /// Returns a copy of the simulator at a location in the neighbourhood of tiles.
    #[inline(always)]
    pub(super) fn read(&self, at: At) -> SimulatorOf<P, F> {
        self.tile(at.tile).simulators[at.index as usize]
    }

    /// Adds collisions and virial to the counters of a cell, if the run counts cells.
    pub(super) fn count(&mut self, tile: u32, cell: usize, collisions: f64, virial: f64) {
        if let Some(count) = self.tiles[tile as usize].counts.get_mut(cell) {
            count.collisions += collisions;
            count.virial += virial;
        }
    }

    /// Sets velocity and spin of a simulator in its tile, and records the change for other
    /// processes.
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

/// Locks a tile without waiting, as the colouring of tiles keeps it free.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
