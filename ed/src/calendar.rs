//! Event calendars: priority queues of the next events of all disks, as a ring of time buckets
//! (`Buckets`) and as a sorted set (`Sorted`).

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::hint::select_unpredictable;

use binary_heap_plus::{BinaryHeap, MinComparator};
use stosszahl_model::memory;

use crate::prefetch_plan::{AHEAD, NAMES, PrefetchPlan};

/// Calendar entry: the time of the next event of one disk, and the number of the disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalendarEntry {
    /// Time of the event, counted from the epoch of the engine \[engine time\]: zero or more;
    /// finite if the event is returned by a calendar.
    pub time: f64,
    /// Number in the engine of the disk whose event this is.
    pub disk: u32,
}

impl CalendarEntry {
    /// Returns time and disk of the event as one integer that sorts like them: bits of non-negative
    /// times sort like the times.
    #[inline]
    fn key(self) -> u128 {
        u128::from(self.time.to_bits()) << 32 | u128::from(self.disk)
    }
}

impl Eq for CalendarEntry {}

impl PartialOrd for CalendarEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Order by time; simultaneous events by the disks' numbers, so that the order is defined.
impl Ord for CalendarEntry {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

/// Source of the next event times of all disks, from which a calendar is filled and checked. A disk
/// has at most one event.
pub trait EventTimes {
    /// Returns the number of disks of the gas.
    fn disks(&self) -> u32;

    /// Returns the time of the next event of a disk; infinite if it has none.
    fn time(&self, disk: u32) -> f64;

    /// Returns true if this source of event times wants announcements of coming events, for
    /// prefetching.
    fn foresighted(&self) -> bool {
        false
    }

    /// Announces disks whose events come up `_ahead` buckets from now; that bucket ends at the time
    /// `_end`. `_plan` keeps prefetch data until then; after a jump of the calendar it may belong
    /// to other disks.
    fn expect(&self, _disks: &[u32], _ahead: usize, _end: f64, _plan: &mut PrefetchPlan) {}

    /// Prefetches the record of the predicted collision partner of a disk in the current bucket.
    /// Returns the partner's number; a number beyond all disks if there is none.
    fn prefetch_partner(&self, disk: u32) -> usize {
        disk as usize
    }
}

/// Event calendar: a priority queue of the next events of all disks.
///
/// Nothing is ever removed but by [`Calendar::pop`]: an entry is stale when its disk's next event
/// is at another time. A calendar may drop stale entries, or announce them; the caller can
/// recognise them. It may not announce an entry twice unless it was pushed twice.
pub trait Calendar: Sized + Send + Sync {
    /// Creates a calendar filled with the events of all disks; none of them is earlier than `now`.
    fn new(agenda: &impl EventTimes, now: f64) -> Self;

    /// Adds the next event of a disk, not earlier than the last event popped. It replaces an
    /// earlier entry of the disk; an infinite time means no event. After each pop, the popped
    /// disk's next event must be pushed before the next pop.
    fn push(&mut self, entry: CalendarEntry);

    /// Adds the next event of a disk, unless the calendar already holds exactly this event.
    fn push_once(&mut self, entry: CalendarEntry) {
        self.push(entry);
    }

    /// Removes and returns the earliest event if its time is `until` or earlier.
    fn pop(&mut self, until: f64, agenda: &impl EventTimes) -> Option<CalendarEntry>;

    /// Returns the memory that the calendar occupies \[bytes\].
    fn memory_bytes(&self) -> usize;
}

/// Returns the next events of all disks that have one, as calendar entries.
fn all_entries(agenda: &impl EventTimes) -> impl Iterator<Item = CalendarEntry> {
    (0..agenda.disks())
        .map(|disk| CalendarEntry {
            time: agenda.time(disk),
            disk,
        })
        .filter(|entry| entry.time.is_finite())
}

/// Estimates the rate of events \[1/time\] from the waiting times for the next events: from the
/// shortest twentieth of them, unless these coincide.
pub(crate) fn rate(mut waits: Vec<f64>) -> f64 {
    waits.retain(|&wait| wait > 0.0);
    if waits.is_empty() {
        return 1.0;
    }
    let nth = waits.len() / 20;
    let half = waits.len() / 2;
    let median = *waits.select_nth_unstable_by(half, f64::total_cmp).1;
    let early = *waits.select_nth_unstable_by(nth, f64::total_cmp).1;
    let rate = (nth + 1) as f64 / early.max(1e-4 * median).max(f64::MIN_POSITIVE);
    rate.min(1e300)
}

/// Reference event calendar, a sorted set of entries, against which [`Buckets`] is tested.
#[derive(Debug, Default)]
pub struct Sorted(BTreeSet<CalendarEntry>);

impl Calendar for Sorted {
    fn new(agenda: &impl EventTimes, _now: f64) -> Self {
        Self(all_entries(agenda).collect())
    }

