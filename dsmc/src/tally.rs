//! Work counters of a DSMC run, and the bounds of speed and energy from which the next time step is
//! chosen.

use serde::{Deserialize, Serialize};
use stosszahl_model::{ExactSum, Space};

use crate::boundary::{ExactLedgers, Ledgers};
use crate::extrema::larger;

/// Counters of a DSMC run: steps, candidates, collisions, virial and signs of error; independent of
/// machine and number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CollisionCounters {
    /// Number of time steps since the start of the run.
    pub steps: u64,
    /// Number of candidate pairs drawn.
    pub trials: u64,
    /// Number of collisions of simulators, the accepted candidate pairs.
    pub collisions: u64,
    /// Number of candidate pairs whose relative speed exceeded the majorant.
    pub majorant_violations: u64,
    /// Number of cells with at least two simulators, summed over steps.
    pub active_cells: u64,
    /// Number of active cells whose contact value chi was at its limit, summed over steps.
    pub limited_cells: u64,
    /// Number of collisions in cells whose contact value chi was at its limit.
    pub limited_collisions: u64,
    /// Sum over collisions of the distance between the partners' centres \[length\].
    pub separation: f64,
    /// Virial of all collisions \[energy\]: the sum of `w ((r_i - r_j) . dp + dr_i . p_i' + dr_j .
    /// p_j')`, with simulator weight w, momentum dp gained by the first, and displacements dr of
    /// both. It is the momentum that collisions carry, so that `Z = 1 + virial/(D N T t)` for N
    /// particles at constant T.
    pub virial: f64,
    /// Number of cross-cell candidates for which no partner was within range.
    pub missed: u64,
    /// Number of cross-cell candidates for which a partner was sought.
    pub searches: u64,
    /// Largest number of collisions per simulator in one cell and one step, a measure of too long
    /// steps. For stochastic disks, also the largest expected number of events of a pair.
    pub busiest_cell: f64,
}

/// Number of collisions and virial of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellCount {
    /// Number of collisions of particles in the cell: those of simulators, times their weight.
    pub collisions: f64,
    /// Virial of the collisions in the cell, its contribution to [`CollisionCounters::virial`]
    /// \[energy\].
    pub virial: f64,
}

impl CollisionCounters {
    /// Adds the counters of other work in the same steps to these. Floating-point sums depend on
    /// the order of adding.
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

/// Sums of the counters of several tiles in one step by superaccumulators, independent of the order
/// of the tiles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct StepCounters {
    /// Integer counters, whose sums are exact anyway.
    whole: CollisionCounters,
    separation: ExactSum,
    virial: ExactSum,
    ledgers: ExactLedgers,
}

impl StepCounters {
    /// Adds the counters of a tile to the sums of the step.
    pub(crate) fn add(&mut self, tally: &CollisionCounters) {
        self.separation.add(tally.separation);
        self.virial.add(tally.virial);
        self.whole.add(&CollisionCounters {
            separation: 0.0,
            virial: 0.0,
            ..*tally
        });
    }

    /// Adds the boundary ledgers of a tile to the sums of the step, and clears them in the tile.
    pub(crate) fn take_ledgers<S: Space>(&mut self, ledgers: &mut Ledgers<S>) {
        self.ledgers.take_ledgers(ledgers);
    }

    /// Adds the sums of other tiles or of another process to these.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.whole.add(&other.whole);
        self.separation.merge(&other.separation);
        self.virial.merge(&other.virial);
        self.ledgers.merge(&other.ledgers);
    }

    /// Adds the sums of the step, rounded, to the counters and ledgers of the run.
    pub(crate) fn enter<S: Space>(&self, tally: &mut CollisionCounters, ledgers: &mut Ledgers<S>) {
        tally.add(&CollisionCounters {
            separation: self.separation.value(),
            virial: self.virial.value(),
            ..self.whole
        });
        self.ledgers.enter(ledgers);
    }
}

/// Largest speeds and kinetic energy of the gas before the collisions of a step, from which the
/// next time step is chosen. Independent of the grouping of cells, because maxima have no order and
/// energies are added as integers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct StepBounds<S: Space> {
    /// Largest absolute value of each velocity component of any simulator \[length/time\].
    pub(crate) speeds: S::Vector,
    /// Sum of m v^2 over simulators, as an integer number of [`EnergyUnit`]s.
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

/// Unit of energy for integer sums of m v^2: a power of two, about 2^-58 of the last total
/// \[energy\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct EnergyUnit(f64);

impl EnergyUnit {
    /// Creates the energy unit for integer sums of about `total`, and of at most 64 times `total`
    /// \[energy\].
    pub(crate) fn for_total(total: f64) -> Self {
        let exponent = (total.to_bits() >> 52) as i32 - 1023;
        let power = (exponent + 1 - 58).clamp(-1000, 1000);
        Self(f64::from_bits(((power + 1023) as u64) << 52))
    }

    /// Returns the inverse of the energy unit \[1/energy\].
    pub(crate) fn inverse(self) -> f64 {
        1.0 / self.0
    }
}

impl<S: Space> StepBounds<S> {
    /// Adds the simulators of one cell to the bounds: their smallest and largest velocity
    /// components, and their sum of m v^2. `units` is the inverse energy unit.
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

    /// Raises the largest absolute velocity components to `fastest` where these are larger
    /// \[length/time\].
    #[inline(always)]
    pub(crate) fn note_speeds(&mut self, fastest: S::Vector) {
        let speeds = self.speeds;
        self.speeds = S::from_components(|axis| larger(speeds[axis], fastest[axis]));
    }

    /// Adds a value of m v^2 \[energy\] to the integer sum; `units` is the inverse energy unit.
    #[inline(always)]
    pub(crate) fn add_energy(&mut self, twice_energy: f64, units: f64) {
        self.energy = self.energy.saturating_add((twice_energy * units) as u64);
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.speeds = S::from_components(|axis| larger(self.speeds[axis], other.speeds[axis]));
        self.energy = self.energy.saturating_add(other.energy);
    }

    /// Returns true if the integer sum of energies has reached its largest value.
    pub(crate) fn is_full(&self) -> bool {
        self.energy == u64::MAX
    }

    /// Sets the integer sum of m v^2 from an energy \[energy\], in the given unit.
    pub(crate) fn set_twice_energy(&mut self, twice_energy: f64, unit: EnergyUnit) {
        self.energy = (twice_energy * unit.inverse()) as u64;
    }

    /// Returns the sum of m v^2 over simulators \[energy\], twice the kinetic energy.
    pub(crate) fn twice_energy(&self, unit: EnergyUnit) -> f64 {
        self.energy as f64 * unit.0
    }
}
