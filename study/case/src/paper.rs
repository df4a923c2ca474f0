//! Paper files: one TOML file says which bundled cases make the figures of a paper, and what the
//! paper says of each.
//!
//! They are read as cases are: types, ranges and words against a schema made from the types here,
//! then relations between keys. Every error names the file, the line, the key, the value found and
//! what is allowed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::error::{CaseError, Problem};
use crate::origin::{Origins, value_at};
use crate::overrides::bare_keys;
use crate::relations::refusal;
use crate::schema::{Format, schema_of};
use crate::{CasePoint, read_text};

/// Version of the paper format that this program reads.
const VERSION: u64 = 1;

/// Paper to be reproduced: its runs, its figures, and what it claims.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Version of the paper format. This program reads version 1.
    pub format: u64,
    /// Title of the paper.
    #[schemars(length(min = 1))]
    pub title: String,
    /// Source of the paper: authors, journal and year.
    #[schemars(length(min = 1))]
    pub source: String,
    /// Remark on the paper as a whole, for the reader.
    pub remark: Option<String>,
    /// Chance that any claim of the paper is called different though it is not.
    #[serde(default = "usual")]
    #[schemars(extend("minimum" = 1e-12, "exclusiveMaximum" = 1.0))]
    pub family_wise_error_rate: f64,
    /// Runs of the paper, by name.
    pub run: BTreeMap<String, PaperRunSpec>,
    /// Figures and tables of the paper.
    #[schemars(length(min = 1, max = 1000))]
    pub figure: Vec<PaperFigureSpec>,
}

fn usual() -> f64 {
    0.05
}

fn yes() -> bool {
    true
}

/// Run of a paper: a case, and the keys that are set in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperRunSpec {
    /// The case: a bundled one by its name, or a file beside the paper.
    #[schemars(length(min = 1))]
    pub case: String,
    /// Keys of the case that the run sets, dotted.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: BTreeMap<String, Value>,
    /// Keys of the case that are set in addition where the run must be quick.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub quick: BTreeMap<String, Value>,
}

/// Figure or table of a paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperFigureSpec {
    /// Number of the figure in the paper, such as "3b" or "Table I".
    #[schemars(length(min = 1))]
    pub name: String,
    /// Title of the figure.
    #[schemars(length(min = 1))]
    pub title: String,
    /// Run whose tables the figure shows; also that of its claims unless they name another.
    #[schemars(length(min = 1))]
    pub run: String,
    /// Tables of the run that are drawn.
    #[serde(default)]
    pub tables: Vec<String>,
    /// Parts of the paper's figure that are missing here.
    pub missing: Option<String>,
    /// Claims of the paper about this figure.
    #[serde(default)]
    pub claim: Vec<Claim>,
}

/// Location of a number in the tables of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberPlace {
    /// Run of the number. Default: that of the claim.
    pub run: Option<String>,
    /// Values of swept keys that choose the point of the number. Default: that of the claim.
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub point: Option<BTreeMap<String, Value>>,
    /// Table of the number. Default: that of the claim.
    pub table: Option<String>,
    /// Column of the number. Default: that of the claim.
    pub column: Option<String>,
    /// Key columns of the number's row that differ from those of the claim.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub keys: BTreeMap<String, Value>,
}

/// Claim of a paper about one number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Claim of the paper in words.
    #[schemars(length(min = 1))]
    pub claim: String,
    /// Run of the claim. Default: that of the figure.
    pub run: Option<String>,
    /// Values of swept keys that choose the point of the claim.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub point: BTreeMap<String, Value>,
    /// Table that holds the claimed number.
    pub table: Option<String>,
    /// Column of the claimed number.
    pub column: Option<String>,
    /// Values of key columns that choose its row: words, numbers, or [from, to], of whose rows the
    /// mean is taken.
    #[serde(default, rename = "where")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub keys: BTreeMap<String, Value>,
    /// Derived quantity in place of a table, by the name that `check` gives it; or the `seconds` or
    /// `collisions` of a run.
    pub derived: Option<String>,
    /// Number by which the claimed number is divided.
    pub over: Option<NumberPlace>,
    /// Numeric key column: the claim is about the power of it by which the quotient grows.
    pub power_of: Option<String>,
    /// Source of the standard error of the claimed number.
    #[serde(default)]
    pub errors: Errors,
    /// Value that the paper states.
    pub value: Option<f64>,
    /// Values that the paper states at several places: pairs of `along` and the paper's number.
    pub values: Option<Vec<[f64; 2]>>,
    /// Key column over which `values` are given.
    pub along: Option<String>,
    /// Lower bound that the paper states.
    pub above: Option<f64>,
    /// Upper bound that the paper states.
    pub below: Option<f64>,
    /// Standard error of the paper's value, or of its reading from a figure.
    #[schemars(range(min = 0.0))]
    pub error: Option<f64>,
    /// Largest deviation from the paper's value that counts as agreement, as a share of the value.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 10.0))]
    pub margin: Option<f64>,
    /// Largest deviation from the paper's value that counts as agreement, in the unit of the value.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub within: Option<f64>,
    /// Correct value, where that of the paper is wrong.
    pub corrected: Option<f64>,
    /// Reason why the paper's value is wrong, with the source of the correction.
    pub correction: Option<String>,
    /// True if quick runs can test the claim.
    #[serde(default = "yes")]
    pub quick: bool,
}

