//! Where a run stands, what it did, and how it is continued.

use serde::{Deserialize, Serialize};
use stosszahl_model::Physics;
use stosszahl_model::random::Streams;

use super::contact::Contacts;
use super::engine::Engine;
use super::gas::{Gas, Grains, Particle};
use super::kernel::{Contact, Kernel};
use super::motion::Motion;
use super::selection::Selection;
use stosszahl_model::interrupt::Interruption;

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Proposals, those of nothing included.
    pub proposals: u64,
    /// Pairs that were looked at.
    pub trials: u64,
    /// Pairs that met, whatever followed.
    pub collisions: u64,
    /// Times that all bounds were fitted anew.
    pub rebuilds: u64,
    /// Kinetic energy lost in bounces.
    pub energy_lost: f64,
}

/// Why an advance ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The time is reached.
    Time,
    /// The number of collisions is reached.
    Collisions,
    /// Nothing will ever collide again: one particle is left, or all are at rest. A finite time is reached.
    Still,
    /// A pause was asked for: [`Engine::pause_on`].
    Paused,
    /// It was broken off: [`Engine::stop_on`].
    Interrupted,
}

/// Everything that a run needs to continue to the same bytes, but the scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "S: Serialize, M: Serialize, C: Serialize",
    deserialize = "S: Deserialize<'de>, M: Deserialize<'de>, C: Deserialize<'de>"
))]
pub struct Checkpoint<P: Physics, S, M, C> {
    kernel: Kernel,
    contact: Contact,
    volume: f64,
    particles: Vec<Particle<P>>,
    gone: usize,
    selection: S,
    motion: M,
    contacts: C,
    clock: Clock,
    tally: Tally,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    pub time: f64,
    /// Advances so far; each has its own random stream.
    pub advances: u64,
    /// Collisions since the bounds were fitted.
    pub since: u64,
    pub outdated: bool,
}

impl<P: Grains, S: Selection<P>, M: Motion<P>, C: Contacts<P>> Engine<P, S, M, C> {
    /// Everything that is needed to continue to the same bytes.
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

    /// Continues from a checkpoint of the same scene and streams.
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
