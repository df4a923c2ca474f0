//! Case files: a TOML file says which gas is run, in which box, by which engines, and what is
//! measured. This crate reads, checks and expands it.
//!
//! A case is read in four steps. First the text becomes a table in which every key knows its place.
//! Then values of the command line and of a sweep are written into the table. The table is checked
//! against the JSON [`schema`], which holds types, ranges and words; and finally relations between
//! keys are checked on the typed [`Case`]. Every error names the file, the line, the key, the value
//! found and what is allowed.
//!
//! ```
//! use std::path::Path;
//! use stosszahl_case::CaseFile;
//!
//! let text = r#"
//! format = 2
//! title = "Homogeneous cooling"
//! [gas]
//! number = 100
//! restitution = 0.9
//! [box]
//! packing_fraction = 0.1
//! [run]
//! until = 10
//! [engine.ed]
//! [[sweep]]
//! "gas.restitution" = [0.8, 0.9]
//! "#;
//! let file = CaseFile::from_text(Path::new("cooling.toml"), text, &["replicas=8".to_owned()])?;
//! assert_eq!(file.points.len(), 2);
//! assert_eq!(file.points[0].name, "restitution=0.8");
//! assert_eq!(file.points[0].case.replicas, 8);
//! # Ok::<(), stosszahl_case::CaseError>(())
//! ```

pub mod bundled;
pub mod error;
pub mod format;
mod origin;
mod overrides;
pub mod paper;
mod relations;
mod renamed;
mod schema;
mod sweep;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;
use toml::{Table, Value};

pub use bundled::{Bundled, CaseBundle};
pub use error::{CaseError, Fault, Refusal, SYNONYMS, nearest};
pub use format::Case;
pub use paper::{Paper, PaperFile};
pub use schema::{Format, schema, schema_of};

use error::Problem;
use format::leading_question;
use origin::{Origins, split};
use overrides::Override;

/// Version of the case format that this program reads.
const VERSION: f64 = 2.0;

/// Largest size of a case file \[bytes\].
const MOST_BYTES: u64 = 1 << 20;

/// Case file as read: its text, and the cases that it describes, one for each point of a sweep.
#[derive(Clone, Debug)]
pub struct CaseFile {
    /// Text of the case file, byte for byte.
    pub text: String,
    /// Path of the case file.
    pub path: PathBuf,
    /// Points of the sweeps, all different; a single point without settings if there is no sweep.
    pub points: Vec<CasePoint>,
    /// Notes on how the file was read, in sentences for the user.
    pub notes: Vec<String>,
}

/// Point of a sweep: its name, its settings, and the case with them.
#[derive(Clone, Debug, Serialize)]
pub struct CasePoint {
    /// Name of the point, safe for a folder, such as `packing_fraction=0.25,restitution=1`; empty
    /// without settings.
    pub name: String,
    /// Keys and values that the sweep sets at this point.
    pub settings: Vec<SweepSetting>,
    /// Case with the settings of this point.
    pub case: Case,
    #[serde(skip)]
    table: Table,
    #[serde(skip)]
    origins: Origins,
}

/// Key of a case and the value that a sweep gives to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepSetting {
    /// Dotted name of the key, such as `gas.restitution`.
    pub key: String,
    /// Value that the sweep gives to the key, as written.
    pub value: Value,
}

impl CasePoint {
    /// Creates the error for a value that is not allowed, or for its absence. `key` is dotted, such
    /// as `measure.fields.cells`, with elements of lists counted from 1.
    pub fn refuse(&self, key: &str, allowed: impl Into<String>) -> CaseError {
        self.refuse_found(key, None, allowed)
    }

    /// Creates the error for a value that is not allowed because of `what` was found behind it,
    /// such as in a file that it names.
    pub fn refuse_found(
        &self,
        key: &str,
        what: Option<String>,
        allowed: impl Into<String>,
    ) -> CaseError {
        let mut problem = relations::refusal(&self.table, key, allowed);
        if let Fault::BadValue { found, .. } | Fault::MissingKey { found, .. } = &mut problem.fault
        {
            *found = what;
        }
        self.origins.refuse(problem)
    }
}

