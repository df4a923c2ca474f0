//! Errors with which the initial state of a replica cannot be created.

use stosszahl_model::Failure;
use stosszahl_model::initial::PlacementError;

use crate::plan::{CasePlan, PlanError};

/// Error of a particle for which no free position is found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "particle {particle} of {count} finds no place in {trials} trials; fewer or smaller particles, or a larger box, are needed \
     (random addition jams near a packing fraction of 0.5 in the plane and 0.35 in space)"
)]
pub struct PlacementFailed {
    /// Index of the particle that finds no position.
    pub particle: usize,
    /// Number of particles to place.
    pub count: usize,
    /// Number of random positions tried.
    pub trials: usize,
}

/// Error with which an initial state cannot be created.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// A particle finds no free position.
    #[error(transparent)]
    PlacementFailed(#[from] PlacementFailed),
    /// The start was interrupted.
    #[error("stopped")]
    Interrupted,
    /// The lattice, or particles of several sizes, do not fit into the box.
    #[error("start.placement: {0}")]
    Placement(#[source] PlacementError),
    /// Two placed particles overlap; this is an error of the program.
    #[error("particles {} and {} of the start overlap by {depth}", pair[0], pair[1])]
    Overlap {
        /// Indices of the overlapping particles.
        pair: [usize; 2],
        /// Depth of the overlap \[length\].
        depth: f64,
    },
    /// The plan has no box in which particles can be placed.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Sizes of particles or sides of the box are invalid.
    #[error(transparent)]
    Invalid(#[from] stosszahl_model::InvalidValue),
    /// The elastic dynamics of the equilibration cannot start or continue.
    #[error("elastic equilibration: {0}")]
    Dynamics(#[from] stosszahl_ed::EventDrivenError),
    /// The elastic dynamics of the equilibration fails within a segment.
    #[error("elastic equilibration: {0}")]
    Failure(#[from] Failure),
}

impl From<PlacementError> for StartError {
    fn from(error: PlacementError) -> Self {
        match error {
            PlacementError::Interrupted => Self::Interrupted,
            other => Self::Placement(other),
        }
    }
}

impl StartError {
    /// Returns true if the case cannot be started as it is.
    pub(crate) fn is_refusal(&self) -> bool {
        match self {
            Self::PlacementFailed(_) | Self::Placement(_) | Self::Plan(_) | Self::Invalid(_) => {
                true
            }
            Self::Dynamics(error) => {
                !matches!(error, stosszahl_ed::EventDrivenError::Checkpoint(_))
            }
            Self::Interrupted | Self::Overlap { .. } | Self::Failure(_) => false,
        }
    }

    /// Converts lengths, times and speeds in the error to the units of the case.
    pub(crate) fn in_units(self, plan: &CasePlan) -> Self {
        match self {
            Self::Dynamics(error) => Self::Dynamics(error.in_units(&plan.message_units())),
            Self::Failure(failure) => Self::Failure(plan.told(failure)),
            Self::Placement(error) => Self::Placement(error.in_units(plan.scale.length)),
            Self::Overlap { pair, depth } => Self::Overlap {
                pair,
                depth: depth * plan.scale.length,
            },
            Self::PlacementFailed(_) | Self::Interrupted | Self::Plan(_) | Self::Invalid(_) => self,
        }
    }
}
