//! What the engine refuses.

use std::fmt;

use stosszahl_model::walls::ObstacleError;
use stosszahl_model::{Invalid, MessageUnits, brief};

use crate::surroundings::FACES;

/// Name of a position in [`EngineError::BadNumber`].
pub(crate) const POSITION: &str = "position";

/// Why the engine could not start or go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The box is narrower than a disk.
    #[error("a disk of diameter {diameter} meets its own image in a box of {} x {}; both sides must be longer", brief(lengths[0]), brief(lengths[1]), diameter = brief(*diameter))]
    BoxTooSmall {
        /// Largest diameter.
        diameter: f64,
        /// Box.
        lengths: [f64; 2],
    },
    /// A position or velocity is no finite number, or too large to be squared.
    #[error("disk {disk} has {quantity} {value:?}; allowed are finite numbers up to 1e150")]
    BadNumber {
        /// Index of the disk.
        disk: usize,
        /// `position` or `velocity`.
        quantity: &'static str,
        /// What was found.
        value: [f64; 2],
    },
    /// A spin is no finite number, or too large to be squared.
    #[error("disk {disk} has a spin whose energy is no finite number; allowed are others")]
    BadSpin {
        /// Index of the disk.
        disk: usize,
    },
    /// A checkpoint of other boundaries.
    #[error(
        "{found} ledgers of walls and obstacles; allowed are none, or {expected} with these boundaries"
    )]
    WrongLedgers {
        /// How many were given.
        found: usize,
        /// How many there are.
        expected: usize,
    },
    /// Not one value for each disk.
    #[error("{found} {quantity} for {disks} disks; allowed are none, or one for each disk")]
    WrongCount {
        /// What there is not one of for each disk.
        quantity: &'static str,
        /// How many were given.
        found: usize,
        /// How many disks there are.
        disks: usize,
    },
    /// More disks than the engine can number.
    #[error("{disks} disks; allowed are up to {}", u32::MAX - 1)]
    TooMany {
        /// How many were given.
        disks: usize,
    },
    /// A face through which disks could leave.
    #[error(
        "axis {axis}, side {side}: the face is open; allowed are periodic faces and walls, as exact dynamics keeps its disks"
    )]
    OpenFace {
        /// Which, from 0.
        axis: usize,
        /// 0 for the lower face, 1 for the upper.
        side: usize,
    },
    /// The box of the state is not the one of the boundaries.
    #[error("axis {axis}: the box of the state {}, the boundaries say that it {}; allowed are the same", around(*state), around(!state))]
    UnlikeBox {
        /// Which, from 0.
        axis: usize,
        /// Whether the box of the state is periodic along it.
        state: bool,
    },
    /// The shear rate of the box is not that of the particles' flow.
    #[error(
        "the box of the state has the shear rate {found:?}, the scene {rate:?}; allowed are the same"
    )]
    UnlikeFlow {
        /// Shear rate of the box of the state.
        found: Option<f64>,
        /// Shear rate of the scene.
        rate: Option<f64>,
    },
    /// Image flags in a shear flow.
    #[error(
        "a start in a shear flow has image flags; allowed are none, as they do not tell displacements from the flow"
    )]
    FlagsInFlow,
    /// Two walls leave a disk no room.
    #[error(
        "axis {axis}: between the walls there is room for {room} at the least; allowed is a diameter of {diameter} or more", room = brief(*room), diameter = brief(*diameter))]
    NoRoom {
        /// Which, from 0.
        axis: usize,
        /// Least distance of the two walls.
        room: f64,
        /// Largest diameter.
        diameter: f64,
    },
    /// An obstacle that cannot be where it is.
    #[error("obstacle {obstacle}: {source}")]
    BadObstacle {
        /// Which, from 0.
        obstacle: usize,
        /// What is wrong with it.
        source: ObstacleError,
    },
    /// A law, a size or a box that cannot be.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// Bytes that are no checkpoint of this engine.
    #[error("the bytes are no checkpoint of these disks: {0}")]
    Checkpoint(#[from] postcard::Error),
    /// Two disks that overlap at the start.
    #[error("disks {} and {} overlap by {depth:e}; allowed are rounding errors", pair[0], pair[1])]
    OverlappingDisks {
        /// Their indices.
        pair: [usize; 2],
        /// How far.
        depth: f64,
    },
    /// A disk that starts inside a wall or an obstacle.
    #[error("disk {disk} at ({}, {}) overlaps {what} by {depth:e}; allowed are rounding errors", brief(place[0]), brief(place[1]))]
    Overlap {
        /// Index of the disk.
        disk: usize,
        /// Its position.
        place: [f64; 2],
        /// The wall or obstacle.
        what: Touchable,
        /// How far.
        depth: f64,
    },
    /// A disk that went through a wall, which the engine never lets happen.
    #[error(
        "disk {disk} left the box through {wall} at time {time}; this is an error of the program",
        time = brief(*time)
    )]
    Escaped {
        /// Index of the disk.
        disk: usize,
        /// The wall.
        wall: Touchable,
        /// When.
        time: f64,
    },
    /// The time of the start is no finite number.
    #[error("the start is at time {time}; allowed are finite numbers", time = brief(*time))]
    BadStart {
        /// What was found.
        time: f64,
    },
    /// The requested time is no number, or so far that flying disks lose their positions.
    #[error(
        "asked to advance to time {until}; allowed are times that disks reach with a position that has digits left, or infinity",
        until = brief(*until)
    )]
    BadTime {
        /// What was requested.
        until: f64,
    },
    /// The disks move but do not meet.
    #[error(
        "no collision in the work of {crossings} crossings of cells, until time {time}: they may never meet; ask for an earlier time, or for a gas whose disks do not fly past each other for ever",
        time = brief(*time)
    )]
    NoCollisions {
        /// When the engine gave up.
        time: f64,
        /// Cell boundaries crossed since the last collision, and work that took as long.
        crossings: u64,
    },
    /// Infinitely many contacts with a wall or an obstacle in a finite time, or a disk that comes to rest on it.
    #[error(
        "inelastic collapse at time {time}: {collisions} contacts without progress of time among {}, the last of disk {disk} with {what} \
         near ({}, {}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), brief(place[0]), brief(place[1]),
        time = brief(*time)
    )]
    WallCollapse {
        /// When \[time\].
        time: f64,
        /// Contacts since time last advanced.
        collisions: u64,
        /// The last disk.
        disk: usize,
        /// What it touched.
        what: Touchable,
        /// All that took part in the last contacts, in order.
        cluster: Vec<usize>,
        /// Where.
        place: [f64; 2],
    },
    /// Infinitely many collisions in a finite time.
    #[error(
        "inelastic collapse at time {time}: {collisions} collisions without progress of time among {}, the last of disks {} and {} \
         near ({}, {}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), pair[0], pair[1], brief(place[0]), brief(place[1]),
        time = brief(*time)
    )]
    InelasticCollapse {
        /// When \[time\].
        time: f64,
        /// Collisions since time last advanced.
        collisions: u64,
        /// The last pair.
        pair: [usize; 2],
        /// All that took part in the last collisions, in order.
        cluster: Vec<usize>,
        /// Where.
        place: [f64; 2],
    },
}

