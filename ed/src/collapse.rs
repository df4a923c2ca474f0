//! Detection of inelastic collapse, and of gases whose disks never meet.

use std::collections::BTreeSet;

use crate::cells::NONE;

/// Number of collisions without progress of time that count as a collapse, besides a number that
/// grows with the number of disks.
const COLLAPSE: u64 = 4000;

/// Latest collisions whose disks are the cluster of a collapse.
const RECENT: usize = 256;

/// Number of contacts between two checks of the time.
const LOOK: u64 = 1024;

/// Collisions in a row with negligible approach that are a collapse, if time does not advance.
const FEW: usize = 32;

/// Negligible approach: distance at the approach speed over the current time, in diameters. Only a
/// geometric series of collisions leads there, while chance does once in 10^60.
const FEEBLE: f64 = 1e-60;

/// Largest advance of time that counts as none, over the absolute time.
const FINE: f64 = 1e-13;

/// Largest advance of time that counts as none in a field, over the absolute time: disks at rest on
/// a floor hop for the resolution of the clock, 2e-16, and a thousand times that is no advance
/// either.
const COARSE: f64 = 1e-12;

/// Cell crossings without a collision after which a run is given up, plus a number that grows with
/// the number of disks.
pub(crate) const PATIENCE: u64 = 10_000_000;

/// Number of cells that are cleared in about the time of a crossing, or less: the limit for a gas
/// of two disks in a million cells is some seconds either way.
const CELLS_OF_A_CROSSING: usize = 512;

/// Detector of a lack of progress. Times are engine times.
#[derive(Clone)]
pub(crate) struct CollapseDetector {
    /// Engine time at which time last advanced noticeably.
    time: f64,
    /// Number of contacts when time last advanced.
    collisions: u64,
    /// Pair and engine time of the last collisions.
    recent: [([u32; 2], f64); RECENT],
    /// Number of collisions in a row with negligible approach.
    negligible: usize,
    /// Number of crossings since the last collision.
    idle: u64,
}

/// Contact, and the gas in which it happens.
pub(crate) struct ContactInfo {
    pub(crate) pair: [u32; 2],
    pub(crate) now: f64,
    /// Absolute time of the contact, in the unit of engine time.
    pub(crate) absolute_time: f64,
    /// Engine time in which a typical disk moves by its diameter.
    pub(crate) unit: f64,
    /// Number of disks.
    pub(crate) disks: usize,
    /// True if disks fly straight, without gravity.
    pub(crate) straight: bool,
}

impl ContactInfo {
    /// Returns true if the disks, or one and a wall, approached negligibly at this speed for their
    /// diameter; `None` if there is no time to compare with.
    #[inline(always)]
    pub(crate) fn is_negligible(&self, approach: f64, diameter: f64) -> Option<bool> {
        let way = approach.abs() * self.absolute_time.abs();
        (way > 0.0).then_some(way < FEEBLE * diameter)
    }

    /// Returns the largest advance of engine time that counts as none: a fixed share of the
    /// absolute time, so that it does not depend on the epoch of the engine.
    #[inline(always)]
    fn resolution(&self) -> f64 {
        let fine = if self.straight { FINE } else { COARSE };
        fine * (self.absolute_time.abs() + self.unit)
    }
}

impl CollapseDetector {
    /// Creates a detector at the engine time 0, with the number of contacts when time last
    /// advanced.
    pub(crate) fn new(collisions: u64) -> Self {
        Self {
            time: 0.0,
            collisions,
            recent: [([NONE; 2], f64::NEG_INFINITY); RECENT],
            negligible: 0,
            idle: 0,
        }
    }

    /// Counts a fresh start with this many cells, whose work stands for crossings. Returns the
    /// crossings since the last collision, if they are too many for this number of disks. In a wide
    /// box of few disks hardly any are between two such starts.
    pub(crate) fn fresh_start(&mut self, cells: usize, disks: usize) -> Option<u64> {
        self.idle += (cells / CELLS_OF_A_CROSSING) as u64;
        self.crossing(disks)
    }

    /// Returns this detector with the clock set to zero, after a fresh start.
    pub(crate) fn afresh(&self, collisions: u64) -> Self {
        Self {
            idle: self.idle,
            ..Self::new(self.collisions.min(collisions))
        }
    }

    /// Sets the number of crossings to zero.
    pub(crate) fn reset_idle(&mut self) {
        self.idle = 0;
    }

    /// Number of crossings since the last collision.
    pub(crate) fn idle(&self) -> u64 {
        self.idle
    }

    /// Sets the number of crossings, if they were counted elsewhere.
    pub(crate) fn set_idle(&mut self, idle: u64) {
        self.idle = idle;
    }

