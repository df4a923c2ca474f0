//! Errors of the engine.

use std::fmt;

use stosszahl_model::walls::ObstacleError;
use stosszahl_model::{InvalidValue, MessageUnits, format_short};

use crate::surroundings::FACES;

/// Name of a position in [`EventDrivenError::BadNumber`].
pub(crate) const POSITION: &str = "position";

/// Reason why the engine could not start or continue.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EventDrivenError {
    /// Uniform shear flow in a program compiled without it.
    #[error(
        "this program has no uniform shear flow; it was compiled without the feature \"shear\""
    )]
    NoShear,
    /// Rough disks in a program compiled without them.
    #[error("this program has no disks that spin; it was compiled without the feature \"rough\"")]
    NoRough,
    /// The box is narrower than a disk.
    #[error("a disk of diameter {diameter} meets its own image in a box of {} x {}; both sides must be longer", format_short(lengths[0]), format_short(lengths[1]), diameter = format_short(*diameter))]
    BoxTooSmall {
        /// Largest diameter \[length\].
        diameter: f64,
        /// Sides of the box \[length\].
        lengths: [f64; 2],
    },
    /// A position or velocity is no finite number, or too large to be squared.
    #[error("disk {disk} has {quantity} {value:?}; allowed are finite numbers up to 1e150")]
    BadNumber {
        /// Index of the disk.
        disk: usize,
        /// Name of the quantity: `position` or `velocity`.
        quantity: &'static str,
        /// Value found.
        value: [f64; 2],
    },
    /// A spin is no finite number, or too large to be squared.
    #[error("disk {disk} has a spin whose energy is no finite number; allowed are others")]
    BadSpin {
        /// Index of the disk.
        disk: usize,
    },
    /// The checkpoint is of other boundaries.
    #[error(
        "{found} ledgers of walls and obstacles; allowed are none, or {expected} with these boundaries"
    )]
    WrongLedgers {
        /// Number of ledgers given.
        found: usize,
        /// Number of ledgers of the boundaries.
        expected: usize,
    },
    /// A quantity does not have one value for each disk.
    #[error("{found} {quantity} for {disks} disks; allowed are none, or one for each disk")]
    WrongCount {
        /// Name of the quantity.
        quantity: &'static str,
        /// Number of values given.
        found: usize,
        /// Number of disks.
        disks: usize,
    },
    /// There are more disks than the engine can number.
    #[error("{disks} disks; allowed are up to {}", u32::MAX - 1)]
    TooMany {
        /// Number of disks given.
        disks: usize,
    },
    /// A face is open, so that disks could leave.
    #[error(
        "axis {axis}, side {side}: the face is open; allowed are periodic faces and walls, as exact dynamics keeps its disks"
    )]
    OpenFace {
        /// Axis, from 0.
        axis: usize,
        /// Side: 0 lower, 1 upper.
        side: usize,
    },
    /// The box of the state is not the one of the boundaries.
    #[error("axis {axis}: the box of the state {}, the boundaries say that it {}; allowed are the same", boundary_word(*state), boundary_word(!state))]
    UnlikeBox {
        /// Axis, from 0.
        axis: usize,
        /// True if the box of the state is periodic along the axis.
        state: bool,
    },
    /// The shear rate of the box differs from the shear rate of the particles.
    #[error(
        "the box of the state has the shear rate {found:?}, the scene {rate:?}; allowed are the same"
    )]
    UnlikeFlow {
        /// Shear rate of the box of the state \[1/time\].
        found: Option<f64>,
        /// Shear rate of the scene \[1/time\].
        rate: Option<f64>,
    },
    /// The start has image flags in a shear flow.
    #[error(
        "a start in a shear flow has image flags; allowed are none, as they do not tell displacements from the flow"
    )]
    FlagsInFlow,
    /// Two walls leave a disk no room.
    #[error(
        "axis {axis}: between the walls there is room for {room} at the least; allowed is a diameter of {diameter} or more", room = format_short(*room), diameter = format_short(*diameter))]
    NoRoom {
        /// Axis, from 0.
        axis: usize,
        /// Least distance of the two walls \[length\].
        room: f64,
        /// Largest diameter \[length\].
        diameter: f64,
    },
    /// An obstacle is outside the box, or invalid.
    #[error("obstacle {obstacle}: {source}")]
    BadObstacle {
        /// Number of the obstacle, from 0.
        obstacle: usize,
        /// Fault of the obstacle.
        source: ObstacleError,
    },
    /// A law, a size or a box is invalid.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The bytes are no checkpoint of this engine.
    #[error("the bytes are no checkpoint of these disks: {0}")]
    Checkpoint(#[from] postcard::Error),
    /// Two disks overlap at the start.
    #[error("disks {} and {} overlap by {depth:e}; allowed are rounding errors", pair[0], pair[1])]
    OverlappingDisks {
        /// Indices of the disks.
        pair: [usize; 2],
        /// Depth of the overlap \[length\].
        depth: f64,
    },
    /// A disk starts inside a wall or an obstacle.
    #[error("disk {disk} at ({}, {}) overlaps {what} by {depth:e}; allowed are rounding errors", format_short(place[0]), format_short(place[1]))]
    Overlap {
        /// Index of the disk.
        disk: usize,
        /// Position of the disk \[length\].
        place: [f64; 2],
        /// Wall or obstacle that the disk overlaps.
        what: Touchable,
        /// Depth of the overlap \[length\].
        depth: f64,
    },
    /// A disk went through a wall, which the engine must never allow.
    #[error(
        "disk {disk} left the box through {wall} at time {time}; this is an error of the program",
        time = format_short(*time)
    )]
    Escaped {
        /// Index of the disk.
        disk: usize,
        /// Wall that the disk went through.
        wall: Touchable,
        /// Time at which it was found \[time\].
        time: f64,
    },
    /// The time of the start is no finite number.
    #[error("the start is at time {time}; allowed are finite numbers", time = format_short(*time))]
    BadStart {
        /// Time found.
        time: f64,
    },
    /// The requested time is no number, or so far that flying disks lose their positions.
    #[error(
        "asked to advance to time {until}; allowed are times that disks reach with a position that has digits left, or infinity",
        until = format_short(*until)
    )]
    BadTime {
        /// Time requested \[time\].
        until: f64,
    },
    /// The disks move but do not meet.
    #[error(
        "no collision in the work of {crossings} crossings of cells, until time {time}: they may never meet; ask for an earlier time, or for a gas whose disks do not fly past each other for ever",
        time = format_short(*time)
    )]
    NoCollisions {
        /// Time at which the engine gave up \[time\].
        time: f64,
        /// Cell boundaries crossed since the last collision, and work that took as long.
        crossings: u64,
    },
    /// Infinitely many contacts with a wall or an obstacle in a finite time, or a disk that comes
    /// to rest on it.
    #[error(
        "inelastic collapse at time {time}: {collisions} contacts without progress of time among {}, the last of disk {disk} with {what} \
         near ({}, {}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), format_short(place[0]), format_short(place[1]),
        time = format_short(*time)
    )]
    WallCollapse {
        /// Time of the collapse \[time\].
        time: f64,
        /// Number of contacts since time last advanced.
        collisions: u64,
        /// Index of the last disk.
        disk: usize,
        /// Wall or obstacle that it touched.
        what: Touchable,
        /// Indices of all disks of the last contacts, in order.
        cluster: Vec<usize>,
        /// Position of the last contact \[length\].
        place: [f64; 2],
    },
    /// Infinitely many collisions in a finite time.
    #[error(
        "inelastic collapse at time {time}: {collisions} collisions without progress of time among {}, the last of disks {} and {} \
         near ({}, {}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), pair[0], pair[1], format_short(place[0]), format_short(place[1]),
        time = format_short(*time)
    )]
    InelasticCollapse {
        /// Time of the collapse \[time\].
        time: f64,
        /// Number of collisions since time last advanced.
        collisions: u64,
        /// Indices of the last pair.
        pair: [usize; 2],
        /// Indices of all disks of the last collisions, in order.
        cluster: Vec<usize>,
        /// Position of the last contact \[length\].
        place: [f64; 2],
    },
}

impl EventDrivenError {
    /// Returns true if the gas has collapsed: its state is the state at the collapse, and it does
    /// not advance further.
    pub fn is_collapse(&self) -> bool {
        matches!(
            self,
            Self::InelasticCollapse { .. } | Self::WallCollapse { .. }
        )
    }

    /// Converts times, lengths and speeds of the error to the units of a case. Errors of obstacles
    /// are in these units already.
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
    /// The wall at a face of the box.
    Wall {
        /// Axis, from 0.
        axis: usize,
        /// Side: 0 lower, 1 upper.
        side: usize,
    },
    /// An obstacle, by its number from 0.
    Obstacle(usize),
}

impl Touchable {
    /// Returns the wall or obstacle of the given ledger: the faces come first.
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

/// Returns the word for a periodic or a closed box.
fn boundary_word(periodic: bool) -> &'static str {
    if periodic { "is periodic" } else { "has walls" }
}

/// Formats the disks of a cluster; of a large one, the first.
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