impl EngineError {
    /// Whether the gas has collapsed: it stands at that moment, and does not come further.
    pub fn is_collapse(&self) -> bool {
        matches!(
            self,
            Self::InelasticCollapse { .. } | Self::WallCollapse { .. }
        )
    }

    /// Converts times, lengths and speeds of the error to the units of a case. Obstacles are written in these already.
    #[must_use]
    pub fn in_units(mut self, units: &MessageUnits) -> Self {
        match &mut self {
            Self::BoxTooSmall { diameter, lengths } => {
                *diameter *= units.length;
                *lengths = units.place(*lengths);
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
                *place = units.place(*place);
                *depth *= units.length;
            }
            Self::Escaped { time, .. }
            | Self::BadStart { time }
            | Self::BadTime { until: time }
            | Self::NoCollisions { time, .. } => *time *= units.time,
            Self::WallCollapse { time, place, .. }
            | Self::InelasticCollapse { time, place, .. } => {
                *time *= units.time;
                *place = units.place(*place);
            }
            Self::BadSpin { .. }
            | Self::WrongLedgers { .. }
            | Self::WrongCount { .. }
            | Self::TooMany { .. }
            | Self::OpenFace { .. }
            | Self::UnlikeBox { .. }
            | Self::FlagsInFlow
            | Self::BadObstacle { .. }
            | Self::Invalid(_)
            | Self::Checkpoint(_) => {}
        }
        self
    }
}

/// What a disk can touch besides others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touchable {
    /// The wall at a face of the box.
    Wall {
        /// Axis, from 0.
        axis: usize,
        /// 0 for the lower face, 1 for the upper.
        side: usize,
    },
    /// An obstacle, by its number from 0.
    Obstacle(usize),
}

impl Touchable {
    /// What has the account of the given number: the faces come first.
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

/// Whether a box is periodic, in words.
fn around(periodic: bool) -> &'static str {
    if periodic { "is periodic" } else { "has walls" }
}

/// The disks of a cluster; of a large one, the first.
fn named(cluster: &[usize]) -> String {
    const MOST: usize = 12;
    let names: Vec<String> = cluster.iter().take(MOST).map(usize::to_string).collect();
    let more = if cluster.len() > MOST { ", ..." } else { "" };
    format!("{} disks ({}{more})", cluster.len(), names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit of length of 1e-3, of time of 0.1 and of speed of 1e-2.
    #[test]
    fn numbers_of_messages_are_converted() {
        let units = MessageUnits {
            length: 1e-3,
            time: 0.1,
            speed: 1e-2,
        };
        let bad = |quantity| EngineError::BadNumber {
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
                EngineError::BoxTooSmall {
                    diameter: 2.0,
                    lengths: [1.5, 8.0],
                },
                &["diameter 0.002", "0.0015 x 0.008"],
            ),
            (
                EngineError::NoRoom {
                    axis: 0,
                    room: 0.5,
                    diameter: 1.0,
                },
                &["room for 0.0005", "diameter of 0.001"],
            ),
            (
                EngineError::OverlappingDisks { pair, depth: 0.5 },
                &["by 5e-4"],
            ),
            (
                EngineError::Overlap {
                    disk: 1,
                    place,
                    what: Touchable::Obstacle(0),
                    depth: 0.5,
                },
                &["(0.02, 0.03)", "by 5e-4"],
            ),
            (EngineError::BadTime { until: 50.0 }, &["time 5;"]),
            (
                EngineError::NoCollisions {
                    time: 50.0,
                    crossings: 7,
                },
                &["until time 5:", "7 crossings"],
            ),
            (
                EngineError::InelasticCollapse {
                    time: 50.0,
                    collisions: 9,
                    pair,
                    cluster: cluster.clone(),
                    place,
                },
                &["at time 5:", "(0.02, 0.03)", "disks 4 and 5"],
            ),
            (
                EngineError::WallCollapse {
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
