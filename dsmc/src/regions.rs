//! Adaptive simulator weights: the weight factor of a region of the box follows its number of
//! simulators.

use stosszahl_model::ParticleModel;
use stosszahl_model::random::Purpose;

use crate::boundary::{GridBoundaries, SimulatorWeights, enter};
use crate::engine::DsmcEngine;
use crate::particle::DisplacementTracking;
use crate::random_counts::draw_whole;

/// Number of time steps between two adaptations of the simulator weights.
const EVERY: u64 = 16;

/// Lowest number of the random streams for adaptive weights; numbers of free flights stay below it.
const REGION_STREAMS: u64 = 1 << 63;

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Doubles or halves the weight factors of regions that hold too many or too few simulators.
    /// Each simulator of such a region is deleted, kept or doubled at random; the change is entered
    /// in the balance ledger. Tiles must be sorted before, and are sorted after.
    pub(crate) fn follow_number(&mut self) {
        let Some(surroundings) = &self.surroundings else {
            return;
        };
        let weights = surroundings.weights().clone();
        let mut counts = vec![0; weights.factors().len()];
        for cell in self.cells_in_order() {
            let (tile, local) = self.grid.locate(cell);
            counts[surroundings.region(&self.grid, cell)] += self.tiles[tile].members(local).len();
        }
        let mean = self.means.simulators() as f64 / counts.len() as f64;
        let changes = weights.changes(&counts, mean);
        if changes.iter().all(|change| *change == 1.0) {
            return;
        }
        let draws = self
            .streams
            .bundle(Purpose::Balance, REGION_STREAMS | self.tally.steps);
        let mut simulators = Vec::with_capacity(self.simulators);
        for cell in self.cells_in_order() {
            let (tile, local) = self.grid.locate(cell);
            let number = self.grid.number(cell);
            let change = changes[surroundings.region(&self.grid, cell)];
            let before = surroundings.factor(number);
            for (order, simulator) in self.tiles[tile].members(local).iter().enumerate() {
                if change == 1.0 {
                    simulators.push(*simulator);
                    continue;
                }
                let address = (u64::from(number) << 32) | order as u64;
                let copies = draw_whole(1.0 / change, &mut draws.stream_at(address));
                let particles = self.constants.weight * before * (copies as f64 * change - 1.0);
                self.ledgers.balanced += 1;
                enter::<P, F>(&self.scene, simulator, particles, &mut self.ledgers.balance);
                simulators.extend((0..copies).map(|_| *simulator));
            }
        }
        let factors = weights.factors().iter().zip(&changes);
        let factors: Vec<f64> = factors.map(|(factor, change)| factor * change).collect();
        if let Some(surroundings) = &mut self.surroundings {
            surroundings.set_weights(&self.grid, weights.with_factors(&factors));
        }
        self.simulators = simulators.len();
        self.fill(&simulators);
        self.update_step_bounds();
    }

    /// Returns true if the simulator weights adapt in this time step.
    pub(crate) fn weighs_anew(&self) -> bool {
        self.followed().is_some() && self.tally.steps.is_multiple_of(EVERY)
    }

    /// Returns the simulator weights if they are adaptive; `None` if fixed.
    pub(crate) fn followed(&self) -> Option<&SimulatorWeights> {
        let surroundings = self.surroundings.as_ref();
        surroundings
            .map(GridBoundaries::weights)
            .filter(|all| all.follows())
    }
}