    /// Number of contacts since time last advanced noticeably, of this many in all.
    pub(crate) fn stalled(&self, collisions: u64) -> u64 {
        collisions - self.collisions
    }

    /// Counts a crossing. Returns the crossings since the last collision, if they are too many for
    /// this number of disks.
    #[inline(always)]
    pub(crate) fn crossing(&mut self, disks: usize) -> Option<u64> {
        self.idle += 1;
        (self.idle > PATIENCE + 100 * disks as u64).then_some(self.idle)
    }

    /// Counts a contact with a wall. Returns the crossings since the last collision, if time has no
    /// end and they are too many for this number of disks.
    #[inline]
    pub(crate) fn rebound(&mut self, ends: bool, disks: usize) -> Option<u64> {
        if ends {
            self.idle = 0;
        }
        self.crossing(disks)
    }

    /// Counts a contact, the last of this number, [`ContactInfo::is_negligible`] or not; true if it
    /// is a collapse. With a wall, the partner is [`NONE`].
    #[inline(always)]
    pub(crate) fn collision(
        &mut self,
        number: u64,
        latest: &ContactInfo,
        is_negligible: Option<bool>,
    ) -> bool {
        self.remember(number, latest);
        if let Some(is_negligible) = is_negligible {
            self.negligible = if is_negligible {
                self.negligible + 1
            } else {
                0
            };
            if self.negligible >= FEW {
                let before = self.recent[(number as usize + RECENT - FEW) % RECENT].1;
                return latest.now - before <= latest.resolution();
            }
        }
        self.has_stopped(number, latest)
    }

    /// Counts a contact with an approach that is not negligible, after another such contact; true
    /// if it is a collapse. Of many in a row only the numbers of [`Self::counts`] need be counted.
    pub(crate) fn usual_collision(&mut self, number: u64, latest: &ContactInfo) -> bool {
        self.remember(number, latest);
        self.has_stopped(number, latest)
    }

    /// Returns the numbers of the contacts from `first` to `last` that change the detector:
    /// contacts at which the time is checked, and the last [`RECENT`].
    pub(crate) fn counts(first: u64, last: u64) -> impl Iterator<Item = u64> {
        let late = first.max((last + 1).saturating_sub(RECENT as u64));
        let looks = (first.next_multiple_of(LOOK)..late).step_by(LOOK as usize);
        looks.chain(late..=last)
    }

    #[inline(always)]
    fn remember(&mut self, number: u64, latest: &ContactInfo) {
        if latest.pair[1] != NONE {
            self.idle = 0;
        }
        self.recent[number as usize % RECENT] = (latest.pair, latest.now);
    }

    /// Returns true if time has not advanced for too many contacts; checked once in a while.
    #[inline(always)]
    fn has_stopped(&mut self, number: u64, latest: &ContactInfo) -> bool {
        if !number.is_multiple_of(LOOK) {
            return false;
        }
        if latest.now - self.time > latest.resolution() {
            (self.time, self.collisions) = (latest.now, number);
        }
        self.stalled(number) > COLLAPSE + 8 * latest.disks as u64
    }

    /// Returns true if the approach at the last contact was negligible.
    pub(crate) fn is_negligible(&self) -> bool {
        self.negligible > 0
    }

    /// Returns the pairs of the latest contacts; with a wall, the partner is [`NONE`].
    pub(crate) fn recent(&self) -> impl Iterator<Item = [u32; 2]> {
        let pairs = self.recent.iter().map(|(pair, _)| *pair);
        pairs.filter(|pair| *pair != [NONE; 2])
    }

    /// Returns the disks of the last collisions.
    pub(crate) fn cluster(&self) -> BTreeSet<u32> {
        let recent = self.recent.iter().flat_map(|(pair, _)| *pair);
        recent.filter(|&disk| disk != NONE).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A detector that counts some of many contacts has the state of one that counts all.
    #[test]
    fn few_contacts_count() {
        for (first, last) in [
            (1, 0),
            (1, 1),
            (1, 300),
            (5, 1023),
            (900, 1030),
            (1024, 5000),
        ] {
            let latest = |number: u64| ContactInfo {
                pair: [number as u32, 7],
                now: 1e-3 * number as f64,
                absolute_time: 1.0,
                unit: 1.0,
                disks: 10,
                straight: true,
            };
            let after = |numbers: Vec<u64>| {
                let mut progress = CollapseDetector::new(0);
                for number in numbers {
                    assert!(!progress.usual_collision(number, &latest(number)));
                }
                (progress.time, progress.collisions, progress.recent)
            };
            let some: Vec<u64> = CollapseDetector::counts(first, last).collect();
            assert!(some.len() <= RECENT + 5);
            assert!(
                after(some) == after((first..=last).collect()),
                "{first} {last}"
            );
        }
    }
}
