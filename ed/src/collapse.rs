//! Detection of inelastic collapse, infinitely many contacts in a finite time, and of gases whose
//! disks never collide. Both end an event-driven run with an error.

use std::collections::BTreeSet;

use crate::cells::NONE;

/// Number of contacts without noticeable progress of time that counts as inelastic collapse; eight
/// times the number of disks is added to it.
const COLLAPSE: u64 = 4000;

/// Number of the latest contacts that are remembered: their disks are reported as the cluster of a
/// collapse.
const RECENT: usize = 256;

/// Number of contacts between two checks whether time advances.
const LOOK: u64 = 1024;

/// Number of collisions in a row with negligible approach speed that count as a collapse, if time
/// does not advance.
const FEW: usize = 32;

/// Limit below which an approach is negligible: approach speed times the current time, in
/// diameters. Only a geometric series of collisions leads there, while chance does once in 10^60.
const FEEBLE: f64 = 1e-60;

/// Largest advance of time, relative to the absolute time, that counts as no progress in a gas
/// without field.
const FINE: f64 = 1e-13;

/// Largest advance of time, relative to the absolute time, that counts as no progress under
/// gravity. Disks at rest on a floor hop for the resolution of the clock, 2e-16; a thousand hops
/// are no progress either.
const COARSE: f64 = 1e-12;

/// Number of cell crossings without a collision after which a run ends with an error; 100 times the
/// number of disks is added to it.
pub(crate) const PATIENCE: u64 = 10_000_000;

/// Number of cells whose clearing counts as one cell crossing in the limit [`PATIENCE`], as it
/// takes about as long.
const CELLS_OF_A_CROSSING: usize = 512;

/// Detector of inelastic collapse, and of runs without collisions. All times are engine times.
#[derive(Clone)]
pub(crate) struct CollapseDetector {
    /// Engine time at which progress of time was last noticed.
    time: f64,
    /// Number of contacts of the run at which progress of time was last noticed.
    collisions: u64,
    /// Disk numbers and engine times of the latest contacts, as a ring buffer.
    recent: [([u32; 2], f64); RECENT],
    /// Number of collisions in a row whose approach speed was negligible.
    negligible: usize,
    /// Number of cell crossings since the last collision.
    idle: u64,
}

/// Contact, with the data of the gas that the detector of collapse compares it with.
pub(crate) struct ContactInfo {
    pub(crate) pair: [u32; 2],
    pub(crate) now: f64,
    /// Absolute time of the contact, times the engine's unit of speed.
    pub(crate) absolute_time: f64,
    /// Engine time in which a typical disk of the gas moves by its diameter.
    pub(crate) unit: f64,
    /// Number of disks of the gas.
    pub(crate) disks: usize,
    /// True if disks fly straight; false under gravity.
    pub(crate) straight: bool,
}

impl ContactInfo {
    /// Returns true if the approach speed of the contact is negligible: at it, a tiny fraction of a
    /// diameter is covered in the current absolute time. `None` if speed or time is zero.
    #[inline(always)]
    pub(crate) fn is_negligible(&self, approach: f64, diameter: f64) -> Option<bool> {
        let way = approach.abs() * self.absolute_time.abs();
        (way > 0.0).then_some(way < FEEBLE * diameter)
    }

    /// Returns the largest advance of engine time that counts as no progress: a fixed fraction of
    /// the absolute time, so that it does not depend on the epoch of the engine.
    #[inline(always)]
    fn resolution(&self) -> f64 {
        let fine = if self.straight { FINE } else { COARSE };
        fine * (self.absolute_time.abs() + self.unit)
    }
}

impl CollapseDetector {
    /// Creates a detector of collapse at engine time 0. `collisions` is the number of contacts of
    /// the run when time last advanced.
    pub(crate) fn new(collisions: u64) -> Self {
        Self {
            time: 0.0,
            collisions,
            recent: [([NONE; 2], f64::NEG_INFINITY); RECENT],
            negligible: 0,
            idle: 0,
        }
    }

    /// Counts a restart of the engine with `cells` cells as the number of cell crossings that takes
    /// as long. Returns the crossings since the last collision, if too many for this number of
    /// disks: a wide box of few disks has hardly any crossings between two restarts.
    pub(crate) fn fresh_start(&mut self, cells: usize, disks: usize) -> Option<u64> {
        self.idle += (cells / CELLS_OF_A_CROSSING) as u64;
        self.crossing(disks)
    }

    /// Returns a detector of collapse for a restarted engine: clock zero, the count of crossings
    /// kept.
    pub(crate) fn afresh(&self, collisions: u64) -> Self {
        Self {
            idle: self.idle,
            ..Self::new(self.collisions.min(collisions))
        }
    }

    /// Sets the number of cell crossings since the last collision to zero.
    pub(crate) fn reset_idle(&mut self) {
        self.idle = 0;
    }

    /// Returns the number of cell crossings since the last collision.
    pub(crate) fn idle(&self) -> u64 {
        self.idle
    }

    /// Sets the number of cell crossings since the last collision, if they were counted elsewhere.
    pub(crate) fn set_idle(&mut self, idle: u64) {
        self.idle = idle;
    }

    /// Returns the number of contacts since time last advanced noticeably; `collisions` is the
    /// number of all contacts of the run.
    pub(crate) fn stalled(&self, collisions: u64) -> u64 {
        collisions - self.collisions
    }

    /// Counts a cell crossing. Returns the crossings since the last collision, if they are too many
    /// for this number of disks.
    #[inline(always)]
    pub(crate) fn crossing(&mut self, disks: usize) -> Option<u64> {
        self.idle += 1;
        (self.idle > PATIENCE + 100 * disks as u64).then_some(self.idle)
    }

    /// Counts a contact with a wall as a crossing. Returns the crossings since the last collision,
    /// if they are too many. If the run has an end time (`ends`), contacts with walls are progress
    /// and the count restarts.
    #[inline]
    pub(crate) fn rebound(&mut self, ends: bool, disks: usize) -> Option<u64> {
        if ends {
            self.idle = 0;
        }
        self.crossing(disks)
    }

    /// Counts a contact, by its number in the run and whether its approach was negligible; true if
    /// the gas has collapsed. With a wall, the partner is [`NONE`].
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

    /// Counts a contact whose approach is not negligible, after another such contact; true if the
    /// gas has collapsed. Of many in a row only the numbers of [`Self::counts`] must be counted.
    pub(crate) fn usual_collision(&mut self, number: u64, latest: &ContactInfo) -> bool {
        self.remember(number, latest);
        self.has_stopped(number, latest)
    }

    /// Returns those numbers of contacts from `first` to `last` that change the detector: contacts
    /// at which the progress of time is checked, and the last [`RECENT`].
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

    /// Returns true if time has not advanced noticeably during too many contacts; tests only every
    /// [`LOOK`] contacts.
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

    /// Returns true if the approach speed at the last contact was negligible.
    pub(crate) fn is_negligible(&self) -> bool {
        self.negligible > 0
    }

    /// Returns the disk numbers of the latest contacts; for a wall, the partner is [`NONE`].
    pub(crate) fn recent(&self) -> impl Iterator<Item = [u32; 2]> {
        let pairs = self.recent.iter().map(|(pair, _)| *pair);
        pairs.filter(|pair| *pair != [NONE; 2])
    }

    /// Returns the numbers of the disks in the latest contacts: the cluster of a collapse.
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
