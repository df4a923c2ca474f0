//! The manifest of a results folder (`manifest.json`) and the index of a sweep (`sweep.json`).
//!
//! The manifest records what was run, from which start, on which machine and with how much work,
//! the verdicts in words, and the description of each table. JSON has no NaN: a non-finite number
//! is written as `null` and read back as NaN.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

use crate::error::ResultsError;
use crate::regular;
use crate::table::{Figure, Table, TableColumn};
use crate::verdict::VerdictText;

/// Version of the formats of manifest and sweep index that this program writes and reads.
pub const FORMAT: u32 = 2;
/// Name of the manifest inside a results folder.
pub const MANIFEST_FILE: &str = "manifest.json";
/// Name of the index file inside a sweep folder.
pub const SWEEP_FILE: &str = "sweep.json";
/// Name of the summary table of all points inside a sweep folder.
pub const SWEEP_TABLE: &str = "sweep.csv";
/// Name of the report page inside a results folder or a sweep folder.
pub const REPORT_FILE: &str = "report.html";

/// Contents of `manifest.json`: description of a run and of its files.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the manifest format, [`FORMAT`].
    pub format: u32,
    /// Program that wrote the folder.
    pub program: Program,
    /// Fingerprints of the run; set when it is finished.
    pub fingerprint: RunFingerprints,
    /// Title of the run as plain text.
    pub title: String,
    /// Question that the run answers, and the location of the answer.
    #[serde(default)]
    pub question: RunQuestion,
    /// Text of the case file, verbatim.
    pub case_text: String,
    /// Case as it was run, with every default filled in.
    pub case: serde_json::Value,
    /// Unit of all times of the case.
    pub time_unit: TimeUnitSize,
    /// Quantities derived from the case.
    pub derived: Vec<Derived>,
    /// Machine that the run was made on.
    pub machine: Machine,
    /// Seed of all random streams.
    pub seed: u64,
    /// Number of replicas of the run.
    pub replicas: u64,
    /// Wall time of the whole run \[s\].
    #[serde(deserialize_with = "null_is_nan")]
    pub wall_seconds: f64,
    /// Record of the initial state of each replica.
    pub start: Vec<StartRecord>,
    /// Work of each engine, in computing time and counts.
    pub engines: Vec<EngineWork>,
    /// Verdicts, the most important first.
    pub verdicts: Vec<VerdictText>,
    /// Choices that the program made, with the reasons.
    pub choices: Vec<String>,
    /// Warnings about the run, in words.
    pub warnings: Vec<String>,
    /// Snapshots of replica 0.
    pub snapshots: Vec<Snapshot>,
    /// Files of particle frames of replica 0, for the particle player.
    #[serde(default)]
    pub frames: Vec<FramesEntry>,
    /// Descriptions of the tables; set when the run is finished.
    pub tables: Vec<TableEntry>,
}

/// Question of a run, and the number that answers it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunQuestion {
    /// Question as text; empty if none is asked.
    pub text: String,
    /// Table that has the answer to the question; empty if nothing is compared.
    pub table: String,
    /// Column of the table that has the answer.
    pub column: String,
}

/// Name and version of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Name of the program.
    pub name: String,
    /// Version of the program, such as `2.0.0`.
    pub version: String,
    /// Commit of the build, and whether sources had changed since; empty if unknown.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub commit: String,
}

/// Fingerprints of a run, as hexadecimal BLAKE3 hashes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunFingerprints {
    /// Hash of all inputs that determine the numbers: program version, case, input files.
    pub numbers: String,
    /// Hash of all inputs that affect only how results are shown and judged.
    pub output: String,
}

/// Unit of all times of a case: its name and size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeUnitSize {
    /// Name of the unit of time, such as `Haff's cooling time`.
    pub name: String,
    /// Size of the unit of time, in the time unit of the case's length, mass and energy.
    #[serde(deserialize_with = "null_is_nan")]
    pub size: f64,
}

/// Quantity derived from a case, such as the mean free path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Derived {
    /// Name of the quantity, in words.
    pub name: String,
    /// Value of the derived quantity.
    #[serde(deserialize_with = "null_is_nan")]
    pub value: f64,
    /// Unit of the value; `1` for pure numbers.
    pub unit: String,
}

