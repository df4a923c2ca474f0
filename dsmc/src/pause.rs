//! Pauses between two steps.

/// A pause between two steps, in the middle of the flight from the one to the other. The gas is whole there; what goes on to
/// the same time takes the next step as if there had been none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pause {
    /// The time that the advance was to reach.
    pub(crate) until: f64,
    /// The time at the end of the last step.
    pub(crate) time: f64,
    /// Length of the next step.
    pub(crate) step: f64,
}
