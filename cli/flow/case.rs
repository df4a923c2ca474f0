//! The case of a flow, as it is written.

use std::path::Path;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::case::typed::{self, refuse};
use crate::case::{Form, KeyPath, Kind, Problem, Schema};

/// A flow between walls: grains that may spin, gravity, inflow and obstacles, by either engine or both.
///
/// Lengths, masses and times are in any consistent units; temperatures are energies.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// The format of this file.
    #[schemars(extend("const" = 1, "x-allowed" = "the format of this version is 1"))]
    pub format: u64,
    /// The kind of case.
    #[schemars(extend("const" = "flow", "x-allowed" = "the kind of this case is \"flow\""))]
    pub kind: String,
    /// What the case shows, in one line.
    #[schemars(extend("minLength" = 1, "x-allowed" = "a title has at least one letter"))]
    pub title: String,
    /// Seed of every random stream.
    #[serde(default = "one")]
    #[schemars(extend("minimum" = 0, "x-allowed" = "a seed is a whole number from 0 to 9223372036854775807"))]
    pub seed: u64,
    /// Number of independent runs.
    #[serde(default = "four")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000, "x-allowed" = "a number of replicas is a whole number from 1 to 1000000"))]
    pub replicas: u64,
    /// The species of grains, at least one.
    #[schemars(extend("minItems" = 1, "maxItems" = 100, "x-allowed" = "at least one [[species]] with a number"))]
    pub species: Vec<Species>,
    /// What happens when two grains touch.
    #[serde(default)]
    pub contact: Contact,
    /// The box.
    #[serde(rename = "box")]
    pub domain: Box,
    /// What stands at its faces.
    #[serde(default)]
    pub walls: Faces,
    /// A uniform acceleration.
    pub gravity: Option<Gravity>,
    /// Streams of grains through open faces. Monte Carlo only.
    #[serde(default)]
    pub inflow: Vec<Inflow>,
    /// Bodies inside the box, in the plane.
    #[serde(default)]
    pub obstacle: Vec<Obstacle>,
    /// The initial state that all engines share.
    #[serde(default)]
    pub start: Start,
    /// How long to run and how often to look.
    pub run: Run,
    /// The fields.
    #[serde(default)]
    pub fields: Fields,
    /// The engines to run; at least one.
    #[schemars(extend("x-allowed" = "at least one engine: [engine.ed] or [engine.dsmc]"))]
    pub engine: Engines,
    /// How results are judged.
    #[serde(default)]
    pub verdict: Judge,
    /// Parameter sweeps. Each block maps dotted keys to lists of values and stands for their product.
    #[serde(default, skip_serializing)]
    #[schemars(
        with = "Vec<std::collections::BTreeMap<String, Vec<serde_json::Value>>>",
        extend("x-allowed" = "each [[sweep]] block holds quoted dotted keys, such as \"contact.restitution\" = [0.9, 1], each with a list of at least one value")
    )]
    pub sweep: Vec<std::collections::BTreeMap<String, Vec<toml::Value>>>,
}

fn one() -> u64 {
    1
}

fn four() -> u64 {
    4
}

/// Grains of one kind.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Species {
    /// A name for tables and plots. Default: its number.
    #[schemars(extend("minLength" = 1, "x-allowed" = "a name has at least one letter"))]
    pub name: Option<String>,
    /// Number of grains in the box at the start, or, with `start.empty`, in a box that the inflow has filled.
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000, "x-allowed" = "a number of grains is a whole number from 1 to 1000000000"))]
    pub number: u64,
    /// Diameter; with `start.mean_free_path`, in any unit. Default 1.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a diameter lies above 0"))]
    pub diameter: f64,
    /// Mass of a grain. Default 1.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mass lies above 0"))]
    pub mass: f64,
}

fn unit() -> f64 {
    1.0
}