/// Source of the standard error of a number in a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Errors {
    /// Errors from replicas, which are few: intervals are Student's.
    #[default]
    Replicas,
    /// Errors from many blocks of time: intervals are normal.
    Blocks,
}

/// Paper file as read: its content and the positions of its keys.
#[derive(Clone, Debug)]
pub struct PaperFile {
    /// Path of the paper file.
    pub path: PathBuf,
    /// Content of the paper file.
    pub paper: Paper,
    table: Table,
    origins: Origins,
}

impl PaperFile {
    /// Reads a paper file and checks it.
    ///
    /// # Errors
    /// [`CaseError`] says what is wrong, and where.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        Self::from_text(path, &read_text(path)?)
    }

    /// Reads a paper from text. `path` appears in messages, and case files are relative to its
    /// folder.
    ///
    /// # Errors
    /// As [`PaperFile::read`], but for the file itself.
    pub fn from_text(path: &Path, text: &str) -> Result<Self, CaseError> {
        let (mut table, origins) = Origins::parse_toml(path, text.trim_start_matches('\u{feff}'))?;
        let read = read(&mut table).map_err(|problem| origins.refuse(problem));
        let file = Self {
            path: path.to_owned(),
            paper: read?,
            table,
            origins,
        };
        file.check_relations()?;
        Ok(file)
    }

    /// Creates the error for a value that is not allowed, or for its absence. `key` is dotted, such
    /// as `figure.1.claim.2.table`, with elements of lists counted from 1.
    pub fn refuse(&self, key: &str, allowed: impl Into<String>) -> CaseError {
        self.origins.refuse(refusal(&self.table, key, allowed))
    }

    /// Checks relations between the keys of a paper, such as runs that figures name.
    fn check_relations(&self) -> Result<(), CaseError> {
        let names: Vec<&str> = self.paper.run.keys().map(String::as_str).collect();
        let known = |key: &str, name: &str| {
            let good = self.paper.run.contains_key(name);
            let allowed = || format!("one of the runs {}", names.join(", "));
            good.then_some(())
                .ok_or_else(|| self.refuse(key, allowed()))
        };
        for (name, run) in &self.paper.run {
            // The name of a run is that of a folder.
            let keys = bare_keys(name).filter(|keys| keys.len() == 1);
            if keys.is_none() {
                let allowed = "names of runs are of letters, digits, - and _";
                return Err(self.refuse("run", allowed));
            }
            for (part, keys) in [("set", &run.set), ("quick", &run.quick)] {
                if let Some(bad) = keys.keys().find(|key| bare_keys(key).is_none()) {
                    let allowed =
                        format!("dotted keys, such as \"gas.number\", which {bad} is not");
                    return Err(self.refuse(&format!("run.{name}.{part}"), allowed));
                }
            }
        }
        for (number, figure) in (1..).zip(&self.paper.figure) {
            let key = format!("figure.{number}");
            known(&format!("{key}.run"), &figure.run)?;
            let twins = self.paper.figure.iter().take(number - 1);
            if twins.clone().any(|other| other.name == figure.name) {
                let allowed = "names of figures differ";
                return Err(self.refuse(&format!("{key}.name"), allowed));
            }
            for (number, claim) in (1..).zip(&figure.claim) {
                let key = format!("{key}.claim.{number}");
                if let Some(run) = &claim.run {
                    known(&format!("{key}.run"), run)?;
                }
                if let Some(run) = claim.over.as_ref().and_then(|over| over.run.as_ref()) {
                    known(&format!("{key}.over.run"), run)?;
                }
                self.check_claim(&key, claim)?;
            }
        }
        Ok(())
    }

    fn check_claim(&self, key: &str, claim: &Claim) -> Result<(), CaseError> {
        let refuse =
            |inside: &str, allowed: &str| Err(self.refuse(&format!("{key}.{inside}"), allowed));
        let bounds = usize::from(claim.above.is_some()) + usize::from(claim.below.is_some());
        let values = usize::from(claim.value.is_some()) + usize::from(claim.values.is_some());
        if (bounds, values) != (1, 0) && (bounds, values) != (0, 1) {
            return refuse("value", "one of value, values, above and below");
        }
        let margins = usize::from(claim.margin.is_some()) + usize::from(claim.within.is_some());
        if margins != values {
            return refuse(
                "margin",
                "a value has a margin or a within, a bound neither",
            );
        }
        if claim.margin.is_some() && claim.value == Some(0.0) {
            return refuse("margin", "a share of zero is none; use within");
        }
        if claim.error.is_some() && values == 0 {
            return refuse("error", "a bound has no error");
        }
        match (&claim.derived, &claim.table, &claim.column) {
            (Some(_), None, None) | (None, Some(_), Some(_)) => {}
            (Some(_), ..) => {
                return refuse("derived", "it stands in place of a table and a column");
            }
            (None, None, _) => return refuse("table", "a table and a column, or derived"),
            (None, _, None) => return refuse("column", "a table and a column, or derived"),
        }
        if claim.along.is_some() != claim.values.is_some() {
            return refuse("along", "the key column of values, and only of values");
        }
        if claim.power_of.is_some() && claim.over.is_none() {
            return refuse(
                "power_of",
                "it is the power of a quotient, so that over is needed",
            );
        }
        if claim.corrected.is_some() && claim.correction.is_none() {
            return refuse(
                "correction",
                "what is corrected needs a reason and its source",
            );
        }
        if claim.corrected.is_some() && claim.value.is_none() {
            return refuse("corrected", "only a value can be corrected");
        }
        let places = [
            ("where", Some(&claim.keys)),
            ("over.where", claim.over.as_ref().map(|over| &over.keys)),
        ];
        for (inside, keys) in places {
            for (name, value) in keys.into_iter().flatten() {
                if !is_choice(value) {
                    let allowed = format!("{name} is a text, a number or [from, to]");
                    return refuse(inside, &allowed);
                }
            }
        }
        Ok(())
    }
}

