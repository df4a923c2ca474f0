//! The tangential contact law, and what a particle stores for it.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The tangential half of the contact law.
///
/// The associated type is all that a particle stores for it: a smooth grain carries `()`, which is
/// zero bytes and zero instructions.
pub trait Surface: Copy + Debug + Send + Sync + 'static {
    /// Angular velocity of one particle, or nothing.
    type Spin: Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned + Send + Sync;
}

/// No tangential impulse: spins never change, so none is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smooth;

impl Surface for Smooth {
    type Spin = ();
}
