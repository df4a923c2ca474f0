//! Exact event-driven dynamics of inelastic hard disks: smooth or rough, in a periodic box or
//! between walls, around obstacles and under gravity.
//!
//! Between collisions disks fly on straight lines or on parabolas, which a uniform field makes
//! alike for all, so the next collision of a pair is the root of a quadratic and no time step
//! exists. The engine follows Lubachevsky, J. Comput. Phys. 94, 255 (1991),
//! doi:10.1016/0021-9991(91)90222-7, in its main lines:
//!
//! * each disk has a clock of its own and is moved only when something happens to it;
//! * the box is divided into cells at least one diameter wide; a disk looks for partners in the
//!   nine cells around it, and when it crosses into a cell, only in the three that are new to it;
//! * each disk has exactly one event in the calendar, the earliest of its predicted contacts and
//!   its next crossing. A contact is known to at least one of its partners, or will be: one that
//!   comes after the next contact of the other disk is left to that disk, which predicts anew then.
//!   When the partner has meanwhile collided with another, the disk predicts again at that moment;
//! * the calendar ([`Buckets`]) is a ring of time buckets that name disks, one cache line each. Old
//!   events are not removed but recognised when they come up: their disk's next event is at another
//!   time.
//!
//! Positions are kept relative to the corner of the disk's cell and times relative to an epoch. So
//! precision depends neither on the size of the box nor on the age of the gas, and neighbours
//! across the periodic boundary need no special case. Speeds are in a power of two near that of the
//! fastest disk, so that gases of any temperature compute alike. Disks of very different sizes get
//! a hierarchy of grids.
//!
//! Walls and obstacles ([`DiskBoundaries`]) are found in a table by cell; a contact with one of
//! them takes the place of one with a partner, so that a disk still has one event. Contact times
//! with all of them are closed forms or bracketed roots (`stosszahl_model::walls`). The momentum
//! and energy that they give to the gas are in [`EventDrivenEngine::ledgers`].
//!
//! The cost of one collision is about constant in the number of disks but for the memory hierarchy:
//! measurements, and rejected alternatives, are in `docs/development/event-driven.md`.
//!
//! [`plain`] is the oracle: all pairs, all disks moved at every event, nothing clever.

mod arrange;
mod calendar;
mod cell_list_walk;
mod cells;
mod checkpoint;
mod collapse;
mod collide;
mod contact;
mod disk;
mod engine;
mod error;
mod events;
mod first_contacts;
mod frames;
mod grid_hierarchy;
mod image_flags;
mod logging;
mod motion;
mod pair_prediction;
pub mod plain;
mod predict;
mod prefetch;
mod prefetch_plan;
mod rebound;
mod record;
mod simulate;
mod sliding_pair;
mod sliding_rows;
mod sliding_search;
mod start;
mod strip_log;
mod strips;
mod surroundings;

pub use calendar::{Buckets, Calendar, CalendarEntry, EventTimes, Sorted};
pub use cells::crossings_per_collision;
pub use checkpoint::{DissipationRule, EventCounters, EventDrivenCheckpoint};
pub use contact::time_to_contact;
pub use engine::EventDrivenEngine;
pub use error::{EventDrivenError, Touchable};
pub use prefetch_plan::PrefetchPlan;
pub use simulate::{resume, simulate, strips_for};
pub use strips::{StripSettings, StripedEngine};
pub use surroundings::DiskBoundaries;

/// Version of the statistics of the event-driven engine: one more with each change that moves means
/// beyond their errors, under *Results changed* in the changelog. Other digits of the same means do
/// not count. Costly results in the documentation are refused once it has moved.
pub const STATISTICS_VERSION: u32 = 1;
