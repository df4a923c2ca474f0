//! Map of periodic images of a box: positions and velocities of the images of a particle, at rest
//! or sliding in a shear flow.
//!
//! Everything that wraps a position, looks for a nearest image or shifts a copy asks here. In a box
//! under uniform shear (Lees & Edwards, J. Phys. C 5, 1921 (1972), doi:10.1088/0022-3719/5/15/006)
//! the boxes above and below slide: their images are displaced along the first axis, and move
//! faster by the shear rate times the height of the box.

use serde::{Deserialize, Serialize};

use crate::invalid::InvalidValue;
use crate::space::Space;

/// Uniform shear flow u = (a y, 0), with the flow along the first axis and its gradient along the
/// second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shear {
    /// Shear rate a of the flow \[1/time\]; not zero.
    pub rate: f64,
    /// Displacement of the periodic image above along the first axis, from 0 to the width of the
    /// box \[length\].
    pub offset: f64,
}

impl Shear {
    /// Creates a shear flow whose periodic images are not yet displaced.
    ///
    /// # Errors
    /// [`InvalidValue`] if the rate is zero or not finite.
    pub fn new(rate: f64) -> Result<Self, InvalidValue> {
        let is_rate = rate.is_finite() && rate != 0.0;
        InvalidValue::require(is_rate, "shear rate", rate, "finite and not 0")?;
        Ok(Self { rate, offset: 0.0 })
    }
}

/// Displacement and relative velocity of a periodic image of a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Image<V> {
    /// Displacement of the image from the original particle \[length\].
    pub position: V,
    /// Velocity of the image relative to the original particle \[length/time\]; zero for peculiar
    /// velocities.
    pub velocity: V,
}

/// Returns the nearest periodic image of a difference of coordinates, for a period along one axis:
/// from -period/2 to period/2 \[length\].
#[inline(always)]
pub fn nearest(difference: f64, period: f64) -> f64 {
    difference - period * (difference / period).round()
}

/// Returns the periodic image of a coordinate in `[0, period)` \[length\].
#[inline(always)]
pub fn wrapped(x: f64, period: f64) -> f64 {
    if (0.0..period).contains(&x) {
        return x;
    }
    let inside = x.rem_euclid(period);
    // A tiny negative x rounds to the period itself, which is the image of the origin.
    if inside < period { inside } else { 0.0 }
}

/// Returns the nearest periodic image of the difference of two coordinates in a box, for a period
/// and its half \[length\]: without a branch or a division.
#[inline(always)]
pub fn nearest_inside(difference: f64, period: f64, half: f64) -> f64 {
    let image = if difference > half { period } else { 0.0 };
    let image = if difference < -half { -period } else { image };
    difference - image
}

/// Returns the periodic image of a coordinate in `[0, period]` \[length\]: a coordinate at the far
/// edge is unchanged.
pub fn wrapped_or_edge(x: f64, period: f64) -> f64 {
    if (0.0..=period).contains(&x) {
        return x;
    }
    let inside = x - period * (x / period).floor();
    if inside < period { inside } else { 0.0 }
}

/// Map of the periodic images of a box, with its sides, periodic axes and shear flow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Images<S: Space> {
    lengths: S::Vector,
    /// True for each axis along which the box is periodic, and for axes beyond the dimension.
    periodic: [bool; 3],
    /// Uniform shear flow, in which the boxes above and below slide; `None` without.
    shear: Option<Shear>,
}

impl<S: Space> Images<S> {
    /// Creates the map of periodic images of a box with the sides `lengths` \[length\], along its
    /// periodic axes.
    pub fn new(lengths: S::Vector, periodic: [bool; 3]) -> Self {
        Self {
            lengths,
            periodic,
            shear: None,
        }
    }

    /// Returns the map of periodic images in a uniform shear flow; without flow for `None`.
    #[must_use]
    pub fn sheared(self, shear: Option<Shear>) -> Self {
        Self { shear, ..self }
    }

    /// Returns the side lengths of the box \[length\].
    #[inline]
    pub fn lengths(&self) -> S::Vector {
        self.lengths
    }

