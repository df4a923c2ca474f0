//! Why a part of a run ended early, here or in another process.

use serde::{Deserialize, Serialize};
use stosszahl_model::Failure;
use stosszahl_model::snapshot::SnapshotError;

use crate::control::Interrupted;
use crate::engines::BeginError;
use crate::plan::PlanError;
use crate::start::StartError;

/// Why a part of a run ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// The plan is impossible after all.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The start cannot be made.
    #[error(transparent)]
    Start(StartError),
    /// The engine cannot start.
    #[error(transparent)]
    Begin(BeginError),
    /// The engine cannot go on, as in inelastic collapse.
    #[error("{failure}")]
    Stopped {
        /// Why.
        failure: Failure,
        /// The gas at that moment as extended XYZ; empty where it is not known.
        state: String,
    },
    /// More collisions than the case allows.
    #[error("{collisions} collisions have reached engine.ed.collision_limit")]
    CollisionLimit {
        /// How many happened.
        collisions: u64,
    },
    /// A checkpoint cannot be written or read.
    #[error(transparent)]
    Checkpoint(#[from] SnapshotError),
    /// A process cannot write its part of a checkpoint.
    #[error("{0}")]
    Shards(Failure),
    /// A record of a measurement cannot be written or read.
    #[error("the record of a measurement: {0}")]
    Record(#[from] postcard::Error),
    /// A file cannot be written.
    #[error(transparent)]
    Results(#[from] stosszahl_results::ResultsError),
    /// The user asked to stop; checkpoints are written.
    #[error("stopped; continue with --resume")]
    Interrupted,
    /// It ended early in another process.
    #[error("{0}")]
    Elsewhere(Elsewhere),
}

/// Why a part ended early in another process: what a [`PartError`] says, in words that can be sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elsewhere {
    text: String,
    end: End,
    /// The gas at that moment as extended XYZ; empty where it is not known.
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
    /// What an error says.
    pub(crate) fn of(error: &PartError) -> Self {
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

    /// Any other reason.
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
    /// Whether the gas itself cannot go on, which says nothing of other replicas.
    pub fn is_of_gas(&self) -> bool {
        match self {
            Self::Stopped { .. } | Self::CollisionLimit { .. } => true,
            Self::Elsewhere(why) => why.end == End::OfGas,
            _ => false,
        }
    }

    /// Whether the case is to blame: it cannot be started.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Plan(_) => true,
            Self::Start(error) => error.is_refusal(),
            Self::Begin(error) => error.is_refusal(),
            Self::Elsewhere(why) => why.end == End::Refused,
            _ => false,
        }
    }

    /// Whether it was only asked to stop.
    pub fn is_interruption(&self) -> bool {
        match self {
            Self::Interrupted => true,
            Self::Elsewhere(why) => why.end == End::Interrupted,
            _ => false,
        }
    }

    /// The gas that cannot go on, as extended XYZ; empty where it is not known.
    pub fn state(&self) -> &str {
        match self {
            Self::Stopped { state, .. } => state,
            Self::Elsewhere(why) => &why.state,
            _ => "",
        }
    }
}
