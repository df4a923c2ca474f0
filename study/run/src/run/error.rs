//! Errors that end a run early.

use stosszahl_case::CaseError;
use stosszahl_model::snapshot::SnapshotError;
use stosszahl_results::ResultsError;

use crate::follow::PartError;

/// Largest number of threads of a run.
pub(crate) const MOST_THREADS: usize = 1024;

/// Error that ends a run early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Case that cannot be run.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// Error of the results folder.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// Journal that cannot be written or read.
    #[error(transparent)]
    Journal(#[from] SnapshotError),
    /// Number of threads out of range.
    #[error("{found} threads; allowed: from 1 to {MOST_THREADS}")]
    Threads {
        /// Requested number of threads.
        found: usize,
    },
    /// Threads that cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// Failed pilot run of `[accuracy]`.
    #[error("pilot of accuracy.target: {0}")]
    Pilot(#[source] PartError),
    /// Memory above the limit.
    #[error(
        "the run needs about {:.1} GiB and {:.1} GiB are free; fewer particles, simulators or threads need less; \
         --ignore-memory-limit runs it all the same",
        needed / 1_073_741_824.0, available / 1_073_741_824.0
    )]
    Memory {
        /// Estimated memory of the whole process \[bytes\].
        needed: f64,
        /// Free memory \[bytes\].
        available: f64,
    },
    /// Missing replicas, or a part of a run that cannot be read.
    #[error("{0}")]
    Incomplete(String),
    /// The processes that share a run cannot continue together.
    #[error("{0}")]
    Processes(String),
    /// No gas of the case can be held by several processes.
    #[error(
        "no gas of this case can be held by several processes; allowed: Monte Carlo engines in cells, [engine.dsmc-...] with a \
         [box]. Several processes share the replicas of any case with `stosszahl run --join`"
    )]
    NothingToDecompose,
    /// One replica failed, or all of them.
    #[error("replica {replica}, {part}: {source}")]
    Replica {
        /// Number of the replica, from 0.
        replica: u64,
        /// Name of the part: `start`, or the engine.
        part: String,
        /// Error of the part.
        source: Box<PartError>,
    },
}

impl RunError {
    /// Returns true if the run only stopped because it was asked to.
    pub fn is_interruption(&self) -> bool {
        let source = match self {
            Self::Replica { source, .. } => source,
            Self::Pilot(source) => source,
            _ => return false,
        };
        source.is_interruption()
    }

    /// Returns true if the case is at fault and cannot be started.
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

    /// Returns true if the gas itself cannot continue.
    pub(crate) fn is_of_gas(&self) -> bool {
        matches!(self, Self::Replica { source, .. } if source.is_of_gas())
    }
}
