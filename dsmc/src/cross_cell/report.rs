//! Results of the collisions of one tile in one time step, and bounds of the contact value that
//! neighbouring tiles need.

use serde::{Deserialize, Serialize};
use stosszahl_model::Collision;

use super::arm::Distances;
use crate::tally::CollisionCounters;

/// Bounds over the cells of a tile, taken before the collisions of a time step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct TileBounds {
    /// Largest contact value chi of any cell of the tile.
    pub(super) chi: f64,
}

/// Results of the collisions of one tile: work counters, partner distances and logged collisions.
#[derive(Default)]
pub(crate) struct TileReport {
    pub(crate) tally: CollisionCounters,
    pub(crate) distances: Distances,
    pub(crate) log: Vec<Collision>,
}
