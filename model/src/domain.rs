//! Simulation box of a gas, periodic along some or all of its axes.

use serde::{Deserialize, Serialize};

use crate::images::{Images, Shear};
use crate::invalid::InvalidValue;
use crate::space::{Space, Vector};

/// A rectangular box from the origin to `lengths`, periodic along some of its axes, or all.
///
/// Where periodic images are, and how fast they move, is known to [`Images`]. Walls at the faces of
/// the other axes are described by [`crate::walls::Walls`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Domain<S: Space> {
    images: Images<S>,
}

impl<S: Space> Domain<S> {
    /// Creates a box with the given side lengths \[length\] that is periodic in every direction.
    ///
    /// # Errors
    /// [`InvalidValue`] unless all are positive and finite.
    pub fn periodic(lengths: S::Vector) -> Result<Self, InvalidValue> {
        Self::new(lengths, [true; 3])
    }

    /// Creates a box that is periodic along some of its axes.
    pub(crate) fn new(lengths: S::Vector, periodic: [bool; 3]) -> Result<Self, InvalidValue> {
        for axis in 0..S::DIMENSION {
            InvalidValue::unless_positive("side of the box", lengths[axis])?;
        }
        let images = Images::new(lengths, periodic);
        Ok(Self { images })
    }

    /// Returns this box in uniform shear flow.
    ///
    /// # Errors
    /// [`InvalidValue`] unless the box is periodic along the flow and its gradient.
    pub fn sheared(self, shear: Option<Shear>) -> Result<Self, InvalidValue> {
        if let Some(shear) = shear {
            let is_periodic = self.is_periodic(0) && self.is_periodic(1);
            let allowed = "in a box that is periodic along the first two axes";
            InvalidValue::require(is_periodic, "shear rate", shear.rate, allowed)?;
        }
        let images = self.images.sheared(shear);
        Ok(Self { images })
    }

    /// Returns this box at a time of a uniform shear flow, which is given as it is at time 0.
    ///
    /// # Errors
    /// As [`Self::sheared`], and for a rate that is 0 or not finite.
    pub fn in_flow(self, shear: Option<Shear>, time: f64) -> Result<Self, InvalidValue> {
        if let Some(shear) = shear {
            Shear::new(shear.rate)?;
        }
        let mut sheared = self.sheared(shear)?;
        sheared.advance(time);
        Ok(sheared)
    }

    /// Returns the map of periodic images.
    #[inline]
    pub fn images(&self) -> &Images<S> {
        &self.images
    }

    /// Moves the images by a time: the boxes above and below slide under shear.
    pub fn advance(&mut self, duration: f64) {
        self.images.advance(duration);
    }

    /// Returns true if the box is periodic along an axis.
    #[inline]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.images.is_periodic(axis)
    }

    /// Side lengths \[length\].
    #[inline]
    pub fn lengths(&self) -> S::Vector {
        self.images.lengths()
    }

    /// Area or volume \[length^D\].
    pub fn volume(&self) -> f64 {
        (0..S::DIMENSION).map(|axis| self.lengths()[axis]).product()
    }

    /// Returns the image of a position with every component in `[0, length)`, along the axes that
    /// are periodic.
    #[inline]
    pub fn wrap(&self, position: S::Vector) -> S::Vector {
        self.images.wrap(position)
    }

    /// Returns the shortest vector from the second position to the first, over all periodic images
    /// \[length\].
    #[inline]
    pub fn displacement(&self, first: S::Vector, second: S::Vector) -> S::Vector {
        self.images.nearest(first - second)
    }

    /// Shortest distance between two positions, over all periodic images \[length\].
    pub fn distance(&self, first: S::Vector, second: S::Vector) -> f64 {
        self.displacement(first, second).square().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;
    use nalgebra::vector;

    #[test]
    fn wraps_into_the_half_open_box() {
        let domain = Domain::<Plane>::periodic(vector![2.0, 3.0]).expect("positive");
        assert_eq!(domain.wrap(vector![2.0, -0.5]), vector![0.0, 2.5]);
        assert_eq!(domain.wrap(vector![-1e-300, 9.0]), vector![0.0, 0.0]);
        assert!(
            (domain.distance(vector![0.1, 0.1], vector![1.9, 2.9]) - 0.08_f64.sqrt()).abs() < 1e-15
        );
        assert!(Domain::<Plane>::periodic(vector![1.0, 0.0]).is_err());
    }
}
