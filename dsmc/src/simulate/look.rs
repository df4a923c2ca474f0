//! How the common interface looks at simulators.

use stosszahl_model::Physics;

use crate::engine::Engine;
use crate::simulator::{Follow, SimulatorOf};

impl<P, F> Engine<P, F>
where
    P: Physics,
    F: Follow<P::Space>,
{
    /// Shows each simulator and the number of particles that it stands for, in the order of the numbers of their cells.
    pub(super) fn each(&self, mut look: impl FnMut(&SimulatorOf<P, F>, f64)) {
        for cell in self.cells_in_order() {
            let (tile, local) = self.grid.locate(cell);
            let weight = self.weight_in(self.grid.number(cell));
            for simulator in self.tiles[tile].members(local) {
                look(simulator, weight);
            }
        }
    }

    /// The numbers of the tiles that this process holds.
    pub(super) fn tiles_here(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.tiles.len()).filter(|&tile| self.tiles[tile].is_here)
    }

    /// The same of one tile.
    pub(super) fn each_in(&self, tile: usize, mut look: impl FnMut(&SimulatorOf<P, F>, f64)) {
        let tile = &self.tiles[tile];
        for local in 0..tile.cells() {
            let weight = self.weight_in(self.grid.number(tile.cell_at(local)));
            for simulator in tile.members(local) {
                look(simulator, weight);
            }
        }
    }

    /// The same of all, with the place of each in [`Engine::state`].
    pub(super) fn each_in_place(&self, mut look: impl FnMut(usize, &SimulatorOf<P, F>, f64)) {
        let (mut places, mut order) = (self.places(), 0);
        self.each(|simulator, weight| {
            let index = places.index(self.scene.sizes(), simulator.tag, order);
            look(index, simulator, weight);
            order += 1;
        });
    }
}
