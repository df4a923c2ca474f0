//! Clock and counters of a run, and the reason for which it stopped.

use serde::{Deserialize, Serialize};

/// Counters of the work of a run; no number depends on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Proposals, those of nothing included.
    pub proposals: u64,
    /// Pairs that were looked at.
    pub trials: u64,
    /// Pairs that met, whatever followed.
    pub collisions: u64,
    /// Times that all bounds were fitted anew.
    pub rebuilds: u64,
    /// Kinetic energy lost in bounces.
    pub energy_lost: f64,
}

/// Reason for which [`Engine::advance`](super::Engine::advance) returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The time is reached.
    Time,
    /// The number of collisions is reached.
    Collisions,
    /// Nothing will ever collide again: one particle is left, or all are at rest. A finite time is reached.
    Still,
    /// A pause was asked for: [`Engine::pause_on`](super::Engine::pause_on).
    Paused,
    /// It was broken off: [`Engine::stop_on`](super::Engine::stop_on).
    Interrupted,
}

/// Position of a run in time and in its random streams.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Current time \[time\].
    pub time: f64,
    /// Advances so far; each has its own random stream.
    pub advances: u64,
    /// Collisions since the bounds were fitted.
    pub since: u64,
    /// True if the bounds must be fitted before the next collision.
    pub outdated: bool,
}
