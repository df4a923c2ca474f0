//! The box in which the gas lives.

use serde::{Deserialize, Serialize};

use crate::invalid::Invalid;
use crate::space::{Space, Vector};

/// A rectangular box from the origin to `lengths`, periodic along some of its axes, or all.
///
/// All wrapping and all minimum images of the project go through this type. What stands at the faces of the
/// other axes is described by [`crate::walls::Walls`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Domain<S: Space> {
    lengths: S::Vector,
    /// By axis; beyond the dimension, true.
    periodic: [bool; 3],
}

impl<S: Space> Domain<S> {
    /// A box with the given side lengths that is periodic in every direction.
    ///
    /// # Errors
    /// [`Invalid`] unless all are positive and finite.
    pub fn periodic(lengths: S::Vector) -> Result<Self, Invalid> {
        Self::new(lengths, [true; 3])
    }

    /// A box that is periodic along some of its axes.
    pub(crate) fn new(lengths: S::Vector, periodic: [bool; 3]) -> Result<Self, Invalid> {
        for axis in 0..S::DIMENSION {
            Invalid::unless_positive("side of the box", lengths[axis])?;
        }
        Ok(Self { lengths, periodic })
    }

    /// Whether the box is periodic along an axis.
    #[inline]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.periodic[axis]
    }

    /// Side lengths \[length\].
    pub fn lengths(&self) -> S::Vector {
        self.lengths
    }

    /// Area or volume \[length^D\].
    pub fn volume(&self) -> f64 {
        (0..S::DIMENSION).map(|axis| self.lengths[axis]).product()
    }

    /// The image of a position with every component in `[0, length)`, along the axes that are periodic.
    #[inline]
    pub fn wrap(&self, mut position: S::Vector) -> S::Vector {
        for axis in 0..S::DIMENSION {
            let length = self.lengths[axis];
            let x = position[axis];
            if !(0.0..length).contains(&x) && self.periodic[axis] {
                let inside = x.rem_euclid(length);
                // A tiny negative x rounds to the length itself, which is the origin's image.
                position[axis] = if inside < length { inside } else { 0.0 };
            }
        }
        position
    }

    /// The shortest vector from the second position to the first, over all periodic images.
    #[inline]
    pub fn displacement(&self, first: S::Vector, second: S::Vector) -> S::Vector {
        let mut difference = first - second;
        for axis in 0..S::DIMENSION {
            let length = self.lengths[axis];
            if self.periodic[axis] {
                difference[axis] -= length * (difference[axis] / length).round();
            }
        }
        difference
    }

    /// The distance between two positions, over all periodic images.
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
