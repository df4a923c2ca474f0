//! The dimension of the scene, as a type.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use nalgebra::SVector;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Vector arithmetic that the engines and measurements need; met by `nalgebra`'s static vectors.
pub trait Vector:
    Copy
    + Debug
    + Default
    + PartialEq
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
    + Index<usize, Output = f64>
    + IndexMut<usize>
    + Serialize
    + DeserializeOwned
    + Send
    + Sync
    + 'static
{
    /// The scalar product a . b.
    fn inner(&self, other: &Self) -> f64;

    /// The squared length.
    fn square(&self) -> f64 {
        self.inner(self)
    }
}

impl<const D: usize> Vector for SVector<f64, D>
where
    SVector<f64, D>: Default + Serialize + DeserializeOwned,
{
    #[inline]
    fn inner(&self, other: &Self) -> f64 {
        self.dot(other)
    }
}

/// The space in which the particles move.
pub trait Space: Copy + Debug + Default + Send + Sync + 'static {
    /// Number of components of a position.
    const DIMENSION: usize;
    /// Positions and velocities.
    type Vector: Vector;
}

/// Two dimensions: disks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plane;

/// Three dimensions: spheres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Volume;

impl Space for Plane {
    const DIMENSION: usize = 2;
    type Vector = SVector<f64, 2>;
}

impl Space for Volume {
    const DIMENSION: usize = 3;
    type Vector = SVector<f64, 3>;
}
