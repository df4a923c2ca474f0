//! Motion of particles between collisions: straight, parabolic, or in a shear flow.

use std::fmt::Debug;

use crate::images::Shear;
use crate::invalid::InvalidValue;
use crate::space::Space;

/// Motion of particles between contacts.
///
/// A uniform field cancels in the relative motion of a pair, so the prediction of a collision does
/// not depend on it; only [`Field::move_particle`] does.
pub trait Field<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// True where flight is along straight lines.
    const FREE: bool;

    /// True in uniform shear flow, where velocities are peculiar: relative to the flow.
    const SHEARED: bool = false;

    /// Shear rate of the flow \[1/time\]; zero where there is none.
    #[inline(always)]
    fn shear_rate(&self) -> f64 {
        0.0
    }

    /// Uniform acceleration \[length/time^2\]; zero in free flight.
    fn acceleration(&self) -> S::Vector;

    /// Moves one particle by the time `duration`.
    fn move_particle(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64);
}

/// Straight lines at constant speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Free;

impl<S: Space> Field<S> for Free {
    const FREE: bool = true;

    #[inline(always)]
    fn acceleration(&self) -> S::Vector {
        S::Vector::default()
    }

    #[inline]
    fn move_particle(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64) {
        *position += *velocity * duration;
    }
}

/// Parabolic flight: one acceleration for all particles, at all places and times; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gravity<S: Space> {
    acceleration: S::Vector,
}

impl<S: Space> Gravity<S> {
    /// Creates a field from an acceleration \[length/time^2\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless its components are finite.
    pub fn new(acceleration: S::Vector) -> Result<Self, InvalidValue> {
        for axis in 0..S::DIMENSION {
            let found = acceleration[axis];
            InvalidValue::require(found.is_finite(), "acceleration", found, "finite numbers")?;
        }
        Ok(Self { acceleration })
    }
}

impl<S: Space> Field<S> for Gravity<S> {
    const FREE: bool = false;

    #[inline(always)]
    fn acceleration(&self) -> S::Vector {
        self.acceleration
    }

    #[inline]
    fn move_particle(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64) {
        let gained = self.acceleration * duration;
        *position += (*velocity + gained * 0.5) * duration;
        *velocity += gained;
    }
}

/// Straight lines through a uniform shear flow u = (a y, 0), for velocities relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheared {
    rate: f64,
}

impl Sheared {
    /// Creates a flow with a shear rate a \[1/time\].
    ///
    /// # Errors
    /// [`InvalidValue`] if the rate is zero or not finite.
    pub fn new(rate: f64) -> Result<Self, InvalidValue> {
        let Shear { rate, .. } = Shear::new(rate)?;
        Ok(Self { rate })
    }
}

impl<S: Space> Field<S> for Sheared {
    const FREE: bool = true;
    const SHEARED: bool = true;

    #[inline(always)]
    fn shear_rate(&self) -> f64 {
        self.rate
    }

    #[inline(always)]
    fn acceleration(&self) -> S::Vector {
        S::Vector::default()
    }

    /// Advances a particle. Neither the velocity in the frame of the box nor that along the
    /// gradient changes; the flow at the particle does.
    #[inline]
    fn move_particle(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64) {
        let mut fixed = *velocity;
        fixed[0] += self.rate * position[1];
        *position += fixed * duration;
        velocity[0] -= self.rate * (velocity[1] * duration);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Plane, Vector};
    use nalgebra::vector;

    /// m v^2/2 - m a . r does not change in flight: a few roundings.
    #[test]
    fn flight_keeps_the_energy() {
        let field = Gravity::<Plane>::new(vector![0.3, -2.0]).expect("finite");
        let (mut position, mut velocity) = (vector![1.0, 2.0], vector![-0.5, 1.5]);
        let energy = |position: nalgebra::Vector2<f64>, velocity: nalgebra::Vector2<f64>| {
            let down = Field::<Plane>::acceleration(&field);
            0.5 * velocity.square() - down.inner(&position)
        };
        let start = energy(position, velocity);
        for step in 0..100 {
            field.move_particle(&mut position, &mut velocity, 0.01 * f64::from(step));
        }
        let scale = position.norm() * 2.0 + velocity.norm_squared();
        assert!((energy(position, velocity) - start).abs() < 1e-14 * scale);
        assert!(Gravity::<Plane>::new(vector![f64::NAN, 0.0]).is_err());
    }
}
