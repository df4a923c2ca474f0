//! Record of one disk in the engine: position, velocity, predicted contact and cell, in one cache
//! line.

use nalgebra::Vector2;

use crate::cells::{CellCoordinates, NONE};

/// Record of a disk in one cache line: position, velocity, clock, predicted contact and cell. Times
/// and speeds are in engine units.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct DiskRecord {
    /// Position at the engine time `clock`, relative to the corner of the disk's cell \[length\].
    pub(crate) position: Vector2<f64>,
    pub(crate) velocity: Vector2<f64>,
    /// Engine time at which the disk has the stored position and velocity.
    pub(crate) clock: f64,
    /// Engine time of the predicted contact with `partner`; infinite without one.
    pub(crate) contact: f64,
    /// Predicted contact partner: the number of a disk; beyond the number of disks, a wall or
    /// obstacle; or [`NONE`].
    pub(crate) partner: u32,
    /// Number of the next disk in the linked list of the cell, or [`NONE`].
    pub(crate) next: u32,
    /// Collision count of the partner when the contact was predicted; [`VOID`] if the partner's
    /// count has restarted since.
    pub(crate) partner_count: u16,
    /// Number of collisions of the disk modulo 16 bits: from [`FIRST`] to the largest number, then
    /// from [`FIRST`] again.
    pub(crate) count: u16,
    /// Column and row of the disk's cell in the finest grid.
    pub(crate) home: CellCoordinates,
}

/// Collision count that no disk ever has: a contact predicted at it never happens.
pub(crate) const VOID: u16 = 0;

/// Collision count of a disk that another strip simulates; no contact is ever predicted with it.
pub(crate) const ABSENT: u16 = VOID + 1;

/// Collision count of a disk before its first collision.
pub(crate) const FIRST: u16 = ABSENT + 1;

impl DiskRecord {
    /// Creates the record of a disk at engine time 0 without a predicted contact; `position` is
    /// relative to the corner of the cell `home`.
    pub(crate) fn new(
        home: CellCoordinates,
        position: Vector2<f64>,
        velocity: Vector2<f64>,
    ) -> Self {
        Self {
            position,
            velocity,
            clock: 0.0,
            contact: f64::INFINITY,
            partner: NONE,
            next: NONE,
            partner_count: VOID,
            count: FIRST,
            home,
        }
    }

    /// Returns the placeholder record of a disk that another strip simulates: it has no events, and
    /// contacts predicted with it are void.
    pub(crate) fn absent() -> Self {
        Self {
            clock: f64::INFINITY,
            count: ABSENT,
            ..Self::new([0; 2], Vector2::zeros(), Vector2::zeros())
        }
    }

    /// Returns true if the record is the placeholder of a disk that another strip simulates.
    pub(crate) fn is_absent(&self) -> bool {
        self.clock == f64::INFINITY
    }
}