/// What happens when two grains touch.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Normal restitution: 1 is elastic.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "x-allowed" = "a restitution is a number from 0 to 1"))]
    pub restitution: f64,
    /// Tangential restitution, from -1 (smooth) to 1 (perfectly rough). Without it grains are smooth and do not spin.
    #[schemars(extend("minimum" = -1.0, "maximum" = 1.0, "x-allowed" = "a tangential restitution is a number from -1 (smooth) to 1 (perfectly rough); left out, grains do not spin"))]
    pub tangential_restitution: Option<f64>,
    /// Moment of inertia over mass times squared radius. Default: 1/2 for disks, 2/5 for spheres.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0, "x-allowed" = "a moment of inertia over m R^2 lies above 0 and at most at 1, and is given only with contact.tangential_restitution"))]
    pub inertia: Option<f64>,
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            restitution: 1.0,
            tangential_restitution: None,
            inertia: None,
        }
    }
}

/// The box.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Box {
    /// Its sides: two for disks, three for spheres.
    #[schemars(extend(
        "minItems" = 2, "maxItems" = 3,
        "items" = serde_json::json!({"type": "number", "exclusiveMinimum": 0.0}),
        "x-allowed" = "the size of the box is a list of two sides (disks) or three (spheres), each above 0"
    ))]
    pub size: Vec<f64>,
}

/// What stands at the six faces: a word, or a table that describes a wall.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Faces {
    /// Lower face of the first axis.
    #[schemars(extend("x-allowed" = "a face is \"periodic\", \"specular\", \"open\", or a table with restitution and slip, or with temperature"))]
    pub left: Face,
    /// Upper face of the first axis.
    #[schemars(extend("x-allowed" = "a face is \"periodic\", \"specular\", \"open\", or a table with restitution and slip, or with temperature"))]
    pub right: Face,
    /// Lower face of the second axis.
    #[schemars(extend("x-allowed" = "a face is \"periodic\", \"specular\", \"open\", or a table with restitution and slip, or with temperature"))]
    pub bottom: Face,
    /// Upper face of the second axis.
    #[schemars(extend("x-allowed" = "a face is \"periodic\", \"specular\", \"open\", or a table with restitution and slip, or with temperature"))]
    pub top: Face,
    /// Lower face of the third axis.
    #[schemars(extend("x-allowed" = "a face is \"periodic\", \"specular\", \"open\", or a table with restitution and slip, or with temperature"))]
    pub back: Face,
    /// Upper face of the third axis.
    #[schemars(extend("x-allowed" = "a face is \"periodic\", \"specular\", \"open\", or a table with restitution and slip, or with temperature"))]
    pub front: Face,
}

/// Names of the faces, lower and upper, by axis.
pub const FACES: [[&str; 2]; 3] = [["left", "right"], ["bottom", "top"], ["back", "front"]];

impl Faces {
    /// The face at an axis and side.
    pub fn at(&self, axis: usize, side: usize) -> &Face {
        match (axis, side) {
            (0, 0) => &self.left,
            (0, _) => &self.right,
            (1, 0) => &self.bottom,
            (1, _) => &self.top,
            (_, 0) => &self.back,
            _ => &self.front,
        }
    }
}

/// One face.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Face {
    /// A word.
    Word(FaceWord),
    /// A wall.
    Wall(Wall),
}

impl Default for Face {
    fn default() -> Self {
        Self::Word(FaceWord::Periodic)
    }
}

/// A face in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FaceWord {
    /// What leaves here enters on the opposite side.
    Periodic,
    /// A wall that reverses the normal velocity and nothing else.
    Specular,
    /// What leaves is gone. Monte Carlo only.
    Open,
}

/// A wall.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Normal restitution.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "x-allowed" = "the restitution of a wall is a number from 0 to 1; it or temperature is given"))]
    pub restitution: Option<f64>,
    /// What is left of the tangential velocity of the contact: 1 is no friction, -1 is perfectly rough. Default 1.
    #[schemars(extend("minimum" = -1.0, "maximum" = 1.0, "x-allowed" = "the slip of a wall is a number from -1 to 1, and is given only with restitution"))]
    pub slip: Option<f64>,
    /// Temperature of a wall that forgets how grains came.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the temperature of a wall is an energy of at least 0, and is given instead of restitution"))]
    pub temperature: Option<f64>,
    /// Velocity at which the wall slides along itself.
    #[schemars(extend(
        "minItems" = 2, "maxItems" = 3,
        "x-allowed" = "the sliding of a wall is a velocity with as many components as the box has sides, zero across the wall"
    ))]
    pub sliding: Option<Vec<f64>>,
    /// How the wall moves to and fro.
    pub vibration: Option<Vibration>,
}

