//! The case format, version 2: the keys, their types, their ranges and their defaults.
//!
//! The doc comments are the descriptions of the JSON Schema. Lengths, masses and energies are in the units of the case;
//! times are in the unit that `run.time_unit` names. What defaults and checks follow from is asked of a case by methods such as
//! [`Case::has_box`] and [`Case::is_uniform`].

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

mod domain;
mod engines;
mod gas;
mod nature;
mod question;
mod restitution;
mod thermostat;

pub use domain::*;
pub use engines::*;
pub use gas::*;
pub use question::*;
pub use restitution::*;
pub use thermostat::*;

/// Case: a gas, a box, forces, engines, and what is measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Version of the case format. This program reads version 2.
    pub format: u64,
    /// Title in one line. Default: made of the gas as it is run. Where `--set` or a sweep changes
    /// the gas, that is added.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    #[schemars(length(min = 1))]
    pub title: String,
    /// Question that the case answers, and the number that answers it.
    #[serde(default, skip_serializing_if = "QuestionSpec::is_default")]
    pub question: QuestionSpec,
    /// Units of lengths, masses and energies.
    #[serde(default)]
    pub units: UnitsSpec,
    /// Seed of every random stream.
    #[schemars(extend("maximum" = i64::MAX))]
    #[serde(default = "one")]
    pub seed: u64,
    /// Number of independent runs, each with its own initial state; error bars come from their
    /// spread.
    #[serde(default = "four")]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub replicas: u64,
    /// The gas: its dimension, its particles, their contacts.
    pub gas: GasSpec,
    /// Several species, in place of `gas.number`, `gas.diameter` and `gas.mass`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 1000))]
    pub species: Vec<SpeciesSpec>,
    /// Very many species by a power law, in gases without positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_law: Option<PowerLaw>,
    /// Every particle with its own size, in gases without positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polydisperse: Option<PolydisperseSpec>,
    /// Restitution of single pairs of species, in place of `gas.restitution`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pair: Vec<PairSpec>,
    /// The box. Without it the gas has no positions: it is homogeneous by construction.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub domain: Option<BoxSpec>,
    /// Faces of the box.
    #[serde(default, skip_serializing_if = "FacesSpec::is_periodic")]
    pub walls: FacesSpec,
    /// Bodies inside the box, in the plane.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacle: Vec<ObstacleSpec>,
    /// Streams through open faces. Monte Carlo only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inflow: Vec<InflowSpec>,
    /// A uniform acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<GravitySpec>,
    /// Thermostat: scaling of all velocities to the energy of the start, or a bath of random kicks, with drag or without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thermostat: Option<ThermostatSpec>,
    /// Particles that stick together and break, in gases without positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aggregation: Option<AggregationSpec>,
    /// The initial state that all engines share.
    #[serde(default)]
    pub start: StartSpec,
    /// The engines to run. A table that is present is run. Without a box the engine is `dsmc-homogeneous`.
    #[serde(default)]
    pub engine: EnginesSpec,
    /// End of the run and sample times.
    pub run: RunSpec,
    /// Measurements besides the energy: a table for each, by its name.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub measure: BTreeMap<String, toml::Table>,
    /// Rules of the verdicts on results.
    #[serde(default)]
    pub verdict: VerdictSpec,
    /// Largest error of the Monte Carlo engines; their simulators and time steps are then chosen by the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySpec>,
    /// Parameter sweeps: each block maps quoted dotted keys, such as "gas.restitution", to values
    /// and stands for their product.
    #[serde(default, skip_serializing)]
    pub sweep: Vec<BTreeMap<String, SweepAxis>>,
}

fn one() -> u64 {
    1
}

fn four() -> u64 {
    4
}

fn unit() -> f64 {
    1.0
}

/// Values of one swept key: a list, or a range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SweepAxis {
    /// List of single values of a swept key.
    List(
        #[schemars(with = "Vec<serde_json::Value>", length(min = 1, max = 10_000))]
        Vec<toml::Value>,
    ),
    /// Range of values of a swept key, in equal steps or equal factors.
    Range(SweepRange),
}

