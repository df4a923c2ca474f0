//! Memory needs of the next buckets of the calendar.

/// Number of buckets ahead of their turn that disks are prefetched; `Disks::prefetch` has the steps
/// at each distance.
pub(crate) const AHEAD: usize = 4;

/// Most disks that a bucket names.
pub(crate) const NAMES: usize = 16;

/// Prefetch plan of one bucket: the next actions of its disks, as far as they are known; each disk
/// is listed once.
///
/// Contacts and crossings are listed apart: their order is unpredictable for the processor, and a
/// wrong prediction costs more than the sorting.
#[derive(Clone, Copy, Debug)]
pub struct PrefetchPlan {
    /// Disks that will touch another disk: the first `touching` entries.
    pub(crate) contacts: [u32; NAMES],
    pub(crate) touching: usize,
    /// Indices of the cells whose lists a disk will read as it enters another cell: the first
    /// `leaving` entries.
    pub(crate) followed: [[u32; 4]; NAMES],
    pub(crate) leaving: usize,
}

impl PrefetchPlan {
    /// Plan of a bucket that names no disk.
    pub(crate) const NOTHING: Self = Self {
        contacts: [0; NAMES],
        touching: 0,
        followed: [[0; 4]; NAMES],
        leaving: 0,
    };

    /// Returns the disks that will touch another disk.
    pub(crate) fn contacts(&self) -> &[u32] {
        &self.contacts[..self.touching.min(NAMES)]
    }

    /// Returns the indices of the cells that crossing disks will search, four for each.
    pub(crate) fn followed(&self) -> &[[u32; 4]] {
        &self.followed[..self.leaving.min(NAMES)]
    }
}
