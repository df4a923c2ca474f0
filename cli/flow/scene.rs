//! Where the choices of a flow become types: the dimension, and whether grains spin.
//!
//! All flows have species, if only one, and gravity, if only none: a type for each would make four times as many engines
//! to be compiled, and costs a flow a few operations for each flight.

use stosszahl_model::{Constant, Gravity, Physics, Plane, Scene, Smooth, Space, Surface, Volume};

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
        Some(rough) => build(plan, rough, job),
        None => build(plan, Smooth, job),
    }
}

fn build<S: Space, W: Within<S>, C: Surface<S>>(plan: &Plan, surface: C, job: W) -> W::Output {
    let gravity = plan.flow.gravity.as_ref().map(|g| &g.acceleration[..]);
    let acceleration = Plan::vector::<S>(gravity.unwrap_or_default());
    // The case allows nothing that has no meaning here.
    let restitution = Constant::new(plan.flow.contact.restitution).unwrap_or(Constant::ELASTIC);
    let field = Gravity::new(acceleration).unwrap_or_default();
    job.visit(Scene {
        space: S::default(),
        surface,
        restitution,
        sizes: plan.sizes.clone(),
        field,
    })
}