impl CaseFile {
    /// Returns the common beginning of the titles of all points of the file.
    pub fn title(&self) -> String {
        let mut titles = self.points.iter().map(|point| &*point.case.title);
        let mut common: Vec<&str> = titles.next().unwrap_or("").split(", ").collect();
        for title in titles {
            let same = common.iter().zip(title.split(", "));
            let same = same.take_while(|(a, b)| **a == *b).count();
            common.truncate(same.max(1));
        }
        common.join(", ")
    }

    /// Returns the question that the case answers, as text; `None` if there is none.
    pub fn question(&self) -> Option<String> {
        let written = self.points.first()?.case.question.text.clone();
        written.or_else(|| leading_question(&self.text))
    }

    /// Reads a case file, with overrides `key=value` as given to `--set`. Options of measurements
    /// are not checked; see [`Format::read`].
    ///
    /// The value of an override is TOML, or a bare word taken as text. A key that is overridden is
    /// no longer swept; with `run.until`, times and windows of measurements beyond it are left out.
    ///
    /// # Errors
    /// A file that cannot be read, is not UTF-8 or not TOML; a key that is unknown or missing; a
    /// value that is not allowed, alone or beside another; an override that is not `key=value`.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, CaseError> {
        Format::plain().read(path, overrides)
    }

    /// Reads a case from text. `path` appears in messages, and start files are relative to its
    /// folder.
    ///
    /// # Errors
    /// As [`CaseFile::read`], but for the file itself.
    pub fn from_text(path: &Path, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        Format::plain().from_text(path, text, overrides)
    }
}

impl Format {
    /// Reads a case file and checks names and options of its measurements too.
    ///
    /// # Errors
    /// As [`CaseFile::read`].
    pub fn read(&self, path: &Path, overrides: &[String]) -> Result<CaseFile, CaseError> {
        self.from_text(path, &read_text(path)?, overrides)
    }

    /// Reads a case from text, and checks names and options of its measurements too.
    ///
    /// # Errors
    /// As [`CaseFile::read`], but for the file itself.
    pub fn from_text(
        &self,
        path: &Path,
        text: &str,
        overrides: &[String],
    ) -> Result<CaseFile, CaseError> {
        let (mut table, mut origins) =
            Origins::parse_toml(path, text.trim_start_matches('\u{feff}'))?;
        check_version(&table).map_err(|problem| origins.refuse(problem))?;
        let read = |one: &String| {
            let read = Override::parse_override(path, one)?;
            // A title may look like a number.
            let as_text = self.type_of(&read.key) == Some("string");
            Ok(if as_text { read.into_text() } else { read })
        };
        let overrides = overrides.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        for one in &overrides {
            origins.set_by_argument(&one.key, &one.argument);
        }
        let expanded = sweep::expand(self, &mut table, &overrides);
        let sweep::Expanded { points, fixed } =
            expanded.map_err(|problem| origins.refuse(problem))?;
        let until_key = split("run.until");
        let mut until = None;
        for one in &overrides {
            set(&mut table, &origins, &one.key, &one.value)?;
            if one.key == until_key {
                until = one
                    .value
                    .as_float()
                    .or(one.value.as_integer().map(|n| n as f64));
            }
        }
        let may_repeat = until.is_some() || !fixed.is_empty();
        let mut names = sweep::Names::new(&points);
        let mut seen: BTreeMap<String, String> = BTreeMap::new();
        let mut read = Vec::new();
        for settings in points {
            let (mut table, mut origins) = (table.clone(), origins.clone());
            for one in &settings {
                origins.set_by_sweep(&one.key, &one.source);
                set(&mut table, &origins, &one.key, &one.value)?;
            }
            if let Some(until) = until {
                overrides::shorten(&mut table, until);
            }
            let case = self
                .case(&mut table, path)
                .map_err(|problem| origins.refuse(problem))?;
            let name = names.name(&settings);
            if let Some(twin) = seen.insert(format!("{case:?}"), name.clone()) {
                if may_repeat {
                    continue;
                }
                let allowed =
                    format!("points of sweeps differ; this is the same case as the point {twin}");
                let source = settings.last().map(|one| one.source.clone());
                let value = Value::String(name);
                let problem = Problem::bad(&source.unwrap_or_default(), &value, allowed);
                return Err(origins.refuse(problem));
            }
            let case = with_title(case, &overrides);
            let setting = |one: sweep::ChosenValue| SweepSetting {
                key: one.written,
                value: one.value,
            };
            read.push(CasePoint {
                name,
                settings: settings.into_iter().map(setting).collect(),
                case,
                table,
                origins,
            });
        }
        Ok(CaseFile {
            text: text.to_owned(),
            path: path.to_owned(),
            points: read,
            notes: fixed.iter().map(|key| sweep_note(key)).collect(),
        })
    }