    fn push(&mut self, entry: CalendarEntry) {
        if entry.time.is_finite() {
            self.0.insert(entry);
        }
    }

    fn pop(&mut self, until: f64, _agenda: &impl EventTimes) -> Option<CalendarEntry> {
        if self.0.first()?.time > until {
            return None;
        }
        self.0.pop_first()
    }

    fn memory_bytes(&self) -> usize {
        // Nodes of a B-tree are at least half full.
        2 * self.0.len() * size_of::<CalendarEntry>()
    }
}

/// Event calendar as a ring of time buckets, each with the disks whose next event falls into it.
///
/// Bucket number floor(t/width), computed the same way everywhere. A bucket is one cache line that
/// names disks but no times, so that filing an event waits for nothing: the line is only written
/// to. When it becomes the current one, the time of each of its disks is looked up, which also
/// shows the stale ones, and the events of this bucket are lined up. An event of the current bucket
/// joins them, one beyond the ring goes to the far list, which is looked through four times a turn,
/// and one that finds its bucket full to a heap. As the disks of the next buckets are known, they
/// are prefetched before their turn.
///
/// Nothing is allocated in steady state. The width is chosen anew when the mean load of a bucket
/// leaves its bounds: a cooling gas slows down by orders of magnitude.
pub struct Buckets {
    inverse_width: f64,
    /// Time of the next event of each disk, by disk number; infinite if it has none.
    times: Vec<f64>,
    ring: Vec<Bucket>,
    /// Number of disks stored in each bucket of the ring.
    counts: Vec<u8>,
    /// Number of the current bucket: floor(time/width).
    current: u64,
    /// Events of the current bucket, unordered: the first `few` entries are valid.
    soon: Soon,
    /// Number of valid events in `soon`, the unordered list of the current bucket.
    few: usize,
    /// Events of the current bucket that do not fit into the short list `soon`, as a heap.
    crowd: BinaryHeap<CalendarEntry, MinComparator>,
    /// Bucket number and disk of events whose bucket in the ring is full, as a heap.
    spill: BinaryHeap<(u64, u32), MinComparator>,
    far: Vec<CalendarEntry>,
    /// Bucket number and disk of events not yet written into the ring, because their buckets are
    /// still being prefetched: the first `waits` entries are valid.
    waiting: [(u64, u32); WAITING],
    waits: usize,
    /// Prefetch plans of the next buckets; the plan of bucket n is at n modulo `AHEAD`.
    plans: [PrefetchPlan; AHEAD],
    /// Number of disk entries in the ring of buckets and in the overflow heap `spill`.
    near: usize,
    /// Number of events popped since bucket number `since` was current: the mean load follows from
    /// it.
    popped: usize,
    since: u64,
    last_time: f64,
}

/// Short unordered list of the events of the current bucket: bit patterns of times, and disks, as
/// two arrays. A pair read just after its parts were written would stall the processor. Unused
/// entries hold the largest time.
struct Soon {
    times: [u64; FEW],
    disks: [u32; FEW],
}

impl Soon {
    const NOTHING: Self = Self {
        times: [u64::MAX; FEW],
        disks: [0; FEW],
    };
}

#[derive(Clone, Copy)]
#[repr(align(64))]
struct Bucket([u32; NAMES]);

/// Target number of events per bucket, from which the width of buckets is chosen.
const LOAD: f64 = 8.0;

/// Least and largest mean number of events per bucket; beyond them a new width of buckets is
/// chosen.
const LOADS: [f64; 2] = [5.0, 11.0];

/// Capacity of the unordered list of the current bucket, whose earliest event is found by comparing
/// all.
const FEW: usize = 24;

/// Number of events compared together in the search for the earliest event, without a check of the
/// count.
const BLOCK: usize = 4;

/// Prefetch distance in the scan of the far list: number of entries ahead whose event times are
/// requested from memory.
const LOOK_AHEAD: usize = 16;

/// Capacity of the buffer of events that wait to be written into their buckets.
const WAITING: usize = 32;

impl Buckets {
    #[inline]
    fn bucket(&self, time: f64) -> u64 {
        // By way of a signed number, which is what processors convert to.
        (time * self.inverse_width) as i64 as u64
    }

