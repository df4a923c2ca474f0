//! What can go wrong with a gas without positions.

/// Why a gas cannot be made or cannot go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GasError {
    /// A number out of range.
    #[error("{name} is {value}: allowed is {allowed}")]
    BadNumber {
        /// Which.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A pair met more often than its bound allows: an error of the selection.
    #[error(
        "a pair's collision rate, {rate}, exceeds the bound by which it was selected, {bound}, at time {time}"
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
