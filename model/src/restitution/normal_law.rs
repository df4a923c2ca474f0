//! The interface of a normal contact law.

use std::fmt::Debug;

/// Normal restitution as a function of the normal approach speed.
pub trait Restitution: Clone + Debug + Send + Sync + 'static {
    /// The coefficient of restitution, in [0, 1], at a normal approach speed `approach` >= 0
    /// \[length/time\].
    fn normal(&self, approach: f64) -> f64;

    /// The same for a pair of the given species (see [`crate::Sizes::kind`]), where the law depends on them.
    #[inline]
    fn between(&self, _kinds: [u32; 2], approach: f64) -> f64 {
        self.normal(approach)
    }
}
