//! Event calendars.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::mem;

use binary_heap_plus::{BinaryHeap, MinComparator};

/// One event: something may happen to `disk` at `time`, unless the disk has collided since, which its
/// `count` of collisions tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// When, relative to the epoch of the engine \[time\]; finite.
    pub time: f64,
    /// To whom.
    pub disk: u32,
    /// The disk's number of collisions when the event was predicted.
    pub count: u32,
}

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// By time; simultaneous events by the disks' numbers, so that the order is defined.
impl Ord for Entry {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        self.time
            .total_cmp(&other.time)
            .then_with(|| (self.disk, self.count).cmp(&(other.disk, other.count)))
    }
}

/// A priority queue of events.
pub trait Calendar: Sized {
    /// A calendar that holds the first event of each of `disks` disks.
    fn new(entries: Vec<Entry>, disks: usize) -> Self;

    /// Adds an event.
    fn push(&mut self, entry: Entry);

    /// Takes the earliest event if it is not later than `until`.
    fn pop(&mut self, until: f64) -> Option<Entry>;

    /// Memory held \[bytes\].
    fn bytes(&self) -> usize;
}

/// The plain calendar: a sorted set. The oracle of [`Buckets`].
#[derive(Debug, Default)]
pub struct Sorted(BTreeSet<Entry>);

impl Calendar for Sorted {
    fn new(entries: Vec<Entry>, _disks: usize) -> Self {
        Self(entries.into_iter().collect())
    }

    fn push(&mut self, entry: Entry) {
        self.0.insert(entry);
    }

    fn pop(&mut self, until: f64) -> Option<Entry> {
        if self.0.first()?.time > until {
            return None;
        }
        self.0.pop_first()
    }

    fn bytes(&self) -> usize {
        // Nodes of a B-tree are at least half full.
        2 * self.0.len() * size_of::<Entry>()
    }
}

/// A ring of time buckets with a heap for the current one.
///
/// Bucket number floor(t/width), computed the same way everywhere. An event of the current bucket or
/// before goes to the heap, one within the ring is appended to its bucket unsorted, a later one to the
/// far list, which is looked through four times a turn. When the heap is empty the next bucket's
/// storage becomes the heap and the heap's empty storage becomes that bucket, so nothing is allocated
/// in steady state. The width is chosen anew when the mean load of a bucket leaves [1, 16]: a cooling
/// gas slows down by orders of magnitude.
pub struct Buckets {
    inverse_width: f64,
    ring: Vec<Vec<Entry>>,
    /// Number of the current bucket.
    current: u64,
    heap: BinaryHeap<Entry, MinComparator>,
    far: Vec<Entry>,
    /// Events in the ring.
    near: usize,
    /// Events popped since the far list was last looked through.
    popped: usize,
    last_time: f64,
}

/// Events that a bucket should hold.
const LOAD: f64 = 4.0;

impl Buckets {
    #[inline]
    fn bucket(&self, time: f64) -> u64 {
        (time * self.inverse_width) as u64
    }

    fn mask(&self) -> u64 {
        self.ring.len() as u64 - 1
    }

    /// Buckets between two looks at the far list.
    fn quarter(&self) -> u64 {
        self.ring.len() as u64 / 4
    }

    #[inline]
    fn file(&mut self, entry: Entry) {
        let bucket = self.bucket(entry.time);
        if bucket <= self.current {
            self.heap.push(entry);
        } else if bucket - self.current < self.ring.len() as u64 {
            let slot = (bucket & self.mask()) as usize;
            self.ring[slot].push(entry);
            self.near += 1;
        } else {
            self.far.push(entry);
        }
    }

    /// Moves what has come near from the far list into the ring.
    fn refile(&mut self) {
        let mut far = mem::take(&mut self.far);
        let length = self.ring.len() as u64;
        far.retain(|&entry| {
            let stays = self.bucket(entry.time).saturating_sub(self.current) >= length;
            if !stays {
                self.file(entry);
            }
            stays
        });
        self.far = far;
    }

    /// Chooses the width anew for `LOAD` events a bucket at the given rate and files everything again.
    fn rebuild(&mut self, rate: f64) {
        let mut all = mem::replace(
            &mut self.heap,
            BinaryHeap::from_vec_cmp(Vec::new(), MinComparator),
        )
        .into_vec();
        for bucket in &mut self.ring {
            all.append(bucket);
        }
        all.append(&mut self.far);
        self.near = 0;
        self.inverse_width = rate / LOAD;
        self.current = self.bucket(self.last_time);
        for entry in all {
            self.file(entry);
        }
    }

