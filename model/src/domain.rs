//! Simulation box of a gas, periodic along some or all of its axes, at rest or in a shear flow.

use serde::{Deserialize, Serialize};

use crate::images::{Images, Shear};
use crate::invalid::InvalidValue;
use crate::space::{Space, Vector};

/// Rectangular simulation box from the origin to `lengths`, periodic along some of its axes, or
/// all.
///
/// Where periodic images are, and how fast they move, is known to [`Images`]. Walls at the faces of
/// the other axes are described by [`crate::walls::Walls`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Domain<S: Space> {
    images: Images<S>,
}

impl<S: Space> Domain<S> {
    /// Creates a box with the given side lengths \[length\] that is periodic along all axes.
    ///
    /// # Errors
    /// [`InvalidValue`] unless all are positive and finite.
    pub fn periodic(lengths: S::Vector) -> Result<Self, InvalidValue> {
        Self::new(lengths, [true; 3])
    }

    /// Creates a box with the given side lengths \[length\] that is periodic along some of its
    /// axes.
    pub(crate) fn new(lengths: S::Vector, periodic: [bool; 3]) -> Result<Self, InvalidValue> {
        for axis in 0..S::DIMENSION {
            InvalidValue::unless_positive("side of the box", lengths[axis])?;
        }
        let images = Images::new(lengths, periodic);
        Ok(Self { images })
    }

    /// Returns this box in a uniform shear flow (Lees-Edwards boundary), or without flow for
    /// `None`.
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

    /// Returns this box at a time of a uniform shear flow, whose state is given at time 0; without
    /// flow for `None`.
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

    /// Returns the map of periodic images of the box.
    #[inline]
    pub fn images(&self) -> &Images<S> {
        &self.images
    }

    /// Advances the periodic images by a time \[time\]: in a shear flow the boxes above and below
    /// slide.
    pub fn advance(&mut self, duration: f64) {
        self.images.advance(duration);
    }

    /// Returns true if the box is periodic along an axis.
    #[inline]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.images.is_periodic(axis)
    }

    /// Returns the side lengths of the box \[length\].
    #[inline]
    pub fn lengths(&self) -> S::Vector {
        self.images.lengths()
    }

    /// Returns the area or volume of the box \[length^D\].
    pub fn volume(&self) -> f64 {
        (0..S::DIMENSION).map(|axis| self.lengths()[axis]).product()
    }

    /// Returns a position wrapped into the box: every coordinate in `[0, length)` along the
    /// periodic axes.
    #[inline]
    pub fn wrap(&self, position: S::Vector) -> S::Vector {
        self.images.wrap(position)
    }

    /// Returns the shortest vector from the position `second` to the position `first`, over all
    /// periodic images \[length\].
    #[inline]
    pub fn displacement(&self, first: S::Vector, second: S::Vector) -> S::Vector {
        self.images.nearest(first - second)
    }

    /// Returns the shortest distance between two positions, over all periodic images \[length\].
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
