//! Orders of the Sonine expansion: their range, the norms of the polynomials and the tolerance of
//! the integration.

use stosszahl_model::InvalidValue;

use super::super::error::TheoryError;
use super::super::integrate::Tolerance;

/// Relative and absolute tolerance of each integration step.
pub(super) const TOLERANCE: Tolerance = Tolerance {
    relative: 1e-6,
    absolute: 1e-8,
};

/// Checks that the Sonine order is from 1 to `most`; `allowed` states this range in the error.
pub(super) fn check_orders(
    orders: usize,
    most: usize,
    allowed: &'static str,
) -> Result<(), TheoryError> {
    let name = "order of the Sonine expansion";
    let is_offered = (1..=most).contains(&orders);
    InvalidValue::require(is_offered, name, orders as f64, allowed)?;
    Ok(())
}

/// Computes the norms of Laguerre's polynomials, `<S_p^2> = Gamma(p + 1 + alpha)/(p! Gamma(1 +
/// alpha))`, for p up to `most`.
pub(super) fn norms(alpha: f64, most: usize) -> Vec<f64> {
    let mut norms = vec![1.0];
    for p in 1..=most {
        norms.push(norms[p - 1] * (p as f64 + alpha) / p as f64);
    }
    norms
}
