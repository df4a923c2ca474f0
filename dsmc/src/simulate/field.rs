//! Uniform gravity or shear flow, chosen at run time, so that both share one engine type.

use stosszahl_model::{
    Field, Gravity, InvalidValue, Law, ParticleSpec, Scene, Sheared, Space, Species, Surface,
};

/// Field of a gas, chosen at run time: uniform gravity or a uniform shear flow.
#[derive(Clone, Copy, Debug)]
pub(super) enum UniformField<S: Space> {
    /// Uniform gravity, a constant acceleration that may be zero.
    Gravity(Gravity<S>),
    /// Uniform shear flow, with particle velocities relative to it.
    Sheared(Sheared),
}

impl<S: Space> Field<S> for UniformField<S> {
    const FREE: bool = false;
    const SHEARED: bool = true;

    #[inline(always)]
    fn shear_rate(&self) -> f64 {
        match self {
            Self::Gravity(_) => 0.0,
            Self::Sheared(flow) => Field::<S>::shear_rate(flow),
        }
    }

    #[inline(always)]
    fn acceleration(&self) -> S::Vector {
        match self {
            Self::Gravity(gravity) => gravity.acceleration(),
            Self::Sheared(_) => S::Vector::default(),
        }
    }

    #[inline]
    fn move_particle(&self, position: &mut S::Vector, velocity: &mut S::Vector, duration: f64) {
        match self {
            Self::Gravity(gravity) => gravity.move_particle(position, velocity, duration),
            Self::Sheared(flow) => Field::<S>::move_particle(flow, position, velocity, duration),
        }
    }
}

/// Creates the particle model for particles of any sizes with a surface, under gravity or in a
/// shear flow.
///
/// # Errors
/// [`InvalidValue`] for sizes or fields that are not allowed.
pub(super) fn scene_of<S: Space, C: Surface<S>>(
    grains: &ParticleSpec,
    surface: C,
    count: usize,
) -> Result<Scene<S, C, Law, Species, UniformField<S>>, InvalidValue> {
    if grains.shear_rate.is_some() {
        let flow = grains.sheared(surface, count)?;
        return Ok(in_field(flow, UniformField::Sheared));
    }
    Ok(in_field(
        grains.scene(surface, count)?,
        UniformField::Gravity,
    ))
}

/// Returns a particle model whose field is replaced by `field(old field)`.
fn in_field<S, C, R, Z, F, G>(
    scene: Scene<S, C, R, Z, F>,
    field: impl FnOnce(F) -> G,
) -> Scene<S, C, R, Z, G> {
    Scene {
        space: scene.space,
        surface: scene.surface,
        restitution: scene.restitution,
        sizes: scene.sizes,
        field: field(scene.field),
    }
}
