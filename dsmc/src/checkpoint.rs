//! Checkpoints of a cell-based gas.

use serde::{Deserialize, Serialize};
use stosszahl_model::ParticleModel;

use crate::boundary::Ledgers;
use crate::cross_cell::ContactDistance;
use crate::engine::DsmcEngine;
use crate::particle::{DisplacementTracking, SimulatorOf, Untracked};
use crate::start_means::Means;
use crate::tally::{CollisionCounters, EnergyUnit, StepBounds};

/// State from which a run continues to the same bytes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct DsmcCheckpoint<P: ParticleModel, F: DisplacementTracking<P::Space> = Untracked> {
    pub(crate) time: f64,
    /// Displacement of the box above in a shear flow \[length\]; 0 without one.
    pub(crate) offset: f64,
    /// Simulators in the order of their cells.
    pub(crate) simulators: Vec<SimulatorOf<P, F>>,
    pub(crate) stock: StepBounds<P::Space>,
    pub(crate) unit: EnergyUnit,
    pub(crate) tally: CollisionCounters,
    pub(crate) arm: ContactDistance,
    pub(crate) ledgers: Ledgers<P::Space>,
    pub(crate) means: Means,
    /// Weight factors of regions that follow the number of simulators; empty where none do.
    pub(crate) factors: Vec<f64>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcCheckpoint<P, F> {
    /// Sets the simulators, in the order of their cells.
    pub(crate) fn hold(&mut self, simulators: Vec<SimulatorOf<P, F>>) {
        self.simulators = simulators;
    }
}

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Returns the state from which the run continues to the same bytes.
    pub fn checkpoint(&self) -> DsmcCheckpoint<P, F> {
        DsmcCheckpoint {
            simulators: self.ordered().copied().collect(),
            ..self.without_simulators()
        }
    }

    /// Returns the state of the run without its simulators.
    pub(crate) fn without_simulators(&self) -> DsmcCheckpoint<P, F> {
        DsmcCheckpoint {
            time: self.time,
            offset: self.grid.offset(),
            simulators: Vec::new(),
            stock: self.stock,
            unit: self.unit,
            tally: self.tally,
            arm: self.arm.clone(),
            ledgers: self.ledgers.clone(),
            means: self.means,
            factors: self
                .followed()
                .map_or_else(Vec::new, |all| all.factors().to_vec()),
        }
    }

    /// Restores the state of a checkpoint of the same gas, except the simulators.
    pub(crate) fn take_over(&mut self, checkpoint: DsmcCheckpoint<P, F>) {
        (self.time, self.stock, self.unit) = (checkpoint.time, checkpoint.stock, checkpoint.unit);
        (self.tally, self.arm) = (checkpoint.tally, checkpoint.arm);
        self.ledgers = checkpoint.ledgers;
    }
}
