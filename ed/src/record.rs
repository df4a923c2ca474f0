//! The record of one disk.

use nalgebra::Vector2;

use crate::cells::{CellCoordinates, NONE};

/// Record of a disk in one cache line. Times and speeds are in the engine's own units.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct DiskRecord {
    /// Position relative to the corner of the cell, at the time `clock`.
    pub(crate) position: Vector2<f64>,
    pub(crate) velocity: Vector2<f64>,
    /// Time of position and velocity.
    pub(crate) clock: f64,
    /// Predicted time of contact with `partner`; infinite without one.
    pub(crate) contact: f64,
    /// Number of the partner: a disk; beyond the number of disks, a wall or obstacle; or [`NONE`].
    pub(crate) partner: u32,
    /// Next disk in the list of the cell, or [`NONE`].
    pub(crate) next: u32,
    /// Count of the partner when the contact was predicted; [`VOID`] if that count came up again
    /// since.
    pub(crate) partner_count: u16,
    /// Collisions of this disk, from [`FIRST`] to the largest number and from [`FIRST`] again.
    pub(crate) count: u16,
    /// Cell of the finest grid.
    pub(crate) home: CellCoordinates,
}

/// Count that no disk has.
pub(crate) const VOID: u16 = 0;

/// Count of a disk that is simulated elsewhere; no contact was predicted with it.
pub(crate) const ABSENT: u16 = VOID + 1;

/// First count of a disk.
pub(crate) const FIRST: u16 = ABSENT + 1;

impl DiskRecord {
    /// Creates the record of a disk at time 0 without a predicted contact.
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

    /// Placeholder of a disk that is simulated elsewhere: it has no events, and a contact predicted
    /// with it is void.
    pub(crate) fn absent() -> Self {
        Self {
            clock: f64::INFINITY,
            count: ABSENT,
            ..Self::new([0; 2], Vector2::zeros(), Vector2::zeros())
        }
    }

    /// Returns true if the disk is simulated elsewhere.
    pub(crate) fn is_absent(&self) -> bool {
        self.clock == f64::INFINITY
    }
}