/// A wall that goes into the gas and back at constant speed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vibration {
    /// How far it goes.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "an amplitude lies above 0 and below half the box"))]
    pub amplitude: f64,
    /// Time of one way there and back.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a period lies above 0"))]
    pub period: f64,
}

/// A uniform acceleration.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Its components.
    #[schemars(extend(
        "minItems" = 2, "maxItems" = 3,
        "x-allowed" = "an acceleration has as many components as the box has sides"
    ))]
    pub acceleration: Vec<f64>,
}

/// A stream of grains through an open face: the flux of a drifting Maxwellian.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inflow {
    /// The face.
    #[schemars(extend("x-allowed" = "the face of an inflow is \"left\", \"right\", \"bottom\", \"top\", \"back\" or \"front\", and is open"))]
    pub face: FaceName,
    /// Grains per volume (area in the plane) outside, by species. Default: those of the uniform box.
    #[schemars(extend(
        "minItems" = 1,
        "items" = serde_json::json!({"type": "number", "minimum": 0.0}),
        "x-allowed" = "the number densities of an inflow are one for each species, at least 0"
    ))]
    pub number_density: Option<Vec<f64>>,
    /// Mean velocity outside.
    #[schemars(extend(
        "minItems" = 2, "maxItems" = 3,
        "x-allowed" = "the velocity of an inflow has as many components as the box has sides"
    ))]
    pub velocity: Vec<f64>,
    /// Temperature outside. Default: `start.temperature`.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the temperature of an inflow is an energy of at least 0"))]
    pub temperature: Option<f64>,
    /// Temperature of rotation outside. Default: that of translation.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the spin temperature of an inflow is an energy of at least 0, and is given only with contact.tangential_restitution"))]
    pub spin_temperature: Option<f64>,
}

/// A face by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum FaceName {
    Left,
    Right,
    Bottom,
    Top,
    Back,
    Front,
}

impl FaceName {
    /// Axis and side.
    pub fn place(self) -> (usize, usize) {
        match self {
            Self::Left => (0, 0),
            Self::Right => (0, 1),
            Self::Bottom => (1, 0),
            Self::Top => (1, 1),
            Self::Back => (2, 0),
            Self::Front => (2, 1),
        }
    }
}

/// A body inside the box: one of four shapes, and its surface.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// A disc.
    pub disc: Option<Disc>,
    /// A thin wall of straight pieces: two points or more.
    #[schemars(extend("minItems" = 2, "x-allowed" = "a polyline is a list of at least two points [x, y] inside the box"))]
    pub polyline: Option<Vec<[f64; 2]>>,
    /// A filled polygon: three points or more.
    #[schemars(extend("minItems" = 3, "x-allowed" = "a polygon is a list of at least three points [x, y] inside the box"))]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// Normal restitution of its surface. Default 1, unless it has a temperature.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "x-allowed" = "the restitution of an obstacle is a number from 0 to 1"))]
    pub restitution: Option<f64>,
    /// What is left of the tangential velocity of the contact. Default 1.
    #[schemars(extend("minimum" = -1.0, "maximum" = 1.0, "x-allowed" = "the slip of an obstacle is a number from -1 to 1"))]
    pub slip: Option<f64>,
    /// Temperature of a surface that forgets how grains came.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the temperature of an obstacle is an energy of at least 0, and is given instead of restitution and slip"))]
    pub temperature: Option<f64>,
}

/// A disc.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Its centre.
    #[schemars(extend("x-allowed" = "the centre of a disc is a point [x, y] inside the box"))]
    pub centre: [f64; 2],
    /// Its radius.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the radius of a disc lies above 0"))]
    pub radius: f64,
}

