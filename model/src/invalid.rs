//! What constructors refuse.

use crate::brief;

/// A number that a law, a size or a box cannot have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity} is {found}; allowed: {allowed}", found = brief(*found))]
#[non_exhaustive]
pub struct Invalid {
    /// What is wrong.
    pub quantity: &'static str,
    /// What was found.
    pub found: f64,
    /// What is allowed.
    pub allowed: &'static str,
}

impl Invalid {
    /// The error, for other crates.
    pub fn new(quantity: &'static str, found: f64, allowed: &'static str) -> Self {
        Self {
            quantity,
            found,
            allowed,
        }
    }

    /// Passes a number on that lies where it may, refuses it otherwise.
    ///
    /// # Errors
    /// [`Invalid`] unless `is_allowed`.
    pub fn unless(
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

    /// A finite number above zero.
    ///
    /// # Errors
    /// [`Invalid`] for all others.
    pub fn unless_positive(quantity: &'static str, found: f64) -> Result<f64, Self> {
        Self::unless(
            found > 0.0 && found.is_finite(),
            quantity,
            found,
            "finite numbers above 0",
        )
    }
}
