//! Commands of the root process to the other processes of a decomposed gas.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::decomposition::{Ranks, ShardLocation, broadcast, to_bytes};

/// Command of the root process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum RootCommand {
    /// Advances to a time, for at most a number of steps; `true` if collisions are observed.
    Advance(f64, u64, bool),
    /// Gathers all tiles in the root process.
    Unite,
    /// Adds own particles to the sum of this name, given empty; with neighbours up to a distance if
    /// one is given.
    AddUp(Option<f64>, String, Vec<u8>),
    /// Restarts the tracking of displacements.
    DisplacementTracking,
    /// Sums squared displacements.
    Ways,
    /// Writes own tiles into files whose names begin with this stem.
    Write(String, ShardLocation),
    /// Ends the gas.
    End,
}

impl RootCommand {
    pub(super) fn give(&self, ranks: &dyn Ranks) {
        broadcast(ranks, to_bytes(self));
    }
}

/// Other processes of a decomposed gas, from the root process.
pub(super) struct Others(pub(super) Arc<dyn Ranks>);

impl Others {
    /// Commands the other processes to advance.
    pub(super) fn advance(&self, until: f64, steps: u64, looks: bool) {
        RootCommand::Advance(until, steps, looks).give(&*self.0);
    }
}