/// The initial state.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Start {
    /// Temperature, m <v^2>/D.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a temperature is an energy above 0"))]
    pub temperature: f64,
    /// Temperature of rotation. Default: that of translation.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a spin temperature is an energy of at least 0, and is given only with contact.tangential_restitution"))]
    pub spin_temperature: Option<f64>,
    /// Mean free path in the uniform box: all diameters are scaled so that it is this. For a dilute gas in Monte Carlo.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mean free path lies above 0, and is given only where [engine.dsmc] alone runs with the scheme \"boltzmann\""))]
    pub mean_free_path: Option<f64>,
    /// Mean velocity. Default: at rest.
    #[schemars(extend(
        "minItems" = 2, "maxItems" = 3,
        "x-allowed" = "the velocity of the start has as many components as the box has sides"
    ))]
    pub velocity: Option<Vec<f64>>,
    /// Begin with an empty box, which the inflow fills.
    #[schemars(extend("x-allowed" = "start.empty is true or false; an empty box needs an [[inflow]]"))]
    pub empty: bool,
}

impl Default for Start {
    fn default() -> Self {
        Self {
            temperature: 1.0,
            spin_temperature: None,
            mean_free_path: None,
            velocity: None,
            empty: false,
        }
    }
}

/// How long to run and how often to look.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// End of the run \[time\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the end of the run lies above 0"))]
    pub until: f64,
    /// Samples, at equal intervals.
    #[serde(default = "four_hundred")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000, "x-allowed" = "a number of samples is a whole number from 1 to 1000000, and a multiple of run.blocks"))]
    pub samples: u64,
    /// Blocks of time that fields are kept for, and that their standard errors come from.
    #[serde(default = "forty")]
    #[schemars(extend("minimum" = 1, "maximum" = 10_000, "x-allowed" = "a number of blocks is a whole number from 1 to 10000"))]
    pub blocks: u64,
    /// Seconds of computing between two checkpoints.
    #[serde(default = "thirty")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the seconds between checkpoints lie above 0"))]
    pub checkpoint_seconds: f64,
}

fn four_hundred() -> u64 {
    400
}

fn forty() -> u64 {
    40
}

fn thirty() -> f64 {
    30.0
}

/// The fields.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fields {
    /// Cells along the first two axes.
    #[schemars(extend(
        "items" = serde_json::json!({"type": "integer", "minimum": 1, "maximum": 1000}),
        "x-allowed" = "the cells of the fields are two whole numbers from 1 to 1000"
    ))]
    pub cells: [u64; 2],
    /// Windows of time to be shown besides the steady state; moved to the ends of blocks.
    #[schemars(extend("x-allowed" = "the windows of the fields are a list of [start, end] with 0 <= start < end <= run.until"))]
    pub windows: Vec<[f64; 2]>,
}

impl Default for Fields {
    fn default() -> Self {
        Self {
            cells: [20, 20],
            windows: Vec::new(),
        }
    }
}

/// The engines.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Engines {
    /// Exact event-driven disks.
    pub ed: Option<Exact>,
    /// Monte Carlo collisions in cells.
    pub dsmc: Option<MonteCarlo>,
}

/// Exact event-driven disks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Exact {
    /// Contact time of the TC model: a disk that touches a disk or a wall again sooner does so elastically. 0 is off.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a contact time is at least 0"))]
    pub contact_time: f64,
}

/// Monte Carlo collisions in cells.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MonteCarlo {
    /// Which pairs collide, and how often.
    #[schemars(extend("x-allowed" = "a scheme is \"boltzmann\", \"free-volume\", \"enskog\" or \"contact-point\""))]
    pub scheme: Scheme,
    /// Side of a cell. Default: half the mean free path of the uniform box, and at least such that a cell holds ten
    /// simulators, but no less than two diameters for dense schemes; "contact-point" chooses for itself.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the side of a cell lies above 0"))]
    pub cell_size: Option<f64>,
    /// Simulators for each grain.
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000, "x-allowed" = "a number of simulators for each grain is a whole number from 1 to 1000000"))]
    pub simulators_per_grain: u64,
    /// Steps in which the fastest grain crosses a cell, and in a mean free time.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1000.0, "x-allowed" = "a number of steps lies above 0 and at most at 1000"))]
    pub steps_per_crossing: f64,
    /// Where walls act on a grain. Default: on its centre for the scheme "boltzmann", otherwise at its radius.
    #[schemars(extend("x-allowed" = "walls act on the \"centre\" or at the \"radius\" of a grain"))]
    pub walls_act_on: Option<WallsActOn>,
    /// Weights of simulators by region: more simulators where grains are few.
    pub weights: Option<Weights>,
}

