//! The results folder: whether it may be written into, and what in it belongs to the program.
//!
//! A folder is the program's own if it has a `run.json` of it, which is written before anything else and says which
//! runs the folder is for. Only files that the program writes are ever removed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::{Deserialize, Serialize};
use stosszahl_model::snapshot::{Fingerprint, SnapshotError, write_whole};

use crate::flow::tables::{BoundaryRow, FieldRow, ProfileRow, SeriesRow};
use crate::homogeneous::tables::{
    CheckRow, ClusterRow, GasRow, SizeRow, SpeciesRow, TimeAveragedRow,
};
use crate::manifest::{MANIFEST_FILE, SWEEP_FILE};
use crate::report::REPORT_FILE;
use crate::run::{CHECKPOINTS, SNAPSHOTS};
use crate::tables::{
    ComparisonRow, DisplacementRow, DissipationRow, EnergyRow, ErrorBudgetRow, ImpactParameterRow,
    ImpactSummaryRow, PairCorrelationRow, PairImpactRow, PartialTemperatureRow, ReplicaRow, Row,
    SteadyRow, StructureFactorRow,
};

/// Marks a results folder.
const RUN_FILE: &str = "run.json";

/// Every file that a run of any kind writes at the top of its folder.
const FILES: &[&str] = &[
    EnergyRow::FILE,
    ComparisonRow::FILE,
    ImpactParameterRow::FILE,
    ImpactSummaryRow::FILE,
    StructureFactorRow::FILE,
    PairCorrelationRow::FILE,
    DissipationRow::FILE,
    SteadyRow::FILE,
    DisplacementRow::FILE,
    ErrorBudgetRow::FILE,
    PartialTemperatureRow::FILE,
    PairImpactRow::FILE,
    ReplicaRow::FILE,
    GasRow::FILE,
    SpeciesRow::FILE,
    TimeAveragedRow::FILE,
    ClusterRow::FILE,
    SizeRow::FILE,
    CheckRow::FILE,
    SeriesRow::FILE,
    FieldRow::FILE,
    ProfileRow::FILE,
    BoundaryRow::FILE,
    MANIFEST_FILE,
    REPORT_FILE,
];

/// Why a folder cannot take the results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// There are results already.
    #[error("{} exists; use --resume to continue it, --force to replace it, or --out for another folder", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("{} is no results folder (it has no run.json of this program) and is not replaced; use --out for another folder", path.display())]
    NotResults {
        /// The folder.
        path: PathBuf,
    },
    /// The case or start file is inside.
    #[error("{} lies in the folder {} that would be replaced", input.display(), path.display())]
    InputInside {
        /// The folder.
        path: PathBuf,
        /// The file.
        input: PathBuf,
    },
    /// There is nothing to continue.
    #[error("{}: nothing to resume here; expected a results folder of this case", path.display())]
    NothingToResume {
        /// The folder.
        path: PathBuf,
    },
    /// The folder belongs to another case.
    #[error("{} belongs to another run (case, overrides, seed or version differ); use --force to replace it, or --out for another folder", path.display())]
    Foreign {
        /// The folder.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: {source}", path.display())]
    System {
        /// Where.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// The mark cannot be written.
    #[error(transparent)]
    Mark(#[from] SnapshotError),
}

impl ResultsError {
    /// Whether the system is at fault, and not what was asked.
    pub fn is_system(&self) -> bool {
        matches!(self, Self::System { .. } | Self::Mark(_))
    }
}

/// The mark of a results folder.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Mark {
    program: String,
    version: String,
    /// Fingerprints of the runs by subfolder; one with an empty name without a sweep.
    runs: BTreeMap<String, String>,
}

impl Mark {
    fn new(runs: &[(String, Fingerprint)]) -> Self {
        let hex = |fingerprint: &Fingerprint| {
            fingerprint.iter().fold(String::new(), |mut text, byte| {
                // Writing to a string cannot fail.
                let _ = write!(text, "{byte:02x}");
                text
            })
        };
        Self {
            program: "stosszahl".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            runs: runs
                .iter()
                .map(|(name, run)| (name.clone(), hex(run)))
                .collect(),
        }
    }

    fn read(folder: &Path) -> Option<Self> {
        let text = fs::read(folder.join(RUN_FILE)).ok()?;
        let mark: Self = serde_json::from_slice(&text).ok()?;
        (mark.program == "stosszahl").then_some(mark)
    }
}

/// What to do with a folder that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Refuse it.
    Refuse,
    /// Continue it.
    Resume,
    /// Replace it.
    Replace,
}

