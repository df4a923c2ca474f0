//! Record of one run of a frontier, as stored in the journal.

use serde::{Deserialize, Serialize};

/// Result of one run of a setting: values of the quantities, and cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunResult {
    /// Values of all quantities of the frontier in their order; NaN for a value that the run lacks.
    pub values: Vec<f64>,
    /// Number of pair collisions; those of simulators in Monte Carlo.
    pub collisions: u64,
    /// Number of time steps of Monte Carlo; 0 for exact dynamics.
    pub steps: u64,
    /// Memory of the engine \[bytes\].
    pub bytes: usize,
    /// CPU time of the start, the engine and its measurements \[s\].
    pub core_seconds: f64,
    /// Wall time of the start, the engine and its measurements \[s\].
    pub wall_seconds: f64,
}

/// Result of a run, or the reason why it failed, in words.
pub(crate) type Found = Result<RunResult, String>;

/// Result of one run of a frontier, and the CPU time that it took.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RunRecord {
    /// Result of the run, or the reason why it failed.
    pub(crate) found: Found,
    /// CPU time that the run took \[s\], also if it failed.
    pub(crate) spent: f64,
}
