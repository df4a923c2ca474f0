//! Velocity changes of simulators in ghost cells, as messages between processes.

use serde::{Deserialize, Serialize};
use stosszahl_model::{ParticleModel, Space, SpinOf, Surface, Vector, VectorOf};

use crate::particle::DisplacementTracking;
use crate::tile::Tile;

/// New velocity and spin of a simulator after a collision, addressed by its tile, its cell in the
/// tile, and its index in the cell.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Change<V, W> {
    pub(crate) tile: u32,
    pub(crate) cell: u32,
    pub(super) place: u32,
    pub(super) velocity: V,
    pub(super) spin: W,
}

/// Change of velocity and spin of a simulator, for a given particle model.
pub(crate) type ChangeOf<P> = Change<VectorOf<P>, SpinOf<P>>;

impl<V: Vector, W: Copy> Change<V, W> {
    /// Sets velocity and spin of the simulator in a tile; does nothing if the tile does not hold
    /// its cell.
    #[inline]
    pub(super) fn apply<P, F>(&self, tile: &mut Tile<P, F>)
    where
        P: ParticleModel,
        P::Space: Space<Vector = V>,
        P::Surface: Surface<P::Space, Spin = W>,
        F: DisplacementTracking<P::Space>,
    {
        let cell = self.cell as usize;
        let index = tile.starts[cell] + self.place;
        if index >= tile.starts[cell + 1] {
            return;
        }
        let simulator = &mut tile.simulators[index as usize];
        (simulator.velocity, simulator.spin) = (self.velocity, self.spin);
    }
}