/// Returns true if a value can select rows of a table: a word, a number, or a pair of numbers.
fn is_choice(value: &Value) -> bool {
    match value {
        Value::String(_) => true,
        Value::Array(ends) => ends.len() == 2 && ends.iter().all(|end| number(end).is_some()),
        other => number(other).is_some(),
    }
}

/// Converts a TOML integer or float to a floating-point number; `None` for other values.
pub fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|whole| whole as f64);
    value.as_float().or(whole)
}

/// Checks the table of a paper against the schema and converts it to a typed paper.
fn read(table: &mut Table) -> Result<Paper, Problem> {
    let version = ["format".to_owned()];
    if let Some(value) = value_at(table, &version)
        && number(value) != Some(VERSION as f64)
    {
        return Err(Problem::bad(&version, value, "this program reads format 1"));
    }
    Format::of_type(schema_of::<Paper>()).check(table)?;
    let read: Result<Paper, _> = Value::Table(table.clone()).try_into();
    // The schema lets nothing pass that the types refuse.
    read.map_err(|error| Problem::missing(&[], error.message()))
}

impl CasePoint {
    /// Returns true if the sweep sets all of these keys to these values at this point.
    pub fn has(&self, chosen: &BTreeMap<String, Value>) -> bool {
        let same = |a: &Value, b: &Value| match (number(a), number(b)) {
            (Some(a), Some(b)) => (a - b).abs() <= 1e-9 * a.abs().max(b.abs()),
            _ => a == b,
        };
        chosen.iter().all(|(key, value)| {
            let mut settings = self.settings.iter();
            settings.any(|one| one.key == *key && same(&one.value, value))
        })
    }
}
