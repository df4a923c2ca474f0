//! Interface of selections of pairs.

use rand::Rng;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::gas::{HomogeneousGas, SmoothPhysics};

/// Candidate pair of the acceptance-rejection method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePair {
    /// Index of the first partner.
    pub first: u32,
    /// Index of the second partner; never the first.
    pub second: u32,
    /// Upper bound of the relative speed of the pair \[length/time\]. The pair is proposed at the
    /// rate `k bound`, k being its kernel, so that acceptance with the probability `g/bound` makes
    /// it collide at the rate `k g`.
    pub bound: f64,
}

/// Consequence of a change of a particle for the proposals that were drawn before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProposalValidity {
    /// The law of proposals is unchanged.
    Kept,
    /// The law has changed; proposals that were drawn ahead are void.
    Changed,
    /// The selection must be rebuilt before the next proposal.
    Outdated,
}

/// Method to propose pairs, each at a known rate that is at least its collision rate.
///
/// Between two changes, proposals form a Poisson process of constant rate
/// [`SelectionMethod::proposal_rate`], each drawn independently from one law. A proposal may turn
/// out to be nothing ([`SelectionMethod::resolve_proposal`] gives `None`): it takes its share of
/// time and has no other effect. So the law may be kept simple and still be exact, and proposals
/// may be drawn ahead in batches, which hides the latency of memory. Proposals drawn before a
/// change of the law are discarded; this is exact because draws do not depend on events in between.
pub trait SelectionMethod<P: SmoothPhysics>: Clone + Serialize + DeserializeOwned {
    /// Proposal that is drawn ahead.
    type Draw: Copy + Default;

    /// Name on the command line.
    const NAME: &'static str;

    /// Creates a selection that must be rebuilt before its first use.
    fn new() -> Self;

    /// Adapts all bounds to the current state.
    fn rebuild_bounds(&mut self, gas: &mut HomogeneousGas<P>);

    /// Rate of proposals, null ones included \[1/time\].
    fn proposal_rate(&self) -> f64;

    /// Draws one proposal; the rate is above zero.
    fn draw_proposal(&self, stream: &mut impl Rng) -> Self::Draw;

    /// Prefetches the memory that [`SelectionMethod::prefetch_particles`] reads.
    #[inline]
    fn prefetch_index(&self, _draw: &Self::Draw) {}

    /// Prefetches the particles of a proposal.
    fn prefetch_particles(&self, gas: &HomogeneousGas<P>, draw: &Self::Draw);

    /// Returns the particles that are now in the slots of a proposal; `None` for a null proposal.
    fn resolve_proposal(&self, gas: &HomogeneousGas<P>, draw: &Self::Draw)
    -> Option<CandidatePair>;

    /// Updates the selection for a new velocity of a particle.
    fn velocity_changed(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity;

    /// Updates the selection for a particle that was added at the end of the list. Sizes never
    /// change: particles that merge or break are gone, and their successors are added.
    fn particle_added(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity;

    /// Collisions per particle after which the bounds are rebuilt.
    fn rebuild_interval(&self) -> f64;

    /// Memory held \[bytes\].
    fn memory_bytes(&self) -> usize;
}