/// Range of values of a swept key in equal steps or equal factors, with 12 digits each; whole
/// numbers where the key asks for them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepRange {
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// Number of values, in place of a step.
    #[schemars(range(min = 2, max = 10_000))]
    pub points: Option<u64>,
    /// Difference between two values, or with `log` their quotient, in place of a number of values.
    /// The last value is the last step that does not go beyond `to`.
    pub step: Option<f64>,
    /// True for equal factors in place of equal steps; both ends are then above 0.
    #[serde(default)]
    pub log: bool,
}

/// Units of lengths, masses and energies in a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UnitsSpec {
    /// Reduced units: any consistent ones; diameter, mass and temperature default to 1.
    #[default]
    Reduced,
    /// SI units: metres, kilograms, seconds, joules; diameter, mass and temperature must be given.
    Si,
}

/// File name endings of start files, which decide their format.
pub const START_FILE_ENDINGS: [&str; 9] = [
    ".csv",
    ".xyz",
    ".extxyz",
    ".dump",
    ".lammpstrj",
    ".data",
    ".lmp",
    ".gsd",
    ".sph",
];

/// Initial state of the gas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StartSpec {
    /// Placement of the particles.
    pub placement: PlacementSpec,
    /// File with positions or velocities: CSV (`.csv`), extended XYZ (`.xyz`, `.extxyz`), a dump of
    /// LAMMPS (`.dump`, `.lammpstrj`) or a data file of it (`.data`, `.lmp`), GSD (`.gsd`) or a file
    /// of EDMD (`.sph`), relative to the case file; with placement or velocities = "file".
    #[schemars(length(min = 1))]
    pub file: Option<String>,
    /// Corners `[[x0, y0], [x1, y1]]` of the region in which the particles lie, of three numbers in
    /// space. Default: the whole box.
    #[schemars(extend("items" = json!({"type": "array", "minItems": 2, "maxItems": 3, "items": {"type": "number"}})))]
    pub region: Option<[Vec<f64>; 2]>,
    /// Source of the initial velocities.
    pub velocities: VelocitiesSpec,
    /// Elastic collisions per particle before t = 0; 0 means none. Default: 10 for smooth disks in a periodic box without gravity,
    /// and `10 sqrt(phi) chi` up to 100 at packings above 0.3; 0 in other gases and where a file or a region gives the places.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub equilibration: Option<f64>,
    /// Give up equilibrating here. Default: four times `equilibration`, and at least 200.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub longest_equilibration: Option<f64>,
    /// Mean velocity. Default: at rest.
    #[schemars(extend("minItems" = 2, "maxItems" = 3))]
    pub velocity: Option<Vec<f64>>,
    /// Temperature of rotation. Default: that of translation.
    #[schemars(range(min = 0.0))]
    pub spin_temperature: Option<f64>,
    /// Begin with an empty box, which the inflow fills.
    pub empty: bool,
}

impl Default for StartSpec {
    fn default() -> Self {
        Self {
            placement: PlacementSpec::Disordered,
            file: None,
            region: None,
            velocities: VelocitiesSpec::MAXWELLIAN,
            equilibration: None,
            longest_equilibration: None,
            velocity: None,
            spin_temperature: None,
            empty: false,
        }
    }
}

/// Placement of the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlacementSpec {
    /// Random places of the particles, without overlap.
    Disordered,
    /// Particles on the sites of a square lattice.
    Square,
    /// Particles on the sites of a hexagonal lattice.
    Hexagonal,
    /// Places of the particles from `start.file`.
    File,
}

/// Source of the initial velocities: a word, or a distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum VelocitiesSpec {
    /// Source of the initial velocities in a word.
    Word(VelocityWord),
    /// Initial velocities drawn from a distribution with a given fourth cumulant.
    Drawn(VelocityCumulant),
}

impl VelocitiesSpec {
    /// Initial velocities drawn from a Maxwell distribution.
    pub const MAXWELLIAN: Self = Self::Word(VelocityWord::Maxwellian);
    /// Initial velocities read from the start file.
    pub const FILE: Self = Self::Word(VelocityWord::File);
}

/// Word for the source of the initial velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityWord {
    /// Initial velocities drawn from a Maxwell distribution.
    Maxwellian,
    /// Initial velocities from `start.file`. With another placement than "file" each replica deals
    /// them to its particles anew, within species.
    File,
}

