//! Speed against error: what `stosszahl frontier` measures around a case, and what it recommends.
//!
//! | module | owns |
//! |---|---|
//! | `setting` | which numerical choices are varied, and in which sequences |
//! | `quantity` | what is measured of a run, and where theory is exact |
//! | `budget` | how a budget is shared out, by counts of work |
//! | `measure` | runs on all cores, each on one thread |
//! | `kept_runs` | the results folder, and the runs that are kept in it |
//! | `reference` | the ensemble of exact dynamics, kept on disk |
//! | `front` | bias, noise, cost, and the Pareto front |
//! | `orders` | whether errors fall as theory says |
//! | `recommend` | the cheapest setting for a target, tested on fresh seeds |
//! | `sweep` | all of it, one after the other, and the words |
//!
//! A setting is never measured against itself: the reference is theory where that is exact, and otherwise exact dynamics
//! with seeds of its own. Replicas are not swept, for n of them lower the noise of one by √n and leave its bias.

mod budget;
mod front;
mod kept_runs;
mod measure;
mod orders;
mod quantity;
mod recommend;
mod reference;
mod setting;
mod sweep;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use stosszahl_case::{CaseError, CaseFile};
use stosszahl_model::Interrupt;
use stosszahl_model::snapshot::SnapshotError;
use stosszahl_results::{Folder, ResultsError, Table};

use crate::crew::Crew;
use crate::plan::PlanError;

pub use measure::assist;
pub use quantity::Kind;

/// How a frontier is measured.
pub struct Options<'a> {
    /// What must be within the target; all kinds are measured.
    pub kinds: Vec<Kind>,
    /// Largest error that a recommended setting may have.
    pub target: f64,
    /// Core time for the whole sweep, planned at nominal speeds \[s\].
    pub budget: f64,
    /// Results folder; the runs that a frontier of the same case left there are not made again.
    pub folder: PathBuf,
    /// Folder of kept references.
    pub cache: PathBuf,
    /// Threads.
    pub threads: usize,
    /// Most times that a recommendation is tested on fresh seeds.
    pub tests: u64,
    /// Replaces a results folder, with the runs that are kept in it.
    pub force: bool,
    /// Told now and then which run has ended.
    pub tell: &'a (dyn Fn(&str) + Sync),
    /// Shares the results folder with other processes that measure the same frontier; one of which nothing is heard for so long is lost.
    pub join: Option<Duration>,
    /// Raised to stop within a second; the runs that are done are kept.
    pub interrupt: &'a Interrupt,
    /// What connects this process with others that make runs too: they call [`assist`] with the same case.
    pub crew: Option<&'a dyn Crew>,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Frontier {
    /// Title of the case.
    pub title: String,
    /// Which engine keeps the target at the least cost.
    pub headline: String,
    /// What is recommended of each engine, and the time that it all took.
    pub conclusions: Vec<String>,
    /// What was measured against what.
    pub provenance: String,
    /// Settings that were not measured, each with the reason.
    pub left_out: Vec<String>,
    /// The largest error of each kind against core time, with its figure: single runs, and the front with replicas.
    pub figure: Table,
    /// What a page lists.
    pub lists: Vec<List>,
    /// The results folder, which no other process writes into until this is dropped: the page is to be written before.
    pub held: Arc<Folder>,
    /// Whether this process is to write the page: one of those that share the folder.
    pub is_reporter: bool,
}

/// A table in words.
#[derive(Clone, Debug)]
pub struct List {
    /// What it shows.
    pub title: String,
    /// Its columns: the name, and whether it holds words.
    pub columns: &'static [(&'static str, bool)],
    /// Its rows.
    pub rows: Vec<Vec<String>>,
}

/// Why a frontier cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrontierError {
    /// The case is refused.
    #[error(transparent)]
    Invalid(#[from] CaseError),
    /// The case cannot be swept.
    #[error("{found}; a frontier needs {expected}")]
    Case {
        /// What the case has.
        found: String,
        /// What is needed.
        expected: &'static str,
    },
    /// A system size cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// Another process cannot do its part.
    #[error("{0}")]
    Crew(String),
    /// The kept ensemble or the journal of kept runs is not usable.
    #[error("{0}; remove the file to make its runs anew")]
    Kept(#[source] SnapshotError),
    /// Runs of the reference, or of a recommendation, failed.
    #[error("{what}: {reason}")]
    Runs {
        /// What cannot be had.
        what: &'static str,
        /// Why.
        reason: String,
    },
    /// A folder cannot be made.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It was asked to stop.
    #[error("stopped; the same command goes on with the runs that are kept")]
    Interrupted,
    /// A file cannot be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The kept ensemble cannot be written.
    #[error(transparent)]
    Write(#[from] SnapshotError),
}

impl FrontierError {
    /// Whether what was asked for is at fault, and not the system or a run.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Invalid(_) | Self::Case { .. } | Self::Plan(_) | Self::Kept(_) => true,
            Self::Results(error) => !error.is_system(),
            _ => false,
        }
    }
}

/// Measures the settings around a case, tests what it recommends, and writes `frontier.csv`, `orders.csv` and
/// `recommendation.md`. Numbers are the same for the same case, seed and budget, but for timings and what follows from them.
///
/// # Errors
/// [`FrontierError`] if the case is refused, the reference cannot be had, or a file cannot be written.
pub fn frontier(file: &CaseFile, options: &Options<'_>) -> Result<Frontier, FrontierError> {
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
