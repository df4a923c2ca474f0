//! Pauses between two steps.

/// Pause between two time steps, in the middle of a free flight, where all simulators have the same
/// time. If the advance continues to the same end time, the next step equals the step of a run
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
