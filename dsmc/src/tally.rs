//! Counters of a run, and the statistics behind the next time step.

use serde::{Deserialize, Serialize};
use stosszahl_model::{ExactSum, Space};

use crate::boundary::{ExactLedgers, Ledgers};
use crate::extrema::larger;

/// Counters of a run, independent of machine and number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CollisionCounters {
    /// Number of time steps.
    pub steps: u64,
    /// Number of candidate pairs.
    pub trials: u64,
    /// Number of accepted pairs of simulators.
    pub collisions: u64,
    /// Candidate pairs whose relative speed exceeded the majorant.
    pub majorant_violations: u64,
    /// Number of cells with at least two simulators, summed over steps.
    pub active_cells: u64,
    /// Number of active cells in which chi was limited, summed over steps.
    pub limited_cells: u64,
    /// Collisions in cells in which chi was limited.
    pub limited_collisions: u64,
    /// Sum over collisions of the distance of the partners \[length\].
    pub separation: f64,
    /// Sum over collisions of `w ((r_i - r_j) . dp + dr_i . p_i' + dr_j . p_j')` \[energy\], with
    /// simulator weight w, momentum dp gained by the first, and displacements dr of both: the
    /// momentum that collisions carry, so that `Z = 1 + virial/(D N T t)` for N particles at
    /// constant T.
    pub virial: f64,
    /// Cross-cell candidates for which no partner was in range.
    pub missed: u64,
    /// Cross-cell candidates for which a partner was sought.
    pub searches: u64,
    /// Largest number of collisions per simulator in one cell and step. For overlapping disks,
    /// which collide at most once in a step, also the largest expected number of a pair.
    pub busiest_cell: f64,
}

/// Collisions and virial of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellCount {
    /// Number of collisions of particles: of simulators, times their weight.
    pub collisions: f64,
    /// Contribution of the cell to [`CollisionCounters::virial`] \[energy\].
    pub virial: f64,
}

impl CollisionCounters {
    /// Adds counters of other work in the same steps. Floating-point sums depend on the order of
    /// adding.
    pub(crate) fn add(&mut self, other: &Self) {
        self.trials += other.trials;
        self.collisions += other.collisions;
        self.majorant_violations += other.majorant_violations;
        self.active_cells += other.active_cells;
        self.limited_cells += other.limited_cells;
        self.limited_collisions += other.limited_collisions;
        self.separation += other.separation;
        self.virial += other.virial;
        self.missed += other.missed;
        self.searches += other.searches;
        self.busiest_cell = self.busiest_cell.max(other.busiest_cell);
    }
}

/// Exact sums of the counters of several tiles in a step, independent of the order of the tiles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct StepCounters {
    /// Counters other than floating-point sums.
    whole: CollisionCounters,
    separation: ExactSum,
    virial: ExactSum,
    ledgers: ExactLedgers,
}

impl StepCounters {
    /// Adds the counters of a tile.
    pub(crate) fn add(&mut self, tally: &CollisionCounters) {
        self.separation.add(tally.separation);
        self.virial.add(tally.virial);
        self.whole.add(&CollisionCounters {
            separation: 0.0,
            virial: 0.0,
            ..*tally
        });
    }

    /// Takes the ledgers of a tile and clears them.
    pub(crate) fn take_ledgers<S: Space>(&mut self, ledgers: &mut Ledgers<S>) {
        self.ledgers.take_ledgers(ledgers);
    }

    /// Adds the counters of other tiles or processes.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.whole.add(&other.whole);
        self.separation.merge(&other.separation);
        self.virial.merge(&other.virial);
        self.ledgers.merge(&other.ledgers);
    }

    /// Adds the sums to the totals of the run.
    pub(crate) fn enter<S: Space>(&self, tally: &mut CollisionCounters, ledgers: &mut Ledgers<S>) {
        tally.add(&CollisionCounters {
            separation: self.separation.value(),
            virial: self.virial.value(),
            ..self.whole
        });
        self.ledgers.enter(ledgers);
    }
}

/// Largest speeds and energy of the gas, from which the next time step follows; taken before the
/// collisions of a step. Independent of the grouping of cells, because maxima have no order and
/// energies are added as integers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct StepBounds<S: Space> {
    /// Largest absolute value of each velocity component \[length/time\].
    pub(crate) speeds: S::Vector,
    /// Sum of m v^2, in [`EnergyUnit`]s.
    energy: u64,
}

impl<S: Space> Default for StepBounds<S> {
    fn default() -> Self {
        Self {
            speeds: S::Vector::default(),
            energy: 0,
        }
    }
}

/// Unit of energy for integer sums: a power of two, about 2^-58 of the last total \[energy\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct EnergyUnit(f64);

impl EnergyUnit {
    /// Unit for energies whose sum is about `total`, and at most 64 times `total`.
    pub(crate) fn for_total(total: f64) -> Self {
        let exponent = (total.to_bits() >> 52) as i32 - 1023;
        let power = (exponent + 1 - 58).clamp(-1000, 1000);
        Self(f64::from_bits(((power + 1023) as u64) << 52))
    }

    /// Inverse of the unit \[1/energy\].
    pub(crate) fn inverse(self) -> f64 {
        1.0 / self.0
    }
}

impl<S: Space> StepBounds<S> {
    /// Adds the simulators of one cell: their smallest and largest velocity components, and the sum
    /// of m v^2.
    #[inline(always)]
    pub(crate) fn add_cell(
        &mut self,
        low: S::Vector,
        high: S::Vector,
        twice_energy: f64,
        units: f64,
    ) {
        self.note_speeds(S::from_components(|axis| larger(high[axis], -low[axis])));
        self.add_energy(twice_energy, units);
    }

    /// Adds absolute velocity components to the maxima.
    #[inline(always)]
    pub(crate) fn note_speeds(&mut self, fastest: S::Vector) {
        let speeds = self.speeds;
        self.speeds = S::from_components(|axis| larger(speeds[axis], fastest[axis]));
    }

    /// Adds a value of m v^2.
    #[inline(always)]
    pub(crate) fn add_energy(&mut self, twice_energy: f64, units: f64) {
        self.energy = self.energy.saturating_add((twice_energy * units) as u64);
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.speeds = S::from_components(|axis| larger(self.speeds[axis], other.speeds[axis]));
        self.energy = self.energy.saturating_add(other.energy);
    }

    /// Returns true if the integer sum of energies has overflowed.
    pub(crate) fn is_full(&self) -> bool {
        self.energy == u64::MAX
    }

    /// Sets the sum of m v^2 \[energy\].
    pub(crate) fn set_twice_energy(&mut self, twice_energy: f64, unit: EnergyUnit) {
        self.energy = (twice_energy * unit.inverse()) as u64;
    }

    /// Sum of m v^2 \[energy\].
    pub(crate) fn twice_energy(&self, unit: EnergyUnit) -> f64 {
        self.energy as f64 * unit.0
    }
}
