//! Delta model: restitution that adds a speed at each contact, so that contacts dissipate and heat.

use super::normal_law::{Restitution, Separation};
use crate::invalid::InvalidValue;

/// Delta model: constant restitution r with a speed that every contact adds. A pair that approaches
/// at the normal speed g separates at `r g + 2 Delta`.
///
/// It models the vertical shaking of a shallow layer, seen from above: R. Brito, D. Risso & R.
/// Soto, *Physical Review E* **87**, 022209 (2013), doi:10.1103/PhysRevE.87.022209. Without walls
/// or bath the gas reaches a steady temperature proportional to `m Delta^2`.
///
/// ```
/// use stosszahl_model::{DeltaModel, Restitution};
/// let law = DeltaModel::new(0.8, 0.05).expect("a law");
/// assert_eq!(law.separation([0, 0], 1.0).speed(1.0), 0.9);
/// assert_eq!(law.separation([0, 0], 0.0).speed(0.0), 0.1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaModel {
    coefficient: f64,
    delta: f64,
}

impl DeltaModel {
    /// Creates a Delta model with a coefficient r and a speed Delta \[length/time\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless r is in \[0, 1\] and Delta is finite and not negative.
    pub fn new(coefficient: f64, delta: f64) -> Result<Self, InvalidValue> {
        let allowed = (0.0..=1.0).contains(&coefficient);
        InvalidValue::require(allowed, "coefficient of restitution", coefficient, "0 to 1")?;
        let allowed = delta >= 0.0 && delta.is_finite();
        InvalidValue::require(
            allowed,
            "added speed Delta",
            delta,
            "0 or a finite number above it",
        )?;
        Ok(Self { coefficient, delta })
    }

    /// Returns the coefficient r: the fraction of the approach speed that is kept.
    pub fn coefficient(self) -> f64 {
        self.coefficient
    }

    /// Returns the speed Delta of the model \[length/time\]; contacts add twice this to the normal
    /// speed of separation.
    pub fn delta(self) -> f64 {
        self.delta
    }
}

impl Restitution for DeltaModel {
    /// Returns the ratio of the normal speeds after and before a contact, `r + 2 Delta/g`; infinite
    /// at g = 0.
    #[inline]
    fn normal_restitution(&self, approach: f64) -> f64 {
        self.coefficient + 2.0 * self.delta / approach
    }

    #[inline]
    fn separation(&self, _kinds: [u32; 2], _approach: f64) -> Separation {
        Separation {
            coefficient: self.coefficient,
            added_speed: 2.0 * self.delta,
        }
    }

    fn max_added_speed(&self) -> f64 {
        2.0 * self.delta
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Law, PerPair};

    #[test]
    fn speeds_below_zero_or_without_bound_are_refused() {
        for delta in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(DeltaModel::new(0.8, delta).is_err(), "{delta}");
        }
        assert!(DeltaModel::new(1.1, 0.1).is_err());
    }

    #[test]
    fn a_law_chosen_at_run_time_adds_the_same_speed() {
        let delta = DeltaModel::new(0.8, 0.05).expect("a law");
        let law = Law::from(delta);
        assert_eq!(law.separation([0, 0], 0.3), delta.separation([0, 0], 0.3));
        assert_eq!(law.max_added_speed(), 0.1);
        assert_eq!((law.constant(), law.delta()), (None, Some(delta)));
        let elastic = Law::ELASTIC;
        let pairs =
            PerPair::new(2, vec![elastic.clone(), law.clone(), law, elastic]).expect("pairs");
        assert_eq!(pairs.separation([1, 0], 0.3).added_speed, 0.1);
        assert_eq!(pairs.separation([1, 1], 0.3).added_speed, 0.0);
        assert_eq!(pairs.max_added_speed(), 0.1);
    }
}
