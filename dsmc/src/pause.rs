//! Pauses between two steps.

/// Pause between two steps, in the middle of the flight from one to the other. The gas is
/// consistent there. If the advance continues to the same time, the next step is that of a run
/// without the pause.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pause {
    /// End time of the advance that was paused.
    pub(crate) until: f64,
    /// Time at the end of the last step.
    pub(crate) time: f64,
    /// Length of the next step.
    pub(crate) step: f64,
}