    /// Returns the begin of the next bucket in units of the bucket width: the time of an event over
    /// the width is below it just if the event belongs to the current bucket or an earlier one.
    /// Infinite after the last bucket.
    fn next_begins(&self) -> f64 {
        if self.current >= i64::MAX as u64 {
            return f64::INFINITY;
        }
        let next = (self.current + 1) as f64;
        // Large numbers are rounded.
        if next as u64 > self.current {
            next
        } else {
            next.next_up()
        }
    }

    fn mask(&self) -> u64 {
        self.ring.len() as u64 - 1
    }

    /// Returns the number of buckets between two scans of the far list: a quarter of the ring.
    fn quarter(&self) -> u64 {
        self.ring.len() as u64 / 4
    }

    /// Stores an event in the current bucket, in the ring of buckets or in the far list, by its
    /// time; ignores infinite times.
    #[inline]
    fn file(&mut self, entry: CalendarEntry) {
        if !entry.time.is_finite() {
            return;
        }
        let number = self.bucket(entry.time);
        if number <= self.current {
            self.line_up(entry);
        } else if number - self.current < self.ring.len() as u64 {
            let slot = (number & self.mask()) as usize;
            memory::prefetch(&self.ring, slot);
            memory::prefetch(&self.counts, slot);
            self.waiting[self.waits % WAITING] = (number, entry.disk);
            self.waits += 1;
            if self.waits == WAITING {
                self.sort_bucket();
            }
        } else {
            self.far.push(entry);
        }
    }

    /// Writes all events of the waiting buffer into their buckets in the ring; those whose bucket
    /// is full go to the overflow heap.
    fn sort_bucket(&mut self) {
        for &(number, disk) in &self.waiting[..std::mem::take(&mut self.waits).min(WAITING)] {
            self.near += 1;
            let slot = (number & (self.ring.len() as u64 - 1)) as usize;
            let count = &mut self.counts[slot];
            if let Some(place) = self.ring[slot].0.get_mut(usize::from(*count)) {
                *place = disk;
                *count += 1;
            } else {
                self.spill.push((number, disk));
            }
        }
    }

    #[inline]
    fn line_up(&mut self, entry: CalendarEntry) {
        if self.few < FEW {
            self.soon.times[self.few] = entry.time.to_bits();
            self.soon.disks[self.few] = entry.disk;
            self.few += 1;
        } else {
            self.crowd.push(entry);
        }
    }

    /// Moves events that are now within the range of the ring from the far list to their buckets,
    /// and drops stale ones.
    fn refile(&mut self) {
        let length = self.ring.len() as u64;
        let mut kept = 0;
        for place in 0..self.far.len() {
            if let Some(later) = self.far.get(place + LOOK_AHEAD) {
                memory::prefetch(&self.times, later.disk as usize);
            }
            let entry = self.far[place];
            if self.times[entry.disk as usize] != entry.time {
                continue;
            }
            if self.bucket(entry.time).saturating_sub(self.current) >= length {
                self.far[kept] = entry;
                kept += 1;
            } else {
                self.file(entry);
            }
        }
        self.far.truncate(kept);
    }

    /// Rebuilds the calendar with a new width of buckets, such that a bucket has `LOAD` events at
    /// the given rate \[1/time\].
    fn rebuild(&mut self, rate: f64) {
        self.counts.fill(0);
        self.soon = Soon::NOTHING;
        self.few = 0;
        self.crowd.clear();
        self.spill.clear();
        self.far.clear();
        self.near = 0;
        self.waits = 0;
        self.inverse_width = rate.min(1e300) / LOAD;
        self.current = self.bucket(self.last_time);
        (self.popped, self.since) = (0, self.current);
        for disk in 0..self.times.len() {
            let time = self.times[disk];
            let disk = disk as u32;
            self.file(CalendarEntry { time, disk });
        }
    }

