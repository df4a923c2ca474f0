//! Errors of Monte Carlo runs of gases without positions.

use stosszahl_model::format_short;

/// Error of a gas without positions: why it cannot be created or advanced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HomogeneousError {
    /// Particles that aggregate are requested, but the program was compiled without the feature
    /// `aggregation`.
    #[error(
        "this program has no particles that stick; it was compiled without the feature \"aggregation\""
    )]
    NoAggregation,
    /// A number of the settings is outside its allowed range.
    #[error(transparent)]
    Invalid(#[from] stosszahl_model::InvalidValue),
    /// The particles have a property, such as roughness or a field, that a gas without positions
    /// cannot simulate.
    #[error("{what} in a gas without positions; allowed: {allowed}")]
    Unfit {
        /// Property of the particles that is not supported.
        what: &'static str,
        /// Properties that are allowed instead.
        allowed: &'static str,
    },
    /// The bytes given are not a checkpoint of this gas; the text says why.
    #[error("the bytes are no checkpoint of this gas: {0}")]
    Checkpoint(String),
    /// A pair is faster than the bound of its relative speed: an internal error of the pair
    /// selection.
    #[error(
        "a pair's relative speed, {speed}, exceeds the bound by which it was selected, {bound}, at time {time}",
        speed = format_short(*speed), bound = format_short(*bound), time = format_short(*time)
    )]
    BoundExceeded {
        /// Relative speed of the pair when it exceeded its bound \[length/time\].
        speed: f64,
        /// Bound of the relative speed by which the pair was selected \[length/time\].
        bound: f64,
        /// Time at which the exceeded bound was found \[time\].
        time: f64,
    },
}
