//! Errors of the event-driven engine: invalid starts, inelastic collapse, and gases without
//! collisions.

use std::fmt;

use stosszahl_model::walls::ObstacleError;
use stosszahl_model::{InvalidValue, MessageUnits, format_short};

use crate::surroundings::FACES;

/// Name of the position as the invalid quantity in [`EventDrivenError::BadNumber`].
pub(crate) const POSITION: &str = "position";

/// Error of the event-driven engine: why it could not start or continue.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EventDrivenError {
    /// A uniform shear flow is requested, but the program was compiled without the feature `shear`.
    #[error(
        "this program has no uniform shear flow; it was compiled without the feature \"shear\""
    )]
    NoShear,
    /// Rough disks are requested, but the program was compiled without the feature `rough`.
    #[error("this program has no disks that spin; it was compiled without the feature \"rough\"")]
    NoRough,
    /// The box is narrower than the largest disk.
    #[error("a disk of diameter {diameter} meets its own image in a box of {} x {}; both sides must be longer", format_short(lengths[0]), format_short(lengths[1]), diameter = format_short(*diameter))]
    BoxTooSmall {
        /// Largest diameter of a disk in the box that is too small \[length\].
        diameter: f64,
        /// Sides of the box that is too small \[length\].
        lengths: [f64; 2],
    },
    /// The position or velocity of a disk is not a finite number, or too large to be squared.
    #[error("disk {disk} has {quantity} {value:?}; allowed are finite numbers up to 1e150")]
    BadNumber {
        /// Index in the state of the disk with an invalid position or velocity.
        disk: usize,
        /// Name of the invalid quantity of a disk: `position` or `velocity`.
        quantity: &'static str,
        /// Invalid position or velocity found.
        value: [f64; 2],
    },
    /// The angular velocity of a disk is not a finite number, or too large to be squared.
    #[error("disk {disk} has a spin whose energy is no finite number; allowed are others")]
    BadSpin {
        /// Index in the state of the disk with an invalid angular velocity.
        disk: usize,
    },
    /// The checkpoint belongs to a box with other walls and obstacles: its number of ledgers
    /// differs.
    #[error(
        "{found} ledgers of walls and obstacles; allowed are none, or {expected} with these boundaries"
    )]
    WrongLedgers {
        /// Number of wall and obstacle ledgers in the checkpoint.
        found: usize,
        /// Number of wall and obstacle ledgers that the box has.
        expected: usize,
    },
    /// A list in the start, for example of image flags, does not have one value for each disk.
    #[error("{found} {quantity} for {disks} disks; allowed are none, or one for each disk")]
    WrongCount {
        /// Name of the list with a wrong number of values.
        quantity: &'static str,
        /// Number of values in the list.
        found: usize,
        /// Number of disks, which the list should have values for.
        disks: usize,
    },
    /// There are more disks than the engine can number with 32 bits.
    #[error("{disks} disks; allowed are up to {}", u32::MAX - 1)]
    TooMany {
        /// Number of disks given, which is too large.
        disks: usize,
    },
    /// A face of the box is an open boundary, through which disks could leave; the engine knows
    /// only closed boxes.
    #[error(
        "axis {axis}, side {side}: the face is open; allowed are periodic faces and walls, as exact dynamics keeps its disks"
    )]
    OpenFace {
        /// Axis of the open face, from 0.
        axis: usize,
        /// Side of the open face: 0 lower, 1 upper.
        side: usize,
    },
    /// The box of the state is periodic where the boundaries have walls, or the reverse.
    #[error("axis {axis}: the box of the state {}, the boundaries say that it {}; allowed are the same", boundary_word(*state), boundary_word(!state))]
    UnlikeBox {
        /// Axis along which box and boundaries differ, from 0.
        axis: usize,
        /// True if the box of the state is periodic along this axis.
        state: bool,
    },
    /// The shear rate of the box differs from the shear rate of the particle model.
    #[error(
        "the box of the state has the shear rate {found:?}, the scene {rate:?}; allowed are the same"
    )]
    UnlikeFlow {
        /// Shear rate of the box in the state \[1/time\]; `None` without shear.
        found: Option<f64>,
        /// Shear rate of the particle model \[1/time\]; `None` without shear.
        rate: Option<f64>,
    },
    /// The start has image flags although the gas is in a shear flow, where they are not supported.
    #[error(
        "a start in a shear flow has image flags; allowed are none, as they do not tell displacements from the flow"
    )]
    FlagsInFlow,
    /// Two opposite walls leave no room for the largest disk.
    #[error(
        "axis {axis}: between the walls there is room for {room} at the least; allowed is a diameter of {diameter} or more", room = format_short(*room), diameter = format_short(*diameter))]
    NoRoom {
        /// Axis along which the two walls are too close, from 0.
        axis: usize,
        /// Least distance between the two walls \[length\].
        room: f64,
        /// Largest diameter of a disk that must fit between the walls \[length\].
        diameter: f64,
    },
    /// An obstacle is outside the box, or its shape is invalid.
    #[error("obstacle {obstacle}: {source}")]
    BadObstacle {
        /// Index of the invalid obstacle, from 0.
        obstacle: usize,
        /// Reason why the obstacle is invalid.
        source: ObstacleError,
    },
    /// A value of a collision law, a size or a box is outside its allowed range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The bytes given are not a checkpoint of this engine.
    #[error("the bytes are no checkpoint of these disks: {0}")]
    Checkpoint(#[from] postcard::Error),
    /// Two disks of the initial state overlap.
    #[error("disks {} and {} overlap by {depth:e}; allowed are rounding errors", pair[0], pair[1])]
    OverlappingDisks {
        /// Indices in the state of the two overlapping disks.
        pair: [usize; 2],
        /// Depth of the overlap of the two disks \[length\].
        depth: f64,
    },
    /// A disk of the initial state overlaps a wall or an obstacle.
    #[error("disk {disk} at ({}, {}) overlaps {what} by {depth:e}; allowed are rounding errors", format_short(place[0]), format_short(place[1]))]
    Overlap {
        /// Index in the state of the disk that overlaps a wall or obstacle.
        disk: usize,
        /// Position of the disk that overlaps a wall or obstacle \[length\].
        place: [f64; 2],
        /// Wall or obstacle that the disk overlaps.
        what: Touchable,
        /// Depth of the overlap of the disk with the wall or obstacle \[length\].
        depth: f64,
    },
    /// A disk went through a wall: an internal error of the engine.
    #[error(
        "disk {disk} left the box through {wall} at time {time}; this is an error of the program",
        time = format_short(*time)
    )]
    Escaped {
        /// Index in the state of the disk that went through a wall.
        disk: usize,
        /// Wall that the disk went through.
        wall: Touchable,
        /// Time at which the disk was found beyond the wall \[time\].
        time: f64,
    },
    /// The time of the initial state is not a finite number.
    #[error("the start is at time {time}; allowed are finite numbers", time = format_short(*time))]
    BadStart {
        /// Time of the initial state, not a finite number.
        time: f64,
    },
    /// The time to advance to is not a number, or so far ahead that moving disks lose the precision
    /// of their positions.
    #[error(
        "asked to advance to time {until}; allowed are times that disks reach with a position that has digits left, or infinity",
        until = format_short(*until)
    )]
    BadTime {
        /// Time to advance to, as requested \[time\].
        until: f64,
    },
    /// The disks move but never collide: the engine gave up.
    #[error(
        "no collision in the work of {crossings} crossings of cells, until time {time}: they may never meet; ask for an earlier time, or for a gas whose disks do not fly past each other for ever",
        time = format_short(*time)
    )]
    NoCollisions {
        /// Time at which the engine gave up waiting for a collision \[time\].
        time: f64,
        /// Number of cell boundaries crossed since the last collision; restarts of the engine count
        /// as as many crossings as take equally long.
        crossings: u64,
    },
    /// Inelastic collapse at a wall or an obstacle: infinitely many contacts in a finite time, or a
    /// disk that comes to rest there.
    #[error(
        "inelastic collapse at time {time}: {collisions} contacts without progress of time among {}, the last of disk {disk} with {what} \
         near ({}, {}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), format_short(place[0]), format_short(place[1]),
        time = format_short(*time)
    )]
    WallCollapse {
        /// Time of the collapse at a wall or obstacle \[time\].
        time: f64,
        /// Number of contacts since time last advanced noticeably.
        collisions: u64,
        /// Index in the state of the last disk that touched the wall or obstacle.
        disk: usize,
        /// Wall or obstacle at which the collapse happened.
        what: Touchable,
        /// Indices in the state of all disks in the latest contacts, in increasing order.
        cluster: Vec<usize>,
        /// Position of the disk at its last contact with the wall or obstacle \[length\].
        place: [f64; 2],
    },
    /// Inelastic collapse: infinitely many collisions between disks in a finite time.
    #[error(
        "inelastic collapse at time {time}: {collisions} collisions without progress of time among {}, the last of disks {} and {} \
         near ({}, {}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), pair[0], pair[1], format_short(place[0]), format_short(place[1]),
        time = format_short(*time)
    )]
    InelasticCollapse {
        /// Time of the inelastic collapse \[time\].
        time: f64,
        /// Number of contacts since time last advanced noticeably.
        collisions: u64,
        /// Indices in the state of the two disks in the last collision.
        pair: [usize; 2],
        /// Indices in the state of all disks in the latest collisions, in increasing order.
        cluster: Vec<usize>,
        /// Position of a disk of the last pair at its collision \[length\].
        place: [f64; 2],
    },
}

