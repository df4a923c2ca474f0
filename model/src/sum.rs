//! Parallel reductions over the particles of a gas, independent of the processes and threads that
//! hold them.
//!
//! A gas shows its particles in groups ([`Simulation::reduce_particles`](crate::Simulation::reduce_particles)). Which
//! particles form a group, their order in it and its number do not depend on how many processes or
//! threads hold the gas; the order of groups may. So within a group numbers are added as usual, and
//! groups are combined independently of their order: exactly ([`Totals`]), in the order of their
//! numbers once all are there ([`SparseSums`]), or as integers.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::bytes::to_bytes;
use crate::exact::ExactSum;
use crate::particle::Particle;

/// Reduction over particles that engines compute in groups of particles. An empty one is sent to
/// other processes to define theirs, so its options are part of it.
pub trait ParticleReduction: Serialize + DeserializeOwned {
    /// Name of the kind of reduction, by which another process finds its code.
    const NAME: &'static str;

    /// Adds a particle to the group that is open now.
    fn add_particle(&mut self, particle: &Particle);

    /// Closes the current group of particles, by its number; the next particle opens a new group.
    fn close_group(&mut self, _group: u32) {}

    /// Adds the result of another reduction of the same kind, with other groups.
    fn merge_sum(&mut self, other: Self);
}

/// Object-safe form of the trait [`ParticleReduction`], through which engines call it.
pub trait DynReduction {
    /// Returns the name of the kind of reduction.
    fn kind_name(&self) -> &'static str;

    /// Adds a particle to the group that is open now, by [`ParticleReduction::add_particle`].
    fn add_particle(&mut self, particle: &Particle);

    /// Closes the current group of particles, by [`ParticleReduction::close_group`].
    fn close_group(&mut self, group: u32);

    /// Serialises options and content of the reduction, for another process.
    fn save_bytes(&self) -> Vec<u8>;

    /// Adds the result of a reduction that another process has saved; false if the bytes are not of
    /// the same kind.
    fn add_saved(&mut self, bytes: &[u8]) -> bool;
}

impl<T: ParticleReduction> DynReduction for T {
    fn kind_name(&self) -> &'static str {
        T::NAME
    }

    fn add_particle(&mut self, particle: &Particle) {
        ParticleReduction::add_particle(self, particle);
    }

    fn close_group(&mut self, group: u32) {
        ParticleReduction::close_group(self, group);
    }

    fn save_bytes(&self) -> Vec<u8> {
        to_bytes(self)
    }

    fn add_saved(&mut self, bytes: &[u8]) -> bool {
        let other = postcard::from_bytes(bytes);
        other.map(|other| self.merge_sum(other)).is_ok()
    }
}

/// Function that restores a reduction from bytes that another process has saved, by the name of its
/// kind; `None` for an unknown kind.
pub type ReductionFactory = fn(&str, &[u8]) -> Option<Box<dyn DynReduction>>;

/// Restores a reduction of the type `T` from saved bytes: a [`ReductionFactory`] for one kind.
pub fn restore_reduction<T: ParticleReduction + 'static>(
    name: &str,
    bytes: &[u8],
) -> Option<Box<dyn DynReduction>> {
    if name != T::NAME {
        return None;
    }
    let sum: T = postcard::from_bytes(bytes).ok()?;
    Some(Box::new(sum))
}

/// Short array of order-independent sums (superaccumulators) over particles, one for each slot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Totals {
    sums: Vec<ExactSum>,
    /// Sum in each slot over the group that is open now.
    #[serde(skip)]
    open: Vec<f64>,
}

impl Totals {
    /// Creates an array of `slots` empty order-independent sums.
    pub fn new(slots: usize) -> Self {
        Self {
            sums: vec![ExactSum::default(); slots],
            open: Vec::new(),
        }
    }

    /// Returns the sum in each slot over the group that is open now, to be added to.
    #[inline]
    pub fn open(&mut self) -> &mut [f64] {
        if self.open.is_empty() {
            self.open = vec![0.0; self.sums.len()];
        }
        &mut self.open
    }

    /// Closes the current group: adds its sums exactly to the totals.
    pub fn close(&mut self) {
        for (sum, part) in self.sums.iter_mut().zip(&mut self.open) {
            sum.add(std::mem::take(part));
        }
    }

    /// Adds the closed groups of another array of sums to this one.
    pub fn merge(&mut self, other: &Self) {
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            sum.merge(more);
        }
    }

    /// Returns the total in each slot, rounded.
    pub fn values(&self) -> Vec<f64> {
        self.sums.iter().map(ExactSum::value).collect()
    }
}

