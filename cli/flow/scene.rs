//! Where the choices of a flow become types.

use stosszahl_model::{
    Constant, Field, Free, Gravity, Monodisperse, Physics, Plane, Rough, Scene, Sizes, Smooth,
    Space, Species, Surface, Volume,
};

use super::plan::Plan;

/// A job that can be done in any scene of a flow.
pub trait Visit {
    /// What it returns.
    type Output;
    /// Does the job in the plane.
    fn plane<P: Physics<Space = Plane>>(self, scene: P) -> Self::Output;
    /// Does the job in space.
    fn space<P: Physics<Space = Volume>>(self, scene: P) -> Self::Output;
}

/// Does a job in the scene of a plan.
pub fn with_scene<V: Visit>(plan: &Plan, job: V) -> V::Output {
    if plan.dimension() == 2 {
        with_surface::<Plane, _>(plan, InPlane(job))
    } else {
        with_surface::<Volume, _>(plan, InSpace(job))
    }
}

/// A job in a space that is known.
trait Within<S: Space> {
    type Output;
    fn visit<P: Physics<Space = S>>(self, scene: P) -> Self::Output;
}

struct InPlane<V>(V);

impl<V: Visit> Within<Plane> for InPlane<V> {
    type Output = V::Output;
    fn visit<P: Physics<Space = Plane>>(self, scene: P) -> V::Output {
        self.0.plane(scene)
    }
}

struct InSpace<V>(V);

impl<V: Visit> Within<Volume> for InSpace<V> {
    type Output = V::Output;
    fn visit<P: Physics<Space = Volume>>(self, scene: P) -> V::Output {
        self.0.space(scene)
    }
}

fn with_surface<S: Space, W: Within<S>>(plan: &Plan, job: W) -> W::Output {
    match plan.rough::<S>() {
        Some(rough) => with_sizes::<S, _, Rough>(plan, rough, job),
        None => with_sizes::<S, _, Smooth>(plan, Smooth, job),
    }
}

fn with_sizes<S: Space, W: Within<S>, C: Surface<S>>(
    plan: &Plan,
    surface: C,
    job: W,
) -> W::Output {
    match (&plan.kinds[..], Species::new(plan.kinds.clone())) {
        ([_, _, ..], Some(species)) => with_field(plan, surface, species, job),
        (kinds, _) => {
            let alike = Monodisperse {
                radius: kinds[0].radius,
                mass: kinds[0].mass,
            };
            with_field(plan, surface, alike, job)
        }
    }
}

fn with_field<S: Space, W: Within<S>, C: Surface<S>, Z: Sizes>(
    plan: &Plan,
    surface: C,
    sizes: Z,
    job: W,
) -> W::Output {
    let gravity = plan.flow.gravity.as_ref();
    match gravity.and_then(|g| Gravity::new(Plan::vector::<S>(&g.acceleration))) {
        Some(gravity) => build(plan, surface, sizes, gravity, job),
        None => build(plan, surface, sizes, Free, job),
    }
}

fn build<S: Space, W: Within<S>, C: Surface<S>, Z: Sizes, F: Field<S>>(
    plan: &Plan,
    surface: C,
    sizes: Z,
    field: F,
    job: W,
) -> W::Output {
    // The case allows nothing else.
    let restitution = Constant::new(plan.flow.contact.restitution).unwrap_or_default();
    job.visit(Scene {
        space: S::default(),
        surface,
        restitution,
        sizes,
        field,
    })
}
