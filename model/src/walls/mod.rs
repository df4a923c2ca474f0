//! Walls, open faces and obstacles of the box, with one wall law for all engines.
//!
//! A face of the box is periodic, a wall, or open. Walls are data: an engine that finds none
//! schedules no event and draws no number for them. Times of contact with plane walls are closed
//! forms ([`flight`]). Bodies inside the box are [`Obstacle`]s, in the plane.

mod descent;
mod feature;
pub mod flight;
mod free_area;
mod obstacle;
mod rebound;
mod vibration;

use serde::{Deserialize, Serialize};

pub use feature::{Feature, FlyingParticle, Hit, Round, StraightEdge};
pub use free_area::FreeArea;
pub use obstacle::{Obstacle, ObstacleError, ObstacleShape, Obstacles};
pub use rebound::{Rebound, Touch, WallLedger};
pub use vibration::Vibration;

use crate::domain::Domain;
use crate::invalid::InvalidValue;
use crate::space::{Plane, Space, Volume};

/// Names of the faces of a box, lower and upper, for each axis: left, right, bottom, top, back,
/// front.
pub const FACES: [[&str; 2]; 3] = [["left", "right"], ["bottom", "top"], ["back", "front"]];

/// Plane wall at a face of the box: its law, sliding velocity and vibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Wall<S: Space> {
    /// Law by which particles rebound from the wall.
    pub rebound: Rebound,
    /// Velocity at which the wall slides parallel to itself \[length/time\].
    pub sliding: S::Vector,
    /// Vibration of the wall along its normal; `None` if it is at rest.
    pub vibration: Option<Vibration>,
}

impl<S: Space> Wall<S> {
    /// Creates a wall at rest with a law of rebound.
    pub fn still(rebound: Rebound) -> Self {
        Self {
            rebound,
            sliding: S::Vector::default(),
            vibration: None,
        }
    }

    /// Creates a specular wall at rest, which reverses the normal velocity of particles and changes
    /// nothing else.
    pub fn specular() -> Self {
        Self::still(Rebound::Restitutive {
            restitution: 1.0,
            slip: 1.0,
        })
    }

    /// Returns the displacement of the wall from its face into the gas at a time \[length\].
    pub fn displacement(&self, time: f64) -> f64 {
        self.vibration.map_or(0.0, |v| v.displacement(time))
    }

    /// Returns the velocity of the wall at a time, given the inward normal of its face
    /// \[length/time\].
    pub fn velocity(&self, normal: S::Vector, time: f64) -> S::Vector {
        match self.vibration {
            Some(vibration) => self.sliding + normal * vibration.velocity(time),
            None => self.sliding,
        }
    }
}

/// Face of the box: periodic, a wall, or open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Face<S: Space> {
    /// Periodic face: particles that leave enter on the opposite side.
    #[default]
    Periodic,
    /// Wall, from which particles rebound.
    Wall(Wall<S>),
    /// Open face: particles that leave are removed. Monte Carlo only, since event-driven dynamics
    /// keeps its disks.
    Open,
}

/// Error why the faces of a box are invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WallError {
    /// One face of an axis is periodic, but the opposite one is not.
    #[error(
        "axis {axis}: one face is periodic and the opposite one is not; allowed are both or none"
    )]
    HalfPeriodic {
        /// Axis that is periodic on one side only, from 0.
        axis: usize,
    },
    /// A number of a wall is outside its allowed range.
    #[error("axis {axis}, side {side}: {source}")]
    BadNumber {
        /// Axis of the wall with an invalid number, from 0.
        axis: usize,
        /// Side of the box where the wall is: 0 lower, 1 upper.
        side: usize,
        /// Invalid number of the wall, and its allowed values.
        source: InvalidValue,
    },
}

/// Faces of a box, lower and upper along each axis; faces beyond the dimension are periodic.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Walls<S: Space> {
    faces: [[Face<S>; 2]; 3],
}

impl Walls<Volume> {
    /// Returns the faces of the first two axes, as those of a two-dimensional box.
    pub fn in_plane(&self) -> Walls<Plane> {
        let flat = |face: Face<Volume>| match face {
            Face::Periodic => Face::Periodic,
            Face::Open => Face::Open,
            Face::Wall(wall) => Face::Wall(Wall {
                rebound: wall.rebound,
                sliding: wall.sliding.xy(),
                vibration: wall.vibration,
            }),
        };
        let mut walls = Walls::default();
        for axis in 0..2 {
            walls.faces[axis] = self.faces[axis].map(flat);
        }
        walls
    }
}

