//! Collision history of particles: former partners, and ring collisions, found by comparing the
//! ancestors of a collision.
//!
//! A collision is an event with two parents, the last events of its partners. Partners whose pasts
//! have an event in common are correlated: the shortest way from the collision back to that event
//! along one partner, and forth along the other, is a *ring*. Its length is the number of its
//! events, the collision itself included. It is two when partners meet again with no collision in
//! between. It is three when two meet that met one third particle, or that meet again after one of
//! them met a third particle (M. H. Ernst & J. R. Dorfman, *Physica* **61**, 157 (1972),
//! doi:10.1016/0031-8914(72)90087-X, on ring collisions).
//!
//! Rings up to [`LONGEST_RING`] are found, by comparing the pasts level by level: 125 comparisons
//! at most.

use serde::{Deserialize, Serialize};

/// Number of latest collisions of a particle whose partners are remembered.
pub const MEMORY: usize = 8;
/// Largest number of collisions that both partners can have had between two collisions with each
/// other, within [`MEMORY`].
pub const MOST_BETWEEN: usize = 2 * (MEMORY - 1);
/// Length of the longest ring that is searched for, in collisions.
pub const LONGEST_RING: usize = 6;

/// Collision events stored for each simulator; as each event has two partners, they reach sixteen
/// collisions back on average.
const EVENTS: usize = 8;
/// Largest number of ancestors of a collision in the most distant generation searched; it doubles
/// with each generation.
const WIDEST: usize = 1 << (LONGEST_RING - 2);

/// Memory of the collision history for each simulator \[bytes\].
pub const BYTES_PER_SIMULATOR: usize = (MEMORY + 2 * EVENTS) * size_of::<u32>() + size_of::<u64>();

/// Collision history: the last partners of each simulator, latest first, and the tree of past
/// collisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct History {
    partners: Vec<[u32; MEMORY]>,
    /// Number of the last collision of each simulator, counted from 1; 0 if it has had none.
    last: Vec<u64>,
    /// Parents of each stored collision: how many collisions ago each partner collided last; 0 if
    /// unknown. A circular buffer.
    parents: Vec<[u32; 2]>,
    count: u64,
}

/// Relation of a collision to the collision history of its partners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Past {
    /// Collisions that both partners have had since they last met; `None` if they did not meet
    /// within [`MEMORY`].
    pub between: Option<usize>,
    /// Length of the ring that the collision closes, in collisions; `None` if it closes none.
    pub ring: Option<usize>,
}

/// One generation of ancestors of a collision: their event numbers, and how many there are.
type Level = ([u64; WIDEST], usize);

impl History {
    pub(super) fn new(simulators: usize) -> Self {
        Self {
            partners: vec![[u32::MAX; MEMORY]; simulators],
            last: vec![0; simulators],
            parents: vec![[0; 2]; EVENTS * simulators.max(1)],
            count: 0,
        }
    }

    /// Records the collision of a pair of indices and returns its relation to their past; `None` if
    /// an index is not tracked.
    pub(super) fn record_collision(&mut self, pair: [u32; 2]) -> Option<Past> {
        let [i, j] = pair.map(|who| who as usize);
        if i.max(j) >= self.partners.len() {
            return None;
        }
        let since = |who: usize, whom: usize| {
            let mut known = self.partners[who].iter();
            known.position(|&other| other as usize == whom)
        };
        let between = since(i, j).zip(since(j, i)).map(|(a, b)| a + b);
        let ring = self.shortest_ring([self.last[i], self.last[j]]);
        for (who, whom) in [(i, j), (j, i)] {
            self.partners[who].rotate_right(1);
            self.partners[who][0] = whom as u32;
        }
        self.count += 1;
        let store = self.parents.len() as u64;
        let ago = |event: u64| match self.count - event {
            ago if event > 0 && ago < store => ago as u32,
            _ => 0,
        };
        let parents = [ago(self.last[i]), ago(self.last[j])];
        self.parents[(self.count % store) as usize] = parents;
        (self.last[i], self.last[j]) = (self.count, self.count);
        Some(Past { between, ring })
    }

    /// Returns true if a collision is recent enough to be in the buffer.
    fn is_stored(&self, event: u64) -> bool {
        event > 0 && event + (self.parents.len() as u64) > self.count
    }

    /// Returns the parents of all collisions of one generation.
    fn parents_of(&self, (level, count): &Level) -> Level {
        let mut before: Level = ([0; WIDEST], 0);
        for &event in &level[..*count] {
            for ago in self.parents[(event % self.parents.len() as u64) as usize] {
                let parent = event - u64::from(ago);
                if ago > 0 && self.is_stored(parent) && before.1 < WIDEST {
                    before.0[before.1] = parent;
                    before.1 += 1;
                }
            }
        }
        before
    }

