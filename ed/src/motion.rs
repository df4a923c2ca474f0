//! Free flight of disks between events: straight lines, or parabolas in a uniform field, in engine
//! units.

use std::marker::PhantomData;

use nalgebra::Vector2;
use stosszahl_model::walls::flight::time_to_plane;
use stosszahl_model::{Field, Plane};

use crate::record::DiskRecord;

/// Law of free flight of a disk: straight lines or, in a uniform field, parabolas. Without field
/// the parabola costs nothing.
#[derive(Debug)]
pub(crate) struct FlightMotion<F> {
    /// Acceleration by the uniform field in engine units, equal for all disks.
    acceleration: Vector2<f64>,
    /// Shear rate of the flow in engine units; zero without a shear flow.
    shear_rate: f64,
    field: PhantomData<F>,
}

impl<F> Clone for FlightMotion<F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for FlightMotion<F> {}

impl<F: Field<Plane>> FlightMotion<F> {
    /// Creates the law of flight in a field, converted to engine units: speeds are divided by
    /// `speed`.
    pub(crate) fn new(field: &F, speed: f64) -> Self {
        Self {
            acceleration: field.acceleration() / speed / speed,
            shear_rate: field.shear_rate() / speed,
            field: PhantomData,
        }
    }

    /// Returns the acceleration by the uniform field in engine units, equal for all disks; zero for
    /// straight flight.
    #[inline(always)]
    pub(crate) fn acceleration(&self) -> Vector2<f64> {
        self.acceleration
    }

    /// Returns the shear rate of the flow in engine units; zero without a shear flow.
    pub(crate) fn shear_rate(&self) -> f64 {
        self.shear_rate
    }

    /// Returns the position of a disk in free flight at an engine time, relative to the corner of
    /// its cell \[length\].
    #[inline(always)]
    pub(crate) fn position_at(&self, disk: &DiskRecord, time: f64) -> Vector2<f64> {
        let flight = time - disk.clock;
        if F::FREE {
            disk.position + disk.velocity * flight
        } else {
            disk.position + (disk.velocity + self.acceleration * (0.5 * flight)) * flight
        }
    }

    /// Returns the velocity of a disk in free flight at an engine time, in engine units.
    #[inline(always)]
    pub(crate) fn velocity(&self, disk: &DiskRecord, time: f64) -> Vector2<f64> {
        if F::FREE {
            disk.velocity
        } else {
            disk.velocity + self.acceleration * (time - disk.clock)
        }
    }

    /// Moves a disk along its free flight to an engine time: position, velocity and clock.
    #[inline(always)]
    pub(crate) fn advance(&self, disk: &mut DiskRecord, time: f64) {
        disk.position = self.position_at(disk, time);
        disk.velocity = self.velocity(disk, time);
        disk.clock = time;
    }

    /// Returns true if a disk at a boundary of its cell crosses it in the positive direction of
    /// `axis`.
    #[inline(always)]
    pub(crate) fn goes_forward(&self, disk: &DiskRecord, axis: usize, width: f64) -> bool {
        if F::FREE || self.acceleration[axis] == 0.0 {
            disk.velocity[axis] > 0.0
        } else {
            // At the top of a parabola the sign of the velocity is that of its rounding.
            disk.position[axis] > 0.5 * width
        }
    }

    /// Returns the engine time at which a disk leaves its cell, never before its clock, and the
    /// axis of the boundary it crosses.
    #[inline(always)]
    pub(crate) fn exit(&self, disk: &DiskRecord, width: Vector2<f64>) -> (f64, usize) {
        let straight = |axis: usize| {
            let speed = disk.velocity[axis];
            let boundary = if speed > 0.0 { width[axis] } else { 0.0 };
            let wait = (boundary - disk.position[axis]) / speed;
            if speed == 0.0 { f64::INFINITY } else { wait }
        };
        if F::FREE {
            let (x, y) = (straight(0), straight(1));
            let wait = if x <= y { x } else { y };
            return (
                disk.clock + if wait > 0.0 { wait } else { 0.0 },
                usize::from(x > y),
            );
        }
        let bent = |axis: usize| {
            let pull = self.acceleration[axis];
            if pull == 0.0 {
                return straight(axis);
            }
            let (place, speed) = (disk.position[axis], disk.velocity[axis]);
            let below = time_to_plane(place, speed, pull);
            let above = time_to_plane(width[axis] - place, -speed, -pull);
            (below.unwrap_or(f64::INFINITY)).min(above.unwrap_or(f64::INFINITY))
        };
        let (x, y) = (bent(0), bent(1));
        let (wait, axis) = if x <= y { (x, 0) } else { (y, 1) };
        if wait > 0.0 {
            // A crossing takes at least one clock step, or the disk would cross for ever.
            ((disk.clock + wait).max(disk.clock.next_up()), axis)
        } else {
            (disk.clock, axis)
        }
    }
}