impl EventDrivenError {
    /// Returns true if the error is an inelastic collapse, between disks or at a wall. The state of
    /// the gas is then that at the collapse, and the gas cannot advance further.
    pub fn is_collapse(&self) -> bool {
        matches!(
            self,
            Self::InelasticCollapse { .. } | Self::WallCollapse { .. }
        )
    }

    /// Converts times, lengths and speeds of the error to the units of a case, for messages. Errors
    /// of obstacles are in these units already.
    #[must_use]
    pub fn in_units(mut self, units: &MessageUnits) -> Self {
        match &mut self {
            Self::BoxTooSmall { diameter, lengths } => {
                *diameter *= units.length;
                *lengths = units.scale_position(*lengths);
            }
            Self::BadNumber {
                quantity, value, ..
            } => {
                let is_position = *quantity == POSITION;
                let unit = if is_position {
                    units.length
                } else {
                    units.speed
                };
                *value = value.map(|number| number * unit);
            }
            Self::NoRoom { room, diameter, .. } => {
                *room *= units.length;
                *diameter *= units.length;
            }
            Self::UnlikeFlow { found, rate } => {
                for number in found.iter_mut().chain(rate) {
                    *number /= units.time;
                }
            }
            Self::OverlappingDisks { depth, .. } => *depth *= units.length,
            Self::Overlap { place, depth, .. } => {
                *place = units.scale_position(*place);
                *depth *= units.length;
            }
            Self::Escaped { time, .. }
            | Self::BadStart { time }
            | Self::BadTime { until: time }
            | Self::NoCollisions { time, .. } => *time *= units.time,
            Self::WallCollapse { time, place, .. }
            | Self::InelasticCollapse { time, place, .. } => {
                *time *= units.time;
                *place = units.scale_position(*place);
            }
            Self::BadSpin { .. }
            | Self::WrongLedgers { .. }
            | Self::WrongCount { .. }
            | Self::TooMany { .. }
            | Self::OpenFace { .. }
            | Self::UnlikeBox { .. }
            | Self::FlagsInFlow
            | Self::NoRough
            | Self::NoShear
            | Self::BadObstacle { .. }
            | Self::Invalid(_)
            | Self::Checkpoint(_) => {}
        }
        self
    }
}

