//! Interface to the other processes that hold tiles of the same gas: exchange of ghost cells and of
//! velocity changes in the collision phase.

use stosszahl_model::ParticleModel;

use super::change::ChangeOf;
use super::report::{TileBounds, TileReport};
use crate::grid::Grid;
use crate::particle::DisplacementTracking;
use crate::tile::Tile;

/// Interface to the processes that hold the other tiles of the gas, for collisions between cells.
pub(crate) trait TilePeers<P: ParticleModel, F: DisplacementTracking<P::Space>>:
    Sync
{
    /// Returns true if another process owns a tile or holds ghost cells of it.
    fn is_seen(&self, tile: usize) -> bool;

    /// Returns true if collisions in a tile and its neighbours can change ghost cells of another
    /// process.
    fn tells(&self, tile: usize) -> bool;

    /// Exchanges ghost cells between processes before the collisions of a time step. Returns the
    /// bounds of the tiles received.
    fn see_around(
        &self,
        tiles: &mut [Tile<P, F>],
        bounds: &[TileBounds],
    ) -> Vec<(usize, TileBounds)>;

    /// Sends the velocity changes by collisions in the tiles of a colour to other processes. Calls
    /// `meanwhile` while messages travel, and `then` with the changes received.
    fn tell_changes(
        &self,
        colour: usize,
        changes: &[ChangeOf<P>],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<ChangeOf<P>>),
    );

    /// Returns the reports of the tiles of all processes, in the order of colours. The root process
    /// also receives the logged collisions if an observer `looks`.
    fn all_reports(
        &self,
        grid: &Grid<P::Space>,
        mine: Vec<(u32, TileReport)>,
        looks: bool,
    ) -> Vec<(u32, TileReport)>;

    /// Empties the ghost tiles of other processes after the collisions of a time step.
    fn see_no_more(&self, tiles: &mut [Tile<P, F>]);
}
