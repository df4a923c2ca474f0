//! Errors that end a part of a run early, here or in another process.

use serde::{Deserialize, Serialize};
use stosszahl_model::Failure;
use stosszahl_model::snapshot::SnapshotError;

use crate::control::Interrupted;
use crate::engines::BeginError;
use crate::plan::PlanError;
use crate::start::error::StartError;

/// Error that ends a part of a run early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// Plan that turns out to be impossible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Start that cannot be made.
    #[error(transparent)]
    Start(StartError),
    /// Engine that cannot start.
    #[error(transparent)]
    Begin(BeginError),
    /// Engine that cannot continue, as in inelastic collapse.
    #[error("{failure}")]
    Stopped {
        /// Failure of the engine.
        failure: Failure,
        /// Gas at that moment as extended XYZ; empty where it is not known.
        state: String,
    },
    /// Number of collisions above the limit of the case.
    #[error("{collisions} collisions have reached engine.ed.collision_limit")]
    CollisionLimit {
        /// Number of collisions so far.
        collisions: u64,
    },
    /// Checkpoint that cannot be written or read.
    #[error(transparent)]
    Checkpoint(#[from] SnapshotError),
    /// Checkpoint shard that a process cannot write.
    #[error("{0}")]
    Shards(Failure),
    /// Measurement record that cannot be written or read.
    #[error("the record of a measurement: {0}")]
    Record(#[from] postcard::Error),
    /// File that cannot be written.
    #[error(transparent)]
    Results(#[from] stosszahl_results::ResultsError),
    /// Interruption by the user; checkpoints are written.
    #[error("stopped; continue with --resume")]
    Interrupted,
    /// Early end in another process.
    #[error("{0}")]
    Elsewhere(Elsewhere),
}

/// Early end of a part in another process: a [`PartError`] in a form that can be sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elsewhere {
    text: String,
    end: End,
    /// Gas at that moment as extended XYZ; empty where it is not known.
    state: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum End {
    OfGas,
    Interrupted,
    Refused,
    Other,
}

impl Elsewhere {
    /// Converts an error to its message and kind.
    pub(crate) fn from_error(error: &PartError) -> Self {
        let end = if error.is_of_gas() {
            End::OfGas
        } else if error.is_interruption() {
            End::Interrupted
        } else if error.is_refusal() {
            End::Refused
        } else {
            End::Other
        };
        Self {
            text: error.to_string(),
            end,
            state: error.state().to_owned(),
        }
    }

    /// Creates an early end for any other reason.
    pub(crate) fn other(text: String) -> Self {
        Self {
            text,
            end: End::Other,
            state: String::new(),
        }
    }
}

impl std::fmt::Display for Elsewhere {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str(&self.text)
    }
}

impl From<Failure> for PartError {
    fn from(failure: Failure) -> Self {
        let state = String::new();
        Self::Stopped { failure, state }
    }
}

impl From<StartError> for PartError {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Interrupted => Self::Interrupted,
            other => Self::Start(other),
        }
    }
}

impl From<BeginError> for PartError {
    fn from(error: BeginError) -> Self {
        match error {
            BeginError::Start(StartError::Interrupted) => Self::Interrupted,
            other => Self::Begin(other),
        }
    }
}

impl From<Interrupted> for PartError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

impl PartError {
    /// Returns true if the gas itself cannot continue, which does not affect other replicas.
    pub fn is_of_gas(&self) -> bool {
        match self {
            Self::Stopped { .. } | Self::CollisionLimit { .. } => true,
            Self::Elsewhere(why) => why.end == End::OfGas,
            _ => false,
        }
    }

    /// Returns true if the case is at fault: it cannot be started.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Plan(_) => true,
            Self::Start(error) => error.is_refusal(),
            Self::Begin(error) => error.is_refusal(),
            Self::Elsewhere(why) => why.end == End::Refused,
            _ => false,
        }
    }

    /// Returns true if the part only stopped because it was asked to.
    pub fn is_interruption(&self) -> bool {
        match self {
            Self::Interrupted => true,
            Self::Elsewhere(why) => why.end == End::Interrupted,
            _ => false,
        }
    }

    /// Gas that cannot continue, as extended XYZ; empty where it is not known.
    pub fn state(&self) -> &str {
        match self {
            Self::Stopped { state, .. } => state,
            Self::Elsewhere(why) => &why.state,
            _ => "",
        }
    }
}
