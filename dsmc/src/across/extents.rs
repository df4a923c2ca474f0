//! How fast partners can be: the bound of trials.
//!
//! A hot simulator anywhere raises the bound of all that may meet it, and in a gas of clusters that is most of the cost. So
//! bounds are local, and they know directions: each cell has the box that holds the velocities in it, and a partner of
//! velocity u is met along k no faster than the corner of a box of its neighbourhood that is farthest against k.

use stosszahl_model::Space;

use crate::tally::{larger, smaller};

/// The smallest box that holds some velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent<S: Space> {
    /// The largest components of -u and of u: side by side, so that they are compared at once.
    most: [S::Vector; 2],
}

impl<S: Space> Extent<S> {
    /// Of nobody.
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

    /// Leaves it as it is, or makes it that of nobody; without a branch, which nobody could foresee.
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

/// How far from a simulator its partners are sought, in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ranges {
    /// The cell of the point around which they are sought.
    pub(super) point: usize,
    /// Cells around that one, where there are others than the simulator itself.
    pub(super) near: usize,
    /// Cells around it, where nobody is nearer.
    pub(super) far: usize,
    /// As many more in both cases, where particles differ in size.
    pub(super) shift: usize,
}

impl Ranges {
    /// Cells around a point that are looked at first.
    pub(super) fn block(self) -> usize {
        self.near + self.shift
    }

    /// Cells around a simulator in which its partners are, unless nobody is near.
    pub(super) fn reach(self) -> usize {
        self.point + self.block()
    }

    /// Cells around a tile that work on it may look at. One more, as a coordinate at the edge of a cell may be rounded to either
    /// side.
    pub(super) fn margin(self) -> usize {
        self.point + self.shift + self.far.max(self.near) + 1
    }
}
