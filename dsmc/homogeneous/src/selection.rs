//! What every selection of pairs must offer.

use rand::Rng;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::gas::{Gas, Grains};

/// Two particles that may collide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Index of one partner.
    pub first: u32,
    /// Index of the other; never the first.
    pub second: u32,
    /// A speed that bounds the pair's: the pair is proposed at the rate `k bound`, k its kernel, so that accepting it
    /// with the probability `g/bound` makes it collide at the rate `k g`.
    pub bound: f64,
}

/// What a change of a particle means for the proposals that were drawn before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// The law of proposals is what it was.
    Kept,
    /// The law is another; proposals that were drawn ahead are void.
    Changed,
    /// The selection must be rebuilt before the next proposal.
    Outdated,
}

/// A way to propose pairs, each at a known rate that is at least its collision rate.
///
/// Between two changes, proposals form a Poisson process of constant rate [`Selection::rate`], each drawn independently
/// from one law. A proposal may turn out to be nothing ([`Selection::resolve`] gives `None`): it takes its share of time
/// and has no other effect. So the law may be kept simple and still be exact, and proposals may be drawn ahead in
/// batches, which hides the latency of memory: what was drawn before a change of the law is thrown away, which is exact
/// because the draws do not depend on anything that happened in between.
pub trait Selection<P: Grains>: Clone + Serialize + DeserializeOwned {
    /// What is drawn ahead.
    type Draw: Copy + Default;

    /// Name, as on the command line.
    const NAME: &'static str;

    /// A selection that must be rebuilt before its first use.
    fn new() -> Self;

    /// Fits all bounds to the present state.
    fn rebuild(&mut self, gas: &mut Gas<P>);

    /// Proposals per unit of time, null ones included.
    fn rate(&self) -> f64;

    /// Draws one proposal; the rate is above zero.
    fn draw(&self, stream: &mut impl Rng) -> Self::Draw;

    /// Calls up the memory that [`Selection::prefetch_particles`] will look at.
    #[inline]
    fn prefetch_index(&self, _draw: &Self::Draw) {}

    /// Calls up the particles.
    fn prefetch_particles(&self, gas: &Gas<P>, draw: &Self::Draw);

    /// Who stands at the places that were drawn, now.
    fn resolve(&self, gas: &Gas<P>, draw: &Self::Draw) -> Option<Candidate>;

    /// Takes note of a new velocity of a particle.
    fn changed(&mut self, gas: &mut Gas<P>, index: u32) -> Standing;

    /// Takes note of a particle that was added at the end of the list. Sizes never change: what merges or breaks is gone,
    /// and what becomes of it is added.
    fn added(&mut self, gas: &mut Gas<P>, index: u32) -> Standing;

    /// Collisions per particle after which the bounds are fitted again.
    fn lifetime(&self) -> f64;

    /// Bytes held.
    fn bytes(&self) -> usize;
}
