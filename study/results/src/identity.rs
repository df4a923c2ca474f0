//! Identity of the runs of a results folder, from fingerprints of their inputs: the file
//! `run.json`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::ErrorKind::{InvalidFilename, InvalidInput, NotADirectory, NotFound};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::ResultsError;
use crate::manifest::RunFingerprints;
use crate::regular;

/// Name of the file that marks a results folder and identifies its runs.
pub(crate) const RUN_FILE: &str = "run.json";
/// Version of the format of `run.json`.
const RUN_FORMAT: u32 = 2;
/// Largest number of differing keys that a message names.
const NAMED: usize = 3;

/// Identity of a run: its sweep point, its case and its fingerprints.
#[derive(Clone, Debug, PartialEq)]
pub struct RunId {
    /// Name of the sweep point and of its subfolder; empty without a sweep.
    pub name: String,
    /// Hash of all inputs that determine the numbers: version, case, input files.
    pub numbers: [u8; 32],
    /// Hash of the whole case without the keys that affect nothing in the folder.
    pub output: [u8; 32],
    pub(crate) case: Value,
}

/// Lists of case keys, dotted, that do not affect the numbers of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Keys<'a> {
    /// Keys that affect nothing in the results folder, such as `run.checkpoint_seconds`.
    pub ignored: &'a [&'a str],
    /// Keys that affect only how results are shown and judged, such as `title` and `verdict`.
    pub output: &'a [&'a str],
}

/// Contents of `run.json`: the runs that a results folder is for.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RunMark {
    program: String,
    format: u32,
    version: String,
    /// Runs by the name of their subfolder; without a sweep one run with an empty name.
    pub(crate) runs: BTreeMap<String, MarkedRun>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MarkedRun {
    pub(crate) fingerprint: RunFingerprints,
    pub(crate) case: Value,
}

impl RunId {
    /// Computes the identity of a run from its case, with all defaults and swept values filled in,
    /// and from the contents, not the names, of its input files.
    ///
    /// # Errors
    /// [`ResultsError`] if a file cannot be read.
    pub fn new(
        name: &str,
        case: &Value,
        keys: Keys<'_>,
        inputs: &[&Path],
    ) -> Result<Self, ResultsError> {
        let mut case = case.clone();
        keys.ignored
            .iter()
            .for_each(|key| remove_key(&mut case, key));
        let output = *blake3::hash(case.to_string().as_bytes()).as_bytes();
        let mut physics = case.clone();
        keys.output
            .iter()
            .for_each(|key| remove_key(&mut physics, key));
        let mut hash = blake3::Hasher::new();
        hash.update(env!("CARGO_PKG_VERSION").as_bytes())
            .update(b"\n")
            .update(physics.to_string().as_bytes());
        for path in inputs {
            let bytes = regular::read_bytes(path).map_err(ResultsError::system(path, "read"))?;
            hash.update(blake3::hash(&bytes).as_bytes());
        }
        Ok(Self {
            name: name.to_owned(),
            numbers: hash.finalize().into(),
            output,
            case,
        })
    }

    /// Returns the fingerprint of a run for checkpoints: of its numbers and the name of its point.
    pub fn identity(&self) -> [u8; 32] {
        let mut hash = blake3::Hasher::new();
        hash.update(&self.numbers).update(self.name.as_bytes());
        hash.finalize().into()
    }

    pub(crate) fn fingerprint(&self) -> RunFingerprints {
        let hex = |bytes| blake3::Hash::from_bytes(bytes).to_string();
        RunFingerprints {
            numbers: hex(self.numbers),
            output: hex(self.output),
        }
    }
}

/// Removes a dotted key from nested tables of a case.
fn remove_key(case: &mut Value, key: &str) {
    let (first, rest) = key
        .split_once('.')
        .map_or((key, None), |(a, b)| (a, Some(b)));
    let Some(table) = case.as_object_mut() else {
        return;
    };
    match (rest, table.get_mut(first)) {
        (Some(rest), Some(inner)) => remove_key(inner, rest),
        (None, Some(_)) => drop(table.remove(first)),
        _ => {}
    }
}