impl Default for MonteCarlo {
    fn default() -> Self {
        Self {
            scheme: Scheme::Boltzmann,
            cell_size: None,
            simulators_per_grain: 1,
            steps_per_crossing: 4.0,
            walls_act_on: None,
            weights: None,
        }
    }
}

/// Which pairs collide, and how often.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// The dilute gas of points.
    #[default]
    Boltzmann,
    /// The rate of the free volume in the cell; the pressure is that of points.
    FreeVolume,
    /// Enskog's rate at the packing around; the pressure is that of points.
    Enskog,
    /// Enskog's rate with partners around the point of contact, and his pressure: the one to compare with exact disks.
    ContactPoint,
}

impl Scheme {
    /// Whether collisions carry momentum over the distance of the partners.
    pub fn carries(self) -> bool {
        self == Self::ContactPoint
    }
}

/// Where walls act on a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallsActOn {
    /// On its centre.
    Centre,
    /// At its radius.
    Radius,
}

/// Weights of simulators by region: stripes of equal width.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// The axis across the stripes: "x" or "y".
    #[schemars(extend("x-allowed" = "stripes of weights lie along \"x\" or \"y\""))]
    pub along: Along,
    /// Weight in each stripe, over that of the start.
    #[schemars(extend(
        "minItems" = 1, "maxItems" = 1000,
        "items" = serde_json::json!({"type": "number", "minimum": 1e-3, "maximum": 1e3}),
        "x-allowed" = "weights are a list of numbers from 0.001 to 1000"
    ))]
    pub factors: Vec<f64>,
}

/// An axis of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Along {
    /// The first.
    X,
    /// The second.
    Y,
}

/// How results are judged.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Judge {
    /// Chance of any false alarm in one comparison.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 0.5, "x-allowed" = "a chance of a false alarm lies above 0 and below 0.5"))]
    pub false_alarm: f64,
}

impl Default for Judge {
    fn default() -> Self {
        Self { false_alarm: 0.01 }
    }
}

impl Form for Flow {
    const KIND: Kind = Kind::Flow;

    fn schema() -> &'static Schema {
        static SCHEMA: OnceLock<Schema> = OnceLock::new();
        SCHEMA.get_or_init(Schema::of::<Self>)
    }

    fn from_table(table: &Table, _folder: &Path) -> Result<Self, Problem> {
        let flow: Self = typed::read(Self::schema(), table)?;
        Relations { table, flow: &flow }.check()?;
        Ok(flow)
    }
}

impl Flow {
    /// Number of axes of the box.
    pub fn dimension(&self) -> usize {
        self.domain.size.len()
    }

    /// Whether grains spin.
    pub fn is_rough(&self) -> bool {
        self.contact.tangential_restitution.is_some()
    }

    /// Number of grains.
    pub fn grains(&self) -> u64 {
        self.species.iter().map(|species| species.number).sum()
    }
}

/// Relations between keys.
struct Relations<'a> {
    table: &'a Table,
    flow: &'a Flow,
}