    /// Makes the next bucket the current one and collects its events; returns false if the calendar
    /// is empty.
    #[inline(always)]
    fn turn(&mut self, agenda: &impl EventTimes) -> bool {
        self.sort_bucket();
        if self.near == 0 {
            // Stale events are dropped first, because the earliest may be stale.
            self.far
                .retain(|entry| self.times[entry.disk as usize] == entry.time);
            // Wider buckets, if most events are beyond the ring.
            if self.far.len() > self.ring.len() / 8 {
                let waits = self.far.iter().map(|entry| entry.time - self.last_time);
                self.rebuild(rate(waits.collect()));
                if self.near + self.waits + self.few > 0 {
                    return true;
                }
            }
            let Some(first) = self.far.iter().min() else {
                return false;
            };
            self.current = self.bucket(first.time).saturating_sub(1);
            (self.popped, self.since) = (0, self.current);
            self.refile();
            self.sort_bucket();
        }
        self.current = self.current.saturating_add(1);
        if self.current.is_multiple_of(self.quarter()) {
            // Of fewer buckets, as there are after a jump or a rebuild, the mean load is not known
            // well.
            let passed = self.current - self.since;
            if passed >= self.quarter() / 2 {
                let load = self.popped as f64 / passed as f64;
                (self.popped, self.since) = (0, self.current);
                let [least, most] = LOADS;
                if load > most || (load > 0.0 && load < least && self.near > self.ring.len() / 8) {
                    self.rebuild(load * self.inverse_width);
                    return true;
                }
            }
            self.refile();
            self.sort_bucket();
        }
        let slot = (self.current & self.mask()) as usize;
        if agenda.foresighted() {
            let mask = self.ring.len() - 1;
            memory::prefetch(&self.ring, (slot + AHEAD + 2) & mask);
            for ahead in (1..=AHEAD).rev() {
                let number = self.current + ahead as u64;
                let end = (number + 1) as f64 / self.inverse_width;
                let slot = (slot + ahead) & mask;
                let bucket = &self.ring[slot].0;
                let named = &bucket[..usize::from(self.counts[slot]).min(bucket.len())];
                let plan = &mut self.plans[number as usize % AHEAD];
                if ahead == AHEAD {
                    for &disk in named {
                        memory::prefetch(&self.times, disk as usize);
                    }
                }
                agenda.expect(named, ahead, end, plan);
            }
        }
        let next_begins = self.next_begins();
        let count = usize::from(std::mem::take(&mut self.counts[slot]));
        self.near -= count;
        for place in 0..count {
            self.admit(self.ring[slot].0[place], next_begins, agenda);
        }
        while let Some(&(number, disk)) = self.spill.peek() {
            if number > self.current {
                break;
            }
            self.spill.pop();
            self.near -= 1;
            self.admit(disk, next_begins, agenda);
        }
        true
    }

    /// Adds the event of a disk stored in the current bucket to the list of due events, unless the
    /// entry is stale: the disk's event time is then at or after [`Self::next_begins`].
    #[inline(always)]
    fn admit(&mut self, disk: u32, next_begins: f64, agenda: &impl EventTimes) {
        memory::prefetch_next(&self.times, agenda.prefetch_partner(disk));
        let time = self.times[disk as usize];
        // A later event has an entry of its own.
        let due = if next_begins < f64::INFINITY {
            time * self.inverse_width < next_begins
        } else {
            time < f64::INFINITY
        };
        if self.few < FEW {
            self.soon.times[self.few] = if due { time.to_bits() } else { u64::MAX };
            self.soon.disks[self.few] = disk;
            self.few += usize::from(due);
        } else if due {
            self.crowd.push(CalendarEntry { time, disk });
        }
    }