impl RunMark {
    pub(crate) fn new(runs: &[RunId]) -> Self {
        let marked = |run: &RunId| MarkedRun {
            fingerprint: run.fingerprint(),
            case: run.case.clone(),
        };
        Self {
            program: "stosszahl".into(),
            format: RUN_FORMAT,
            version: env!("CARGO_PKG_VERSION").into(),
            runs: runs
                .iter()
                .map(|run| (run.name.clone(), marked(run)))
                .collect(),
        }
    }

    /// Reads the `run.json` of a folder; `None` if there is none of this program. Text that is not
    /// JSON, or not of the expected form, is an error.
    pub(crate) fn read_mark(folder: &Path) -> Result<Option<Self>, ResultsError> {
        let damaged = || ResultsError::Damaged {
            path: folder.to_owned(),
        };
        let path = folder.join(RUN_FILE);
        let bytes = match regular::read_bytes(&path) {
            Ok(bytes) => bytes,
            // No regular file of this name, no folder, or a name that no file can have.
            Err(error)
                if matches!(
                    error.kind(),
                    NotFound | NotADirectory | InvalidInput | InvalidFilename
                ) =>
            {
                return Ok(None);
            }
            Err(error) => return Err(ResultsError::system(&path, "read")(error)),
        };
        let value: Value = serde_json::from_slice(&bytes).map_err(|_| damaged())?;
        if value["program"] != "stosszahl" {
            return Ok(None);
        }
        if value["format"] != RUN_FORMAT {
            let found = value.get("format");
            return Err(ResultsError::OtherVersion {
                path: folder.to_owned(),
                found: found.map_or("1".into(), ToString::to_string),
                expected: RUN_FORMAT,
            });
        }
        serde_json::from_value(value)
            .map(Some)
            .map_err(|_| damaged())
    }

    /// Describes the differences to some runs that affect the numbers; `None` if there are none.
    pub(crate) fn differences(&self, runs: &[RunId]) -> Option<String> {
        let names = runs.iter().map(|run| &run.name);
        if !self
            .runs
            .keys()
            .collect::<BTreeSet<_>>()
            .into_iter()
            .eq(names.collect::<BTreeSet<_>>())
        {
            return Some("the points of the sweep differ".into());
        }
        let foreign = runs
            .iter()
            .find(|run| self.runs[&run.name].fingerprint.numbers != run.fingerprint().numbers)?;
        if self.version != env!("CARGO_PKG_VERSION") {
            return Some(format!("version {} of the program wrote it", self.version));
        }
        let named = differences(&self.runs[&foreign.name].case, &foreign.case);
        Some(if named.is_empty() {
            "the files that the case reads have changed".into()
        } else {
            named
        })
    }
}

/// Describes the first keys in which two cases differ.
pub(crate) fn differences(there: &Value, here: &Value) -> String {
    fn flatten(value: &Value, key: &str, into: &mut BTreeMap<String, String>) {
        let inner = |name: &str| match key {
            "" => name.to_owned(),
            _ => format!("{key}.{name}"),
        };
        match value {
            Value::Object(map) => {
                map.iter()
                    .for_each(|(name, value)| flatten(value, &inner(name), into));
            }
            Value::Array(list) if list.iter().any(Value::is_object) => {
                let numbered = list.iter().zip(1..);
                numbered
                    .for_each(|(value, number)| flatten(value, &inner(&format!("{number}")), into));
            }
            Value::Null => {}
            other => drop(into.insert(key.to_owned(), other.to_string())),
        }
    }
    let (mut old, mut new) = (BTreeMap::new(), BTreeMap::new());
    flatten(there, "", &mut old);
    flatten(here, "", &mut new);
    let keys: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let differ: Vec<&String> = keys
        .into_iter()
        .filter(|key| old.get(*key) != new.get(*key))
        .collect();
    let shown = |values: &BTreeMap<String, String>, key: &str| {
        let text = values.get(key).map_or("not set", String::as_str);
        text.chars().take(60).collect::<String>()
    };
    let named = differ.iter().take(NAMED).map(|key| {
        format!(
            "{key}: {} there, {} here",
            shown(&old, key),
            shown(&new, key)
        )
    });
    let mut text = named.collect::<Vec<_>>().join("; ");
    if differ.len() > NAMED {
        // Writing to a string cannot fail.
        let _ = write!(text, "; {} more", differ.len() - NAMED);
    }
    text
}