impl<S: Space> Walls<S> {
    /// Returns the faces of a periodic box without walls.
    pub fn none() -> Self {
        Self::default()
    }

    /// Creates the faces of a box from the lower and the upper face along each axis.
    ///
    /// # Errors
    /// [`WallError`] if an axis is periodic on one side only, or a number of a wall is out of
    /// range.
    pub fn new(faces: &[[Face<S>; 2]]) -> Result<Self, WallError> {
        let mut walls = Self::default();
        for (axis, pair) in faces.iter().take(S::DIMENSION).enumerate() {
            let periodic = pair.map(|face| face == Face::Periodic);
            if periodic[0] != periodic[1] {
                return Err(WallError::HalfPeriodic { axis });
            }
            for (side, face) in pair.iter().enumerate() {
                if let Face::Wall(wall) = face {
                    check_wall(wall, axis).map_err(|source| WallError::BadNumber {
                        axis,
                        side,
                        source,
                    })?;
                }
            }
            walls.faces[axis] = *pair;
        }
        Ok(walls)
    }

    /// Returns the face of the box along an axis, on the lower (0) or upper (1) side.
    pub fn face(&self, axis: usize, side: usize) -> &Face<S> {
        &self.faces[axis][side]
    }

    /// Returns the wall along an axis, on the lower (0) or upper (1) side; `None` if the face is no
    /// wall.
    #[inline]
    pub fn wall(&self, axis: usize, side: usize) -> Option<&Wall<S>> {
        match &self.faces[axis][side] {
            Face::Wall(wall) => Some(wall),
            _ => None,
        }
    }

    /// Returns true if all faces of the box are periodic.
    pub fn is_periodic(&self) -> bool {
        (self.faces.iter().flatten()).all(|face| *face == Face::Periodic)
    }

    /// Returns true if some face of the box is open, so that particles can leave.
    pub fn is_open(&self) -> bool {
        (self.faces.iter().flatten()).any(|face| *face == Face::Open)
    }

    /// Creates a box of the given side lengths with these faces \[length\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless they are positive and finite.
    pub fn domain(&self, lengths: S::Vector) -> Result<Domain<S>, InvalidValue> {
        let periodic = [0, 1, 2].map(|axis| self.faces[axis][0] == Face::Periodic);
        Domain::new(lengths, periodic)
    }

    /// Returns the unit normal vector of a face of the box, pointing into the gas.
    pub fn normal(axis: usize, side: usize) -> S::Vector {
        let mut normal = S::Vector::default();
        normal[axis] = if side == 0 { 1.0 } else { -1.0 };
        normal
    }
}

/// Checks that the law and the sliding velocity of a wall are valid; `axis` is that of its normal.
fn check_wall<S: Space>(wall: &Wall<S>, axis: usize) -> Result<(), InvalidValue> {
    wall.rebound.check_values()?;
    for component in 0..S::DIMENSION {
        let speed = wall.sliding[component];
        let is_along = component != axis || speed == 0.0;
        InvalidValue::require(is_along, "sliding", speed, "a velocity along the wall")?;
        InvalidValue::require(speed.is_finite(), "sliding", speed, "a finite velocity")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;
    use nalgebra::vector;

    #[test]
    fn faces_must_fit_together() {
        let wall = Face::Wall(Wall::<Plane>::specular());
        let half = Walls::new(&[[Face::Periodic, wall]]);
        assert_eq!(half, Err(WallError::HalfPeriodic { axis: 0 }));
        let walls = Walls::new(&[[Face::Periodic; 2], [wall, Face::Open]]).expect("fit");
        assert!(walls.is_open() && !walls.is_periodic());
        let domain = walls.domain(vector![2.0, 3.0]).expect("positive");
        assert_eq!(domain.wrap(vector![-0.5, -0.5]), vector![1.5, -0.5]);
        assert_eq!(
            domain.displacement(vector![0.1, 0.1], vector![1.9, 2.9]),
            vector![0.1 - 1.9 + 2.0, 0.1 - 2.9]
        );
        let mut sliding = Wall::<Plane>::specular();
        sliding.sliding = vector![1.0, 0.5];
        let refused = Walls::new(&[[Face::Wall(sliding); 2]]).expect_err("moves away");
        assert!(refused.to_string().contains("sliding is 1"), "{refused}");
        let hot = Wall::still(Rebound::Diffuse {
            temperature: f64::NAN,
        });
        assert!(Walls::<Plane>::new(&[[Face::Wall(hot); 2]]).is_err());
    }
}