/// Makes the results folder of some runs, or finds the one to continue. `inputs` are files that must survive.
///
/// # Errors
/// [`ResultsError`]; nothing is changed then, unless the system fails half-way.
pub fn open(
    folder: &Path,
    existing: Existing,
    inputs: &[&Path],
    runs: &[(String, Fingerprint)],
) -> Result<(), ResultsError> {
    let path = folder.to_owned();
    let mark = Mark::new(runs);
    let known = Mark::read(folder);
    if existing == Existing::Resume {
        return match known {
            Some(known) if known == mark => Ok(()),
            Some(_) => Err(ResultsError::Foreign { path }),
            None => Err(ResultsError::NothingToResume { path }),
        };
    }
    let empty = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    if folder.exists() && !empty {
        let Some(known) = known else {
            return Err(ResultsError::NotResults { path });
        };
        if existing == Existing::Refuse {
            return Err(ResultsError::Exists { path });
        }
        if let Some(input) = inputs.iter().find(|input| is_inside(input, folder)) {
            return Err(ResultsError::InputInside {
                path,
                input: input.to_path_buf(),
            });
        }
        clear(folder, &known)?;
    }
    fs::create_dir_all(folder).map_err(|source| ResultsError::System { path, source })?;
    let bytes = serde_json::to_vec_pretty(&mark).map_err(|error| ResultsError::System {
        path: folder.join(RUN_FILE),
        source: error.into(),
    })?;
    Ok(write_whole(&folder.join(RUN_FILE), &bytes)?)
}

fn is_inside(file: &Path, folder: &Path) -> bool {
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => file.starts_with(folder),
        _ => false,
    }
}

/// Removes what the program wrote, and the folders of it that are empty then.
fn clear(folder: &Path, mark: &Mark) -> Result<(), ResultsError> {
    for name in mark.runs.keys() {
        // Names of sweep points are single components.
        if Path::new(name).components().count() > 1 || name == ".." {
            continue;
        }
        let place = folder.join(name);
        for file in FILES {
            remove(&place.join(file))?;
        }
        remove_all(&place.join(SNAPSHOTS), "xyz")?;
        remove_checkpoints(&place)?;
        if !name.is_empty() {
            // A folder with something of somebody else's in it stays.
            let _ = fs::remove_dir(&place);
        }
    }
    for file in [SWEEP_FILE, REPORT_FILE, RUN_FILE] {
        remove(&folder.join(file))?;
    }
    Ok(())
}

fn remove(path: &Path) -> Result<(), ResultsError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => Err(ResultsError::System {
            path: path.to_owned(),
            source,
        }),
        _ => Ok(()),
    }
}

/// Removes the files with an ending, and those half-written, from a folder, and the folder if it is empty then.
fn remove_all(folder: &Path, ending: &str) -> Result<(), ResultsError> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(());
    };
    for entry in entries.flatten() {
        let path = entry.path();
        let ours = path
            .extension()
            .is_some_and(|known| known == ending || known == "partial");
        if ours {
            remove(&path)?;
        }
    }
    let _ = fs::remove_dir(folder);
    Ok(())
}

/// Removes the checkpoints of a finished run.
///
/// # Errors
/// [`ResultsError::System`] names what could not be removed.
pub fn remove_checkpoints(place: &Path) -> Result<(), ResultsError> {
    remove_all(&place.join(CHECKPOINTS), "snapshot")
}

/// Whether a run is finished but for its report; `files` are those that a finished run of its kind has.
pub fn is_complete(place: &Path, files: &[&str]) -> bool {
    files.iter().all(|file| place.join(file).exists())
}
