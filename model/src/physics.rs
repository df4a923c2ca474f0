//! Trait bound of all engines, [`ParticleModel`], and the struct [`Scene`] that meets it.

use std::fmt::Debug;

use crate::field::Field;
use crate::restitution::Restitution;
use crate::sizes::Sizes;
use crate::space::Space;
use crate::surface::Surface;

/// Everything physical that an engine must know at compile time.
pub trait ParticleModel: Clone + Debug + Send + Sync + 'static {
    /// Space in which particles move: plane or volume.
    type Space: Space;
    /// Tangential contact law.
    type Surface: Surface<Self::Space>;
    /// Normal contact law.
    type Restitution: Restitution;
    /// Radii and masses.
    type Sizes: Sizes;
    /// Flight between collisions.
    type Field: Field<Self::Space>;

    /// Returns the tangential contact law.
    fn surface(&self) -> &Self::Surface;
    /// Returns the normal contact law.
    fn restitution(&self) -> &Self::Restitution;
    /// Returns the radii and masses.
    fn sizes(&self) -> &Self::Sizes;
    /// Returns the field of flight between collisions.
    fn field(&self) -> &Self::Field;
    /// Returns this physics for particles of other sizes.
    #[must_use]
    fn with_sizes(&self, sizes: Self::Sizes) -> Self;
}

/// Vector of positions and velocities of a physics.
pub type VectorOf<P> = <<P as ParticleModel>::Space as Space>::Vector;
/// Spin of a particle of a physics; `()` for smooth particles.
pub type SpinOf<P> = <<P as ParticleModel>::Surface as Surface<<P as ParticleModel>::Space>>::Spin;

/// Dimension, contact laws, sizes and field of a gas, bundled.
///
/// ```
/// use stosszahl_model::{Constant, Free, Monodisperse, Plane, Scene, Smooth};
/// let scene = Scene {
///     space: Plane,
///     surface: Smooth,
///     restitution: Constant::new(0.8).expect("a coefficient"),
///     sizes: Monodisperse { radius: 0.5, mass: 1.0 },
///     field: Free,
/// };
/// assert_eq!(std::mem::size_of_val(&scene), 24);
/// ```
#[derive(Clone, Debug)]
pub struct Scene<S, C, R, Z, F> {
    /// Space in which particles move: plane or volume.
    pub space: S,
    /// Tangential contact law.
    pub surface: C,
    /// Normal contact law.
    pub restitution: R,
    /// Radii and masses.
    pub sizes: Z,
    /// Flight between collisions.
    pub field: F,
}

impl<S, C, R, Z, F> ParticleModel for Scene<S, C, R, Z, F>
where
    S: Space,
    C: Surface<S>,
    R: Restitution,
    Z: Sizes,
    F: Field<S>,
{
    type Space = S;
    type Surface = C;
    type Restitution = R;
    type Sizes = Z;
    type Field = F;

    #[inline]
    fn surface(&self) -> &C {
        &self.surface
    }
    #[inline]
    fn restitution(&self) -> &R {
        &self.restitution
    }
    #[inline]
    fn sizes(&self) -> &Z {
        &self.sizes
    }
    #[inline]
    fn field(&self) -> &F {
        &self.field
    }
    fn with_sizes(&self, sizes: Z) -> Self {
        Self {
            sizes,
            ..self.clone()
        }
    }
}
