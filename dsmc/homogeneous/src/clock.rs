//! Clock and counters of a run, and the reason for which it stopped.

use serde::{Deserialize, Serialize};

/// Counters of the work of a run; no number depends on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SelectionCounters {
    /// Number of proposals, null ones included.
    pub proposals: u64,
    /// Number of candidate pairs tested.
    pub trials: u64,
    /// Number of pair contacts, whatever the outcome.
    pub collisions: u64,
    /// Number of rebuilds of all bounds.
    pub rebuilds: u64,
    /// Kinetic energy lost in bounces \[energy\].
    pub energy_lost: f64,
}

/// Reason for which [`HomogeneousEngine::advance`](super::HomogeneousEngine::advance) returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The time was reached.
    Time,
    /// The number of collisions was reached.
    Collisions,
    /// No further collisions are possible: one particle is left, or all are at rest. A finite time
    /// is reached.
    Still,
    /// Pause requested by
    /// [`HomogeneousEngine::set_pause_flag`](super::HomogeneousEngine::set_pause_flag).
    Paused,
    /// The advance was interrupted:
    /// [`HomogeneousEngine::set_stop_flag`](super::HomogeneousEngine::set_stop_flag).
    Interrupted,
}

/// Position of a run in time and in its random streams.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Current time \[time\].
    pub time: f64,
    /// Number of advances so far; each has its own random stream.
    pub advances: u64,
    /// Number of collisions since the bounds were rebuilt.
    pub since: u64,
    /// True if the bounds must be rebuilt before the next collision.
    pub outdated: bool,
}
