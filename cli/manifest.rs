//! The manifest of a results folder (`manifest.json`) and the index of a sweep (`sweep.json`).
//!
//! The manifest says what was run, from which start, on which machine, with which work, and what follows from it in
//! words. Writer and reader share these structs. JSON has no NaN: a number that is not finite is written as `null`,
//! which is read back as NaN in the maps `derived` and `work` and refused in a plain number.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

use crate::case::Kind;

/// Version of the manifest format that this program writes and reads.
pub const FORMAT: u32 = 1;
/// Name of the manifest inside a results folder.
pub const MANIFEST_FILE: &str = "manifest.json";
/// Name of the index inside a sweep folder.
pub const SWEEP_FILE: &str = "sweep.json";

/// Contents of `manifest.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format, [`FORMAT`].
    pub format: u32,
    /// Program that wrote the folder.
    pub program: Program,
    /// Title of the run, plain text.
    pub title: String,
    /// The case file, verbatim.
    pub case_text: String,
    /// The case after validation, with every default filled in.
    pub case: serde_json::Value,
    /// Units of the case.
    pub units: Units,
    /// The time that all times are divided by.
    pub t0: ReferenceTime,
    /// Derived quantities by name, such as `mean_free_path`.
    ///
    /// The report looks here for `particles`, `packing_fraction`, `restitution` and `fourth_cumulant_theory`; the
    /// first three are otherwise searched for in `case` under the same names.
    #[serde(deserialize_with = "finite_or_null")]
    pub derived: BTreeMap<String, f64>,
    /// Machine that the run was made on.
    pub machine: Machine,
    /// Seed of all random streams.
    pub seed: u64,
    /// Replicas that were run.
    pub replicas: u64,
    /// Duration of the whole run \[s\].
    pub wall_seconds: f64,
    /// How each replica began.
    pub start: Vec<Start>,
    /// Work of each engine.
    pub engines: Vec<EngineWork>,
    /// Conclusions in words, the most important first.
    pub verdicts: Vec<Verdict>,
    /// Warnings in words.
    pub warnings: Vec<String>,
    /// Snapshots of replica 0.
    pub snapshots: Vec<Snapshot>,
}

/// Name and version of the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Name.
    pub name: String,
    /// Version.
    pub version: String,
}

/// Units of the case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    /// Reduced units, chosen by the case.
    Reduced,
    /// Metre, kilogram, second.
    Si,
}

/// The time that all times are divided by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceTime {
    /// Its value \[s in SI, otherwise units of the case\].
    pub seconds_or_units: f64,
    /// What it means.
    pub definition: TimeDefinition,
}

/// Meaning of the reference time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TimeDefinition {
    /// Haff's cooling time.
    #[serde(rename = "haff")]
    Haff,
    /// Mean free time at the start, for a gas that does not cool.
    #[serde(rename = "mean free time")]
    MeanFreeTime,
}

/// Machine that the run was made on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Cores that the run could use.
    pub cores: u64,
    /// Name of the processor.
    pub processor: String,
    /// Name of the operating system.
    pub system: String,
}

/// How a replica began.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Number of the replica, from zero.
    pub replica: u64,
    /// How the particles were placed.
    pub placement: String,
    /// Elastic collisions per particle before the start \[1\].
    pub collisions_per_particle: f64,
    /// Whether the start passed as an equilibrium state.
    pub equilibrated: bool,
    /// Tests of the start.
    pub tests: Vec<StartTest>,
}

/// One test of the initial state against equilibrium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartTest {
    /// Name of the test.
    pub name: String,
    /// Value of the statistic \[1\].
    #[serde(deserialize_with = "null_is_nan")]
    pub statistic: f64,
    /// Probability of so extreme a statistic in equilibrium \[1\].
    pub p_value: Option<f64>,
    /// Whether the test was passed; `None` where it only informs.
    pub passed: Option<bool>,
    /// What was measured, in words.
    pub detail: String,
}

/// Work of one engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineWork {
    /// Engine.
    pub engine: String,
    /// Duration, summed over the replicas \[s\].
    pub wall_seconds: f64,
    /// Collisions, summed over the replicas.
    pub collisions: u64,
    /// Counts of work by name, such as `predictions`.
    #[serde(deserialize_with = "finite_or_null")]
    pub work: BTreeMap<String, f64>,
}

/// A conclusion in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// What the conclusion is about.
    pub topic: String,
    /// The conclusion, one sentence.
    pub sentence: String,
    /// Its kind.
    pub kind: VerdictKind,
}

/// Kind of a conclusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerdictKind {
    /// The compared quantities agree within their errors.
    Agree,
    /// They differ beyond their errors.
    Differ,
    /// The errors are too wide to tell.
    Undecided,
    /// The result must be read with care.
    Warning,
}

/// A snapshot file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Engine.
    pub engine: String,
    /// Time `t/t0` \[1\].
    pub time_over_t0: f64,
    /// Path of the file, relative to the results folder.
    pub file: String,
}

/// Contents of `sweep.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Title of the sweep, plain text.
    pub title: String,
    /// The case file, verbatim.
    pub case_text: String,
    /// Kind of the case.
    #[serde(default, skip_serializing_if = "Kind::is_default")]
    pub kind: Kind,
    /// Points of the sweep, in the order of the case file.
    pub points: Vec<SweepPoint>,
}

/// One point of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// Name of the point.
    pub name: String,
    /// Its results folder, relative to the sweep folder.
    pub folder: String,
    /// Values of the swept keys.
    pub values: BTreeMap<String, serde_json::Value>,
}

/// Reads a map of numbers in which `null` stands for NaN.
pub(crate) fn finite_or_null<'de, D: Deserializer<'de>>(
    source: D,
) -> Result<BTreeMap<String, f64>, D::Error> {
    let read = BTreeMap::<String, Option<f64>>::deserialize(source)?;
    Ok(read
        .into_iter()
        .map(|(name, value)| (name, value.unwrap_or(f64::NAN)))
        .collect())
}

/// Reads a number that is `null` where it was not finite.
fn null_is_nan<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(source)?.unwrap_or(f64::NAN))
}
