//! Interface of methods that select candidate pairs in a gas without positions, by
//! acceptance-rejection.

use rand::Rng;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::gas::{HomogeneousGas, SmoothPhysics};

/// Candidate pair of the acceptance-rejection method: two particles and a bound of their relative
/// speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePair {
    /// Index of the first particle of the candidate pair.
    pub first: u32,
    /// Index of the second particle of the candidate pair; never that of the first.
    pub second: u32,
    /// Upper bound of the relative speed of the pair \[length/time\]. The pair is proposed at the
    /// rate `k bound`, k being its kernel, so that acceptance with the probability `g/bound` makes
    /// it collide at the rate `k g`.
    pub bound: f64,
}

/// Effect that a change of a particle has on pair proposals drawn before it: none, void, or
/// selection outdated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProposalValidity {
    /// The distribution of pair proposals is unchanged; proposals drawn ahead remain valid.
    Kept,
    /// The distribution of pair proposals has changed; proposals drawn ahead are void.
    Changed,
    /// The pair selection must be rebuilt before the next proposal.
    Outdated,
}

/// Method that proposes candidate pairs, each at a known rate that is at least its collision rate.
///
/// Between two changes, proposals form a Poisson process of constant rate
/// [`SelectionMethod::proposal_rate`], each drawn independently from one law. A proposal may turn
/// out to be nothing ([`SelectionMethod::resolve_proposal`] gives `None`): it takes its share of
/// time and has no other effect. So the law may be kept simple and still be exact, and proposals
/// may be drawn ahead in batches, which hides the latency of memory. Proposals drawn before a
/// change of the law are discarded; this is exact because draws do not depend on events in between.
pub trait SelectionMethod<P: SmoothPhysics>: Clone + Serialize + DeserializeOwned {
    /// Pair proposal drawn ahead, before the particles are known.
    type Draw: Copy + Default;

    /// Name of the selection method on the command line.
    const NAME: &'static str;

    /// Creates a pair selection that must be rebuilt before its first use.
    fn new() -> Self;

    /// Recomputes all bounds of speed and rate for the current particles.
    fn rebuild_bounds(&mut self, gas: &mut HomogeneousGas<P>);

    /// Returns the total rate of pair proposals, null ones included \[1/time\].
    fn proposal_rate(&self) -> f64;

    /// Draws one pair proposal; the proposal rate must be above zero.
    fn draw_proposal(&self, stream: &mut impl Rng) -> Self::Draw;

    /// Prefetches the table entries of a pair proposal that [`SelectionMethod::prefetch_particles`]
    /// reads.
    #[inline]
    fn prefetch_index(&self, _draw: &Self::Draw) {}

    /// Prefetches the two particles of a pair proposal.
    fn prefetch_particles(&self, gas: &HomogeneousGas<P>, draw: &Self::Draw);

    /// Returns the candidate pair that a proposal now refers to; `None` for a null proposal.
    fn resolve_proposal(&self, gas: &HomogeneousGas<P>, draw: &Self::Draw)
    -> Option<CandidatePair>;

    /// Updates the pair selection after the velocity of a particle has changed; returns the effect
    /// on proposals drawn ahead.
    fn velocity_changed(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity;

    /// Updates the pair selection after a particle was added at the end of the list. Sizes never
    /// change: particles that merge or break are removed, and new ones are added.
    fn particle_added(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity;

    /// Returns the number of collisions per particle after which the bounds are rebuilt.
    fn rebuild_interval(&self) -> f64;

    /// Returns the memory that the pair selection occupies \[bytes\].
    fn memory_bytes(&self) -> usize;
}
