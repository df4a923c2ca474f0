//! What keeps a trial from being tried, and a command from succeeding.

use stosszahl_model::initial::PlacementError;
use stosszahl_model::snapshot::SnapshotError;

/// Why something could not be tried, or a command does not succeed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// An option or a number out of range.
    #[error("--{name} {value}: allowed is {allowed}")]
    BadNumber {
        /// Which.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No trial or scheme has this name.
    #[error("--{option} {found}: allowed are {}", allowed.join(", "))]
    Unknown {
        /// The option.
        option: &'static str,
        /// What was asked for.
        found: String,
        /// All names.
        allowed: Vec<&'static str>,
    },
    /// `--budget` is no time.
    #[error("--budget {found}: {source}; allowed is a time such as 90s, 5m or 1h")]
    Budget {
        /// What was found.
        found: String,
        /// Why it is none.
        source: humantime::DurationError,
    },
    /// A law, size or box that cannot be.
    #[error(transparent)]
    Invalid(#[from] stosszahl_model::Invalid),
    /// A start could not be made.
    #[error("no start: {0}")]
    NoStart(&'static str),
    /// The disks do not fit.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The event-driven engine refused what it must take, or cannot go on.
    #[error("the engine refused: {0}")]
    Exact(#[from] stosszahl_ed::EngineError),
    /// The Monte Carlo engine refused what it must take.
    #[error("the engine refused: {0}")]
    MonteCarlo(#[from] stosszahl_dsmc::EngineError),
    /// The engine without positions refused what it must take.
    #[error("the engine refused: {0}")]
    Homogeneous(#[from] stosszahl_dsmc::homogeneous::GasError),
    /// A measurement refused.
    #[error(transparent)]
    Measure(#[from] stosszahl_analysis::Error),
    /// Theory of a mixture has no answer.
    #[error(transparent)]
    Theory(#[from] stosszahl_analysis::theory::TheoryError),
    /// Nothing to average.
    #[error("no replicas")]
    NoReplicas,
    /// A checkpoint could not be written or read.
    #[error("checkpoint: {0}")]
    Checkpoint(#[from] postcard::Error),
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The table cannot be made.
    #[error("table: {0}")]
    Table(#[from] csv::Error),
    /// A page or table cannot be written.
    #[error(transparent)]
    Write(#[from] SnapshotError),
    /// The results folder cannot be made.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Which.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Something does not hold.
    #[error("{0}")]
    Failed(String),
}

impl Trouble {
    /// 2: the input was refused; 1: something failed.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::BadNumber { .. }
            | Self::Unknown { .. }
            | Self::Budget { .. }
            | Self::Placement(_)
            | Self::Homogeneous(_)
            | Self::Invalid(_)
            | Self::NoStart(_) => 2,
            _ => 1,
        }
    }
}
