//! What a run is, between its legs.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::Ledger;
use stosszahl_model::{Body, Physics, ShearWork, State};

/// Which collisions lose energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Dissipation {
    /// None: the laws of the scene and its walls are set aside (to equilibrate). Contacts are elastic and smooth, also with
    /// walls that move.
    Elastic,
    /// All, by the restitution of the scene.
    Scene,
    /// Those of disks whose last contacts, with walls too, are older than this time; others are elastic. The TC
    /// model of Luding & McNamara, Granular Matter 1, 113 (1998), doi:10.1007/s100350050017, which
    /// removes inelastic collapse.
    ContactTime(f64),
}

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Pair collisions.
    pub collisions: u64,
    /// Candidate pairs whose contact was predicted.
    pub predictions: u64,
    /// Events put into the calendar.
    pub pushes: u64,
    /// Cell boundaries crossed.
    pub crossings: u64,
    /// Contacts that did not happen because the partner had collided meanwhile.
    pub broken: u64,
    /// Contacts made elastic by the TC model.
    pub elastic_contacts: u64,
    /// Contacts with walls and obstacles.
    pub rebounds: u64,
}

impl Tally {
    /// Contacts of all kinds.
    pub(crate) fn contacts(&self) -> u64 {
        self.collisions + self.rebounds
    }

    /// Adds what was done elsewhere.
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

/// Everything needed to continue a run.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Checkpoint<P: Physics> {
    /// The gas.
    pub state: State<P>,
    /// Time of each disk's last contact; empty unless the TC model needs it.
    pub last_contact: Vec<f64>,
    /// How often each disk has left the box on the right and at the top, less how often on the left and at the bottom;
    /// the position plus that many sides of the box is that of a disk that was never wrapped (image flags). Empty unless requested,
    /// by a start that has one for each disk.
    pub windings: Vec<[i32; 2]>,
    /// What was done so far.
    pub tally: Tally,
    /// Contacts since time last advanced noticeably.
    pub stalled: u64,
    /// What each wall and obstacle has given to the gas, by `Engine::ledgers`; empty where there are none.
    pub ledgers: Vec<Ledger<P::Space>>,
    /// Contacts of each disk with walls and obstacles so far; empty where there are none.
    pub rebounds: Vec<u32>,
    /// Energy balance so far; zero without a shear flow.
    pub shear_work: ShearWork,
}

impl<P: Physics> Clone for Checkpoint<P> {
    fn clone(&self) -> Self {
        Self {
            state: self.state.clone(),
            last_contact: self.last_contact.clone(),
            windings: self.windings.clone(),
            tally: self.tally,
            stalled: self.stalled,
            ledgers: self.ledgers.clone(),
            rebounds: self.rebounds.clone(),
            shear_work: self.shear_work,
        }
    }
}

impl<P: Physics> Checkpoint<P> {
    /// An empty gas in the same box, for while an engine has the other.
    pub(crate) fn nowhere(other: &Self) -> Self {
        let (time, domain) = (other.state.time, other.state.domain);
        Self::from(State {
            time,
            domain,
            bodies: Vec::new(),
        })
    }

    /// Memory held \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        self.state.bodies.capacity() * size_of::<Body<P>>()
            + self.last_contact.capacity() * 8
            + self.windings.capacity() * 8
            + self.rebounds.capacity() * 4
    }
}

impl<P: Physics> From<State<P>> for Checkpoint<P> {
    fn from(state: State<P>) -> Self {
        Self {
            state,
            last_contact: Vec::new(),
            windings: Vec::new(),
            tally: Tally::default(),
            stalled: 0,
            ledgers: Vec::new(),
            rebounds: Vec::new(),
            shear_work: ShearWork::default(),
        }
    }
}
