//! State of a run between its legs.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::WallLedger;
use stosszahl_model::{ParticleModel, ParticleState, ShearWork, State};

/// Rule for which collisions lose energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum DissipationRule {
    /// No collisions lose energy, so that a gas equilibrates: all contacts are elastic and smooth,
    /// also with moving walls.
    Elastic,
    /// All collisions lose energy, by the coefficients of restitution of disks and walls.
    Scene,
    /// Collisions lose energy if the last contacts of both disks, contacts with walls included, are
    /// older than this time \[time\]; others are elastic. This is the TC model of Luding &
    /// McNamara, Granular Matter 1, 113 (1998), doi:10.1007/s100350050017, which prevents inelastic
    /// collapse.
    ContactTime(f64),
}

/// Work done, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventCounters {
    /// Number of pair collisions.
    pub collisions: u64,
    /// Number of candidate pairs whose contact was predicted.
    pub predictions: u64,
    /// Number of events put into the calendar.
    pub pushes: u64,
    /// Number of cell boundaries crossed.
    pub crossings: u64,
    /// Number of predicted contacts that did not happen because the partner had collided meanwhile.
    pub broken: u64,
    /// Number of contacts made elastic by the TC model.
    pub elastic_contacts: u64,
    /// Number of contacts with walls and obstacles.
    pub rebounds: u64,
}

impl EventCounters {
    /// Number of contacts of all kinds.
    pub(crate) fn contacts(&self) -> u64 {
        self.collisions + self.rebounds
    }

    /// Adds other counters to these, one by one.
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

/// All data from which a run continues to the same bytes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct EventDrivenCheckpoint<P: ParticleModel> {
    /// State of the gas.
    pub state: State<P>,
    /// Time of each disk's last contact; empty unless the TC model needs it.
    pub last_contact: Vec<f64>,
    /// Image flags: number of times each disk has left the box on the right and at the top, less
    /// the number on the left and at the bottom. The position plus that many sides of the box is
    /// the position of a disk that was never wrapped. Empty unless requested, by a start that has
    /// flags for each disk.
    pub image_flags: Vec<[i32; 2]>,
    /// Counters of collisions and other events since the start of the run.
    pub tally: EventCounters,
    /// Number of contacts since time last advanced noticeably.
    pub stalled: u64,
    /// Momentum and energy that each wall and obstacle has given to the gas, by `Engine::ledgers`;
    /// empty without any.
    pub ledgers: Vec<WallLedger<P::Space>>,
    /// Number of contacts of each disk with walls and obstacles so far; empty without any.
    pub rebounds: Vec<u32>,
    /// Energy balance so far; zero without a shear flow.
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
    /// Returns an empty gas in the box of `other`, as a placeholder while an engine has the gas.
    pub(crate) fn nowhere(other: &Self) -> Self {
        let (time, domain) = (other.state.time, other.state.domain);
        Self::from(State {
            time,
            domain,
            bodies: Vec::new(),
        })
    }

    /// Memory of the checkpoint \[bytes\].
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
