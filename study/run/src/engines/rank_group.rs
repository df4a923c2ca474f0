//! Group of processes over which gases are decomposed, and the messages by which the root process
//! begins each gas.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use stosszahl_dsmc::{Ranks, from_first};
use stosszahl_model::to_bytes;

use crate::plan::EnginePlan;

/// Group of processes over which the gases of a sweep point are decomposed, as used by the root
/// process.
#[derive(Clone)]
pub struct RankGroup {
    ranks: Arc<dyn Ranks>,
    point: usize,
}

/// Message of the root process: the gas that all processes hold next.
#[derive(Serialize, Deserialize)]
pub(crate) struct Call {
    /// Index of the sweep point.
    pub(crate) point: usize,
    /// Number of the replica whose gas is held.
    pub(crate) replica: u64,
    /// Name of the engine whose gas is held.
    pub(crate) engine: String,
}

/// Sends a message of the root process to all other processes; `None` ends their part of the run.
pub(crate) fn send_call(ranks: &dyn Ranks, call: Option<&Call>) {
    from_first(ranks, to_bytes(&call));
}

impl RankGroup {
    /// Creates the group for a sweep point with the given index.
    pub(crate) fn new(ranks: Arc<dyn Ranks>, point: usize) -> Self {
        Self { ranks, point }
    }

    /// Returns the number of processes over which a gas is decomposed.
    pub(crate) fn size(&self) -> usize {
        self.ranks.size()
    }

    /// Tells the other processes to hold their parts of an engine's gas, and returns the transport
    /// between all processes.
    pub(crate) fn call(&self, replica: u64, engine: &EnginePlan) -> &Arc<dyn Ranks> {
        let (point, engine) = (self.point, engine.name.to_owned());
        let call = Call {
            point,
            replica,
            engine,
        };
        send_call(&*self.ranks, Some(&call));
        &self.ranks
    }
}