/// Distribution of isotropic velocities whose squares are Gamma-distributed, with a given fourth
/// cumulant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityCumulant {
    /// Fourth cumulant `D/(D + 2) <v^4>/<v^2>^2 - 1`: from -1/2 of disks and -2/5 of spheres, all
    /// of one speed, to 10; 0 is Maxwellian.
    #[schemars(range(min = -0.5, max = 10.0))]
    pub a2: f64,
}

/// End of the run and sample times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunSpec {
    /// Unit of all times in this file. Default: "haff" for smooth particles in a periodic box without gravity (the mean free time of a gas
    /// that does not cool or is sheared), else "case".
    pub time_unit: Option<TimeUnit>,
    /// Time at which the run ends, in the unit `time_unit`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e15))]
    pub until: f64,
    /// First sample after t = 0, with samples in equal factors of time. Default: `until/1000`; not
    /// with `samples`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub first_sample: Option<f64>,
    /// Samples in each factor of ten of time. Default: 12.
    #[schemars(range(min = 1, max = 1000))]
    pub samples_per_decade: Option<u64>,
    /// Number of samples at equal intervals. Default with walls, openings, obstacles or gravity: 400; in a uniform gas samples are in
    /// equal factors of time.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub samples: Option<u64>,
    /// Seconds of computing between two checkpoints.
    #[serde(default = "thirty")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub checkpoint_seconds: f64,
}

fn thirty() -> f64 {
    30.0
}

/// Unit of the times in a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeUnit {
    /// Unit of time that follows from the units of length, mass and energy of the case.
    Case,
    /// Haff's cooling time of the start; of an elastic gas, the mean free time.
    Haff,
    /// Mean time between two collisions of a particle at the start.
    MeanFreeTime,
}

/// Threshold beyond which an interval shows a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DifferBeyond {
    /// Zero: any difference counts.
    Zero,
    /// Margin: only a difference larger than the margin counts.
    Margin,
}

/// Rules of the verdicts on results.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VerdictSpec {
    /// Chance that any verdict of a point says `differ` where there is no difference. Over the
    /// points of a sweep it is the rate of false discoveries.
    #[schemars(extend("minimum" = 1e-12, "exclusiveMaximum" = 0.5))]
    pub family_wise_error_rate: f64,
    /// Margin of every comparison: largest relative difference that counts as agreement.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub tolerance: f64,
    /// Margin of numbers that are zero under chaos, in their own unit: the slope of P(b/d), the
    /// fourth cumulant less theory.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub absolute_tolerance: f64,
    /// Difference beyond which the whole interval must lie to be called one.
    pub differ_beyond: DifferBeyond,
    /// Orders of the Sonine expansion of theory: 1 for Maxwellian species. Default: as many as are
    /// quick.
    #[schemars(range(min = 1, max = 12))]
    pub sonine_orders: Option<u64>,
}

impl Default for VerdictSpec {
    fn default() -> Self {
        Self {
            family_wise_error_rate: 0.05,
            tolerance: 0.05,
            absolute_tolerance: 0.02,
            differ_beyond: DifferBeyond::Zero,
            sonine_orders: None,
        }
    }
}

/// Target error of the Monte Carlo engines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccuracySpec {
    /// Largest error of a Monte Carlo engine against Enskog's theory: a share such as "1%".
    #[schemars(length(min = 1))]
    pub target: String,
}

impl AccuracySpec {
    /// Returns the target error as a number; `None` if the text is not a share.
    pub fn parse_share(&self) -> Option<f64> {
        parse_share(&self.target)
    }
}

/// Parses a share such as `1%` or `0.01`, above 0 and below 1.
///
/// ```
/// use stosszahl_case::format::parse_share;
///
/// assert_eq!(["1%", "0.5 %", "0.02"].map(parse_share), [Some(0.01), Some(0.005), Some(0.02)]);
/// assert!(["", "%", "0", "-1%", "100%", "2", "nan", "inf", "one"].iter().all(|bad| parse_share(bad).is_none()));
/// ```
pub fn parse_share(text: &str) -> Option<f64> {
    let text = text.trim();
    let value = match text.strip_suffix('%') {
        Some(percent) => percent.trim_end().parse::<f64>().ok()? / 100.0,
        None => text.parse().ok()?,
    };
    (value > 0.0 && value < 1.0).then_some(value)
}
