//! Errors of the kinetic theory.

use stosszahl_model::InvalidValue;

/// Reason why a curve cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TheoryError {
    /// A number out of range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The integration failed.
    #[error(
        "the integration stopped at {at} with steps of {step}: the solution is not smooth there"
    )]
    Integration {
        /// Value of the independent variable.
        at: f64,
        /// Length of the last step tried.
        step: f64,
    },
}