impl Relations<'_> {
    fn refuse(&self, key: KeyPath, allowed: impl Into<String>) -> Result<(), Problem> {
        Err(refuse(self.table, key, allowed))
    }

    /// Refuses a key with the sentence of the schema.
    fn refuse_with_sentence(&self, key: KeyPath, dotted: &str) -> Result<(), Problem> {
        self.refuse(key, Flow::schema().sentence(dotted))
    }

    fn check(&self) -> Result<(), Problem> {
        self.sizes()?;
        self.spins()?;
        self.vectors()?;
        self.faces()?;
        self.engines()?;
        self.times()
    }

    fn sizes(&self) -> Result<(), Problem> {
        let Engines { ed, dsmc } = &self.flow.engine;
        let dilute = (dsmc.as_ref()).is_some_and(|dsmc| dsmc.scheme == Scheme::Boltzmann);
        if self.flow.start.mean_free_path.is_some() && (ed.is_some() || !dilute) {
            let key = "start.mean_free_path";
            return self.refuse_with_sentence(KeyPath::of(key), key);
        }
        Ok(())
    }

    fn spins(&self) -> Result<(), Problem> {
        let flow = self.flow;
        if flow.is_rough() {
            return Ok(());
        }
        if flow.contact.inertia.is_some() {
            return self.refuse_with_sentence(KeyPath::of("contact.inertia"), "contact.inertia");
        }
        if flow.start.spin_temperature.is_some() {
            let key = "start.spin_temperature";
            return self.refuse_with_sentence(KeyPath::of(key), key);
        }
        for (index, inflow) in flow.inflow.iter().enumerate() {
            if inflow.spin_temperature.is_some() {
                let key = KeyPath::of("inflow").element(index);
                return self
                    .refuse_with_sentence(key.key("spin_temperature"), "inflow.spin_temperature");
            }
        }
        Ok(())
    }

    fn vectors(&self) -> Result<(), Problem> {
        let flow = self.flow;
        let mut vectors = Vec::new();
        if let Some(gravity) = &flow.gravity {
            let key = "gravity.acceleration";
            vectors.push((KeyPath::of(key), key, &gravity.acceleration));
        }
        if let Some(velocity) = &flow.start.velocity {
            vectors.push((KeyPath::of("start.velocity"), "start.velocity", velocity));
        }
        for (index, inflow) in flow.inflow.iter().enumerate() {
            let key = KeyPath::of("inflow").element(index).key("velocity");
            vectors.push((key, "inflow.velocity", &inflow.velocity));
        }
        for (axis, names) in FACES.iter().enumerate() {
            for (side, name) in names.iter().enumerate() {
                if let Face::Wall(Wall {
                    sliding: Some(sliding),
                    ..
                }) = flow.walls.at(axis, side)
                {
                    let key = KeyPath::of("walls").key(name).key("sliding");
                    if sliding.get(axis).is_some_and(|&across| across != 0.0) {
                        return self.refuse_with_sentence(key, "walls.left.sliding");
                    }
                    vectors.push((key, "walls.left.sliding", sliding));
                }
            }
        }
        for (key, dotted, vector) in vectors {
            if vector.len() != flow.dimension() {
                return self.refuse_with_sentence(key, dotted);
            }
        }
        for (index, inflow) in flow.inflow.iter().enumerate() {
            let densities = inflow.number_density.as_ref();
            if densities.is_some_and(|list| list.len() != flow.species.len()) {
                let key = KeyPath::of("inflow").element(index);
                let key = key.key("number_density");
                return self.refuse_with_sentence(key, "inflow.number_density");
            }
        }
        Ok(())
    }

    fn faces(&self) -> Result<(), Problem> {
        let flow = self.flow;
        for (axis, names) in FACES.iter().enumerate() {
            let faces = [0, 1].map(|side| flow.walls.at(axis, side));
            let periodic = faces.map(|face| *face == Face::default());
            let key = |side: usize| KeyPath::of("walls").key(names[side]);
            if axis >= flow.dimension() && !(periodic[0] && periodic[1]) {
                let side = usize::from(periodic[0]);
                return self.refuse(
                    key(side),
                    "a box of two sides has no face along the third axis",
                );
            }
            if periodic[0] != periodic[1] {
                let side = usize::from(periodic[0]);
                return self.refuse(key(side), "opposite faces are both periodic, or neither is");
            }
            for (side, face) in faces.iter().enumerate() {
                if let Face::Wall(wall) = face {
                    self.wall(wall, &key(side), flow.domain.size[axis])?;
                }
            }
        }
        for (index, inflow) in flow.inflow.iter().enumerate() {
            let (axis, side) = inflow.face.place();
            let open = Face::Word(FaceWord::Open);
            if axis >= flow.dimension() || *flow.walls.at(axis, side) != open {
                let key = KeyPath::of("inflow").element(index).key("face");
                return self.refuse_with_sentence(key, "inflow.face");
            }
        }
        if flow.start.empty && flow.inflow.is_empty() {
            return self.refuse_with_sentence(KeyPath::of("start.empty"), "start.empty");
        }
        for (index, obstacle) in flow.obstacle.iter().enumerate() {
            let key = KeyPath::of("obstacle").element(index);
            let shapes = [
                obstacle.disc.is_some(),
                obstacle.polyline.is_some(),
                obstacle.polygon.is_some(),
            ];
            if shapes.iter().filter(|&&given| given).count() != 1 {
                let allowed = "an obstacle has exactly one of disc, polyline and polygon";
                return self.refuse(key, allowed);
            }
            if flow.dimension() != 2 {
                return self.refuse(key, "obstacles stand in boxes of two sides only");
            }
            if obstacle.temperature.is_some()
                && (obstacle.restitution.is_some() || obstacle.slip.is_some())
            {
                return self.refuse_with_sentence(key.key("temperature"), "obstacle.temperature");
            }
        }
        Ok(())
    }

    fn wall(&self, wall: &Wall, key: &KeyPath, side: f64) -> Result<(), Problem> {
        match (wall.restitution, wall.temperature) {
            (None, None) => {
                return self.refuse_with_sentence(key.key("restitution"), "walls.left.restitution");
            }
            (Some(_), Some(_)) => {
                return self.refuse_with_sentence(key.key("temperature"), "walls.left.temperature");
            }
            (None, Some(_)) if wall.slip.is_some() => {
                return self.refuse_with_sentence(key.key("slip"), "walls.left.slip");
            }
            _ => {}
        }
        if wall
            .vibration
            .is_some_and(|vibration| vibration.amplitude >= 0.5 * side)
        {
            let key = key.key("vibration").key("amplitude");
            return self.refuse(key, "an amplitude lies above 0 and below half the box");
        }
        Ok(())
    }

    fn engines(&self) -> Result<(), Problem> {
        let flow = self.flow;
        let Engines { ed, dsmc } = &flow.engine;
        if ed.is_none() && dsmc.is_none() {
            return self.refuse_with_sentence(KeyPath::of("engine"), "engine");
        }
        if let Some(dsmc) = dsmc.as_ref()
            && dsmc.scheme == Scheme::ContactPoint
            && (dsmc.weights.is_some() || !flow.obstacle.is_empty())
        {
            return self.refuse(
                KeyPath::of("engine.dsmc.scheme"),
                "obstacles and weights go with the schemes \"boltzmann\", \"free-volume\" and \"enskog\"",
            );
        }
        if ed.is_some() {
            if flow.dimension() != 2 {
                return self.refuse(
                    KeyPath::of("engine.ed"),
                    "exact dynamics is of disks: a box of two sides",
                );
            }
            for (axis, names) in FACES.iter().enumerate() {
                for (side, name) in names.iter().enumerate() {
                    if *flow.walls.at(axis, side) == Face::Word(FaceWord::Open) {
                        return self.refuse(
                            KeyPath::of("walls").key(name),
                            "exact dynamics keeps its disks: no open face beside [engine.ed]",
                        );
                    }
                }
            }
        }
        Ok(())
    }

    fn times(&self) -> Result<(), Problem> {
        let run = &self.flow.run;
        if !run.samples.is_multiple_of(run.blocks) {
            return self.refuse_with_sentence(KeyPath::of("run.samples"), "run.samples");
        }
        for (index, [start, end]) in self.flow.fields.windows.iter().enumerate() {
            if !(0.0 <= *start && start < end && *end <= run.until) {
                let key = KeyPath::of("fields.windows").element(index);
                return self.refuse_with_sentence(key, "fields.windows");
            }
        }
        Ok(())
    }
}
