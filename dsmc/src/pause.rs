//! Pause of a DSMC run between two time steps, and resumption to the same bytes.

/// Pause of a run between two time steps, in the middle of a free flight, where all simulators have
/// the same time. If the advance continues to the same end time, the next step equals the step of a
/// run without the pause.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pause {
    /// End time of the advance that was paused \[time\].
    pub(crate) until: f64,
    /// Time of the gas at the end of the last time step \[time\].
    pub(crate) time: f64,
    /// Length of the next time step \[time\].
    pub(crate) step: f64,
}