    /// Returns true if the box has periodic images along an axis.
    #[inline]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.periodic[axis]
    }

    /// Returns the uniform shear flow in which the boxes above and below slide; `None` without.
    #[inline]
    pub fn shear(&self) -> Option<Shear> {
        self.shear
    }

    /// Advances the periodic images by a time \[time\]: in a shear flow the boxes above and below
    /// slide.
    pub fn advance(&mut self, duration: f64) {
        if let Some(shear) = &mut self.shear {
            let way = shear.rate * self.lengths[1] * duration;
            shear.offset = wrapped(shear.offset + way, self.lengths[0]);
        }
    }

    /// Returns displacement and relative velocity of the periodic image in the box that is `boxes`
    /// away along each axis.
    #[inline]
    pub fn image(&self, boxes: [f64; 3]) -> Image<S::Vector> {
        let mut position = S::from_components(|axis| boxes[axis] * self.lengths[axis]);
        let mut velocity = S::Vector::default();
        if let Some(shear) = self.shear {
            position[0] += boxes[1] * shear.offset;
            velocity[0] = boxes[1] * shear.rate * self.lengths[1];
        }
        Image { position, velocity }
    }

    /// Returns the difference of the flow velocities at two points `distance` apart along the
    /// gradient \[length/time\].
    #[inline]
    pub fn flow(&self, distance: f64) -> f64 {
        self.shear.map_or(0.0, |shear| shear.rate * distance)
    }

    /// Returns a position wrapped into the box: every coordinate in `[0, length)` along the
    /// periodic axes.
    #[inline]
    pub fn wrap(&self, mut position: S::Vector) -> S::Vector {
        if let Some(shear) = self.shear {
            let boxes = (position[1] / self.lengths[1]).floor();
            position[0] -= boxes * shear.offset;
        }
        for axis in 0..S::DIMENSION {
            if self.periodic[axis] {
                position[axis] = wrapped(position[axis], self.lengths[axis]);
            }
        }
        position
    }

    /// Returns the nearest periodic image of a difference of positions \[length\]; in a narrow box
    /// under shear, one of the nearest.
    #[inline]
    pub fn nearest(&self, mut difference: S::Vector) -> S::Vector {
        if let Some(shear) = self.shear {
            difference[0] -= (difference[1] / self.lengths[1]).round() * shear.offset;
        }
        for axis in 0..S::DIMENSION {
            if self.periodic[axis] {
                difference[axis] = nearest(difference[axis], self.lengths[axis]);
            }
        }
        difference
    }

    /// Returns the nearest periodic image of a difference of positions in the box or a little
    /// outside \[length\]: by a branch that is seldom taken instead of a division.
    #[inline(always)]
    pub fn nearest_of_near(&self, difference: S::Vector) -> S::Vector {
        if self.shear.is_some() {
            return self.nearest(difference);
        }
        S::from_components(|axis| {
            let (x, length) = (difference[axis], self.lengths[axis]);
            if x.abs() > 0.5 * length && self.periodic[axis] {
                nearest(x, length)
            } else {
                x
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;
    use nalgebra::{Vector2, vector};

    fn sheared() -> Images<Plane> {
        let mut shear = Shear::new(0.5).expect("a rate");
        shear.offset = 0.75;
        Images::new(vector![2.0, 3.0], [true; 3]).sheared(Some(shear))
    }

    /// Positions in any image wrap to one place, up to rounding of some lengths of the box.
    #[test]
    fn images_of_a_place_wrap_to_it() {
        for images in [
            Images::<Plane>::new(vector![2.0, 3.0], [true; 3]),
            sheared(),
        ] {
            for (x, y) in [(0.0, 0.0), (1.9, 2.9), (0.3, 1.4)] {
                let place = vector![x, y];
                for boxes in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-3.0, -2.0, 0.0]] {
                    let image = images.image(boxes);
                    let apart = images.nearest(images.wrap(place + image.position) - place);
                    assert!(apart.norm() < 1e-14, "{apart}");
                    // An image keeps its distance from the original flow.
                    let flow = images.flow(image.position[1]);
                    assert!((image.velocity[0] - flow).abs() < 1e-15);
                }
            }
        }
    }

    /// A particle that flies across the edge continues where its image does, with the velocity of
    /// the image.
    #[test]
    fn flight_commutes_with_wrapping() {
        let mut images = sheared();
        let (start, velocity) = (vector![0.4, 2.9], vector![0.7, 0.5]);
        let image = images.image([0.0, -1.0, 0.0]);
        let (place, speed): (Vector2<f64>, _) = (start + image.position, velocity + image.velocity);
        images.advance(0.6);
        let one = images.wrap(start + velocity * 0.6);
        let other = images.wrap(place + speed * 0.6);
        assert!(images.nearest(one - other).norm() < 1e-14);
    }

    #[test]
    fn a_rate_is_finite_and_not_zero() {
        for rate in [0.0, f64::NAN, f64::INFINITY] {
            assert!(Shear::new(rate).is_err());
        }
    }
}
