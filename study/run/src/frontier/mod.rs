//! Frontier of error against cost: settings of all engines around a case are measured, and the
//! cheapest for a target error is recommended.
//!
//! | module | owns |
//! |---|---|
//! | `setting` | numerical choices that are varied, and their sequences |
//! | `quantity` | quantities of a run, and where theory is exact |
//! | `budget` | how a budget is shared out, by counts of work |
//! | `measure` | runs on all cores, each on one thread |
//! | `kept_runs` | the results folder, and the runs that are kept in it |
//! | `reference` | the ensemble of exact dynamics, kept on disk |
//! | `front` | bias, noise, cost, and the Pareto front |
//! | `orders` | whether errors fall as theory says |
//! | `recommend` | the cheapest setting for a target, tested on fresh seeds |
//! | `pilot` | short runs that choose the resolution of a case for `[accuracy] target` |
//! | `sweep` | all of it, one after the other, and the words |
//!
//! A setting is never measured against itself: the reference is theory where that is exact, and
//! otherwise exact dynamics with seeds of its own. Replicas are not swept, for n of them lower the
//! noise of one by √n and leave its bias.

mod budget;
mod front;
mod kept_runs;
mod measure;
mod orders;
mod pilot;
mod quantity;
mod recommend;
mod reference;
mod run_record;
mod setting;
mod sweep;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use stosszahl_case::{CaseError, CaseFile};
use stosszahl_model::Interrupt;
use stosszahl_model::snapshot::SnapshotError;
use stosszahl_results::{Folder, ResultsError, Table};

use crate::plan::PlanError;

pub(crate) use pilot::choose_resolution;
pub use quantity::QuantityKind;

/// Options of the measurement of a frontier.
pub struct FrontierOptions<'a> {
    /// Kinds of quantities whose error must be within the target; all kinds are measured.
    pub kinds: Vec<QuantityKind>,
    /// Largest error that a recommended setting may have, as a fraction of the unit of the
    /// quantity: mostly of its reference value.
    pub target: f64,
    /// CPU time for the whole frontier, planned at nominal speeds \[s\].
    pub budget: f64,
    /// Results folder of the frontier; runs that an earlier frontier of the same case stored there
    /// are reused.
    pub folder: PathBuf,
    /// Folder in which reference ensembles are stored for later frontiers.
    pub cache: PathBuf,
    /// Number of threads of the measurement; each runs one replica at a time.
    pub threads: usize,
    /// Largest number of tests of a recommendation on fresh seeds.
    pub tests: u64,
    /// True to replace an existing results folder with the runs stored in it.
    pub force: bool,
    /// Callback for progress messages, with the run that has ended.
    pub tell: &'a (dyn Fn(&str) + Sync),
    /// Time without heartbeat after which a process is lost; `None` if the folder is not shared
    /// with other processes.
    pub join: Option<Duration>,
    /// Interrupt that stops the measurement within a second; finished runs are kept.
    pub interrupt: &'a Interrupt,
}

/// Results of a frontier: recommendations as sentences, a figure, and lists for the page.
#[derive(Clone, Debug)]
pub struct Frontier {
    /// Title of the measured case.
    pub title: String,
    /// Sentence on the engine that meets the target at the least cost.
    pub headline: String,
    /// Recommendations as sentences, one for each class of engines, and the CPU time of the
    /// measurement.
    pub conclusions: Vec<String>,
    /// Description of the measurement and its reference, in words.
    pub provenance: String,
    /// Settings that were not measured, each with the reason.
    pub left_out: Vec<String>,
    /// Table of the largest error of each kind of quantity against CPU time, with its figure:
    /// single runs, and the Pareto front over all numbers of replicas.
    pub figure: Table,
    /// Lists for the report page.
    pub lists: Vec<WordTable>,
    /// Results folder, locked by this process until the value is dropped. The page must be written
    /// before.
    pub held: Arc<Folder>,
    /// True if this process, of all that share the folder, has to write the page.
    pub is_reporter: bool,
}

/// List of formatted rows that the command `frontier` prints and its report shows.
#[derive(Clone, Debug)]
pub struct WordTable {
    /// Title of the list.
    pub title: String,
    /// Columns of the list: name, and true if the column holds words.
    pub columns: &'static [(&'static str, bool)],
    /// Rows of the list, formatted.
    pub rows: Vec<Vec<String>>,
}

/// Error with which a frontier cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrontierError {
    /// The case file is invalid.
    #[error(transparent)]
    Invalid(#[from] CaseError),
    /// A frontier cannot be measured for this kind of case.
    #[error("{found}; a frontier needs {expected}")]
    Case {
        /// Property of the case that prevents it.
        found: String,
        /// Property that the case must have.
        expected: &'static str,
    },
    /// The case cannot be planned with another system size.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// The stored reference ensemble or the journal of runs is damaged or of another case.
    #[error("{0}; remove the file to make its runs anew")]
    Kept(#[source] SnapshotError),
    /// Runs of the reference, or of a recommendation, failed.
    #[error("{what}: {reason}")]
    Runs {
        /// Result that is missing because its runs failed, in words.
        what: &'static str,
        /// Reason why the runs failed.
        reason: String,
    },
    /// A folder cannot be created.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Path of the folder that cannot be created.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The measurement was interrupted.
    #[error("stopped; the same command goes on with the runs that are kept")]
    Interrupted,
    /// A file of the results folder cannot be written or read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The reference ensemble or the journal cannot be written.
    #[error(transparent)]
    Write(#[from] SnapshotError),
}

impl FrontierError {
    /// Returns true if the input is invalid; false for a failure of the system or of a run.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Invalid(_) | Self::Case { .. } | Self::Plan(_) | Self::Kept(_) => true,
            Self::Results(error) => !error.is_system(),
            _ => false,
        }
    }
}

/// Measures the settings around a case, tests what it recommends, and writes `frontier.csv`,
/// `orders.csv` and `recommendation.md`. Results depend only on case, seed and budget, except for
/// timings and what follows from them.
///
/// # Errors
/// [`FrontierError`] if the case is refused, the reference cannot be had, or a file cannot be
/// written.
pub fn frontier(file: &CaseFile, options: &FrontierOptions<'_>) -> Result<Frontier, FrontierError> {
    let (found, tables) = sweep::sweep(file, options)?;
    if !found.is_reporter {
        return Ok(found);
    }
    for table in &tables {
        found.held.write(&table.file(), &table.to_csv()?)?;
    }
    let words = sweep::markdown(&found);
    found.held.write("recommendation.md", words.as_bytes())?;
    if options.join.is_some() {
        found.held.settle_claims()?;
    }
    Ok(found)
}