    /// Returns the earliest event of the unordered list `soon` and its index there; `None` if the
    /// list is empty.
    #[inline(always)]
    fn earliest(&self) -> Option<(usize, CalendarEntry)> {
        if self.few == 0 {
            return None;
        }
        let (mut at, mut time, mut tie) = (0, u64::MAX, false);
        let blocks = self.soon.times.chunks_exact(BLOCK).enumerate();
        for (block, times) in blocks.take(self.few.div_ceil(BLOCK)) {
            for (within, &its) in times.iter().enumerate() {
                tie |= its == time;
                at = select_unpredictable(its < time, BLOCK * block + within, at);
                time = time.min(its);
            }
        }
        let Soon { times, disks } = &self.soon;
        if tie {
            let simultaneous = (0..self.few).filter(|&place| times[place] == time);
            at = simultaneous.min_by_key(|&place| disks[place]).unwrap_or(at);
        }
        let disk = disks[at];
        let time = f64::from_bits(time);
        Some((at, CalendarEntry { time, disk }))
    }
}

impl Calendar for Buckets {
    fn new(agenda: &impl EventTimes, now: f64) -> Self {
        let mut times = memory::reserved(agenda.disks() as usize);
        times.extend((0..agenda.disks()).map(|disk| agenda.time(disk)));
        let waits = times.iter().filter(|time: &&f64| time.is_finite());
        let waits: Vec<f64> = waits.map(|time| time - now).collect();
        let buckets = (waits.len() / 2).next_power_of_two().max(16);
        let rate = rate(waits);
        let mut calendar = Self {
            inverse_width: 1.0,
            times,
            ring: memory::filled(Bucket([0; NAMES]), buckets),
            counts: memory::filled(0, buckets),
            current: 0,
            soon: Soon::NOTHING,
            few: 0,
            crowd: BinaryHeap::new_min(),
            spill: BinaryHeap::new_min(),
            far: Vec::new(),
            waiting: [(0, 0); WAITING],
            waits: 0,
            plans: [PrefetchPlan::NOTHING; AHEAD],
            near: 0,
            popped: 0,
            since: 0,
            last_time: now,
        };
        calendar.rebuild(rate);
        calendar
    }

    #[inline(always)]
    fn push(&mut self, entry: CalendarEntry) {
        debug_assert!(entry.time >= self.last_time);
        self.times[entry.disk as usize] = entry.time;
        self.file(entry);
    }

    fn push_once(&mut self, entry: CalendarEntry) {
        if self.times[entry.disk as usize] != entry.time {
            self.push(entry);
        }
    }

    #[inline(always)]
    fn pop(&mut self, until: f64, agenda: &impl EventTimes) -> Option<CalendarEntry> {
        loop {
            let few = self.earliest();
            if let Some(&first) = self.crowd.peek()
                && few.is_none_or(|(_, entry)| first < entry)
            {
                if first.time > until {
                    return None;
                }
                self.crowd.pop();
                self.popped += 1;
                self.last_time = first.time;
                return Some(first);
            }
            if let Some((place, first)) = few {
                if first.time > until {
                    return None;
                }
                self.few -= 1;
                self.soon.times[place] = self.soon.times[self.few];
                self.soon.disks[place] = self.soon.disks[self.few];
                self.soon.times[self.few] = u64::MAX;
                self.popped += 1;
                self.last_time = first.time;
                return Some(first);
            }
            if !self.turn(agenda) {
                return None;
            }
        }
    }

