//! Results of the collisions around a tile, and bounds that its neighbours need.

use serde::{Deserialize, Serialize};
use stosszahl_model::Collision;

use super::arm::Distances;
use crate::tally::CollisionCounters;

/// Bounds over the cells of a tile before the collisions of a step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct TileBounds {
    /// Largest chi of a cell.
    pub(super) chi: f64,
}

/// Counters, contact distances and logged collisions of the work on one tile.
#[derive(Default)]
pub(crate) struct TileReport {
    pub(crate) tally: CollisionCounters,
    pub(crate) distances: Distances,
    pub(crate) log: Vec<Collision>,
}
