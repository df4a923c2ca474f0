//! Free flight of particles between collisions: straight lines, parabolas under gravity, or in a
//! uniform shear flow.

use std::fmt::Debug;

use crate::images::Shear;
use crate::invalid::InvalidValue;
use crate::space::Space;

/// Law of free flight between contacts: without force, under uniform gravity, or in a uniform shear
/// flow.
///
/// A uniform field cancels in the relative motion of a pair, so the prediction of a collision does
/// not depend on it; only [`Field::move_particle`] does.
pub trait Field<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// True if particles fly along straight lines.
    const FREE: bool;

    /// True in a uniform shear flow, where velocities are peculiar: relative to the flow.
    const SHEARED: bool = false;

    /// Returns the shear rate of the flow \[1/time\]; zero without shear.
    #[inline(always)]
    fn shear_rate(&self) -> f64 {
        0.0
    }

    /// Returns the uniform acceleration of all particles \[length/time^2\]; zero in free flight.
    fn acceleration(&self) -> S::Vector;

    /// Moves one particle in free flight by the time `duration` \[time\]: position and velocity.
    fn move_particle(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64);
}

/// Free flight without force, along straight lines at constant velocity.
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

/// Uniform gravity: parabolic flight with one acceleration for all particles, places and times; by
/// default none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gravity<S: Space> {
    acceleration: S::Vector,
}

impl<S: Space> Gravity<S> {
    /// Creates uniform gravity from an acceleration \[length/time^2\].
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

/// Uniform shear flow u = (a y, 0): straight flight, with particle velocities relative to the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheared {
    rate: f64,
}

impl Sheared {
    /// Creates a uniform shear flow with the shear rate a \[1/time\].
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

    /// Moves one particle in free flight through the shear flow. Its velocity in the frame of the
    /// box stays constant; the flow at its position changes.
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
