//! First contacts of all disks of a start.

use std::ops::Range;

use stosszahl_model::threads::each_of;
use stosszahl_model::{Field, ParticleModel, Plane, Sizes};

use crate::calendar::Calendar;
use crate::contact::Candidates;
use crate::disk::DiskSystem;
use crate::engine::EventDrivenEngine;

/// Number of disks whose contacts are found by one thread at a time.
const GROUP: usize = 1024;
/// Number of groups of [`GROUP`] disks whose contacts are kept at a time.
const GROUPS: usize = 64;

/// Contacts of [`GROUP`] disks in sequence.
#[derive(Default)]
struct Ahead {
    /// Contacts, as wait \[time\] and partner, of one disk after the other.
    contacts: Vec<(f64, u32)>,
    /// End of the contacts of each disk.
    ends: Vec<usize>,
    /// Number of candidates tested.
    looked: u64,
}

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Predicts the next contacts of all disks, which have none, as if disk after disk predicted:
    /// for each disk the earliest contact that is not left to an earlier disk.
    ///
    /// The set of contacts does not depend on the order, so that all threads search for it if the
    /// gas is spread over them.
    pub(crate) fn look_at_all(&mut self) {
        let count = self.disks.all.len();
        if self.disks.hierarchical() || self.disks.cells.wide() {
            (0..count as u32).for_each(|disk| self.predict_from_scratch(disk));
            return;
        }
        let shared = self.parallel;
        for first in (0..count).step_by(GROUP * GROUPS) {
            let last = count.min(first + GROUP * GROUPS);
            let groups = each_of(shared, (first..last).step_by(GROUP), |_, begin| {
                self.look_ahead(begin..last.min(begin + GROUP))
            });
            let mut disk = first as u32;
            for group in &groups {
                self.tally.predictions += group.looked;
                let mut begin = 0;
                for &end in &group.ends {
                    (self.disks).expect_earliest(disk, &group.contacts[begin..end]);
                    self.look_at_surroundings(disk);
                    (begin, disk) = (end, disk + 1);
                }
            }
        }
    }

    /// Predicts all contacts of a range of disks with their neighbours.
    fn look_ahead(&self, disks: Range<usize>) -> Ahead {
        let mut ahead = Ahead::default();
        let mut candidates = self.candidates.clone();
        for disk in disks {
            ahead.looked += self.disks.contacts(
                &mut candidates,
                disk as u32,
                self.scene.sizes(),
                &self.tags,
                &mut ahead.contacts,
            );
            ahead.ends.push(ahead.contacts.len());
        }
        ahead
    }
}

impl<F: Field<Plane>> DiskSystem<F> {
    /// Finds all contacts with the disks around one, in a single grid, after a wait and in the
    /// order of their lists. Returns the number of candidates.
    fn contacts<S: Sizes>(
        &self,
        candidates: &mut Candidates,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
        all: &mut Vec<(f64, u32)>,
    ) -> u64 {
        let lists = self.open(self.home(who), self.all[who as usize].clock);
        self.gather::<S, false>(lists, candidates, who, sizes, tags, |candidates| {
            all.extend(candidates.all_candidates(self.slides(who, sizes, tags)));
        })
    }

    /// Records the earliest of some contacts that is not left to its partner.
    fn expect_earliest(&mut self, who: u32, contacts: &[(f64, u32)]) {
        let clock = self.all[who as usize].clock;
        let (mut limit, mut best) = (f64::INFINITY, None);
        for &(wait, other) in contacts {
            if wait < limit && wait <= self.all[other as usize].contact - clock {
                limit = wait;
                best = Some((wait, other));
            }
        }
        self.expect_first(who, best);
    }
}

#[cfg(test)]
mod tests {
    use crate::Buckets;
    use crate::cells::NONE;
    use crate::disk::tests::lattice;

    use super::*;

    /// Prediction of all at once, by one thread or more, equals one after the other, bit by bit:
    /// some contacts are left to the other disk. There are more disks than are kept at a time.
    #[test]
    fn all_at_once_is_one_after_the_other() {
        let mut engine = lattice::<Buckets>(260);
        engine
            .advance(f64::INFINITY, 50_000, &mut ())
            .expect("disorder");
        for disk in 0..engine.disks.all.len() as u32 {
            engine.disks.advance(disk, engine.now);
        }
        let forget = |engine: &mut EventDrivenEngine<_, Buckets>| {
            engine.tally.predictions = 0;
            for disk in 0..engine.disks.all.len() as u32 {
                engine.disks.expect_contact(disk, f64::INFINITY, NONE);
            }
        };
        let known = |engine: &EventDrivenEngine<_, Buckets>| {
            let disks = engine.disks.all.iter();
            let contacts: Vec<_> = disks
                .map(|disk| (disk.contact, disk.partner, disk.partner_count))
                .collect();
            (contacts, engine.tally.predictions)
        };
        forget(&mut engine);
        for disk in 0..engine.disks.all.len() as u32 {
            engine.predict_from_scratch(disk);
        }
        let one_by_one = known(&engine);
        for parallel in [false, true] {
            forget(&mut engine);
            engine.parallel = parallel;
            engine.look_at_all();
            assert!(known(&engine) == one_by_one);
        }
        // The earliest contact of each disk, also those left to others, would be different.
        let mut contacts = Vec::new();
        let left = (0..engine.disks.all.len() as u32).filter(|&disk| {
            contacts.clear();
            let (sizes, tags) = (engine.scene.sizes(), &engine.tags);
            let mut candidates = engine.candidates.clone();
            (engine.disks).contacts(&mut candidates, disk, sizes, tags, &mut contacts);
            let earliest = contacts
                .iter()
                .map(|its| its.0)
                .fold(f64::INFINITY, f64::min);
            engine.disks.all[disk as usize].contact > engine.now + earliest
        });
        assert!(left.count() > 1000);
    }
}
