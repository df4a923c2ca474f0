//! What a measurement may see while an engine runs.

use crate::collision::Collision;
use crate::physics::{Physics, VectorOf};

/// A measurement that an engine feeds. It does nothing by default; tuples compose, and `()` compiles to
/// nothing. States at chosen times are asked of the engine instead.
pub trait Observe<P: Physics> {
    /// Whether it looks at collisions at all: engines that must store them until it may look do not, if not.
    const LOOKS: bool = true;

    /// Called once for each collision, in order of time.
    #[inline]
    fn collision(&mut self, _collision: &Collision<VectorOf<P>>) {}
}

impl<P: Physics> Observe<P> for () {
    const LOOKS: bool = false;
}

impl<P: Physics, A: Observe<P>> Observe<P> for &mut A {
    const LOOKS: bool = A::LOOKS;

    #[inline]
    fn collision(&mut self, collision: &Collision<VectorOf<P>>) {
        (**self).collision(collision);
    }
}

impl<P: Physics, A: Observe<P>, B: Observe<P>> Observe<P> for (A, B) {
    const LOOKS: bool = A::LOOKS || B::LOOKS;

    #[inline]
    fn collision(&mut self, collision: &Collision<VectorOf<P>>) {
        self.0.collision(collision);
        self.1.collision(collision);
    }
}
