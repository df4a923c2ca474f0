//! Bird's acceptance-rejection selection of pairs: any two particles with equal probability, with
//! one majorant of the collision rate for all pairs.
//!
//! The baseline method. The majorant is the largest `k(a_c, a_d)(v_c + v_d)` over two classes of
//! size with their largest radii and speeds. That is tighter than the largest radius with the
//! largest speed, and as exact. The majorant is raised as soon as a particle exceeds the speed of
//! its class.

use rand::Rng;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Sizes, Vector, memory};

use super::alias::split;
use super::classes::{ClassBounds, bring_to_rest, joined, raised};
use super::gas::{GONE, HomogeneousGas, SmoothPhysics, size_key};
use super::selection::{CandidatePair, ProposalValidity, SelectionMethod};

/// Candidate pair, as the indices of two particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairIndices {
    first: u32,
    second: u32,
}

/// Bird's selection of candidate pairs: any two particles, with one majorant of the collision rate
/// for all pairs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Bird {
    classes: Vec<ClassBounds>,
    majorant: f64,
    rate: f64,
    listed: u32,
}

impl Bird {
    /// Raises the majorant so that it bounds the collision rates of all pairs with a particle of
    /// the size class `number`, and updates the proposal rate.
    fn raise<P: SmoothPhysics>(&mut self, gas: &HomogeneousGas<P>, number: usize) {
        let own = self.classes[number];
        for other in &self.classes {
            let speeds = own.square.sqrt() + other.square.sqrt();
            let pair = gas.kernel().rate_coefficient(own.radius, other.radius) * speeds;
            self.majorant = self.majorant.max(pair);
        }
        self.listed = gas.particles.len() as u32;
        let listed = f64::from(self.listed);
        self.rate = 0.5 * listed * (listed - 1.0).max(0.0) * self.majorant;
    }
}

impl<P: SmoothPhysics> SelectionMethod<P> for Bird {
    type Draw = PairIndices;
    const NAME: &'static str = "single-majorant";

    fn new() -> Self {
        Self {
            classes: Vec::new(),
            majorant: 0.0,
            rate: 0.0,
            listed: 0,
        }
    }

    fn rebuild_bounds(&mut self, gas: &mut HomogeneousGas<P>) {
        gas.sort();
        self.classes.clear();
        for particle in &mut gas.particles {
            let radius = gas.scene.sizes().radius(particle.tag);
            let key = size_key(radius);
            if self.classes.last().is_none_or(|class| class.key != key) {
                self.classes.push(ClassBounds::new(key));
            }
            let number = self.classes.len() - 1;
            self.classes[number].admit(radius, particle.velocity.square());
            particle.mark = number as u32;
        }
        bring_to_rest(&mut self.classes);
        self.majorant = 0.0;
        self.rate = 0.0;
        for number in 0..self.classes.len() {
            self.raise(gas, number);
        }
    }

    fn proposal_rate(&self) -> f64 {
        self.rate
    }

    #[inline]
    fn draw_proposal(&self, stream: &mut impl Rng) -> PairIndices {
        let (first, _) = split(stream.next_u64(), self.listed);
        let (other, _) = split(stream.next_u64(), self.listed - 1);
        PairIndices {
            first,
            second: other + u32::from(other >= first),
        }
    }

    #[inline]
    fn prefetch_particles(&self, gas: &HomogeneousGas<P>, draw: &PairIndices) {
        memory::prefetch(&gas.particles, draw.first as usize);
        memory::prefetch(&gas.particles, draw.second as usize);
    }

    #[inline]
    fn resolve_proposal(
        &self,
        gas: &HomogeneousGas<P>,
        draw: &PairIndices,
    ) -> Option<CandidatePair> {
        let [first, second] = [draw.first, draw.second].map(|index| &gas.particles[index as usize]);
        if (first.mark == GONE) | (second.mark == GONE) {
            return None;
        }
        let pair = gas
            .kernel
            .rate_coefficient(gas.radius(first), gas.radius(second));
        Some(CandidatePair {
            first: draw.first,
            second: draw.second,
            bound: self.majorant / pair,
        })
    }

    #[inline]
    fn velocity_changed(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity {
        let Some(number) = raised(gas, index, &mut self.classes) else {
            return ProposalValidity::Kept;
        };
        self.raise(gas, number);
        ProposalValidity::Changed
    }

    fn particle_added(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity {
        let Some((number, radius)) = joined(gas, index, &self.classes) else {
            return ProposalValidity::Outdated;
        };
        let square = gas.particles[index as usize].velocity.square();
        self.classes[number].admit(radius, square);
        self.raise(gas, number);
        ProposalValidity::Changed
    }

    fn rebuild_interval(&self) -> f64 {
        1.0
    }

    fn memory_bytes(&self) -> usize {
        self.classes.capacity() * size_of::<ClassBounds>()
    }
}
