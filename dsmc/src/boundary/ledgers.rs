//! What the gas was given and what it lost at its boundaries.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::Ledger;
use stosszahl_model::{Exact, Space, Vector};

/// Particles that came (above zero) or went (below), with all that they carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Transfer<S: Space> {
    /// Number of particles: of simulators, times what each stands for.
    pub particles: f64,
    /// Their mass.
    pub mass: f64,
    /// Their momentum \[mass length/time\].
    pub momentum: S::Vector,
    /// Their kinetic energy, of rotation too.
    pub energy: f64,
}

impl<S: Space> Transfer<S> {
    /// Enters a simulator that stands for `particles`, which is below zero for one that goes, with the mass, velocity
    /// and energy of one of them.
    pub(crate) fn enter(&mut self, particles: f64, mass: f64, velocity: S::Vector, energy: f64) {
        self.particles += particles;
        self.mass += particles * mass;
        self.momentum += velocity * (particles * mass);
        self.energy += particles * energy;
    }

    /// Adds the entries of another.
    pub fn add(&mut self, other: &Self) {
        self.particles += other.particles;
        self.mass += other.mass;
        self.momentum += other.momentum;
        self.energy += other.energy;
    }
}

/// All that boundaries gave to the gas since the start. With the weight of the gas, it makes up the changes of its mass,
/// momentum and energy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Ledgers<S: Space> {
    /// What walls gave, by axis and side.
    pub walls: [[Ledger<S>; 2]; 3],
    /// What left through open faces, by axis and side: below zero.
    pub open: [[Transfer<S>; 2]; 3],
    /// What obstacles gave, by their number.
    pub obstacles: Vec<Ledger<S>>,
    /// What flowed in, by the number of the inflow.
    pub inflows: Vec<Transfer<S>>,
    /// What splitting and merging of simulators added; zero on average.
    pub balance: Transfer<S>,
    /// How often a simulator changed its weight.
    pub balanced: u64,
    /// How often a particle was laid to rest on a wall or an obstacle, as it touched too often in one flight.
    pub rests: u64,
}

impl<S: Space> Ledgers<S> {
    /// Empty ledgers for numbers of inflows and obstacles.
    pub(crate) fn of(inflows: usize, obstacles: usize) -> Self {
        Self {
            inflows: vec![Transfer::default(); inflows],
            obstacles: vec![Ledger::default(); obstacles],
            ..Self::default()
        }
    }

    /// All sums, in an order that depends on the number of inflows and obstacles alone.
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

    /// What all walls, openings and obstacles together gave: mass, momentum, energy.
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

/// Entries of some tiles, whose sums do not depend on their order; empty without boundaries.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ExactLedgers {
    sums: Vec<Exact>,
    balanced: u64,
    rests: u64,
}

impl ExactLedgers {
    /// Adds the entries of a tile, and clears those.
    pub(crate) fn take<S: Space>(&mut self, other: &mut Ledgers<S>) {
        let mut place = 0;
        other.sums(|sum| {
            if place == self.sums.len() {
                self.sums.push(Exact::default());
            }
            self.sums[place].add(std::mem::take(sum));
            place += 1;
        });
        self.balanced += std::mem::take(&mut other.balanced);
        self.rests += std::mem::take(&mut other.rests);
    }

    /// Adds those of other tiles.
    pub(crate) fn merge(&mut self, other: &Self) {
        let most = self.sums.len().max(other.sums.len());
        self.sums.resize(most, Exact::default());
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            sum.merge(more);
        }
        self.balanced += other.balanced;
        self.rests += other.rests;
    }

    /// Adds all to the totals.
    pub(crate) fn enter<S: Space>(&self, total: &mut Ledgers<S>) {
        let mut sums = self.sums.iter();
        total.sums(|sum| *sum += sums.next().map_or(0.0, Exact::value));
        total.balanced += self.balanced;
        total.rests += self.rests;
    }
}

/// Energy of a particle that moves and turns.
pub(crate) fn energy<V: Vector>(mass: f64, velocity: V, spin_energy: f64) -> f64 {
    0.5 * mass * velocity.square() + spin_energy
}