    /// Goes to the next bucket; false if there is no event at all.
    fn turn(&mut self) -> bool {
        if self.near == 0 {
            let Some(first) = self
                .far
                .iter()
                .map(|entry| entry.time)
                .min_by(f64::total_cmp)
            else {
                return false;
            };
            self.current = self.bucket(first).saturating_sub(1);
            self.popped = 0;
            self.refile();
        }
        self.current = self.current.saturating_add(1);
        if self.current.is_multiple_of(self.quarter()) {
            let load = self.popped as f64 / self.quarter() as f64;
            self.popped = 0;
            // An emptied heap and a bucket boundary: nothing of the current bucket is in flight.
            if load > 16.0 || (load > 0.0 && load < 1.0) {
                let rate = load * self.inverse_width;
                self.current -= 1;
                self.rebuild(rate);
                return true;
            }
            self.refile();
        }
        let slot = (self.current & self.mask()) as usize;
        let bucket = mem::take(&mut self.ring[slot]);
        self.near -= bucket.len();
        let early = mem::replace(
            &mut self.heap,
            BinaryHeap::from_vec_cmp(bucket, MinComparator),
        )
        .into_vec();
        if early.is_empty() {
            self.ring[slot] = early;
        } else {
            // Filed by `refile` into the bucket that has just become the current one.
            self.heap.extend(early);
        }
        true
    }
}

impl Calendar for Buckets {
    fn new(entries: Vec<Entry>, disks: usize) -> Self {
        // The rate of events from the earliest twentieth of them.
        let mut times: Vec<f64> = entries.iter().map(|entry| entry.time).collect();
        let nth = times.len() / 20;
        let rate = if times.is_empty() {
            1.0
        } else {
            let early = *times.select_nth_unstable_by(nth, f64::total_cmp).1;
            (nth + 1) as f64 / early.max(f64::MIN_POSITIVE)
        };
        let rate = if rate.is_finite() { rate } else { 1.0 };
        let buckets = (disks / 2).next_power_of_two().max(16);
        let mut calendar = Self {
            inverse_width: rate / LOAD,
            ring: vec![Vec::new(); buckets],
            current: 0,
            heap: BinaryHeap::from_vec_cmp(Vec::new(), MinComparator),
            far: Vec::new(),
            near: 0,
            popped: 0,
            last_time: 0.0,
        };
        for entry in entries {
            calendar.file(entry);
        }
        calendar
    }

    #[inline]
    fn push(&mut self, entry: Entry) {
        debug_assert!(entry.time.is_finite() && entry.time >= self.last_time);
        self.file(entry);
    }

    #[inline]
    fn pop(&mut self, until: f64) -> Option<Entry> {
        loop {
            if let Some(first) = self.heap.peek() {
                if first.time > until {
                    return None;
                }
                self.popped += 1;
                self.last_time = first.time;
                return self.heap.pop();
            }
            if !self.turn() {
                return None;
            }
        }
    }

    fn bytes(&self) -> usize {
        let buckets: usize = self.ring.iter().map(Vec::capacity).sum();
        (buckets + self.far.capacity() + self.heap.capacity()) * size_of::<Entry>()
            + self.ring.capacity() * size_of::<Vec<Entry>>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// The same events in the same order as the sorted set, while the rate of events changes by
    /// twelve decades in both directions, with ties, bursts and long silences.
    #[test]
    fn buckets_pop_what_the_sorted_set_pops() {
        for seed in 0..8 {
            let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
            let disks = 200;
            let entries: Vec<Entry> = (0..disks)
                .map(|disk| Entry {
                    time: stream.random::<f64>(),
                    disk,
                    count: 0,
                })
                .collect();
            let mut fast = Buckets::new(entries.clone(), disks as usize);
            let mut plain = Sorted::new(entries, disks as usize);
            let mut until = 0.0;
            for step in 0..60_000_u32 {
                let expected = plain.pop(until);
                assert_eq!(fast.pop(until), expected);
                let Some(entry) = expected else {
                    match plain.0.first() {
                        Some(next) => until = next.time * (1.0 + stream.random::<f64>()),
                        None => break,
                    }
                    continue;
                };
                let decade = 6.0 * (f64::from(step) * 2e-4).sin();
                let mut wait = 10.0_f64.powf(decade) * -stream.random::<f64>().ln();
                if stream.random_bool(0.05) {
                    wait = 0.0;
                } else if stream.random_bool(0.02) {
                    wait *= 1e5;
                }
                for copy in 0..=u32::from(stream.random_bool(0.02)) {
                    let next = Entry {
                        time: entry.time + wait,
                        disk: entry.disk,
                        count: 2 * step + copy,
                    };
                    fast.push(next);
                    plain.push(next);
                }
            }
        }
    }

    #[test]
    fn empty_and_distant_calendars() {
        let mut empty = Buckets::new(Vec::new(), 0);
        assert_eq!(empty.pop(f64::INFINITY), None);
        let late = Entry {
            time: 1e300,
            disk: 0,
            count: 0,
        };
        empty.push(late);
        assert_eq!(empty.pop(1e299), None);
        assert_eq!(empty.pop(f64::INFINITY), Some(late));
    }
}
