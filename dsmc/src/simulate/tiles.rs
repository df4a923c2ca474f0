//! Access to simulators tile by tile, for distributed sums.

use stosszahl_model::ParticleModel;

use crate::engine::DsmcEngine;
use crate::particle::{DisplacementTracking, SimulatorOf};

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Numbers of the tiles that this process holds.
    pub(super) fn tiles_here(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.tiles.len()).filter(|&tile| self.tiles[tile].is_here)
    }

    /// Calls `look` with each simulator of a tile and its weight, in particles.
    pub(super) fn each_in(&self, tile: usize, mut look: impl FnMut(&SimulatorOf<P, F>, f64)) {
        let tile = &self.tiles[tile];
        for local in 0..tile.cells() {
            let weight = self.weight_in(self.grid.number(tile.cell_at(local)));
            for simulator in tile.members(local) {
                look(simulator, weight);
            }
        }
    }
}
