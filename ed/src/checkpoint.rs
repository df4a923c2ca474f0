//! Checkpoint of an event-driven run: the state of the gas and all counters from which a run
//! resumes, and the rule for which collisions lose energy.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::WallLedger;
use stosszahl_model::{ParticleModel, ParticleState, ShearWork, State};

/// Rule for which collisions dissipate energy: none, all, or all but those within a contact time
/// (TC model).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum DissipationRule {
    /// All contacts are elastic and smooth, also with moving walls: a gas equilibrates.
    Elastic,
    /// All collisions dissipate energy, by the coefficients of restitution of disks and walls.
    Scene,
    /// Contact time of the TC model \[time\], which prevents inelastic collapse: a collision is
    /// elastic if one of the disks had another contact, also with a wall, less than this time
    /// before. Luding & McNamara, Granular Matter 1, 113 (1998), doi:10.1007/s100350050017.
    ContactTime(f64),
}

/// Work counters of an event-driven run, in numbers of events that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventCounters {
    /// Number of collisions between two disks.
    pub collisions: u64,
    /// Number of candidate pairs tested for a contact.
    pub predictions: u64,
    /// Number of events pushed into the event calendar.
    pub pushes: u64,
    /// Number of times that disks crossed from one cell of the cell lists into another.
    pub crossings: u64,
    /// Number of predicted contacts that did not happen because the partner had collided with
    /// another disk before.
    pub broken: u64,
    /// Number of contacts made elastic by the TC model.
    pub elastic_contacts: u64,
    /// Number of contacts with walls and obstacles.
    pub rebounds: u64,
}

impl EventCounters {
    /// Returns the number of contacts of all kinds: between disks, and with walls and obstacles.
    pub(crate) fn contacts(&self) -> u64 {
        self.collisions + self.rebounds
    }

    /// Adds each counter of another set of event counters to the same counter here.
    pub(crate) fn add(&mut self, other: &Self) {
        self.collisions += other.collisions;
        self.predictions += other.predictions;
        self.pushes += other.pushes;
        self.crossings += other.crossings;
        self.broken += other.broken;
        self.elastic_contacts += other.elastic_contacts;
        self.rebounds += other.rebounds;
    }
}

/// Checkpoint of an event-driven run: all data, besides the particle model, from which it resumes
/// to the same bytes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct EventDrivenCheckpoint<P: ParticleModel> {
    /// Time, box, and positions, velocities and spins of all disks.
    pub state: State<P>,
    /// Time of the last contact of each disk \[time\]; empty unless the TC model needs it.
    pub last_contact: Vec<f64>,
    /// Image flags: number of times each disk has left the box on the right and at the top, less
    /// the number on the left and at the bottom. The position plus that many sides of the box is
    /// the position of a disk that was never wrapped. Empty unless requested, by a start that has
    /// flags for each disk.
    pub image_flags: Vec<[i32; 2]>,
    /// Counters of collisions and other events since the start of the run.
    pub tally: EventCounters,
    /// Number of contacts since time last advanced noticeably, for the detection of inelastic
    /// collapse.
    pub stalled: u64,
    /// Momentum and energy that each wall and obstacle has given to the gas, in the order of
    /// `Engine::ledgers`; empty without walls and obstacles.
    pub ledgers: Vec<WallLedger<P::Space>>,
    /// Number of contacts of each disk with walls and obstacles since the start; empty without
    /// walls and obstacles.
    pub rebounds: Vec<u32>,
    /// Energy balance of a shear flow since the start: work, dissipation and supplied energy; zero
    /// without a shear flow.
    pub shear_work: ShearWork,
}

impl<P: ParticleModel> Clone for EventDrivenCheckpoint<P> {
    fn clone(&self) -> Self {
        Self {
            state: self.state.clone(),
            last_contact: self.last_contact.clone(),
            image_flags: self.image_flags.clone(),
            tally: self.tally,
            stalled: self.stalled,
            ledgers: self.ledgers.clone(),
            rebounds: self.rebounds.clone(),
            shear_work: self.shear_work,
        }
    }
}

impl<P: ParticleModel> EventDrivenCheckpoint<P> {
    /// Returns an empty checkpoint with the box and time of `other`: a placeholder while an engine
    /// owns the gas.
    pub(crate) fn nowhere(other: &Self) -> Self {
        let (time, domain) = (other.state.time, other.state.domain);
        Self::from(State {
            time,
            domain,
            bodies: Vec::new(),
        })
    }

    /// Returns the memory that the checkpoint occupies \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        self.state.bodies.capacity() * size_of::<ParticleState<P>>()
            + self.last_contact.capacity() * 8
            + self.image_flags.capacity() * 8
            + self.rebounds.capacity() * 4
    }
}

impl<P: ParticleModel> From<State<P>> for EventDrivenCheckpoint<P> {
    fn from(state: State<P>) -> Self {
        Self {
            state,
            last_contact: Vec::new(),
            image_flags: Vec::new(),
            tally: EventCounters::default(),
            stalled: 0,
            ledgers: Vec::new(),
            rebounds: Vec::new(),
            shear_work: ShearWork::default(),
        }
    }
}
