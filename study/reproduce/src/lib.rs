//! Reproduction of papers: the cases of their figures, and a verdict on each of their claims.
//!
//! A paper is data ([`stosszahl_case::paper`]): runs of cases, figures, and claims that each name
//! one number of a table and what the paper says of it. [`Reproduction::new`] reads the cases and
//! finds every run, point, table and column before anything is run. [`Reproduction::run`] runs what
//! is not finished, one folder for each run. [`Reproduction::judge`] looks the numbers up and lets
//! the one judge of [`stosszahl_study::judge`] speak; all claims of a paper share its chance of a
//! false alarm (Bonferroni), also where only one figure is asked for. [`Reproduction::write`]
//! leaves `claims.csv` and a page.
//!
//! | module  | owns                                          |
//! |---------|-----------------------------------------------|
//! | `plan`  | which runs and claims there are, and their checks |
//! | `cases` | the cases of a paper, with what it sets     |
//! | `find`  | numbers in the tables of finished runs        |
//! | `folder`| the folder of a paper                         |
//! | `judged`| claims with their verdicts, as table and page |

mod cases;
mod find;
mod folder;
mod judged;
mod plan;

use std::io;
use std::path::PathBuf;

use stosszahl_case::CaseError;
use stosszahl_report::ReportError;
use stosszahl_results::ResultsError;
use stosszahl_study::RunError;

pub use judged::{Judged, Outcome};
pub use plan::{Demand, FigureOutline, Reproduction};

/// Reason why a paper could not be reproduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// The paper or one of its cases is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The paper has no such figure.
    #[error("--figure {found}: the figures of this paper are {}", allowed.join(", "))]
    NoFigure {
        /// Name requested.
        found: String,
        /// Names of the figures of the paper.
        allowed: Vec<String>,
    },
    /// The folder holds something else.
    #[error("{}: {found}; use --out for another folder", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
        /// Content found there.
        found: String,
    },
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A results folder cannot be read or written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A page cannot be built.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The folder of the paper cannot be used.
    #[error("{}: {source}", path.display())]
    System {
        /// The folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}