    fn memory_bytes(&self) -> usize {
        self.ring.capacity() * size_of::<Bucket>()
            + self.counts.capacity()
            + self.times.capacity() * size_of::<f64>()
            + (self.far.capacity() + self.crowd.capacity()) * size_of::<CalendarEntry>()
            + self.spill.capacity() * size_of::<(u64, u32)>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    struct Times(Vec<f64>);

    impl EventTimes for Times {
        fn disks(&self) -> u32 {
            self.0.len() as u32
        }
        fn time(&self, disk: u32) -> f64 {
            self.0[disk as usize]
        }
    }

    /// Returns the next event that is not stale.
    fn next<Q: Calendar>(calendar: &mut Q, until: f64, times: &Times) -> Option<CalendarEntry> {
        loop {
            let entry = calendar.pop(until, times)?;
            if times.time(entry.disk) == entry.time {
                return Some(entry);
            }
        }
    }

    /// Buckets pop the events in the order of the sorted set, while the rate of events changes by
    /// twelve decades in both directions, with ties, bursts, long silences and events that are
    /// replaced before their time.
    #[test]
    fn buckets_pop_what_the_sorted_set_pops() {
        for seed in 0..8 {
            let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
            let disks = 200;
            let mut times = Times((0..disks).map(|_| stream.random::<f64>()).collect());
            let mut fast = Buckets::new(&times, 0.0);
            let mut plain = Sorted::new(&times, 0.0);
            let mut until = 0.0;
            for step in 0..60_000_u32 {
                let expected = next(&mut plain, until, &times);
                assert_eq!(next(&mut fast, until, &times), expected);
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
                let mut changed = vec![entry.disk];
                if stream.random_bool(0.5) {
                    changed.push(stream.random_range(0..disks));
                }
                if stream.random_bool(0.02) {
                    // No event of its own until another disk brings one.
                    wait = f64::INFINITY;
                }
                for disk in changed {
                    let again = CalendarEntry {
                        time: entry.time + wait,
                        disk,
                    };
                    times.0[disk as usize] = again.time;
                    fast.push(again);
                    plain.push(again);
                }
            }
        }
    }

    /// All events in one bucket: it spills and the crowd grows, but order is kept.
    #[test]
    fn simultaneous_events_come_in_the_order_of_the_disks() {
        let mut times = Times(vec![1.0; 1000]);
        times.0[500] = 1.0 + f64::EPSILON;
        let mut calendar = Buckets::new(&times, 0.0);
        let mut found = Vec::new();
        while let Some(entry) = calendar.pop(2.0, &times) {
            found.push(entry.disk);
            times.0[entry.disk as usize] = f64::INFINITY;
            let (time, disk) = (f64::INFINITY, entry.disk);
            calendar.push(CalendarEntry { time, disk });
        }
        let expected: Vec<u32> = (0..1000).filter(|&disk| disk != 500).chain([500]).collect();
        assert_eq!(found, expected);
    }

    /// The end of a bucket separates the same times from later ones as their numbers do, rounded
    /// and saturated ones too.
    #[test]
    fn a_bucket_ends_where_the_next_begins() {
        let mut calendar = Buckets::new(&Times(vec![1.0]), 0.0);
        calendar.inverse_width = 1.0;
        let numbers = (0..=63).map(|power| 1_u64 << power);
        for number in numbers.chain([3, 1000, 5 << 51, i64::MAX as u64 - 1, i64::MAX as u64]) {
            for current in [number - 1, number, number + 1] {
                calendar.current = current.min(i64::MAX as u64);
                let (next, near) = (calendar.next_begins(), calendar.current as f64);
                let times = [
                    near - 1.5,
                    near.next_down(),
                    near,
                    near.next_up(),
                    near + 1.0,
                ];
                let far = [near + 2.0, 2.0 * near, 1e300, f64::MAX];
                for time in times.into_iter().chain(far).filter(|&time| time >= 0.0) {
                    let due = calendar.bucket(time) <= calendar.current;
                    assert_eq!(time < next, due, "{time} {current}");
                }
            }
        }
    }

    /// The last bucket has all events, even those whose number is beyond all numbers.
    #[test]
    fn the_last_bucket_has_all_events() {
        let times = Times(vec![1e300, f64::INFINITY, 1.0, f64::INFINITY]);
        let mut calendar = Buckets::new(&times, 0.0);
        calendar.inverse_width = 1e300;
        calendar.current = i64::MAX as u64;
        (calendar.few, calendar.soon) = (0, Soon::NOTHING);
        for disk in 0..4 {
            calendar.admit(disk, calendar.next_begins(), &times);
        }
        assert_eq!(calendar.few, 2);
        assert_eq!(calendar.soon.disks[..2], [0, 2]);
    }

    #[test]
    fn empty_and_distant_calendars() {
        let mut times = Times(vec![f64::INFINITY]);
        let mut calendar = Buckets::new(&times, 0.0);
        assert_eq!(calendar.pop(f64::INFINITY, &times), None);
        times.0[0] = 1e300;
        let late = CalendarEntry {
            time: 1e300,
            disk: 0,
        };
        calendar.push(late);
        assert_eq!(calendar.pop(1e299, &times), None);
        assert_eq!(calendar.pop(f64::INFINITY, &times), Some(late));
    }
}
