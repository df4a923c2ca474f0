//! What the next buckets of the calendar will need from memory.

/// Buckets ahead of their turn that disks are prefetched; `Disks::prefetch` says what is done at each
/// distance.
pub(crate) const AHEAD: usize = 4;

/// Disks that a bucket names at most.
pub(crate) const NAMES: usize = 16;

/// Prefetch plan of one bucket: what its disks are about to do, as far as it is known; each is listed once.
///
/// Contacts and crossings are listed apart: which of them comes up cannot be foreseen by the processor, and a wrong
/// guess of it costs more than the sorting.
#[derive(Clone, Copy, Debug)]
pub struct PrefetchPlan {
    /// Disks that will touch others: the first `touching`.
    pub(crate) contacts: [u32; NAMES],
    pub(crate) touching: usize,
    /// Places of the cells whose lists a disk will follow that goes into the next cell: the first `leaving`.
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

    /// Disks that will touch others.
    pub(crate) fn contacts(&self) -> &[u32] {
        &self.contacts[..self.touching.min(NAMES)]
    }

    /// Places of the cells that crossing disks will look into, four for each.
    pub(crate) fn followed(&self) -> &[[u32; 4]] {
        &self.followed[..self.leaving.min(NAMES)]
    }
}
