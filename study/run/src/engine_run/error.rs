//! Errors that end one part of a run early, in this or in another process.

use serde::{Deserialize, Serialize};
use stosszahl_model::Failure;
use stosszahl_model::snapshot::SnapshotError;

use crate::control::Interrupted;
use crate::engines::BeginError;
use crate::plan::PlanError;
use crate::start::error::StartError;

/// Error that ends a part of a run early: the start or one engine of a replica.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// The plan of the case turns out to be impossible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The initial state cannot be created.
    #[error(transparent)]
    Start(StartError),
    /// The engine cannot start.
    #[error(transparent)]
    Begin(BeginError),
    /// The engine cannot continue, as in inelastic collapse.
    #[error("{failure}")]
    Stopped {
        /// Failure reported by the engine.
        failure: Failure,
        /// State of the gas when it stopped, as extended XYZ; empty if unknown.
        state: String,
    },
    /// The number of collisions exceeds the limit of the case.
    #[error("{collisions} collisions have reached engine.ed.collision_limit")]
    CollisionLimit {
        /// Number of collisions so far.
        collisions: u64,
    },
    /// A checkpoint cannot be written or read.
    #[error(transparent)]
    Checkpoint(#[from] SnapshotError),
    /// A process cannot write its shard of a checkpoint.
    #[error("{0}")]
    Shards(Failure),
    /// The record of a measurement cannot be serialized or read.
    #[error("the record of a measurement: {0}")]
    Record(#[from] postcard::Error),
    /// A file of the results folder cannot be written.
    #[error(transparent)]
    Results(#[from] stosszahl_results::ResultsError),
    /// The user has interrupted the run; checkpoints are written.
    #[error("stopped; continue with --resume")]
    Interrupted,
    /// The part has ended early in another process.
    #[error("{0}")]
    Elsewhere(Elsewhere),
}

/// Early end of a part of a run in another process: a [`PartError`] in a form that can be sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elsewhere {
    text: String,
    end: End,
    /// State of the gas when it stopped, as extended XYZ; empty if unknown.
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
    /// Converts an error to its message and kind, so that it can be sent.
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

    /// Creates the error of another process from a message alone.
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
    /// Returns true if the gas itself cannot continue. Other replicas are then not affected.
    pub fn is_of_gas(&self) -> bool {
        match self {
            Self::Stopped { .. } | Self::CollisionLimit { .. } => true,
            Self::Elsewhere(why) => why.end == End::OfGas,
            _ => false,
        }
    }

    /// Returns true if the case cannot be started as it is.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Plan(_) => true,
            Self::Start(error) => error.is_refusal(),
            Self::Begin(error) => error.is_refusal(),
            Self::Elsewhere(why) => why.end == End::Refused,
            _ => false,
        }
    }

    /// Returns true if the part has only been interrupted.
    pub fn is_interruption(&self) -> bool {
        match self {
            Self::Interrupted => true,
            Self::Elsewhere(why) => why.end == End::Interrupted,
            _ => false,
        }
    }

    /// Returns the state of a gas that cannot continue, as extended XYZ; empty if unknown.
    pub fn state(&self) -> &str {
        match self {
            Self::Stopped { state, .. } => state,
            Self::Elsewhere(why) => &why.state,
            _ => "",
        }
    }
}
