//! What can go wrong with a gas without positions.

use stosszahl_model::brief;

/// Why a gas cannot be made or cannot go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GasError {
    /// A number that a law, a size or a gas cannot have.
    #[error(transparent)]
    Invalid(#[from] stosszahl_model::Invalid),
    /// Physics that a gas without positions does not have.
    #[error("{what} in a gas without positions; allowed: {allowed}")]
    Unfit {
        /// What was found.
        what: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Bytes that are no checkpoint of this gas.
    #[error("the bytes are no checkpoint of this gas: {0}")]
    Checkpoint(String),
    /// A pair met more often than its bound allows: an error of the selection.
    #[error(
        "a pair's collision rate, {rate}, exceeds the bound by which it was selected, {bound}, at time {time}",
        rate = brief(*rate), bound = brief(*bound), time = brief(*time)
    )]
    BoundExceeded {
        /// Its rate.
        rate: f64,
        /// The bound.
        bound: f64,
        /// When.
        time: f64,
    },
}
