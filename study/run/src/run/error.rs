//! Errors that end a run early, with its case, folder, memory or a replica.

use stosszahl_case::CaseError;
use stosszahl_model::snapshot::SnapshotError;
use stosszahl_results::ResultsError;

use crate::engine_run::PartError;

/// Largest number of threads of a run.
pub(crate) const MOST_THREADS: usize = 1024;

/// Error that ends a run early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The case cannot be run.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The results folder cannot be used.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The journal of finished replicas cannot be written or read.
    #[error(transparent)]
    Journal(#[from] SnapshotError),
    /// The number of threads is out of range.
    #[error("{found} threads; allowed: from 1 to {MOST_THREADS}")]
    Threads {
        /// Requested number of threads.
        found: usize,
    },
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// The pilot run of `[accuracy]` failed.
    #[error("pilot of accuracy.target: {0}")]
    Pilot(#[source] PartError),
    /// The run needs more memory than is available.
    #[error(
        "the run needs about {:.1} GiB and {:.1} GiB are free; fewer particles, simulators or threads need less; \
         --ignore-memory-limit runs it all the same",
        needed / 1_073_741_824.0, available / 1_073_741_824.0
    )]
    Memory {
        /// Estimated memory of the whole process \[bytes\].
        needed: f64,
        /// Available memory \[bytes\].
        available: f64,
    },
    /// Replicas are missing, or a part of a run cannot be read; in words.
    #[error("{0}")]
    Incomplete(String),
    /// The processes that share a run cannot continue together; in words.
    #[error("{0}")]
    Processes(String),
    /// No gas of the case can be decomposed over several processes.
    #[error(
        "no gas of this case can be held by several processes; allowed: Monte Carlo engines in cells, [engine.dsmc-...] with a \
         [box]. Several processes share the replicas of any case with `stosszahl run --join`"
    )]
    NothingToDecompose,
    /// A replica failed, alone or with all others.
    #[error("replica {replica}, {part}: {source}")]
    Replica {
        /// Number of the failed replica, from 0.
        replica: u64,
        /// Name of the failed part: `start`, or the engine.
        part: String,
        /// Error of the failed part.
        source: Box<PartError>,
    },
}

impl RunError {
    /// Returns true if the run was only interrupted.
    pub fn is_interruption(&self) -> bool {
        let source = match self {
            Self::Replica { source, .. } => source,
            Self::Pilot(source) => source,
            _ => return false,
        };
        source.is_interruption()
    }

    /// Returns true if the case cannot be started as it is.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Case(_)
            | Self::Threads { .. }
            | Self::Memory { .. }
            | Self::Incomplete(_)
            | Self::NothingToDecompose => true,
            Self::Replica { source, .. } => source.is_refusal(),
            Self::Pilot(source) => source.is_refusal(),
            _ => false,
        }
    }

    /// Returns true if the run ended because the gas itself cannot continue.
    pub(crate) fn is_of_gas(&self) -> bool {
        matches!(self, Self::Replica { source, .. } if source.is_of_gas())
    }
}
