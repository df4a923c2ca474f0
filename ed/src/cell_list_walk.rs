//! Walk through the lists of disks of several cells.

use crate::cells::NONE;
use crate::record::DiskRecord;

/// Most lists of cells open at a time, where cells are at rest: four by four.
const STILL: usize = 16;

/// Lists of disks, of one cell each, that are followed side by side: the next disk of each waits in
/// a ring. One loop over all lists has only one unpredictable end. Two arrays avoid packing.
pub(crate) struct CellListWalk<const RING: usize = STILL> {
    disks: [u32; RING],
    cells: [u32; RING],
    begin: usize,
    end: usize,
}

impl<const RING: usize> CellListWalk<RING> {
    pub(crate) fn new() -> Self {
        Self {
            disks: [NONE; RING],
            cells: [0; RING],
            begin: 0,
            end: 0,
        }
    }

    /// Opens the list that begins with a disk, if there is one and it is wanted. The number of its
    /// cell is passed on with its disks.
    #[inline(always)]
    pub(crate) fn open(&mut self, first: u32, cell: usize, wanted: bool) {
        self.disks[self.end % RING] = first;
        self.cells[self.end % RING] = cell as u32;
        self.end += usize::from(first != NONE) & usize::from(wanted);
    }

    /// Returns the next disk of any list, with its number and the number of its cell.
    #[inline(always)]
    pub(crate) fn next<'a>(
        &mut self,
        all: &'a [DiskRecord],
    ) -> Option<(u32, usize, &'a DiskRecord)> {
        if self.begin == self.end {
            return None;
        }
        let (who, cell) = (self.disks[self.begin % RING], self.cells[self.begin % RING]);
        let disk = &all[who as usize];
        self.disks[self.end % RING] = disk.next;
        self.cells[self.end % RING] = cell;
        self.end += usize::from(disk.next != NONE);
        self.begin += 1;
        Some((who, cell as usize, disk))
    }

    /// Number of disks returned so far.
    #[inline(always)]
    pub(crate) fn followed(&self) -> u64 {
        self.begin as u64
    }
}
