//! The only place where run-time choices become types.

use stosszahl_model::{Free, Monodisperse, Physics, Plane, Restitution, Scene, Sizes, Smooth};

use crate::setup::{Law, Setup};

/// The physics that both engines of this program accept.
pub trait Planar: Physics<Space = Plane, Surface = Smooth, Field = Free> {}

impl<P: Physics<Space = Plane, Surface = Smooth, Field = Free>> Planar for P {}

/// A job that can be done in any scene.
pub trait Visit {
    /// What it returns.
    type Output;
    /// Does the job in this scene.
    fn visit<P: Planar>(self, scene: P) -> Self::Output;
}

/// Does a job in the scene of a case, in reduced units.
pub fn with_scene<V: Visit>(setup: &Setup, job: V) -> V::Output {
    match setup.law {
        Law::Constant(law) => with_restitution(setup, law, job),
        Law::Viscoelastic(law) => with_restitution(setup, law, job),
    }
}

fn with_restitution<V: Visit>(setup: &Setup, restitution: impl Restitution, job: V) -> V::Output {
    match &setup.sizes {
        None => with_sizes(
            restitution,
            Monodisperse {
                radius: 0.5,
                mass: 1.0,
            },
            job,
        ),
        Some(sizes) => with_sizes(restitution, sizes.clone(), job),
    }
}

fn with_sizes<V: Visit>(restitution: impl Restitution, sizes: impl Sizes, job: V) -> V::Output {
    job.visit(Scene {
        space: Plane,
        surface: Smooth,
        restitution,
        sizes,
        field: Free,
    })
}
