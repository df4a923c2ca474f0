//! The manifest of a results folder of a gas without positions.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::case::Kind;
use crate::manifest::{Machine, Program, Verdict, finite_or_null};

/// Contents of `manifest.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format, [`crate::manifest::FORMAT`].
    pub format: u32,
    /// Kind of the case.
    pub kind: Kind,
    /// Program that wrote the folder.
    pub program: Program,
    /// Title of the run, plain text.
    pub title: String,
    /// The case file, verbatim.
    pub case_text: String,
    /// The case after validation, with every default filled in.
    pub case: serde_json::Value,
    /// Derived quantities by name, such as `packing_fraction`.
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
    /// Counts of work by name, averaged over the replicas.
    #[serde(deserialize_with = "finite_or_null")]
    pub work: BTreeMap<String, f64>,
    /// Conclusions in words.
    pub verdicts: Vec<Verdict>,
    /// Warnings in words.
    pub warnings: Vec<String>,
}