/// Wall or obstacle that a disk can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touchable {
    /// Wall at a face of the box.
    Wall {
        /// Axis of the wall, the direction of its normal: 0 or 1.
        axis: usize,
        /// Side of the box where the wall is: 0 lower, 1 upper.
        side: usize,
    },
    /// Obstacle in the box, by its index from 0.
    Obstacle(usize),
}

impl Touchable {
    /// Returns the wall or obstacle with the given index in the list of ledgers, which begins with
    /// the four faces.
    pub(crate) fn of_ledger(ledger: usize) -> Self {
        if ledger < FACES {
            Self::Wall {
                axis: ledger / 2,
                side: ledger % 2,
            }
        } else {
            Self::Obstacle(ledger - FACES)
        }
    }
}

impl fmt::Display for Touchable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wall { axis, side } => write!(f, "the wall of axis {axis}, side {side}"),
            Self::Obstacle(number) => write!(f, "obstacle {number}"),
        }
    }
}

/// Returns the words of the error message for a periodic axis or for one with walls.
fn boundary_word(periodic: bool) -> &'static str {
    if periodic { "is periodic" } else { "has walls" }
}

/// Formats the disk indices of a cluster for an error message; of a large cluster, the first
/// twelve.
fn named(cluster: &[usize]) -> String {
    const MOST: usize = 12;
    let names: Vec<String> = cluster.iter().take(MOST).map(usize::to_string).collect();
    let more = if cluster.len() > MOST { ", ..." } else { "" };
    format!("{} disks ({}{more})", cluster.len(), names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Converts numbers in messages with units of length of 1e-3, of time of 0.1 and of speed of
    /// 1e-2.
    #[test]
    fn numbers_of_messages_are_converted() {
        let units = MessageUnits {
            length: 1e-3,
            time: 0.1,
            speed: 1e-2,
        };
        let bad = |quantity| EventDrivenError::BadNumber {
            disk: 3,
            quantity,
            value: [2.0, f64::NAN],
        };
        let pair = [4, 5];
        let (cluster, place) = (vec![4, 5], [20.0, 30.0]);
        for (error, words) in [
            (bad(POSITION), &["position [0.002, NaN]"][..]),
            (bad("velocity"), &["velocity [0.02, NaN]"]),
            (
                EventDrivenError::BoxTooSmall {
                    diameter: 2.0,
                    lengths: [1.5, 8.0],
                },
                &["diameter 0.002", "0.0015 x 0.008"],
            ),
            (
                EventDrivenError::NoRoom {
                    axis: 0,
                    room: 0.5,
                    diameter: 1.0,
                },
                &["room for 0.0005", "diameter of 0.001"],
            ),
            (
                EventDrivenError::OverlappingDisks { pair, depth: 0.5 },
                &["by 5e-4"],
            ),
            (
                EventDrivenError::Overlap {
                    disk: 1,
                    place,
                    what: Touchable::Obstacle(0),
                    depth: 0.5,
                },
                &["(0.02, 0.03)", "by 5e-4"],
            ),
            (EventDrivenError::BadTime { until: 50.0 }, &["time 5;"]),
            (
                EventDrivenError::NoCollisions {
                    time: 50.0,
                    crossings: 7,
                },
                &["until time 5:", "7 crossings"],
            ),
            (
                EventDrivenError::InelasticCollapse {
                    time: 50.0,
                    collisions: 9,
                    pair,
                    cluster: cluster.clone(),
                    place,
                },
                &["at time 5:", "(0.02, 0.03)", "disks 4 and 5"],
            ),
            (
                EventDrivenError::WallCollapse {
                    time: 50.0,
                    collisions: 9,
                    disk: 4,
                    what: Touchable::Obstacle(0),
                    cluster,
                    place,
                },
                &["at time 5:", "(0.02, 0.03)"],
            ),
        ] {
            let said = error.in_units(&units).to_string();
            assert!(
                words.iter().all(|word| said.contains(word)),
                "{said}: {words:?}"
            );
        }
    }
}
