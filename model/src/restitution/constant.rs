//! Constant restitution: one coefficient of normal restitution for all approach speeds.

use super::normal_law::Restitution;
use crate::invalid::InvalidValue;

/// Law of constant restitution: one coefficient for all approach speeds. [`Constant::ELASTIC`] is
/// the elastic gas, which needs no law of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(f64);

impl Constant {
    /// Law of elastic contacts: coefficient of restitution 1.
    pub const ELASTIC: Self = Self(1.0);

    /// Creates the law of constant restitution with a coefficient.
    ///
    /// # Errors
    /// [`InvalidValue`] outside [0, 1].
    pub fn new(coefficient: f64) -> Result<Self, InvalidValue> {
        let allowed = (0.0..=1.0).contains(&coefficient);
        InvalidValue::require(allowed, "coefficient of restitution", coefficient, "0 to 1")
            .map(Self)
    }

    /// Returns the coefficient of restitution, in \[0, 1\].
    pub fn coefficient(self) -> f64 {
        self.0
    }
}

impl Restitution for Constant {
    #[inline]
    fn normal_restitution(&self, _approach: f64) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_lies_between_zero_and_one() {
        let error = Constant::new(1.1).expect_err("too large");
        assert_eq!(
            error.to_string(),
            "coefficient of restitution is 1.1; allowed: 0 to 1"
        );
        assert!(Constant::new(f64::NAN).is_err());
        assert_eq!(
            Constant::new(0.0).expect("allowed").normal_restitution(1.0),
            0.0
        );
    }
}
