//! Low-rank selection of Bodrova & Osinsky (2024): classes of size with one speed bound each, drawn
//! from trees of sums.
//!
//! Let `v_c` be the largest speed in class c, `n_c` its number and `a_c` its radius. The kernel is
//! a sum of products, so pairs are proposed by drawing a term (s, t), a first class by
//! `n_c v_c a_c^s`, a second one by `n_c a_c^t`, and a particle of each at random. Each pair is
//! thus proposed at the rate `k (v_c + v_d)`. A class whose fastest particle gets faster is updated
//! in its tree.
//!
//! Cost: logarithmic in the number of classes, per draw and update. The speed bound of a class
//! grows with its number of particles, which makes it looser than groups of like speed.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};
use stosszahl_model::{Sizes, Vector, memory};

use super::alias::split;
use super::classes::{ClassBounds, bring_to_rest, joined, raised};
use super::gas::{GONE, HomogeneousGas, SmoothPhysics, size_key};
use super::kernel::powers;
use super::selection::{CandidatePair, ProposalValidity, SelectionMethod};
use super::tree::SumTree;

/// Candidate pair, as two size classes and the index of a particle in each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Members {
    classes: [u32; 2],
    members: [u32; 2],
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Class {
    bounds: ClassBounds,
    members: Vec<u32>,
    /// True if all particles of the class have exactly the radius of its bound.
    exact: bool,
}

impl AsRef<ClassBounds> for Class {
    fn as_ref(&self) -> &ClassBounds {
        &self.bounds
    }
}

impl AsMut<ClassBounds> for Class {
    fn as_mut(&mut self) -> &mut ClassBounds {
        &mut self.bounds
    }
}

/// Low-rank selection of candidate pairs: size classes with one speed bound each, drawn by weight
/// from trees of sums.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LowRank {
    classes: Vec<Class>,
    /// Trees of the weights `n v a^s` of size classes for the first partner, one for each power s
    /// of the radius.
    first: [SumTree; 3],
    /// Trees of the weights `n a^t` of size classes for the second partner, one for each power t of
    /// the radius.
    second: [SumTree; 3],
    /// Proposal rates of the nine terms (s, t) of the collision kernel \[1/time\].
    terms: [f64; 9],
    /// Proposal rate, summed over the nine terms of the collision kernel \[1/time\].
    rate: f64,
    sizes_change: bool,
}

impl LowRank {
    fn weigh_class(&mut self, number: usize) {
        let class = &self.classes[number];
        let count = class.members.len() as f64;
        for (power, weight) in powers(class.bounds.radius).into_iter().enumerate() {
            self.first[power].set(number, count * class.bounds.square.sqrt() * weight);
            self.second[power].set(number, count * weight);
        }
    }

    fn weigh_terms<P: SmoothPhysics>(&mut self, gas: &HomogeneousGas<P>) {
        let m = gas.kernel().coefficients();
        for (s, row) in m.iter().enumerate() {
            for (t, coefficient) in row.iter().enumerate() {
                self.terms[3 * s + t] =
                    coefficient * self.first[s].total() * self.second[t].total();
            }
        }
        self.rate = self.terms.iter().sum();
    }
}

impl<P: SmoothPhysics> SelectionMethod<P> for LowRank {
    type Draw = Members;
    const NAME: &'static str = "low-rank";

    fn new() -> Self {
        Self {
            classes: Vec::new(),
            first: Default::default(),
            second: Default::default(),
            terms: [0.0; 9],
            rate: 0.0,
            sizes_change: false,
        }
    }

    fn rebuild_bounds(&mut self, gas: &mut HomogeneousGas<P>) {
        gas.sort();
        self.classes.clear();
        for (index, particle) in gas.particles.iter_mut().enumerate() {
            let radius = gas.scene.sizes().radius(particle.tag);
            let key = size_key(radius);
            if self
                .classes
                .last()
                .is_none_or(|class| class.bounds.key != key)
            {
                self.classes.push(Class {
                    bounds: ClassBounds::new(key),
                    members: Vec::new(),
                    exact: true,
                });
            }
            let number = self.classes.len() - 1;
            let class = &mut self.classes[number];
            class.exact &= class.members.is_empty() || class.bounds.radius == radius;
            class.bounds.admit(radius, particle.velocity.square());
            class.members.push(index as u32);
            particle.mark = number as u32;
        }
        bring_to_rest(&mut self.classes);
        for tree in self.first.iter_mut().chain(&mut self.second) {
            *tree = SumTree::new(self.classes.len());
        }
        for number in 0..self.classes.len() {
            self.weigh_class(number);
        }
        self.weigh_terms(gas);
    }

