//! Checkpoints of a gas without positions: all data, besides the particle model, from which a run
//! resumes to the same bytes.

use serde::{Deserialize, Serialize};
use stosszahl_model::ParticleModel;
use stosszahl_model::random::Streams;

use super::clock::{Clock, SelectionCounters};
use super::contact::ContactRule;
use super::engine::HomogeneousEngine;
use super::gas::{GasParticle, HomogeneousGas, SmoothPhysics};
use super::kernel::{CollisionKernel, PairCorrelationFactor};
use super::motion::PathRecord;
use super::selection::SelectionMethod;
use stosszahl_model::interrupt::Interruption;

/// Checkpoint of a gas without positions: all data, besides the particle model, from which a run
/// resumes to the same bytes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "S: Serialize, M: Serialize, C: Serialize",
    deserialize = "S: Deserialize<'de>, M: Deserialize<'de>, C: Deserialize<'de>"
))]
pub struct HomogeneousCheckpoint<P: ParticleModel, S, M, C> {
    kernel: CollisionKernel,
    contact: PairCorrelationFactor,
    volume: f64,
    particles: Vec<GasParticle<P>>,
    gone: usize,
    selection: S,
    motion: M,
    contacts: C,
    clock: Clock,
    tally: SelectionCounters,
}

impl<P: SmoothPhysics, S: SelectionMethod<P>, M: PathRecord<P>, C: ContactRule<P>>
    HomogeneousEngine<P, S, M, C>
{
    /// Returns a checkpoint of the current gas, from which the run resumes to the same bytes.
    pub fn checkpoint(&self) -> HomogeneousCheckpoint<P, S, M, C> {
        HomogeneousCheckpoint {
            kernel: self.gas.kernel,
            contact: self.gas.contact,
            volume: self.gas.volume,
            particles: self.gas.particles.clone(),
            gone: self.gas.gone,
            selection: self.selection.clone(),
            motion: self.motion.clone(),
            contacts: self.contacts.clone(),
            clock: self.clock,
            tally: self.tally,
        }
    }

    /// Creates an engine from a checkpoint; particle model and random streams must be as before.
    pub fn resume(
        scene: P,
        checkpoint: HomogeneousCheckpoint<P, S, M, C>,
        streams: Streams,
    ) -> Self {
        Self {
            gas: HomogeneousGas {
                scene,
                kernel: checkpoint.kernel,
                contact: checkpoint.contact,
                volume: checkpoint.volume,
                particles: checkpoint.particles,
                gone: checkpoint.gone,
            },
            selection: checkpoint.selection,
            motion: checkpoint.motion,
            contacts: checkpoint.contacts,
            streams,
            clock: checkpoint.clock,
            tally: checkpoint.tally,
            stop: Interruption::default(),
            paused: None,
        }
    }
}
