//! Checkpoints of a gas without positions.

use serde::{Deserialize, Serialize};
use stosszahl_model::ParticleModel;
use stosszahl_model::random::Streams;

use super::clock::{Clock, SelectionCounters};
use super::contact::Contacts;
use super::engine::Engine;
use super::gas::{Gas, Grains, Particle};
use super::kernel::{Contact, Kernel};
use super::motion::Motion;
use super::selection::Selection;
use stosszahl_model::interrupt::Interruption;

/// All data from which a run resumes to the same bytes, besides the scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "S: Serialize, M: Serialize, C: Serialize",
    deserialize = "S: Deserialize<'de>, M: Deserialize<'de>, C: Deserialize<'de>"
))]
pub struct Checkpoint<P: ParticleModel, S, M, C> {
    kernel: Kernel,
    contact: Contact,
    volume: f64,
    particles: Vec<Particle<P>>,
    gone: usize,
    selection: S,
    motion: M,
    contacts: C,
    clock: Clock,
    tally: SelectionCounters,
}

impl<P: Grains, S: Selection<P>, M: Motion<P>, C: Contacts<P>> Engine<P, S, M, C> {
    /// Returns all data from which the run resumes to the same bytes.
    pub fn checkpoint(&self) -> Checkpoint<P, S, M, C> {
        Checkpoint {
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

    /// Resumes from a checkpoint of the same scene and streams.
    pub fn resume(scene: P, checkpoint: Checkpoint<P, S, M, C>, streams: Streams) -> Self {
        Self {
            gas: Gas {
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
