//! Commands that the root process sends to the other processes of a domain-decomposed gas.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::decomposition::{Ranks, ShardLocation, broadcast, to_bytes};

/// Command of the root process, which all other processes of a decomposed gas execute.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum RootCommand {
    /// Advance to a time \[time\], for at most a number of steps; `true` if collisions are
    /// observed.
    Advance(f64, u64, bool),
    /// Gather all tiles in the root process.
    Unite,
    /// Add the particles of each process to the reduction of this name, given empty as bytes; with
    /// neighbours up to a distance \[length\], if given.
    AddUp(Option<f64>, String, Vec<u8>),
    /// Restart the measurement of displacements from zero.
    DisplacementTracking,
    /// Sum the squared displacements of all simulators.
    Ways,
    /// Write the tiles of each process into a shard whose file name begins with this stem.
    Write(String, ShardLocation),
    /// End the service of this gas.
    End,
}

impl RootCommand {
    pub(super) fn give(&self, ranks: &dyn Ranks) {
        broadcast(ranks, to_bytes(self));
    }
}

/// Other processes of a decomposed gas, as the root process commands them.
pub(super) struct Others(pub(super) Arc<dyn Ranks>);

impl Others {
    /// Commands the other processes to advance to a time \[time\], for at most `steps` steps;
    /// `looks` is true if collisions are observed.
    pub(super) fn advance(&self, until: f64, steps: u64, looks: bool) {
        RootCommand::Advance(until, steps, looks).give(&*self.0);
    }
}
