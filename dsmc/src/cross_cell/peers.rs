//! Interface to other processes that hold tiles of the same gas.

use stosszahl_model::Physics;

use super::change::ChangeOf;
use super::report::{Bounds, Report};
use crate::grid::Grid;
use crate::particle::Follow;
use crate::tile::Tile;

/// Other processes that hold tiles, as collisions across cells need them.
pub(crate) trait TilePeers<P: Physics, F: Follow<P::Space>>: Sync {
    /// Returns whether another process sees a tile: its owner, or one with a tile next to it.
    fn is_seen(&self, tile: usize) -> bool;

    /// Returns whether work around a tile changes what another process sees.
    fn tells(&self, tile: usize) -> bool;

    /// Exchanges the cells that processes see of each other before the collisions of a step.
    /// Returns the bounds of the tiles that came.
    fn see_around(&self, tiles: &mut [Tile<P, F>], bounds: &[Bounds]) -> Vec<(usize, Bounds)>;

    /// Sends the changes in the tiles of a colour and around them, does other work meanwhile, and
    /// then the work that needs the changes of others.
    fn tell_changes(
        &self,
        colour: usize,
        changes: &[ChangeOf<P>],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<ChangeOf<P>>),
    );

    /// Returns the reports of the tiles of all processes, in the order of colours. Logs of others
    /// reach the first process, if `looks`.
    fn all_reports(
        &self,
        grid: &Grid<P::Space>,
        mine: Vec<(u32, Report)>,
        looks: bool,
    ) -> Vec<(u32, Report)>;

    /// Empties the tiles of other processes after the collisions of a step.
    fn see_no_more(&self, tiles: &mut [Tile<P, F>]);
}
