//! Flight between collisions.

use std::fmt::Debug;

use crate::space::Space;

/// How a particle moves while it touches nothing.
///
/// A uniform field cancels in the relative motion of a pair, so the prediction of a collision does
/// not depend on it; only [`Field::drift`] does.
pub trait Field<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// Moves one particle by the time `duration`.
    fn drift(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64);
}

/// Straight lines at constant speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Free;

impl<S: Space> Field<S> for Free {
    #[inline]
    fn drift(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64) {
        *position += *velocity * duration;
    }
}