    /// Converts a checked TOML table into a typed case.
    fn case(&self, table: &mut Table, path: &Path) -> Result<Case, Problem> {
        relations::replaced(table)?;
        self.check(table)?;
        let read: Result<Case, _> = Value::Table(table.clone()).try_into();
        // The schema lets nothing pass that the types refuse.
        let case = read.map_err(|error| Problem::missing(&[], error.message()))?;
        relations::check_relations(table, &case, path.parent().unwrap_or(Path::new("")))?;
        Ok(case)
    }
}

/// Returns the case with its title: derived from the gas if none is given, and with the overridden
/// keys of the gas added.
fn with_title(mut case: Case, overrides: &[Override]) -> Case {
    if case.title.is_empty() {
        case.title = case.derived_title();
        return case;
    }
    let named = overrides.iter().any(|one| one.key == ["title"]);
    let of_gas = |one: &&Override| {
        let first = one.key.first().map(String::as_str);
        matches!(
            first,
            Some("gas" | "species" | "pair" | "box" | "walls" | "gravity" | "thermostat")
        )
    };
    if !named {
        let changed = overrides.iter().filter(of_gas);
        let changed: Vec<String> = changed
            .map(|one| format!("{} = {}", one.key.join("."), one.value))
            .collect();
        if !changed.is_empty() {
            case.title = format!("{} (with {})", case.title, changed.join(", "));
        }
    }
    case
}

/// Sets a key of a case table to a value, as a sweep or an override does.
fn set(
    table: &mut Table,
    origins: &Origins,
    key: &[String],
    value: &Value,
) -> Result<(), CaseError> {
    overrides::set(table, key, value.clone()).map_err(|length| {
        let allowed = format!("elements are counted from 1; this list has {length}");
        origins.refuse(Problem::bad(key, value, allowed))
    })
}

/// Returns the note that the sweep over `key` is left out because an override sets the key.
fn sweep_note(key: &str) -> String {
    format!("{key} is set from outside, so that the sweep of the case over it is left out")
}

/// Checks the format version before any other key is checked.
fn check_version(table: &Table) -> Result<(), Problem> {
    let key = ["format".to_owned()];
    let version = table.get("format");
    let number = version.and_then(|value| {
        let whole = value.as_integer().map(|whole| whole as f64);
        whole.or(value.as_float())
    });
    match (version, number) {
        (_, Some(VERSION)) => Ok(()),
        (None, _) => Err(Problem::missing(
            &key,
            "write `format = 2` in the first line",
        )),
        (Some(value), _) => Err(Problem::bad(&key, value, "this program reads format 2")),
    }
}

/// Reads the text of a case file; checks size and encoding.
fn read_text(path: &Path) -> Result<String, CaseError> {
    let unreadable = |source| CaseError::Unreadable {
        path: path.to_owned(),
        source,
    };
    if std::fs::metadata(path).map_err(unreadable)?.is_dir() {
        let path = path.to_owned();
        return Err(CaseError::Folder { path });
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(CaseError::TooLarge {
            path: path.to_owned(),
            limit: MOST_BYTES,
        });
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        CaseError::NotUtf8 {
            path: path.to_owned(),
            line: bytes[..at].split(|&byte| byte == b'\n').count(),
            byte: bytes[at],
        }
    })
}
