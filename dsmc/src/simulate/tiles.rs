//! Access to the simulators of a DSMC gas tile by tile, for sums that several processes compute.

use stosszahl_model::ParticleModel;

use crate::engine::DsmcEngine;
use crate::particle::{DisplacementTracking, SimulatorOf};

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Returns the numbers of the tiles that this process owns.
    pub(super) fn tiles_here(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.tiles.len()).filter(|&tile| self.tiles[tile].is_here)
    }

    /// Calls `look` for each simulator of a tile, with its weight (particles per simulator).
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
