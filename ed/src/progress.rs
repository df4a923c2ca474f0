//! Whether time goes on: inelastic collapse, and gases whose disks never meet.

use std::collections::BTreeSet;

use crate::cells::NONE;

/// Collisions without progress of time, beyond those that many disks may have at once, that are called
/// a collapse.
const COLLAPSE: u64 = 20_000;

/// Collisions whose disks are called the cluster of a collapse.
const RECENT: usize = 256;

/// Recent collisions without progress of time that, if they end with hardly any approach, are a collapse.
const FEW: usize = 32;

/// Speed of approach, of that of the fastest disk at the start of the leg, that is hardly any: only a
/// geometric series of collisions leads there, while chance does once in 10^60.
const FEEBLE: f64 = 1e-60;

/// Crossings without a collision, beyond those that many disks need, after which none is awaited.
const PATIENCE: u64 = 10_000_000;

/// Tells progress from its lack. Times are the engine's own.
pub(crate) struct Progress {
    /// When time last advanced noticeably.
    time: f64,
    /// Collisions at that time.
    collisions: u64,
    /// The last collisions: pair and time.
    recent: [([u32; 2], f64); RECENT],
    /// Crossings since the last collision.
    idle: u64,
}

impl Progress {
    /// At the own time 0, with the number of collisions when time last advanced.
    pub(crate) fn new(collisions: u64) -> Self {
        Self {
            time: 0.0,
            collisions,
            recent: [([NONE; 2], f64::NEG_INFINITY); RECENT],
            idle: 0,
        }
    }

    /// Collisions of so many in all since time last advanced noticeably.
    pub(crate) fn stalled(&self, collisions: u64) -> u64 {
        collisions - self.collisions
    }

    /// One more crossing; how many since the last collision, if they are too many for so many disks.
    #[inline]
    pub(crate) fn crossing(&mut self, disks: usize) -> Option<u64> {
        self.idle += 1;
        (self.idle > PATIENCE + 100 * disks as u64).then_some(self.idle)
    }

    /// One more collision, with a number, a time and a speed of approach; true if that is a collapse of a gas
    /// of so many disks. `resolution` is the least noticeable time.
    #[inline]
    pub(crate) fn collision(
        &mut self,
        number: u64,
        pair: [u32; 2],
        now: f64,
        approach: f64,
        disks: usize,
        resolution: impl Fn() -> f64,
    ) -> bool {
        self.idle = 0;
        let place = number as usize % RECENT;
        self.recent[place] = (pair, now);
        if approach.abs() < FEEBLE {
            let before = self.recent[(place + RECENT - FEW) % RECENT].1;
            return now - before <= resolution();
        }
        if !number.is_multiple_of(4096) {
            return false;
        }
        if now - self.time > resolution() {
            (self.time, self.collisions) = (now, number);
        }
        self.stalled(number) > COLLAPSE + 8 * disks as u64
    }

    /// The disks of the last collisions.
    pub(crate) fn cluster(&self) -> BTreeSet<u32> {
        let recent = self.recent.iter().flat_map(|(pair, _)| *pair);
        recent.filter(|&disk| disk != NONE).collect()
    }
}
