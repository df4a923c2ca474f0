//! How fast partners can be: the bound of trials.
//!
//! A hot simulator anywhere raises the bound of all that may meet it, and in a gas of clusters that is most of the cost. So
//! bounds are local, and they know directions: each cell has the box that holds the velocities in it, and a partner of
//! velocity u is met along k no faster than the corner of a box of its neighbourhood that is farthest against k.

use stosszahl_model::Space;

use crate::extrema::{larger, smaller};

/// The smallest box that holds some velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent<S: Space> {
    /// The largest components of -u and of u: side by side, so that they are compared at once.
    most: [S::Vector; 2],
}

impl<S: Space> Extent<S> {
    /// An empty bounding box.
    #[inline(always)]
    pub(super) fn nobody() -> Self {
        Self {
            most: [S::vector(|_| f64::MIN); 2],
        }
    }

    /// Takes a velocity in.
    #[inline(always)]
    pub(super) fn note(&mut self, velocity: S::Vector) {
        self.join(&Self {
            most: [-velocity, velocity],
        });
    }

    /// Empties the box unless `keeps`. Branch-free, because the condition is unpredictable.
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

    /// Its sides; zero if there is nobody.
    #[inline(always)]
    pub(super) fn sides(&self) -> S::Vector {
        let [low, high] = self.most;
        S::vector(|axis| larger(high[axis] + low[axis], 0.0))
    }

    /// How fast a simulator of the box can come along `-k`, at most: the largest `-u . k`. A large negative number if there is nobody.
    #[inline(always)]
    pub(super) fn against(&self, k: S::Vector) -> f64 {
        let ends = [0, 1, 2].map(|axis| usize::from(axis < S::DIMENSION && k[axis] < 0.0));
        self.along(ends, S::vector(|axis| k[axis].abs()))
    }

    /// The same, where it is known which end counts along each axis, and how much.
    #[inline(always)]
    pub(super) fn along(&self, ends: [usize; 3], k: S::Vector) -> f64 {
        (0..S::DIMENSION)
            .map(|axis| self.most[ends[axis]][axis] * k[axis])
            .sum()
    }
}
