//! Data stored for each simulator.

use std::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, ParticleModel, Sizes, Space, SpinOf, Vector, VectorOf};

/// Type-level choice whether displacements are tracked. It changes the data of a simulator by
/// nothing or one vector.
pub trait DisplacementTracking<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// Displacement data of a simulator.
    type DisplacementMark: Copy
        + Debug
        + Default
        + PartialEq
        + Serialize
        + DeserializeOwned
        + Send
        + Sync;
    /// Adds a displacement.
    fn add_displacement(mark: &mut Self::DisplacementMark, by: S::Vector);
    /// Displacement so far \[length\]; zero if untracked.
    fn displacement_of(mark: Self::DisplacementMark) -> S::Vector;
}

/// Displacements are not tracked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Untracked;

impl<S: Space> DisplacementTracking<S> for Untracked {
    type DisplacementMark = ();
    #[inline(always)]
    fn add_displacement((): &mut (), _by: S::Vector) {}
    fn displacement_of((): ()) -> S::Vector {
        S::Vector::default()
    }
}

/// Displacements are tracked, unwrapped across periodic faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tracked;

impl<S: Space> DisplacementTracking<S> for Tracked {
    type DisplacementMark = S::Vector;
    #[inline(always)]
    fn add_displacement(mark: &mut S::Vector, by: S::Vector) {
        *mark += by;
    }
    fn displacement_of(mark: S::Vector) -> S::Vector {
        mark
    }
}

/// Simulator: 32 bytes in two dimensions, plus its size key, displacement and spin where the gas
/// needs them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulator<V, T, M, W> {
    /// Position \[length\].
    pub position: V,
    /// Velocity \[length/time\].
    pub velocity: V,
    /// Key into the table of radii and masses.
    pub tag: T,
    /// Displacement so far, or an empty value.
    pub mark: M,
    /// Angular velocity \[1/time\], or an empty value for smooth particles.
    pub spin: W,
}

/// Simulator of a physical model.
pub type SimulatorOf<P, F> = Simulator<
    VectorOf<P>,
    <<P as ParticleModel>::Sizes as Sizes>::Tag,
    <F as DisplacementTracking<<P as ParticleModel>::Space>>::DisplacementMark,
    SpinOf<P>,
>;

/// True if all components can be squared.
pub(crate) fn is_good<V: Vector>(dimension: usize, vector: V) -> bool {
    (0..dimension).all(|axis| vector[axis].abs() <= 1e150)
}

/// Index in the state, where each particle has its own size; a placeholder otherwise.
pub(crate) fn index<P: ParticleModel>(tag: <P::Sizes as Sizes>::Tag) -> u32 {
    if P::Sizes::INDIVIDUAL {
        P::Sizes::index_of(tag, 0) as u32
    } else {
        Collision::ANONYMOUS
    }
}

/// Area or volume covered by particles of these sizes, in units of the largest particle.
#[inline(always)]
pub(crate) fn covered<P: ParticleModel>(
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