    fn proposal_rate(&self) -> f64 {
        self.rate
    }

    #[inline]
    fn draw_proposal(&self, stream: &mut impl Rng) -> Members {
        let mut place = stream.random::<f64>() * self.rate;
        let mut term = 0;
        for (number, &rate) in self.terms.iter().enumerate() {
            if rate > 0.0 {
                term = number;
                if place < rate {
                    break;
                }
                place -= rate;
            }
        }
        let classes = [
            self.first[term / 3].find_weight(stream.random()) as u32,
            self.second[term % 3].find_weight(stream.random()) as u32,
        ];
        let members = classes.map(|class| {
            let count = self.classes[class as usize].members.len() as u32;
            split(stream.next_u64(), count).0
        });
        Members { classes, members }
    }

    #[inline]
    fn prefetch_index(&self, draw: &Members) {
        for side in 0..2 {
            let members = &self.classes[draw.classes[side] as usize].members;
            memory::prefetch(members, draw.members[side] as usize);
        }
    }

    #[inline]
    fn prefetch_particles(&self, gas: &HomogeneousGas<P>, draw: &Members) {
        for side in 0..2 {
            let members = &self.classes[draw.classes[side] as usize].members;
            memory::prefetch(
                &gas.particles,
                members[draw.members[side] as usize] as usize,
            );
        }
    }

    #[inline]
    fn resolve_proposal(&self, gas: &HomogeneousGas<P>, draw: &Members) -> Option<CandidatePair> {
        let classes = draw.classes.map(|class| &self.classes[class as usize]);
        let [first, second] = [0, 1].map(|side| classes[side].members[draw.members[side] as usize]);
        let gone = |index: u32| gas.particles[index as usize].mark == GONE;
        if (first == second) || gone(first) || gone(second) {
            return None;
        }
        let mut bound = classes[0].bounds.square.sqrt() + classes[1].bounds.square.sqrt();
        if !(classes[0].exact & classes[1].exact) {
            let radius = |index: u32| gas.radius(&gas.particles[index as usize]);
            let pair = gas.kernel.rate_coefficient(radius(first), radius(second));
            bound *= gas
                .kernel
                .rate_coefficient(classes[0].bounds.radius, classes[1].bounds.radius)
                / pair;
        }
        Some(CandidatePair {
            first,
            second,
            bound,
        })
    }

    #[inline]
    fn velocity_changed(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity {
        let Some(number) = raised(gas, index, &mut self.classes) else {
            return ProposalValidity::Kept;
        };
        self.weigh_class(number);
        self.weigh_terms(gas);
        ProposalValidity::Changed
    }

    fn particle_added(&mut self, gas: &mut HomogeneousGas<P>, index: u32) -> ProposalValidity {
        let Some((number, radius)) = joined(gas, index, &self.classes) else {
            return ProposalValidity::Outdated;
        };
        let square = gas.particles[index as usize].velocity.square();
        let class = &mut self.classes[number];
        class.exact &= class.bounds.radius == radius;
        class.bounds.admit(radius, square);
        class.members.push(index);
        self.weigh_class(number);
        self.weigh_terms(gas);
        ProposalValidity::Changed
    }

    fn rebuild_interval(&self) -> f64 {
        1.0
    }

    fn memory_bytes(&self) -> usize {
        self.classes
            .iter()
            .map(|class| size_of::<Class>() + class.members.capacity() * size_of::<u32>())
            .sum::<usize>()
            + self
                .first
                .iter()
                .chain(&self.second)
                .map(SumTree::memory_bytes)
                .sum::<usize>()
    }
}
