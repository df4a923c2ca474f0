//! Commands of the process that drives a gas to those that hold parts of it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::decomposition::{Beside, Ranks, broadcast, write};

/// What the first process tells the others.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Command {
    /// Until when, for how many steps, and whether collisions are looked at.
    Advance(f64, u64, bool),
    /// The first process is to hold all.
    Unite,
    /// All are to add what they hold to the sum of this name, empty as it is; with neighbours up to a distance, if there is one.
    AddUp(Option<f64>, String, Vec<u8>),
    /// Displacements are followed from now on.
    Follow,
    /// All are to add up squared displacements.
    Ways,
    /// All are to write what they hold, into files with names that begin so.
    Write(String, Beside),
    /// The gas is let go of.
    End,
}

impl Command {
    pub(super) fn give(&self, ranks: &dyn Ranks) {
        broadcast(ranks, write(self));
    }
}

/// The processes that do what the first does with its gas.
pub(super) struct Others(pub(super) Arc<dyn Ranks>);

impl Others {
    /// Tells them to advance.
    pub(super) fn advance(&self, until: f64, steps: u64, looks: bool) {
        Command::Advance(until, steps, looks).give(&*self.0);
    }
}
