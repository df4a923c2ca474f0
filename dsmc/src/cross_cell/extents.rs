//! Bounding boxes of velocities: the majorant of the relative speed of candidate pairs.
//!
//! One global majorant would follow the fastest simulator anywhere, and in a gas of clusters that
//! is most of the cost. Majorants are therefore local and directional: each cell has the bounding
//! box of its velocities. A partner approaches along k no faster than the corner of a box in the
//! neighbourhood that is farthest against k.

use stosszahl_model::Space;

use crate::extrema::{larger, smaller};

/// Bounding box of the velocities of a set of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VelocityBox<S: Space> {
    /// Largest components of -u and of u over the velocities u of the set \[length/time\], side by
    /// side so that both are compared at once.
    most: [S::Vector; 2],
}

impl<S: Space> VelocityBox<S> {
    /// Creates the bounding box of an empty set of velocities.
    #[inline(always)]
    pub(super) fn empty() -> Self {
        Self {
            most: [S::from_components(|_| f64::MIN); 2],
        }
    }

    /// Extends the bounding box so that it contains the velocity `u`.
    #[inline(always)]
    pub(super) fn note(&mut self, velocity: S::Vector) {
        self.join(&Self {
            most: [-velocity, velocity],
        });
    }

    /// Empties the bounding box unless `keeps` is true. Branch-free, because the condition is
    /// unpredictable.
    #[inline(always)]
    pub(super) fn keep_if(&mut self, keeps: bool) {
        let most = [f64::MIN, f64::MAX][usize::from(keeps)];
        for one in &mut self.most {
            for axis in 0..S::DIMENSION {
                one[axis] = smaller(one[axis], most);
            }
        }
    }

    #[inline(always)]
    pub(super) fn join(&mut self, other: &Self) {
        for (one, other) in self.most.iter_mut().zip(&other.most) {
            for axis in 0..S::DIMENSION {
                one[axis] = larger(one[axis], other[axis]);
            }
        }
    }

    /// Returns how much a bounding box of velocities relative to a shear flow must be widened
    /// \[length/time\], to bound the approach of partners up to `contact` apart \[length\].
    ///
    /// The flow a y at a partner along k changes the approach speed by at most `a contact |k_x
    /// k_y|`, which is at most `(|k_x| + |k_y|)/sqrt(8)` of `a contact`.
    #[inline(always)]
    pub(super) fn flow_widening(shear_rate: f64, contact: f64) -> f64 {
        0.5 * std::f64::consts::FRAC_1_SQRT_2 * shear_rate.abs() * contact
    }

    /// Returns the bounding box widened by `by` on both sides, along the axes of flow and gradient
    /// \[length/time\].
    #[inline(always)]
    #[must_use]
    pub(super) fn widened(mut self, by: f64) -> Self {
        for one in &mut self.most {
            one[0] += by;
            one[1] += by;
        }
        self
    }

    /// Returns the side lengths of the bounding box of velocities \[length/time\]; zero if it is
    /// empty.
    #[inline(always)]
    pub(super) fn sides(&self) -> S::Vector {
        let [low, high] = self.most;
        S::from_components(|axis| larger(high[axis] + low[axis], 0.0))
    }

    /// Returns the largest `-u . k` over the velocities u in the bounding box; a large negative
    /// number if it is empty.
    #[inline(always)]
    pub(super) fn against(&self, k: S::Vector) -> f64 {
        let ends = [0, 1, 2].map(|axis| usize::from(axis < S::DIMENSION && k[axis] < 0.0));
        self.against_signed(ends, S::from_components(|axis| k[axis].abs()))
    }

    /// Returns the largest `-u . k` over the velocities u in the bounding box, from the absolute
    /// components `k` and the signs `ends`: 1 if a component is negative, else 0.
    #[inline(always)]
    pub(super) fn against_signed(&self, ends: [usize; 3], k: S::Vector) -> f64 {
        (0..S::DIMENSION)
            .map(|axis| self.most[ends[axis]][axis] * k[axis])
            .sum()
    }
}