/// Machine that a run was made on: cores, processor and system.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Number of processor cores that the run could use.
    pub cores: u64,
    /// Name of the machine's processor.
    pub processor: String,
    /// Name of the machine's operating system.
    pub system: String,
}

/// Record of the initial state of a replica: placement, equilibration and its tests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartRecord {
    /// Number of the replica, from zero.
    pub replica: u64,
    /// Method by which particles were placed, in words.
    pub placement: String,
    /// Elastic collisions per particle before the start \[1\].
    #[serde(deserialize_with = "null_is_nan")]
    pub collisions_per_particle: f64,
    /// True if the initial state passed the equilibrium tests; `None` if the case gives the initial
    /// state.
    pub equilibrated: Option<bool>,
    /// Equilibrium tests of the initial state.
    pub tests: Vec<StartTest>,
}

/// One test of the initial state against equilibrium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartTest {
    /// Name of the equilibrium test.
    pub name: String,
    /// Value of the test statistic \[1\].
    #[serde(deserialize_with = "null_is_nan")]
    pub statistic: f64,
    /// Probability of so extreme a statistic in equilibrium \[1\].
    pub p_value: Option<f64>,
    /// True if the initial state passed the test; `None` if the test is only informative.
    pub passed: Option<bool>,
    /// Result of the test as a sentence.
    pub detail: String,
}

/// Work of one engine, over all replicas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineWork {
    /// Name of the engine that did the work.
    pub engine: String,
    /// Computing time of the engine over all replicas \[s\].
    #[serde(deserialize_with = "null_is_nan")]
    pub seconds: f64,
    /// Number of collisions over all replicas.
    pub collisions: u64,
    /// Largest memory of one replica of the engine \[bytes\].
    pub bytes: u64,
    /// Work counters by name, such as `predictions`.
    #[serde(deserialize_with = "finite_or_null")]
    pub work: BTreeMap<String, f64>,
}

/// Snapshot file of one engine at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Name of the engine of the snapshot.
    pub engine: String,
    /// Number of the replica, from 0.
    #[serde(default)]
    pub replica: u64,
    /// Time of the snapshot, in the unit of time of the case.
    #[serde(deserialize_with = "null_is_nan")]
    pub time: f64,
    /// Path of the snapshot file, relative to the results folder, with `/` between names.
    pub file: String,
    /// BLAKE3 hash of the snapshot file, hexadecimal; set when the run is finished.
    #[serde(default)]
    pub blake3: String,
}

impl Snapshot {
    /// Returns true if a report may show the snapshot: particles of the first replica, with
    /// positions.
    pub fn is_shown(&self) -> bool {
        let ending = Path::new(&self.file).extension();
        self.replica == 0 && ending.is_some_and(|ending| ending == "xyz")
    }
}

/// File of particle frames of one engine ([`crate::frames`]).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FramesEntry {
    /// Name of the engine of the frames.
    pub engine: String,
    /// Path of the frames file, relative to the results folder, with `/` between names.
    pub file: String,
    /// BLAKE3 hash of the frames file, hexadecimal.
    pub blake3: String,
}

impl FramesEntry {
    /// Creates the manifest entry of a frames file with the given bytes.
    pub fn new(engine: String, file: String, bytes: &[u8]) -> Self {
        Self {
            engine,
            file,
            blake3: blake3::hash(bytes).to_string(),
        }
    }
}

/// Description of a table of the results folder, without its rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableEntry {
    /// Name of the table; its file is `NAME.csv`.
    pub name: String,
    /// Content of the table in one sentence.
    pub about: String,
    /// Columns of the table: names, units, meanings and roles.
    pub columns: Vec<TableColumn>,
    /// Figures that can be drawn from the table.
    pub figures: Vec<Figure>,
    /// Number of rows of the table.
    pub rows: u64,
    /// BLAKE3 hash of the table's file, hexadecimal.
    pub blake3: String,
}

/// Contents of `sweep.json`: title, case and points of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Version of the index format, [`FORMAT`].
    pub format: u32,
    /// Title of the sweep as plain text.
    pub title: String,
    /// Text of the case file, verbatim.
    pub case_text: String,
    /// Points of the sweep, in the order of the case file.
    pub points: Vec<SweepPoint>,
}

