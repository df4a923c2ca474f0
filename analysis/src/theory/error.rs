//! Errors of the kinetic theory.

use stosszahl_model::Invalid;

/// Why a curve cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TheoryError {
    /// A number out of range.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The integration cannot go on.
    #[error(
        "the integration stopped at {at} with steps of {step}: the solution is not smooth there"
    )]
    Integration {
        /// Where.
        at: f64,
        /// Last step tried.
        step: f64,
    },
}
