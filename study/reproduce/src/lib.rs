//! Reproduction of papers: the cases of their figures, and a verdict on each of their claims.
//!
//! A paper is data ([`stosszahl_case::paper`]): runs of cases, figures, and claims. Each claim
//! names a number in a result table, and the paper's value or bound.
//!
//! - [`Reproduction::new`] reads the cases and finds every run, point, table and column in advance.
//! - [`Reproduction::run_cases`] runs all unfinished cases, one folder for each run.
//! - [`Reproduction::judge`] reads the numbers and compares them with the claims by
//!   [`stosszahl_study::judge`]. All claims of a paper share its family-wise error rate
//!   (Bonferroni), even if only one figure is requested.
//! - [`Reproduction::write`] writes `claims.csv` and the HTML page.
//!
//! | module  | content                                           |
//! |---------|---------------------------------------------------|
//! | `plan`  | selection and checks of runs and claims           |
//! | `cases` | cases of a paper with the keys that the paper sets |
//! | `find`  | lookup of numbers in the tables of finished runs  |
//! | `folder`| output folder of a paper                          |
//! | `judged`| claims with their verdicts, as table and page     |

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

/// Reasons why a paper cannot be reproduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// Error of an invalid paper file, or of an invalid case file of the paper.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// Error of a requested figure that the paper does not have.
    #[error("--figure {found}: the figures of this paper are {}", allowed.join(", "))]
    NoFigure {
        /// Name of the figure that was requested.
        found: String,
        /// Names of all figures of the paper.
        allowed: Vec<String>,
    },
    /// Error of an output folder that holds something other than results of this paper.
    #[error("{}: {found}; use --out for another folder", path.display())]
    Occupied {
        /// Path of the occupied output folder.
        path: PathBuf,
        /// Description of what the occupied output folder holds.
        found: String,
    },
    /// Error of a simulation run that failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Error of a results folder that cannot be read or written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// Error of an HTML report that cannot be built.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// System error for the output folder of the paper.
    #[error("{}: {source}", path.display())]
    System {
        /// Path of the paper's output folder that the system cannot read or write.
        path: PathBuf,
        /// Error that the operating system reported for the output folder.
        source: io::Error,
    },
}
