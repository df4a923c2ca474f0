//! What was done, and what the length of the next step follows.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Exact, Space};

use crate::boundary::{ExactLedgers, Ledgers};
use crate::extrema::larger;

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Steps.
    pub steps: u64,
    /// Pairs tried.
    pub trials: u64,
    /// Pairs of simulators that collided.
    pub collisions: u64,
    /// Trials whose relative speed exceeded the majorant.
    pub majorant_violations: u64,
    /// Cells, summed over steps, with at least two simulators.
    pub active_cells: u64,
    /// Those of them in which chi was limited.
    pub limited_cells: u64,
    /// Collisions in cells in which chi was limited.
    pub limited_collisions: u64,
    /// Sum over collisions of the distance of the partners \[length\].
    pub separation: f64,
    /// Sum over collisions of `w ((r_i - r_j) . dp + dr_i . p_i' + dr_j . p_j')`, with the weight w of a simulator, the
    /// momentum dp that the first gains, and the displacements dr of both: the momentum that collisions carry, so that
    /// `Z = 1 + virial/(D N T t)` for N particles and constant T \[energy\].
    pub virial: f64,
    /// Trials across cells that found no partner in reach.
    pub missed: u64,
    /// Trials that searched for a partner.
    pub searches: u64,
    /// Largest number of collisions per simulator in one cell and step; of overlapping disks, which collide once in a step at
    /// most, also the largest number that a pair would have had.
    pub busiest_cell: f64,
}

/// What happened in one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellCount {
    /// Collisions of pairs of particles: of simulators, times what each stands for.
    pub collisions: f64,
    /// Their share of [`Tally::virial`] \[energy\].
    pub virial: f64,
}

impl Tally {
    /// Adds what was done elsewhere in the same steps. Sums of floating-point numbers depend on the order of adding.
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

/// What some tiles have counted in a step, on its way to the total: no digit depends on the order in which tiles are added.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Counts {
    /// All but the sums of floating-point numbers.
    whole: Tally,
    separation: Exact,
    virial: Exact,
    ledgers: ExactLedgers,
}

impl Counts {
    /// Adds what was done in a tile.
    pub(crate) fn add(&mut self, tally: &Tally) {
        self.separation.add(tally.separation);
        self.virial.add(tally.virial);
        self.whole.add(&Tally {
            separation: 0.0,
            virial: 0.0,
            ..*tally
        });
    }

    /// Takes what boundaries gave to the simulators of a tile.
    pub(crate) fn take<S: Space>(&mut self, ledgers: &mut Ledgers<S>) {
        self.ledgers.take(ledgers);
    }

    /// Adds what others have counted.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.whole.add(&other.whole);
        self.separation.merge(&other.separation);
        self.virial.merge(&other.virial);
        self.ledgers.merge(&other.ledgers);
    }

    /// Adds all to the totals.
    pub(crate) fn enter<S: Space>(&self, tally: &mut Tally, ledgers: &mut Ledgers<S>) {
        tally.add(&Tally {
            separation: self.separation.value(),
            virial: self.virial.value(),
            ..self.whole
        });
        self.ledgers.enter(ledgers);
    }
}

/// What the length of the next step follows, taken before the collisions of a step. It is exactly the same
/// however the cells are grouped, so that steps are too: maxima have no order, and energies are added as integers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Stock<S: Space> {
    /// Largest size of each component of a velocity.
    pub(crate) speeds: S::Vector,
    /// Sum of m v^2, in [`Unit`]s.
    energy: u64,
}

impl<S: Space> Default for Stock<S> {
    fn default() -> Self {
        Self {
            speeds: S::Vector::default(),
            energy: 0,
        }
    }
}

/// The energy that counts as one when energies are added: a power of two, 2^-58 of the last sum or a little more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Unit(f64);

impl Unit {
    /// The unit for energies that sum to about `total`, and at most to 64 times of it.
    pub(crate) fn of(total: f64) -> Self {
        let exponent = (total.to_bits() >> 52) as i32 - 1023;
        let power = (exponent + 1 - 58).clamp(-1000, 1000);
        Self(f64::from_bits(((power + 1023) as u64) << 52))
    }

    /// How many units one is.
    pub(crate) fn inverse(self) -> f64 {
        1.0 / self.0
    }
}

impl<S: Space> Stock<S> {
    /// Notes the simulators of one cell: the largest of their components, and the sum of m v^2.
    #[inline(always)]
    pub(crate) fn note(&mut self, low: S::Vector, high: S::Vector, twice_energy: f64, units: f64) {
        self.note_speeds(S::vector(|axis| larger(high[axis], -low[axis])));
        self.add_energy(twice_energy, units);
    }

    /// Notes components of velocities, without their sign.
    #[inline(always)]
    pub(crate) fn note_speeds(&mut self, fastest: S::Vector) {
        let speeds = self.speeds;
        self.speeds = S::vector(|axis| larger(speeds[axis], fastest[axis]));
    }

    /// Adds m v^2.
    #[inline(always)]
    pub(crate) fn add_energy(&mut self, twice_energy: f64, units: f64) {
        self.energy = self.energy.saturating_add((twice_energy * units) as u64);
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.speeds = S::vector(|axis| larger(self.speeds[axis], other.speeds[axis]));
        self.energy = self.energy.saturating_add(other.energy);
    }

    /// Whether more energy was added than it can hold.
    pub(crate) fn is_full(&self) -> bool {
        self.energy == u64::MAX
    }

    /// Sets the sum of m v^2 \[energy\].
    pub(crate) fn set_twice_energy(&mut self, twice_energy: f64, unit: Unit) {
        self.energy = (twice_energy * unit.inverse()) as u64;
    }

    /// Sum of m v^2 \[energy\].
    pub(crate) fn twice_energy(&self, unit: Unit) -> f64 {
        self.energy as f64 * unit.0
    }
}
