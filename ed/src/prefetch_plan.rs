//! Prefetch plan of one bucket of the event calendar: the disks that will collide and the cells
//! that will be searched.

/// Number of buckets ahead of its turn at which prefetching for a bucket of the calendar begins;
/// `DiskSystem::prefetch` has the step for each distance.
pub(crate) const AHEAD: usize = 4;

/// Largest number of disks stored in one bucket of the calendar.
pub(crate) const NAMES: usize = 16;

/// Prefetch plan of one bucket: the next actions of its disks, as far as they are known; each disk
/// is listed once.
///
/// Contacts and crossings are listed apart: their order is unpredictable for the processor, and a
/// wrong prediction costs more than the sorting.
#[derive(Clone, Copy, Debug)]
pub struct PrefetchPlan {
    /// Numbers of the disks that will touch another disk: the first `touching` entries are valid.
    pub(crate) contacts: [u32; NAMES],
    pub(crate) touching: usize,
    /// Memory indices of the cells that a disk will search when it crosses into another cell, four
    /// for each disk: the first `leaving` entries are valid.
    pub(crate) followed: [[u32; 4]; NAMES],
    pub(crate) leaving: usize,
}

impl PrefetchPlan {
    /// Empty prefetch plan, of a bucket without disks.
    pub(crate) const NOTHING: Self = Self {
        contacts: [0; NAMES],
        touching: 0,
        followed: [[0; 4]; NAMES],
        leaving: 0,
    };

    /// Returns the numbers of the disks in the plan that will touch another disk.
    pub(crate) fn contacts(&self) -> &[u32] {
        &self.contacts[..self.touching.min(NAMES)]
    }

    /// Returns the memory indices of the cells that crossing disks in the plan will search, four
    /// for each.
    pub(crate) fn followed(&self) -> &[[u32; 4]] {
        &self.followed[..self.leaving.min(NAMES)]
    }
}
