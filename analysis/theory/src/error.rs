//! Error type of the kinetic theory.

use stosszahl_model::InvalidValue;

/// Error of a computation in kinetic theory: invalid parameters, or a failed integration.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TheoryError {
    /// A parameter of the theory is out of its range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The integration of the differential equations failed.
    #[error(
        "the integration stopped at {at} with steps of {step}: the solution is not smooth there"
    )]
    Integration {
        /// Value of the independent variable at which the integration failed.
        at: f64,
        /// Length of the last integration step tried.
        step: f64,
    },
}
