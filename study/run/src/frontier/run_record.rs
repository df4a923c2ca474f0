//! Record of one run of a frontier, as its journal holds it.

use serde::{Deserialize, Serialize};

/// Values and work of one run of a setting, by which a frontier ranks it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunResult {
    /// Values of all quantities of the frontier, in their order; NaN where the run has none.
    pub values: Vec<f64>,
    /// Number of pair collisions; of simulators where simulators collide.
    pub collisions: u64,
    /// Number of steps of a Monte Carlo engine; 0 for exact dynamics.
    pub steps: u64,
    /// Memory of the engine \[bytes\].
    pub bytes: usize,
    /// CPU time of the start, the engine and its measurements \[s\].
    pub core_seconds: f64,
    /// Wall time of the start, the engine and its measurements \[s\].
    pub wall_seconds: f64,
}

/// Result of a run, or the reason why it failed.
pub(crate) type Found = Result<RunResult, String>;

/// Result of one run, and its cost.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RunRecord {
    /// Result of the run, or the reason why it failed.
    pub(crate) found: Found,
    /// CPU time that the run took from the budget, also if it failed \[s\].
    pub(crate) spent: f64,
}