    /// Computes the length of the shortest ring, in collisions, that a new collision closes;
    /// `parents` are the last collisions of its partners.
    fn shortest_ring(&self, parents: [u64; 2]) -> Option<usize> {
        // Levels 1, 2, ... of both pasts.
        let mut levels = parents.map(|event| {
            let known = usize::from(self.is_stored(event));
            let mut level = [0; WIDEST];
            level[0] = event;
            vec![(level, known)]
        });
        for length in 2..=LONGEST_RING {
            for own in 1..length {
                let (one, other) = (&levels[0][own - 1], &levels[1][length - own - 1]);
                let others = &other.0[..other.1];
                if one.0[..one.1].iter().any(|event| others.contains(event)) {
                    return Some(length);
                }
            }
            if length < LONGEST_RING {
                for levels in &mut levels {
                    let next = self.parents_of(&levels[length - 2]);
                    levels.push(next);
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn meetings_are_remembered() {
        let mut history = History::new(30);
        let mut between = |pair| history.record_collision(pair).map(|past| past.between);
        assert_eq!(between([1, 2]), Some(None));
        assert_eq!(between([2, 1]), Some(Some(0)));
        assert_eq!(between([1, 3]), Some(None));
        assert_eq!(between([4, 2]), Some(None));
        assert_eq!(between([1, 2]), Some(Some(2)));
        assert_eq!(between([u32::MAX; 2]), None);
        for other in 10..10 + MEMORY as u32 {
            between([1, other]);
        }
        assert_eq!(between([1, 2]), Some(None));
    }

    #[test]
    fn rings_close() {
        let mut history = History::new(8);
        let mut ring = |pair| history.record_collision(pair).and_then(|past| past.ring);
        assert_eq!(ring([0, 1]), None);
        assert_eq!(ring([1, 0]), Some(2));
        assert_eq!(ring([1, 2]), None);
        // 0 and 2 met 1; then 3 and 4 meet, and one of each side.
        assert_eq!(ring([2, 0]), Some(3));
        assert_eq!(ring([3, 4]), None);
        assert_eq!(ring([3, 5]), None);
        assert_eq!(ring([4, 6]), None);
        assert_eq!(ring([5, 6]), Some(4));
    }

    /// Finds the events of a past with the fewest steps to each, from lists of all events.
    fn past(all: &[[usize; 2]], event: usize, steps: usize, found: &mut Vec<(usize, usize)>) {
        if event == 0 || steps > LONGEST_RING {
            return;
        }
        found.push((event, steps));
        for parent in all[event] {
            past(all, parent, steps + 1, found);
        }
    }

    /// All rings of thousands of collisions of few particles, against pasts that are written out.
    /// The buffer is long enough for all that the oracle sees: twelve particles forget nothing of
    /// six levels, but for one that hardly ever collides.
    #[test]
    fn rings_are_those_of_whole_pasts() {
        const PARTICLES: usize = 40;
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(11);
        let mut history = History::new(PARTICLES);
        let (mut all, mut last) = (vec![[0; 2]], [0_usize; PARTICLES]);
        let mut lengths = [0; LONGEST_RING + 1];
        while all.len() < 300 {
            let i = stream.random_range(0..PARTICLES);
            // Neighbours on a circle, so that rings are short.
            let j = (i + stream.random_range(1..4)) % PARTICLES;
            let mut pasts = [Vec::new(), Vec::new()];
            for (who, found) in [i, j].into_iter().zip(&mut pasts) {
                past(&all, last[who], 1, found);
            }
            let mut ring = None;
            for (event, steps) in &pasts[0] {
                for (other, more) in &pasts[1] {
                    if event == other {
                        ring = Some(ring.unwrap_or(usize::MAX).min(steps + more));
                    }
                }
            }
            let ring = ring.filter(|&length| length <= LONGEST_RING);
            let found = history
                .record_collision([i as u32, j as u32])
                .expect("known");
            assert_eq!(found.ring, ring, "event {}", all.len());
            lengths[ring.unwrap_or(0)] += 1;
            all.push([last[i], last[j]]);
            (last[i], last[j]) = (all.len() - 1, all.len() - 1);
        }
        assert!(lengths[2..].iter().all(|&count| count > 5), "{lengths:?}");
    }

    /// Events older than the buffer are forgotten, without a wrong ring.
    #[test]
    fn old_events_are_forgotten() {
        let mut history = History::new(4);
        history.record_collision([0, 1]);
        for _ in 0..2 * EVENTS * 4 {
            assert_ne!(history.record_collision([2, 3]), None);
        }
        let past = history.record_collision([0, 1]).expect("known");
        assert_eq!((past.between, past.ring), (Some(0), None));
    }
}
