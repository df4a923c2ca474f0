//! Threshold model: constant restitution above a threshold of the approach speed, elastic contacts
//! below it.

use super::normal_law::Restitution;
use crate::invalid::InvalidValue;

/// Threshold model: constant restitution r for normal approach speeds from a threshold g* on;
/// slower contacts are elastic.
///
/// The simplest law without inelastic collapse: E. Ben-Naim, S. Y. Chen, G. D. Doolen & S. Redner,
/// *Physical Review Letters* **83**, 4069 (1999), doi:10.1103/PhysRevLett.83.4069. A gas of
/// particles of mass m with Maxwellian velocities at temperature T loses the share
/// `(1 + x) exp(-x)`, `x = m g*^2/(4 T)`, of the energy that it would lose with r at all speeds.
///
/// ```
/// use stosszahl_model::{Restitution, ThresholdModel};
/// let law = ThresholdModel::new(0.8, 0.01).expect("a law");
/// assert_eq!(law.normal_restitution(0.02), 0.8);
/// assert_eq!(law.normal_restitution(0.009), 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThresholdModel {
    coefficient: f64,
    threshold: f64,
}

impl ThresholdModel {
    /// Creates a threshold model with a coefficient r and a threshold g* \[length/time\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless r is in \[0, 1\] and g* is finite and not negative.
    pub fn new(coefficient: f64, threshold: f64) -> Result<Self, InvalidValue> {
        let is_allowed = (0.0..=1.0).contains(&coefficient);
        InvalidValue::require(
            is_allowed,
            "coefficient of restitution",
            coefficient,
            "0 to 1",
        )?;
        let is_allowed = threshold >= 0.0 && threshold.is_finite();
        InvalidValue::require(
            is_allowed,
            "threshold of the approach speed",
            threshold,
            "0 or a finite number above it",
        )?;
        Ok(Self {
            coefficient,
            threshold,
        })
    }
}

impl Restitution for ThresholdModel {
    #[inline]
    fn normal_restitution(&self, approach: f64) -> f64 {
        if approach < self.threshold {
            1.0
        } else {
            self.coefficient
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Law;

    #[test]
    fn thresholds_below_zero_or_without_bound_are_refused() {
        for threshold in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(ThresholdModel::new(0.8, threshold).is_err(), "{threshold}");
        }
        assert!(ThresholdModel::new(1.1, 0.1).is_err());
    }

    #[test]
    fn a_law_chosen_at_run_time_has_the_same_threshold() {
        let law = Law::from(ThresholdModel::new(0.8, 0.5).expect("a law"));
        assert_eq!(
            [0.4, 0.5, 0.6].map(|speed| law.normal_restitution(speed)),
            [1.0, 0.8, 0.8]
        );
        assert_eq!((law.constant(), law.coefficient(0.6)), (None, Some(0.8)));
        assert!(!law.is_elastic());
    }
}