/// Point of a sweep: its name and the swept values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// Name of the point, and of its folder inside the sweep folder.
    pub name: String,
    /// Swept keys of the point with their values.
    pub values: BTreeMap<String, serde_json::Value>,
}

/// Finished run as read from its folder, without the particles of its snapshots.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Manifest of the finished run.
    pub manifest: Manifest,
    /// Tables of the run, in the order of the manifest.
    pub tables: Vec<Table>,
    /// Names of files whose content differs from what the run wrote, by their hashes.
    pub changed: Vec<String>,
}

impl TableEntry {
    /// Creates the manifest entry of a table whose CSV file has the given bytes.
    pub(crate) fn new(table: &Table, bytes: &[u8]) -> Self {
        Self {
            name: table.name.to_string(),
            about: table.about.to_string(),
            columns: table.columns.clone(),
            figures: table.figures.clone(),
            rows: table.rows.len() as u64,
            blake3: blake3::hash(bytes).to_string(),
        }
    }

    /// Returns the name of the table's CSV file.
    pub fn file(&self) -> String {
        format!("{}.csv", self.name)
    }

    /// Reads the rows of the table from its CSV file.
    ///
    /// # Errors
    /// [`ResultsError`] if the file is absent or damaged, or its columns or number of rows differ.
    pub fn read(&self, folder: &Path) -> Result<Table, ResultsError> {
        let mut table = Table {
            name: self.name.clone().into(),
            about: self.about.clone().into(),
            columns: self.columns.clone(),
            rows: Vec::new(),
            figures: self.figures.clone(),
        };
        let path = folder.join(self.file());
        table.read_rows(&path)?;
        let found = table.rows.len() as u64;
        if found == self.rows {
            return Ok(table);
        }
        Err(ResultsError::Length {
            path,
            line: found + 1,
            what: "rows",
            found,
            expected: self.rows,
        })
    }
}

impl Manifest {
    /// Reads the manifest of a folder; `None` if there is none.
    ///
    /// # Errors
    /// [`ResultsError`] if the manifest cannot be read, or has another format.
    pub fn read(folder: &Path) -> Result<Option<Self>, ResultsError> {
        read_json(&folder.join(MANIFEST_FILE))
    }

    /// Reads the manifest of a run that may be finished; `None` without one, or if it is damaged or
    /// of another format: the run is then repeated.
    ///
    /// # Errors
    /// [`ResultsError::System`] if the file exists and cannot be read.
    pub(crate) fn read_finished(folder: &Path) -> Result<Option<Self>, ResultsError> {
        match Self::read(folder) {
            Err(ResultsError::Json { .. } | ResultsError::Format { .. }) => Ok(None),
            other => other,
        }
    }

    /// Returns the names of the files of the finished run with their hashes: tables, snapshots and
    /// frames.
    pub fn files(&self) -> impl Iterator<Item = (String, &str)> {
        let tables = self
            .tables
            .iter()
            .map(|entry| (entry.file(), entry.blake3.as_str()));
        let snapshots = (self.snapshots.iter()).map(|one| (one.file.clone(), one.blake3.as_str()));
        let frames = (self.frames.iter()).map(|one| (one.file.clone(), one.blake3.as_str()));
        tables.chain(snapshots).chain(frames)
    }

    /// Compares the files of the run with their hashes. Returns the names of those that are absent,
    /// and of those whose contents have changed.
    ///
    /// # Errors
    /// [`ResultsError`] if an existing file cannot be read.
    pub fn damage(&self, folder: &Path) -> Result<(Vec<String>, Vec<String>), ResultsError> {
        let (mut absent, mut changed) = (Vec::new(), Vec::new());
        for (file, expected) in self.files() {
            match hash_of(&folder.join(&file))? {
                None => absent.push(file),
                Some(found) if found != expected => changed.push(file),
                Some(_) => {}
            }
        }
        Ok((absent, changed))
    }
}

impl Sweep {
    /// Reads the sweep index of a folder; `None` if there is none.
    ///
    /// # Errors
    /// [`ResultsError`] if the index cannot be read, or has another format.
    pub fn read(folder: &Path) -> Result<Option<Self>, ResultsError> {
        read_json(&folder.join(SWEEP_FILE))
    }
}

