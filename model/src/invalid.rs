//! Error of constructors that are given a number out of range.

use crate::format_short;

/// Number that a law, a size or a box cannot have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity} is {found}; allowed: {allowed}", found = format_short(*found))]
#[non_exhaustive]
pub struct InvalidValue {
    /// Name of the quantity.
    pub quantity: &'static str,
    /// Value found.
    pub found: f64,
    /// Allowed values.
    pub allowed: &'static str,
}

impl InvalidValue {
    /// Creates the error, for other crates.
    pub fn new(quantity: &'static str, found: f64, allowed: &'static str) -> Self {
        Self {
            quantity,
            found,
            allowed,
        }
    }

    /// Returns the number `found` if it is allowed, an error otherwise.
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

    /// Returns a finite number above zero, an error otherwise.
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
