//! Iteration over the disks of several cells, whose linked lists are followed in turn.

use crate::cells::NONE;
use crate::record::DiskRecord;

/// Capacity for linked lists open at a time around a disk or pair, where cells do not slide: four
/// by four cells.
const STILL: usize = 16;

/// Iterator over the disks of several cells, whose linked lists are followed in turn: a ring buffer
/// holds the next disk of each. One loop over all lists has only one unpredictable end. Two arrays
/// avoid packing.
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

    /// Adds the linked list of a cell to the walk, if `wanted` and not empty. `first` is its first
    /// disk; `cell` is the number returned with each of its disks.
    #[inline(always)]
    pub(crate) fn open(&mut self, first: u32, cell: usize, wanted: bool) {
        self.disks[self.end % RING] = first;
        self.cells[self.end % RING] = cell as u32;
        self.end += usize::from(first != NONE) & usize::from(wanted);
    }

    /// Returns the next disk of the walk: its number, the number given to its cell, and its record.
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

    /// Returns the number of disks that the walk has returned so far.
    #[inline(always)]
    pub(crate) fn followed(&self) -> u64 {
        self.begin as u64
    }
}
