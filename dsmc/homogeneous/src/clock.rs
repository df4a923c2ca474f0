//! Clock and work counters of a run without positions, and the reason for which an advance stopped.

use serde::{Deserialize, Serialize};

/// Work counters of a run without positions, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SelectionCounters {
    /// Number of proposed pairs, including null proposals, which name no pair.
    pub proposals: u64,
    /// Number of candidate pairs tested for acceptance.
    pub trials: u64,
    /// Number of pair contacts, including those after which particles merge or break.
    pub collisions: u64,
    /// Number of rebuilds of all bounds of speed and rate.
    pub rebuilds: u64,
    /// Kinetic energy dissipated in bounces \[energy\], without merging and breaking.
    pub energy_lost: f64,
}

/// Reason for which an advance ended:
/// [`HomogeneousEngine::advance`](super::HomogeneousEngine::advance) returns it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The requested time was reached.
    Time,
    /// The requested number of collisions was reached.
    Collisions,
    /// No further collisions are possible: one particle is left, or all are at rest. The clock then
    /// shows the requested time if it is finite.
    Still,
    /// A pause was requested by
    /// [`HomogeneousEngine::set_pause_flag`](super::HomogeneousEngine::set_pause_flag); the next
    /// advance continues.
    Paused,
    /// An interrupt broke off the advance:
    /// [`HomogeneousEngine::set_stop_flag`](super::HomogeneousEngine::set_stop_flag).
    Interrupted,
}

/// Clock of a run without positions: time, number of advances, and state of the bounds.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Current time of the gas \[time\].
    pub time: f64,
    /// Number of advances since the start; each has its own random stream.
    pub advances: u64,
    /// Number of collisions since the bounds of speed and rate were rebuilt.
    pub since: u64,
    /// True if the bounds of speed and rate must be rebuilt before the next collision.
    pub outdated: bool,
}