/// Sparse array of sums by slot: each group adds to few slots of many. The sums of groups are kept
/// apart until all groups are complete.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SparseSums<T> {
    slots: usize,
    /// Sums of closed groups, with group and slot.
    all: Vec<(u32, u32, T)>,
    /// Sum in each slot over the group that is open now; `None` for slots without one.
    #[serde(skip)]
    open: Vec<Option<T>>,
    #[serde(skip)]
    touched: Vec<u32>,
}

impl<T: Copy + Default> SparseSums<T> {
    /// Creates an empty sparse array of sums with `slots` slots.
    pub fn new(slots: usize) -> Self {
        Self {
            slots,
            all: Vec::new(),
            open: Vec::new(),
            touched: Vec::new(),
        }
    }

    /// Returns the sum in a slot over the group that is open now, zero at first, to be added to.
    ///
    /// # Panics
    /// If `slot` is not below the number of slots.
    #[inline]
    pub fn sum_at(&mut self, slot: usize) -> &mut T {
        if self.open.is_empty() {
            self.open = vec![None; self.slots];
        }
        let touched = &mut self.touched;
        self.open[slot].get_or_insert_with(|| {
            touched.push(slot as u32);
            T::default()
        })
    }

    /// Closes the current group of particles, and keeps its sums under its number.
    pub fn close(&mut self, group: u32) {
        for slot in self.touched.drain(..) {
            let part = self.open[slot as usize].take();
            self.all.extend(part.map(|part| (group, slot, part)));
        }
    }

    /// Adds the closed groups of another sparse array of sums to this one.
    pub fn merge(&mut self, other: Self) {
        self.all.extend(other.all);
    }

    /// Calls `show` for the sums of all groups with their slots, in the order of group numbers.
    pub fn in_order(mut self, mut show: impl FnMut(usize, &T)) {
        self.all
            .sort_unstable_by_key(|&(group, slot, _)| (group, slot));
        for (_, slot, part) in &self.all {
            show(*slot as usize, part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights by species as both kinds of sums, to compare them.
    #[derive(Serialize, Deserialize)]
    struct Both {
        totals: Totals,
        parts: SparseSums<f64>,
    }

    impl Both {
        fn new() -> Self {
            Self {
                totals: Totals::new(3),
                parts: SparseSums::new(3),
            }
        }

        fn values(self) -> [Vec<f64>; 2] {
            let mut sums = vec![0.0; 3];
            self.parts.in_order(|place, part| sums[place] += part);
            [self.totals.values(), sums]
        }
    }

    impl ParticleReduction for Both {
        const NAME: &'static str = "both";

        fn add_particle(&mut self, particle: &Particle) {
            let place = particle.species as usize;
            self.totals.open()[place] += particle.weight;
            *self.parts.sum_at(place) += particle.weight;
        }

        fn close_group(&mut self, group: u32) {
            self.totals.close();
            self.parts.close(group);
        }

        fn merge_sum(&mut self, other: Self) {
            self.totals.merge(&other.totals);
            self.parts.merge(other.parts);
        }
    }

    /// Numbers whose sum depends on the order: groups one after the other, and dealt to three that
    /// are put together in another order.
    #[test]
    fn the_order_of_groups_is_nobodys_concern() {
        let show = |sum: &mut dyn DynReduction, group: u32| {
            for number in 0..50 {
                let seed = f64::from(group * 50 + number + 1);
                sum.add_particle(&Particle {
                    species: (group + number / 40) % 3,
                    weight: (seed * 1.7).sin() * 10_f64.powi((seed * 0.7).cos() as i32 * 9),
                    ..Particle::at_rest(1.0, 1.0)
                });
            }
            sum.close_group(group);
        };
        let mut alone = Both::new();
        (0..30).for_each(|group| show(&mut alone, group));
        let asked = DynReduction::save_bytes(&Both::new());
        let mut hands: Vec<_> = (0..3)
            .map(|_| restore_reduction::<Both>("both", &asked).expect("a sum"))
            .collect();
        for group in (0..30).rev() {
            show(&mut *hands[group as usize % 3], group);
        }
        let mut all = Both::new();
        for hand in [1, 2, 0] {
            assert!(all.add_saved(&hands[hand].save_bytes()));
        }
        assert!(!all.add_saved(&[1]));
        let [wanted, found] = [alone.values(), all.values()]
            .map(|[a, b]| a.into_iter().chain(b).map(f64::to_bits).collect::<Vec<_>>());
        assert_eq!(wanted, found);
        assert!(restore_reduction::<Both>("other", &asked).is_none());
    }
}
