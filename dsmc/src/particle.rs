//! What is stored for each simulator.

use std::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Physics, Sizes, Space, SpinOf, Vector, VectorOf};

/// Whether an engine follows how far its simulators come. A type, because it changes what is stored for each:
/// nothing, or one vector.
pub trait Follow<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// What a simulator carries.
    type Mark: Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned + Send + Sync;
    /// Notes a move.
    fn moved(mark: &mut Self::Mark, by: S::Vector);
    /// How far it has come; zero if that is not followed.
    fn way(mark: Self::Mark) -> S::Vector;
}

/// Displacements are not followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unfollowed;

impl<S: Space> Follow<S> for Unfollowed {
    type Mark = ();
    #[inline(always)]
    fn moved((): &mut (), _by: S::Vector) {}
    fn way((): ()) -> S::Vector {
        S::Vector::default()
    }
}

/// Displacements are followed, across the edges of the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Followed;

impl<S: Space> Follow<S> for Followed {
    type Mark = S::Vector;
    #[inline(always)]
    fn moved(mark: &mut S::Vector, by: S::Vector) {
        *mark += by;
    }
    fn way(mark: S::Vector) -> S::Vector {
        mark
    }
}

/// One simulator: 32 bytes in the plane, and its index where particles differ in size, its mark where it is followed, and its
/// spin where particles spin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulator<V, T, M, W> {
    /// Position \[length\].
    pub position: V,
    /// Velocity \[length/time\].
    pub velocity: V,
    /// Key into the table of radii and masses.
    pub tag: T,
    /// How far it has come, or nothing.
    pub mark: M,
    /// Angular velocity \[1/time\], or nothing.
    pub spin: W,
}

/// The simulators of a physics.
pub type SimulatorOf<P, F> = Simulator<
    VectorOf<P>,
    <<P as Physics>::Sizes as Sizes>::Tag,
    <F as Follow<<P as Physics>::Space>>::Mark,
    SpinOf<P>,
>;

/// True if all components can be squared.
pub(crate) fn is_good<V: Vector>(dimension: usize, vector: V) -> bool {
    (0..dimension).all(|axis| vector[axis].abs() <= 1e150)
}

/// The index in the state of what has a tag, where that tells it apart from others.
pub(crate) fn index<P: Physics>(tag: <P::Sizes as Sizes>::Tag) -> u32 {
    if P::Sizes::INDIVIDUAL {
        P::Sizes::index(tag, 0) as u32
    } else {
        Collision::ANONYMOUS
    }
}

/// What the members of a cell cover, who have these tags, in units of the largest particle.
#[inline(always)]
pub(crate) fn covered<P: Physics>(
    sizes: &P::Sizes,
    tags: impl ExactSizeIterator<Item = <P::Sizes as Sizes>::Tag>,
) -> f64 {
    if sizes.are_equal() {
        return tags.len() as f64;
    }
    let unit = 1.0 / sizes.largest_radius();
    let share = |tag| (sizes.radius(tag) * unit).powi(P::Space::DIMENSION as i32);
    tags.map(share).sum()
}
