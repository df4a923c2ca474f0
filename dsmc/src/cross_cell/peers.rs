//! Interface to other processes that hold tiles of the same gas.

use stosszahl_model::ParticleModel;

use super::change::ChangeOf;
use super::report::{TileBounds, TileReport};
use crate::grid::Grid;
use crate::particle::DisplacementTracking;
use crate::tile::Tile;

/// Interface to the processes that hold other tiles, for collisions across cells.
pub(crate) trait TilePeers<P: ParticleModel, F: DisplacementTracking<P::Space>>:
    Sync
{
    /// Returns whether another process reads a tile as ghost cells or owns it.
    fn is_seen(&self, tile: usize) -> bool;

    /// Returns true if collisions around a tile change ghost cells of another process.
    fn tells(&self, tile: usize) -> bool;

    /// Exchanges ghost cells between processes before the collisions of a step. Returns the bounds
    /// of the tiles received.
    fn see_around(
        &self,
        tiles: &mut [Tile<P, F>],
        bounds: &[TileBounds],
    ) -> Vec<(usize, TileBounds)>;

    /// Sends the changes in the tiles of a colour and around them. Calls `meanwhile` while messages
    /// travel, and `then` with the changes received.
    fn tell_changes(
        &self,
        colour: usize,
        changes: &[ChangeOf<P>],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<ChangeOf<P>>),
    );

    /// Returns the reports of the tiles of all processes, in the order of colours. The first
    /// process also receives the collision logs if `looks`, for its observers.
    fn all_reports(
        &self,
        grid: &Grid<P::Space>,
        mine: Vec<(u32, TileReport)>,
        looks: bool,
    ) -> Vec<(u32, TileReport)>;

    /// Empties the ghost tiles after the collisions of a step.
    fn see_no_more(&self, tiles: &mut [Tile<P, F>]);
}
