//! Processes that hold a gas together, and the calls by which the first of them begins it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use stosszahl_dsmc::{Ranks, from_first};

use crate::plan::EnginePlan;

/// Processes that hold the gases of a point together, as the root process sees them.
#[derive(Clone)]
pub struct RankGroup {
    ranks: Arc<dyn Ranks>,
    point: usize,
}

/// Call of the root process: the gas that all processes hold next.
#[derive(Serialize, Deserialize)]
pub(crate) struct Call {
    /// Number of the point.
    pub(crate) point: usize,
    /// Number of the replica.
    pub(crate) replica: u64,
    /// Name of the engine.
    pub(crate) engine: String,
}

/// Sends a call to all other processes; `None` ends their part of the run.
pub(crate) fn send_call(ranks: &dyn Ranks, call: Option<&Call>) {
    // Fails only for types without a length.
    from_first(ranks, postcard::to_stdvec(&call).unwrap_or_default());
}

impl RankGroup {
    /// Creates the group of a point, numbered in the order of the case.
    pub(crate) fn new(ranks: Arc<dyn Ranks>, point: usize) -> Self {
        Self { ranks, point }
    }

    /// Number of processes that hold a gas together.
    pub(crate) fn size(&self) -> usize {
        self.ranks.size()
    }

    /// Calls the other processes to hold the gas of an engine, and returns the transport between
    /// all processes.
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
