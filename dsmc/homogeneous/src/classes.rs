//! Classes of particles of nearly equal size, with one bound of the speed each, for pair selections
//! without groups by speed.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Sizes, Vector};

use super::gas::{COLDEST, HomogeneousGas, SmoothPhysics, size_key};

/// Upper bounds of radius and speed of the particles in one size class.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct ClassBounds {
    /// Number of the size class, a logarithmic scale of radii, see [`size_key`].
    pub(crate) key: u32,
    pub(crate) radius: f64,
    /// Largest squared speed of the particles in the class \[length^2/time^2\].
    pub(crate) square: f64,
}

impl ClassBounds {
    /// Creates the bounds of an empty size class.
    pub(crate) fn new(key: u32) -> Self {
        Self {
            key,
            radius: 0.0,
            square: 0.0,
        }
    }

    /// Raises the bounds of radius and squared speed, if needed, to those of a particle that is
    /// added.
    pub(crate) fn admit(&mut self, radius: f64, square: f64) {
        self.radius = self.radius.max(radius);
        self.square = self.square.max(square);
    }

    /// Raises the bound of the squared speed, if lower than `square`; returns true if it rose.
    #[inline]
    pub(crate) fn rises(&mut self, square: f64) -> bool {
        if square <= self.square {
            return false;
        }
        self.square = square;
        true
    }
}

impl AsRef<ClassBounds> for ClassBounds {
    fn as_ref(&self) -> &ClassBounds {
        self
    }
}

impl AsMut<ClassBounds> for ClassBounds {
    fn as_mut(&mut self) -> &mut ClassBounds {
        self
    }
}

/// Sets the speed bounds of all size classes to zero if all are so small that collision rates
/// underflow.
pub(crate) fn bring_to_rest<C: AsRef<ClassBounds> + AsMut<ClassBounds>>(classes: &mut [C]) {
    if classes.iter().all(|class| class.as_ref().square < COLDEST) {
        for class in classes {
            class.as_mut().square = 0.0;
        }
    }
}

/// Adds a new particle to its size class and stores the class in its `mark`; returns class and
/// radius. `None` if no class has its size, or if so many merged particles are still in the list
/// that it should be rebuilt.
pub(crate) fn joined<P: SmoothPhysics, C: AsRef<ClassBounds>>(
    gas: &mut HomogeneousGas<P>,
    index: u32,
    classes: &[C],
) -> Option<(usize, f64)> {
    if 4 * gas.gone > gas.particles.len() {
        return None;
    }
    let particle = &mut gas.particles[index as usize];
    let radius = gas.scene.sizes().radius(particle.tag);
    let key = size_key(radius);
    let number = classes
        .binary_search_by_key(&key, |class| class.as_ref().key)
        .ok()?;
    particle.mark = number as u32;
    Some((number, radius))
}

/// Raises the speed bound of a particle's size class to its new speed after a collision; returns
/// the class, or `None` if the bound still holds.
#[inline]
pub(crate) fn raised<P: SmoothPhysics, C: AsMut<ClassBounds>>(
    gas: &HomogeneousGas<P>,
    index: u32,
    classes: &mut [C],
) -> Option<usize> {
    let particle = &gas.particles[index as usize];
    let number = particle.mark as usize;
    let square = particle.velocity.square();
    classes[number].as_mut().rises(square).then_some(number)
}
