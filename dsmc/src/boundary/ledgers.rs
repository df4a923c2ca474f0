//! Ledgers of the mass, momentum and energy that the gas exchanges with walls, obstacles, open
//! faces and inflows.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::WallLedger;
use stosszahl_model::{ExactSum, Space, Vector};

/// Number, mass, momentum and energy of particles that entered the gas (positive) or left it
/// (negative).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Transfer<S: Space> {
    /// Number of particles transferred: simulators times their weights; negative if more left.
    pub particles: f64,
    /// Mass of the particles transferred \[mass\].
    pub mass: f64,
    /// Momentum of the particles transferred \[mass length/time\].
    pub momentum: S::Vector,
    /// Kinetic energy of the particles transferred, translational and rotational \[energy\].
    pub energy: f64,
}

impl<S: Space> Transfer<S> {
    /// Adds a simulator to the transfer that stands for `particles` particles, negative if it
    /// leaves, each with this mass, velocity and energy.
    pub(crate) fn enter(&mut self, particles: f64, mass: f64, velocity: S::Vector, energy: f64) {
        self.particles += particles;
        self.mass += particles * mass;
        self.momentum += velocity * (particles * mass);
        self.energy += particles * energy;
    }

    /// Adds another transfer of particles to this one.
    pub fn add(&mut self, other: &Self) {
        self.particles += other.particles;
        self.mass += other.mass;
        self.momentum += other.momentum;
        self.energy += other.energy;
    }
}

/// Ledgers of mass, momentum and energy that each boundary has given to the gas since the start.
/// Their sum, with the weight of the gas, accounts for all changes of the totals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Ledgers<S: Space> {
    /// Momentum and energy that walls have given to the gas, by axis and side.
    pub walls: [[WallLedger<S>; 2]; 3],
    /// Particles that left through open faces, by axis and side of the face; all numbers are
    /// negative.
    pub open: [[Transfer<S>; 2]; 3],
    /// Momentum and energy that each obstacle has given to the gas.
    pub obstacles: Vec<WallLedger<S>>,
    /// Particles that each inflow has brought into the gas.
    pub inflows: Vec<Transfer<S>>,
    /// Mass, momentum and energy added when simulators split or merge at changes of weight; zero on
    /// average.
    pub balance: Transfer<S>,
    /// Number of times that a simulator's weight changed, so that it was split or merged.
    pub balanced: u64,
    /// Number of simulators set to rest on a wall or obstacle after too many contacts in one free
    /// flight.
    pub settled_particles: u64,
}

impl<S: Space> Ledgers<S> {
    /// Creates empty ledgers for the given numbers of inflows and obstacles.
    pub(crate) fn with_counts(inflows: usize, obstacles: usize) -> Self {
        Self {
            inflows: vec![Transfer::default(); inflows],
            obstacles: vec![WallLedger::default(); obstacles],
            ..Self::default()
        }
    }

    /// Calls `each` for every number of the ledgers that is a sum, in an order that depends only on
    /// the numbers of inflows and obstacles.
    fn sums(&mut self, mut each: impl FnMut(&mut f64)) {
        for ledger in self.walls.iter_mut().flatten().chain(&mut self.obstacles) {
            each(&mut ledger.contacts);
            (0..S::DIMENSION).for_each(|axis| each(&mut ledger.momentum[axis]));
            each(&mut ledger.energy);
        }
        let open = self.open.iter_mut().flatten();
        for transfer in open.chain(&mut self.inflows).chain([&mut self.balance]) {
            each(&mut transfer.particles);
            each(&mut transfer.mass);
            (0..S::DIMENSION).for_each(|axis| each(&mut transfer.momentum[axis]));
            each(&mut transfer.energy);
        }
    }

    /// Returns the mass, momentum and energy that all boundaries together have given to the gas.
    pub fn total(&self) -> (f64, S::Vector, f64) {
        let mut sum = self.balance;
        let open = self.open.iter().flatten();
        for transfer in open.chain(&self.inflows) {
            sum.add(transfer);
        }
        let (mut momentum, mut energy) = (sum.momentum, sum.energy);
        for ledger in self.walls.iter().flatten().chain(&self.obstacles) {
            momentum += ledger.momentum;
            energy += ledger.energy;
        }
        (sum.mass, momentum, energy)
    }
}

/// Sums of the ledgers of several tiles by superaccumulators, independent of the order of the
/// tiles; empty without boundaries.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ExactLedgers {
    sums: Vec<ExactSum>,
    balanced: u64,
    settled_particles: u64,
}

impl ExactLedgers {
    /// Adds the ledgers of a tile to the exact sums, and sets those ledgers to zero.
    pub(crate) fn take_ledgers<S: Space>(&mut self, other: &mut Ledgers<S>) {
        let mut place = 0;
        other.sums(|sum| {
            if place == self.sums.len() {
                self.sums.push(ExactSum::default());
            }
            self.sums[place].add(std::mem::take(sum));
            place += 1;
        });
        self.balanced += std::mem::take(&mut other.balanced);
        self.settled_particles += std::mem::take(&mut other.settled_particles);
    }

    /// Adds the exact ledger sums of other tiles to these.
    pub(crate) fn merge(&mut self, other: &Self) {
        let most = self.sums.len().max(other.sums.len());
        self.sums.resize(most, ExactSum::default());
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            sum.merge(more);
        }
        self.balanced += other.balanced;
        self.settled_particles += other.settled_particles;
    }

    /// Adds the exact sums, rounded, to the ledgers `total` of the whole run.
    pub(crate) fn enter<S: Space>(&self, total: &mut Ledgers<S>) {
        let mut sums = self.sums.iter();
        total.sums(|sum| *sum += sums.next().map_or(0.0, ExactSum::value));
        total.balanced += self.balanced;
        total.settled_particles += self.settled_particles;
    }
}

/// Returns the kinetic energy of one particle, translational plus rotational \[energy\].
pub(crate) fn energy<V: Vector>(mass: f64, velocity: V, spin_energy: f64) -> f64 {
    0.5 * mass * velocity.square() + spin_energy
}
