//! Reproduction of papers: the cases of their figures, and a verdict on each of their claims.
//!
//! A paper is data ([`stosszahl_case::paper`]): runs of cases, figures, and claims. Each claim
//! names a number of a table, and the paper's value or bound.
//!
//! - [`Reproduction::new`] reads the cases and finds every run, point, table and column in advance.
//! - [`Reproduction::run_cases`] runs all unfinished cases, one folder for each run.
//! - [`Reproduction::judge`] reads the numbers and judges them by [`stosszahl_study::judge`]. All
//!   claims of a paper share its chance of a false alarm (Bonferroni), also where only one figure
//!   is requested.
//! - [`Reproduction::write`] writes `claims.csv` and a page.
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
mod number_location;
mod plan;

use std::io;
use std::path::PathBuf;

use stosszahl_case::CaseError;
use stosszahl_report::ReportError;
use stosszahl_results::ResultsError;
use stosszahl_study::RunError;

pub use judged::{ClaimOutcome, Judged};
pub use plan::{FigureOutline, ReproduceOptions, Reproduction};

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
        /// Path of the folder.
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
        /// Path of the folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}
