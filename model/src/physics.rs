//! Particle model of a gas: the trait [`ParticleModel`] that engines require, and the struct
//! [`Scene`] that implements it.

use std::fmt::Debug;

use crate::field::Field;
use crate::restitution::Restitution;
use crate::sizes::Sizes;
use crate::space::Space;
use crate::surface::Surface;

/// Particle model that an engine needs at compile time: dimension, contact laws, sizes and field.
pub trait ParticleModel: Clone + Debug + Send + Sync + 'static {
    /// Space in which particles move: two or three dimensions.
    type Space: Space;
    /// Tangential contact law: smooth or rough particles.
    type Surface: Surface<Self::Space>;
    /// Normal contact law: the coefficient of restitution.
    type Restitution: Restitution;
    /// Radii, masses and species of the particles.
    type Sizes: Sizes;
    /// Law of free flight between collisions: straight, under gravity, or in a shear flow.
    type Field: Field<Self::Space>;

    /// Returns the tangential contact law of the particles.
    fn surface(&self) -> &Self::Surface;
    /// Returns the normal contact law of the particles.
    fn restitution(&self) -> &Self::Restitution;
    /// Returns the radii, masses and species of the particles.
    fn sizes(&self) -> &Self::Sizes;
    /// Returns the law of free flight between collisions.
    fn field(&self) -> &Self::Field;
    /// Returns this particle model with other sizes.
    #[must_use]
    fn with_sizes(&self, sizes: Self::Sizes) -> Self;
}

/// Type of positions and velocities in a particle model.
pub type VectorOf<P> = <<P as ParticleModel>::Space as Space>::Vector;
/// Type of the spin of a particle in a particle model; `()` for smooth particles.
pub type SpinOf<P> = <<P as ParticleModel>::Surface as Surface<<P as ParticleModel>::Space>>::Spin;

/// Particle model of a gas as a struct: dimension, contact laws, sizes and field.
///
/// ```
/// use stosszahl_model::{Constant, Free, Monodisperse, Plane, Scene, Smooth};
/// let (law, sizes) = (Constant::ELASTIC, Monodisperse { radius: 0.5, mass: 1.0 });
/// let scene: Scene<Plane, _, _, _, _> = Scene::new(Smooth, law, sizes, Free);
/// assert_eq!(std::mem::size_of_val(&scene), 24);
/// ```
#[derive(Clone, Debug)]
pub struct Scene<S, C, R, Z, F> {
    /// Space in which particles move: two or three dimensions.
    pub space: S,
    /// Tangential contact law: smooth or rough particles.
    pub surface: C,
    /// Normal contact law: the coefficient of restitution.
    pub restitution: R,
    /// Radii, masses and species of the particles.
    pub sizes: Z,
    /// Law of free flight between collisions: straight, under gravity, or in a shear flow.
    pub field: F,
}

impl<S: Default, C, R, Z, F> Scene<S, C, R, Z, F> {
    /// Creates a particle model from its contact laws, sizes and field.
    pub fn new(surface: C, restitution: R, sizes: Z, field: F) -> Self {
        Self {
            space: S::default(),
            surface,
            restitution,
            sizes,
            field,
        }
    }
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
