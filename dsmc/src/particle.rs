//! Simulator, the particle of the DSMC: its stored data, with or without tracking of displacements.

use std::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, ParticleModel, Sizes, Space, SpinOf, Vector, VectorOf};

/// Compile-time choice whether displacements of simulators are tracked: a simulator stores one
/// vector more, or nothing.
pub trait DisplacementTracking<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// Displacement data stored in a simulator: a vector, or nothing.
    type DisplacementMark: Copy
        + Debug
        + Default
        + PartialEq
        + Serialize
        + DeserializeOwned
        + Send
        + Sync;
    /// Adds a flight path to the stored displacement; does nothing if untracked.
    fn add_displacement(mark: &mut Self::DisplacementMark, by: S::Vector);
    /// Returns the displacement accumulated so far \[length\]; zero if untracked.
    fn displacement_of(mark: Self::DisplacementMark) -> S::Vector;
}

/// Choice not to track the displacements of simulators.
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

/// Choice to track the displacements of simulators, unwrapped across periodic faces.
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

/// Simulator, the particle of the DSMC: 32 bytes in two dimensions, plus size tag, displacement and
/// spin where the gas needs them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulator<V, T, M, W> {
    /// Position of the simulator in the box \[length\].
    pub position: V,
    /// Velocity of the simulator \[length/time\].
    pub velocity: V,
    /// Tag by which radius, mass and species of the simulator are found.
    pub tag: T,
    /// Displacement since tracking began \[length\], or an empty value if untracked.
    pub mark: M,
    /// Angular velocity of the simulator \[1/time\], or an empty value for smooth particles.
    pub spin: W,
}

/// Simulator type of a particle model, with or without tracking of displacements.
pub type SimulatorOf<P, F> = Simulator<
    VectorOf<P>,
    <<P as ParticleModel>::Sizes as Sizes>::Tag,
    <F as DisplacementTracking<<P as ParticleModel>::Space>>::DisplacementMark,
    SpinOf<P>,
>;

/// Returns true if all components of a vector are finite and can be squared without overflow.
pub(crate) fn is_good<V: Vector>(dimension: usize, vector: V) -> bool {
    (0..dimension).all(|axis| vector[axis].abs() <= 1e150)
}

/// Returns the index in the state of a simulator that has its own size, by its tag; a placeholder
/// otherwise.
pub(crate) fn index<P: ParticleModel>(tag: <P::Sizes as Sizes>::Tag) -> u32 {
    if P::Sizes::INDIVIDUAL {
        P::Sizes::index_of(tag, 0) as u32
    } else {
        Collision::ANONYMOUS
    }
}

/// Returns the area or volume that particles with these size tags cover, in units of the largest
/// particle.
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
