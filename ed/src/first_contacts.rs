//! Prediction of the first contacts of all disks at the start of an engine, by all threads.

use std::ops::Range;

use stosszahl_model::threads::each_of;
use stosszahl_model::{Field, ParticleModel, Plane, Sizes};

use crate::calendar::Calendar;
use crate::contact::Candidates;
use crate::disk::DiskSystem;
use crate::engine::EventDrivenEngine;

/// Number of disks in a group whose first contacts one thread predicts at a time.
const GROUP: usize = 1024;
/// Number of groups of [`GROUP`] disks whose contacts are kept in memory at a time.
const GROUPS: usize = 64;

/// Predicted contacts of the disks of one group, [`GROUP`] disks with successive numbers.
#[derive(Default)]
struct Ahead {
    /// Predicted contacts, as wait \[engine time\] and partner, of the group's disks one after the
    /// other.
    contacts: Vec<(f64, u32)>,
    /// Index after the last contact of each disk in the list `contacts`.
    ends: Vec<usize>,
    /// Number of candidate pairs tested for the group.
    looked: u64,
}

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Predicts the first contact of every disk: its earliest contact with a disk that has no
    /// earlier contact of its own.
    ///
    /// The set of contacts does not depend on the order of the disks, so that all threads search
    /// if the gas is spread over them.
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

    /// Predicts all contacts of a range of disks with the disks in the cells around them.
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
    /// Appends to `all` every contact of a disk with disks in the cells around it, as wait and
    /// partner. Returns the number of candidates tested.
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

    /// Stores the earliest of the contacts (wait, partner) of a disk that is not later than the
    /// partner's own predicted contact.
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
