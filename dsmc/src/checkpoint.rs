//! Checkpoint of a DSMC run: simulators, clock, counters and ledgers, from which it resumes to the
//! same bytes.

use serde::{Deserialize, Serialize};
use stosszahl_model::ParticleModel;

use crate::boundary::Ledgers;
use crate::cross_cell::ContactDistance;
use crate::engine::DsmcEngine;
use crate::particle::{DisplacementTracking, SimulatorOf, Untracked};
use crate::start_means::Means;
use crate::tally::{CollisionCounters, EnergyUnit, StepBounds};

/// Checkpoint of a DSMC run: all data, besides its parameters, from which it resumes to the same
/// bytes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct DsmcCheckpoint<P: ParticleModel, F: DisplacementTracking<P::Space> = Untracked> {
    pub(crate) time: f64,
    /// Displacement along the flow of the periodic image above in a shear flow \[length\]; 0
    /// without shear.
    pub(crate) offset: f64,
    /// Simulators of the gas, in the order of their cells.
    pub(crate) simulators: Vec<SimulatorOf<P, F>>,
    pub(crate) stock: StepBounds<P::Space>,
    pub(crate) unit: EnergyUnit,
    pub(crate) tally: CollisionCounters,
    pub(crate) arm: ContactDistance,
    pub(crate) ledgers: Ledgers<P::Space>,
    pub(crate) means: Means,
    /// Weight factors of regions, if they adapt to the number of simulators; empty otherwise.
    pub(crate) factors: Vec<f64>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcCheckpoint<P, F> {
    /// Sets the simulators of the checkpoint, in the order of their cells.
    pub(crate) fn hold(&mut self, simulators: Vec<SimulatorOf<P, F>>) {
        self.simulators = simulators;
    }
}

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Returns a checkpoint of the current gas, from which the run resumes to the same bytes.
    pub fn checkpoint(&self) -> DsmcCheckpoint<P, F> {
        DsmcCheckpoint {
            simulators: self.ordered().copied().collect(),
            ..self.without_simulators()
        }
    }

    /// Returns a checkpoint of the run without its simulators: clock, counters, ledgers and
    /// adaptive parameters.
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

    /// Restores clock, counters, ledgers and adaptive parameters from a checkpoint of the same run,
    /// but not the simulators.
    pub(crate) fn take_over(&mut self, checkpoint: DsmcCheckpoint<P, F>) {
        (self.time, self.stock, self.unit) = (checkpoint.time, checkpoint.stock, checkpoint.unit);
        (self.tally, self.arm) = (checkpoint.tally, checkpoint.arm);
        self.ledgers = checkpoint.ledgers;
    }
}
