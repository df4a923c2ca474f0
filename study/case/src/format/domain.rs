//! Keys of the box, its walls, obstacles and inflows.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Box of the gas, with its sides or its packing fraction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Sides of the box: two for disks, three for spheres. This or `packing_fraction`; neither
    /// where a start file has a box.
    #[schemars(extend("minItems" = 2, "maxItems" = 3, "items" = json!({"type": "number", "exclusiveMinimum": 0.0})))]
    pub size: Option<Vec<f64>>,
    /// Share of its area or volume, without what is under obstacles, that particles cover; up to
    /// 0.9069 for disks.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 0.9069))]
    pub packing_fraction: Option<f64>,
    /// Width over the critical length of shear waves, the shortest that grow while the gas cools
    /// (Enskog theory): below 1 the gas stays uniform. The number of disks follows from it.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_over_critical_length: Option<f64>,
    /// Shear rate a of a uniform flow u = (a y, 0), by Lees-Edwards boundaries: flow along the
    /// first axis, gradient along the second. Velocities of the start, and all that is measured,
    /// are relative to it. In 1/time units of the case; not 0.
    pub shear_rate: Option<f64>,
    /// Height over width of a box that is given by its packing fraction.
    #[serde(default = "super::unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub aspect_ratio: f64,
}

/// Faces of the box, six in all: each a word, or a table that describes a wall. Faces without one
/// are periodic.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FacesSpec {
    /// Lower face of the first axis.
    pub left: FaceSpec,
    /// Upper face of the first axis.
    pub right: FaceSpec,
    /// Lower face of the second axis.
    pub bottom: FaceSpec,
    /// Upper face of the second axis.
    pub top: FaceSpec,
    /// Lower face of the third axis.
    pub back: FaceSpec,
    /// Upper face of the third axis.
    pub front: FaceSpec,
}

/// Names of the six faces of the box: lower and upper, by axis.
pub const FACES: [[&str; 2]; 3] = [["left", "right"], ["bottom", "top"], ["back", "front"]];

impl FacesSpec {
    /// Returns the face of the box at an axis and a side (0 lower, 1 upper).
    pub fn face_at(&self, axis: usize, side: usize) -> &FaceSpec {
        match (axis, side) {
            (0, 0) => &self.left,
            (0, _) => &self.right,
            (1, 0) => &self.bottom,
            (1, _) => &self.top,
            (_, 0) => &self.back,
            _ => &self.front,
        }
    }

    /// Returns all faces of the box; in the plane those of the third axis are periodic.
    pub fn all_faces(&self) -> impl Iterator<Item = &FaceSpec> {
        (0..3).flat_map(|axis| [0, 1].map(|side| self.face_at(axis, side)))
    }

    /// Returns true if all faces of the box are periodic.
    pub fn is_periodic(&self) -> bool {
        *self == Self::default()
    }
}

/// Face of the box: a word, or a wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FaceSpec {
    /// Face of the box given by a word.
    Word(FaceWord),
    /// Face of the box that is a wall with properties.
    Wall(WallSpec),
}

impl FaceSpec {
    /// Returns true if particles bounce off the face of the box.
    pub fn is_wall(&self) -> bool {
        !matches!(self, Self::Word(FaceWord::Periodic | FaceWord::Open))
    }
}

impl Default for FaceSpec {
    fn default() -> Self {
        Self::Word(FaceWord::Periodic)
    }
}

/// Word for a face of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FaceWord {
    /// Periodic face: particles that leave here enter on the opposite side.
    Periodic,
    /// Specular wall: it reverses the normal velocity and nothing else.
    Specular,
    /// Open face: particles that leave are gone. Monte Carlo only.
    Open,
}

/// Wall at a face of the box: `restitution` and `slip`, or `temperature`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallSpec {
    /// Normal restitution.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: Option<f64>,
    /// Share of the tangential velocity of the contact that is left: 1 is no friction, -1 is
    /// perfectly rough. Default 1.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub slip: Option<f64>,
    /// Temperature of a diffuse wall.
    #[schemars(range(min = 0.0))]
    pub temperature: Option<f64>,
    /// Velocity at which the wall slides along itself.
    #[schemars(extend("minItems" = 2, "maxItems" = 3))]
    pub sliding: Option<Vec<f64>>,
    /// Vibration of the wall to and fro.
    pub vibration: Option<VibrationSpec>,
}

/// Vibration of a wall, which goes into the gas and back at constant speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VibrationSpec {
    /// Farthest displacement of the wall into the gas.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub amplitude: f64,
    /// Time of one way there and back.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub period: f64,
}

/// Obstacle inside the box: one of three shapes, and its surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// A disk.
    pub circle: Option<CircleSpec>,
    /// A thin wall of straight pieces: two points or more.
    #[schemars(length(min = 2))]
    pub polyline: Option<Vec<[f64; 2]>>,
    /// A filled polygon: three points or more.
    #[schemars(length(min = 3))]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// Normal restitution of its surface. Default 1, unless it has a temperature.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: Option<f64>,
    /// Share of the tangential velocity of the contact that is left. Default 1.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub slip: Option<f64>,
    /// Temperature of a diffuse surface.
    #[schemars(range(min = 0.0))]
    pub temperature: Option<f64>,
}

/// Circle inside the box, the outline of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CircleSpec {
    /// Centre of the disk.
    pub centre: [f64; 2],
    /// Radius of the disk.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius: f64,
}

/// Inflow through an open face: the flux of a drifting Maxwellian.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InflowSpec {
    /// The face: "left", "right", "bottom", "top", "back" or "front".
    #[schemars(extend("enum" = ["left", "right", "bottom", "top", "back", "front"]))]
    pub face: String,
    /// Particles per volume outside, by species. Default: those of the uniform box.
    #[schemars(extend("minItems" = 1, "items" = json!({"type": "number", "minimum": 0.0})))]
    pub number_density: Option<Vec<f64>>,
    /// Mean velocity outside.
    #[schemars(extend("minItems" = 2, "maxItems" = 3))]
    pub velocity: Vec<f64>,
    /// Temperature outside. Default: that of the gas.
    #[schemars(range(min = 0.0))]
    pub temperature: Option<f64>,
    /// Temperature of rotation outside. Default: that of translation.
    #[schemars(range(min = 0.0))]
    pub spin_temperature: Option<f64>,
}

/// A uniform acceleration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravitySpec {
    /// Components of the acceleration.
    #[schemars(extend("minItems" = 2, "maxItems" = 3))]
    pub acceleration: Vec<f64>,
}
