//! Errors of gases without positions.

use stosszahl_model::format_short;

/// Reason why a gas cannot be made or advanced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HomogeneousError {
    /// Particles that stick in a program compiled without them.
    #[error(
        "this program has no particles that stick; it was compiled without the feature \"aggregation\""
    )]
    NoAggregation,
    /// A number is out of range.
    #[error(transparent)]
    Invalid(#[from] stosszahl_model::InvalidValue),
    /// The physics needs positions, which the gas lacks.
    #[error("{what} in a gas without positions; allowed: {allowed}")]
    Unfit {
        /// Property found.
        what: &'static str,
        /// Allowed physics.
        allowed: &'static str,
    },
    /// The bytes are no checkpoint of this gas.
    #[error("the bytes are no checkpoint of this gas: {0}")]
    Checkpoint(String),
    /// A pair met more often than its bound allows: an error of the selection.
    #[error(
        "a pair's collision rate, {rate}, exceeds the bound by which it was selected, {bound}, at time {time}",
        rate = format_short(*rate), bound = format_short(*bound), time = format_short(*time)
    )]
    BoundExceeded {
        /// Rate of the pair \[1/time\].
        rate: f64,
        /// Bound of the rate \[1/time\].
        bound: f64,
        /// Time at which it was found.
        time: f64,
    },
}
