//! Error that a number is outside its allowed range, for constructors of laws, sizes and boxes.

use crate::format_short;

/// Error that a number of a law, a size or a box is outside its allowed range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity} is {found}; allowed: {allowed}", found = format_short(*found))]
#[non_exhaustive]
pub struct InvalidValue {
    /// Name of the quantity with the invalid value.
    pub quantity: &'static str,
    /// Invalid value that was given.
    pub found: f64,
    /// Description of the allowed values.
    pub allowed: &'static str,
}

impl InvalidValue {
    /// Creates the error that a quantity has an invalid value.
    pub fn new(quantity: &'static str, found: f64, allowed: &'static str) -> Self {
        Self {
            quantity,
            found,
            allowed,
        }
    }

    /// Returns the number `found` of a quantity if it is allowed, and the error that it is invalid
    /// otherwise.
    ///
    /// # Errors
    /// [`InvalidValue`] unless `is_allowed`.
    pub fn require(
        is_allowed: bool,
        quantity: &'static str,
        found: f64,
        allowed: &'static str,
    ) -> Result<f64, Self> {
        if is_allowed {
            Ok(found)
        } else {
            Err(Self::new(quantity, found, allowed))
        }
    }

    /// Returns the number `found` of a quantity if it is finite and above zero, and the error that
    /// it is invalid otherwise.
    ///
    /// # Errors
    /// [`InvalidValue`] for all others.
    pub fn unless_positive(quantity: &'static str, found: f64) -> Result<f64, Self> {
        Self::require(
            found > 0.0 && found.is_finite(),
            quantity,
            found,
            "finite numbers above 0",
        )
    }
}
