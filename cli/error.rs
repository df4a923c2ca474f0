//! Errors of commands, and their exit codes.

use std::io;
use std::path::{Path, PathBuf};

use crate::BUNDLE;
use crate::case::CaseError;
use crate::report::ReportError;
use crate::reproduction::ReproduceError;
use crate::results::ResultsError;
use crate::study::RunError;
use crate::study::frontier::FrontierError;
use crate::terminal::{OUT_OF_TIME, STOPPED};

/// Error with which a command of the program ends.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// The case file or an override of its keys is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The run of a case failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The run reached its time limit, `--stop-after`.
    #[error("stopped by --stop-after")]
    OutOfTime,
    /// The report of a results folder cannot be built.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The frontier of a case cannot be measured.
    #[error(transparent)]
    Frontier(#[from] FrontierError),
    /// The reproduction of a paper failed.
    #[error(transparent)]
    Reproduce(ReproduceError),
    /// There is no bundled paper of the given name.
    #[error(
        "no bundled paper is called {0}, and there is no such file; `stosszahl reproduce` lists them"
    )]
    NoBundledPaper(String),
    /// The target error of a frontier is not a share between 0 and 1.
    #[error("--target-error {found}: allowed is a share such as 1% or 0.01, above 0 and below 1")]
    Target {
        /// Target error as typed.
        found: String,
    },
    /// There is no bundled case of the given name.
    #[error("no bundled case is called {0}{close}; `stosszahl cases` lists them", close = close_case(.0))]
    NoBundledCase(String),
    /// Parquet tables are requested, but the program was built without Parquet.
    #[error(
        "--tables parquet: this program was built without Parquet; allowed: csv, or, after `cargo install --path . --features parquet` \
         in a clone of stosszahl, parquet"
    )]
    NoParquet,
    /// The file to write exists already.
    #[error("{} exists; use --force to replace it, or another name", .0.display())]
    FileExists(PathBuf),
    /// The ending of a figure's file names no format, or another one than `--format`.
    #[error("--out {}: the file of a figure ends in .svg or .pdf, as --format says", path.display())]
    FigureEnding {
        /// Path of the figure's file as typed.
        path: PathBuf,
    },
    /// A file of results cannot be read or written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A folder cannot be created or written into.
    #[error("{}: cannot be written: {source}", path.display())]
    Folder {
        /// Path of the folder that cannot be created or written into.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Standard output cannot be written.
    #[error("standard output: {0}")]
    Output(#[from] io::Error),
}

/// Converts a failure of a part of a paper to one of that part.
impl From<ReproduceError> for CommandError {
    fn from(error: ReproduceError) -> Self {
        match error {
            ReproduceError::Case(error) => Self::Case(error),
            ReproduceError::Run(error) => Self::Run(error),
            ReproduceError::Results(error) => Self::Results(error),
            other => Self::Reproduce(other),
        }
    }
}

impl CommandError {
    /// Returns true if the command ended because of an interrupt or a time limit.
    pub(crate) fn is_interruption(&self) -> bool {
        self.exit_code() == STOPPED
    }

    /// Returns the exit code of the error: 2 for refused input, [`STOPPED`] for an interrupt, 1 for
    /// a failed run.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Run(error) if error.is_interruption() => STOPPED,
            Self::OutOfTime => OUT_OF_TIME,
            Self::Frontier(FrontierError::Interrupted) => STOPPED,
            Self::Run(RunError::Results(error)) | Self::Results(error) if !error.is_system() => 2,
            Self::Frontier(error) if error.is_refusal() => 2,
            Self::Case(_)
            | Self::Reproduce(ReproduceError::NoFigure { .. } | ReproduceError::Occupied { .. })
            | Self::Target { .. }
            | Self::NoBundledCase(_)
            | Self::NoBundledPaper(_)
            | Self::FileExists(_)
            | Self::NoParquet
            | Self::Folder { .. }
            | Self::FigureEnding { .. }
            | Self::Report(
                ReportError::NoResults { .. }
                | ReportError::NoFigures { .. }
                | ReportError::NoFigure { .. }
                | ReportError::PrintWidth { .. },
            ) => 2,
            Self::Run(error) if error.is_refusal() => 2,
            Self::Run(_)
            | Self::Report(_)
            | Self::Frontier(_)
            | Self::Reproduce(_)
            | Self::Results(_)
            | Self::Output(_) => 1,
        }
    }
}

/// Formats the bundled case with a similar name as a question; empty if none is similar.
fn close_case(given: &str) -> String {
    match BUNDLE.close_to(Path::new(given)) {
        Some(close) => format!(" (did you mean {close}?)"),
        None => String::new(),
    }
}
