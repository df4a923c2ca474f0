//! What a measurement may see while an engine runs.

use crate::collision::Collision;
use crate::physics::{Physics, VectorOf};

/// A measurement that an engine feeds. It does nothing by default; tuples compose, and `()` compiles to
/// nothing. States at chosen times are asked of the engine instead.
pub trait Observe<P: Physics> {
    /// Called once for each collision, in order of time.
    #[inline]
    fn collision(&mut self, _collision: &Collision<VectorOf<P>>) {}
}

impl<P: Physics> Observe<P> for () {}

impl<P: Physics, A: Observe<P>> Observe<P> for &mut A {
    #[inline]
    fn collision(&mut self, collision: &Collision<VectorOf<P>>) {
        (**self).collision(collision);
    }
}

impl<P: Physics, A: Observe<P>, B: Observe<P>> Observe<P> for (A, B) {
    #[inline]
    fn collision(&mut self, collision: &Collision<VectorOf<P>>) {
        self.0.collision(collision);
        self.1.collision(collision);
    }
}