impl Stored {
    /// Reads all finished points of a sweep folder. For a single run, returns that run with a point
    /// without a name.
    ///
    /// # Errors
    /// As [`Stored::read`].
    pub fn points(folder: &Path) -> Result<Vec<(SweepPoint, Self)>, ResultsError> {
        let points = match Sweep::read(folder)? {
            Some(sweep) => sweep.points,
            None => vec![SweepPoint::default()],
        };
        let mut finished = Vec::new();
        for point in points {
            if let Some(stored) = Self::read(&folder.join(&point.name))? {
                finished.push((point, stored));
            }
        }
        Ok(finished)
    }

    /// Reads a finished run from its folder; `None` if there is no manifest.
    ///
    /// # Errors
    /// [`ResultsError`] if the manifest or a table is damaged, a table is absent, or the run has
    /// none.
    pub fn read(folder: &Path) -> Result<Option<Self>, ResultsError> {
        let Some(manifest) = Manifest::read(folder)? else {
            return Ok(None);
        };
        let (absent, changed) = manifest.damage(folder)?;
        let tables: Vec<String> = absent
            .into_iter()
            .filter(|file| manifest.tables.iter().any(|entry| entry.file() == *file))
            .collect();
        if !tables.is_empty() {
            return Err(ResultsError::Lost {
                path: folder.to_owned(),
                files: tables,
            });
        }
        if manifest.tables.is_empty() {
            return Err(ResultsError::NoResults {
                path: folder.to_owned(),
                found: "the manifest names no table; run the case again",
            });
        }
        let read = manifest.tables.iter().map(|entry| entry.read(folder));
        Ok(Some(Self {
            tables: read.collect::<Result<_, _>>()?,
            manifest,
            changed,
        }))
    }
}

/// Finds the files of a finished run, or of the finished points of a sweep, that have changed.
///
/// # Errors
/// [`ResultsError`] if a manifest, the sweep index or a file cannot be read.
pub fn changed_files(folder: &Path) -> Result<Vec<PathBuf>, ResultsError> {
    let points = match Sweep::read(folder)? {
        Some(sweep) => sweep.points,
        None => vec![SweepPoint::default()],
    };
    let mut all = Vec::new();
    for point in points {
        let inside = folder.join(&point.name);
        if let Some(manifest) = Manifest::read(&inside)? {
            let (_, changed) = manifest.damage(&inside)?;
            all.extend(changed.into_iter().map(|file| inside.join(file)));
        }
    }
    Ok(all)
}

/// Computes the BLAKE3 hash of a file; `None` if the file does not exist.
pub(crate) fn hash_of(path: &Path) -> Result<Option<String>, ResultsError> {
    let read = || -> std::io::Result<String> {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(regular::open(path)?)?;
        Ok(hasher.finalize().to_string())
    };
    match read() {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        other => other.map(Some).map_err(ResultsError::system(path, "read")),
    }
}

/// Reads a JSON file and checks its format number; `None` if the file does not exist.
fn read_json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, ResultsError> {
    let bytes = match regular::read_bytes(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        other => other.map_err(ResultsError::system(path, "read"))?,
    };
    // A file of another format may lack fields of this one, so its number is read first.
    let stamp: serde_json::Value = parse(path, &bytes)?;
    let format = stamp.get("format");
    if format.and_then(serde_json::Value::as_u64) != Some(FORMAT.into()) {
        return Err(ResultsError::Format {
            path: path.to_owned(),
            found: format.map_or("nothing".into(), ToString::to_string),
            expected: FORMAT,
        });
    }
    parse(path, &bytes).map(Some)
}

fn parse<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, ResultsError> {
    let mut source = serde_json::Deserializer::from_slice(bytes);
    serde_path_to_error::deserialize(&mut source).map_err(|error| {
        let key = error.path().to_string();
        let source = error.into_inner();
        ResultsError::Json {
            path: path.to_owned(),
            key,
            line: source.line(),
            source,
        }
    })
}

/// Deserializes a map of numbers in which `null` stands for NaN.
fn finite_or_null<'de, D: Deserializer<'de>>(source: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let read = BTreeMap::<String, Option<f64>>::deserialize(source)?;
    let number = |(name, value): (String, Option<f64>)| (name, value.unwrap_or(f64::NAN));
    Ok(read.into_iter().map(number).collect())
}

/// Deserializes a number; `null` stands for NaN.
fn null_is_nan<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(source)?.unwrap_or(f64::NAN))
}
