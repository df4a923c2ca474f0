//! Computing time of the start and of each engine at nominal speeds.

use stosszahl_case::format::SelectionSpec;

use crate::plan::{CasePlan, EngineKind, EnginePlan};

/// Speed of event-driven dynamics that the time estimate assumes \[pair collisions/s\].
const COLLISIONS_PER_SECOND: f64 = 6e5;
/// Speed of Monte Carlo free flight that the time estimate assumes \[simulators moved by one time
/// step/s\].
const SIMULATOR_STEPS_PER_SECOND: f64 = 1.5e7;
/// Speed of cell crossings in event-driven dynamics that the time estimate assumes \[crossings/s\].
const CROSSINGS_PER_SECOND: f64 = 5e6;
/// Cell crossings per collision that `COLLISIONS_PER_SECOND` already includes.
const USUAL_CROSSINGS: f64 = 5.0;
/// Speed of Monte Carlo collisions with partners from other cells that the time estimate assumes
/// \[collisions/s\].
const COLLISIONS_ACROSS_PER_SECOND: f64 = 5e5;
/// Speed of Monte Carlo candidate pairs that the time estimate assumes \[pairs/s\].
const TRIALS_PER_SECOND: f64 = 5e6;
/// Computing time of one Monte Carlo cell in a time step, over that of one simulator.
const CELL_STEPS: f64 = 0.3;

impl CasePlan {
    /// Returns the time of event-driven dynamics for `pairs` pair collisions on one core \[s\].
    fn exact_seconds(&self, pairs: f64) -> f64 {
        let crossings = (self.crossings_per_collision() - USUAL_CROSSINGS).max(0.0);
        pairs * (1.0 / COLLISIONS_PER_SECOND + crossings / CROSSINGS_PER_SECOND)
    }

    /// Returns the time to equilibrate the initial state of one replica on one core \[s\].
    pub(crate) fn start_seconds(&self) -> f64 {
        if self.equilibration() == 0.0 {
            return 0.0;
        }
        self.exact_seconds(0.5 * self.count() as f64 * self.equilibration())
    }

    /// Estimates the computing time of one engine in one replica on one core \[s\].
    pub fn seconds(&self, engine: &EnginePlan) -> f64 {
        let particles = self.count() as f64;
        let pairs = 0.5 * particles * self.expected_collisions(self.case.run.until);
        let trials = self.trials_per_collision(engine).unwrap_or(0.0);
        let tried = self.collisions(engine) * trials / TRIALS_PER_SECOND;
        match &engine.kind {
            EngineKind::EventDriven { .. } => self.exact_seconds(pairs),
            EngineKind::MonteCarlo(parameters) => {
                let copies = engine.copies() as f64;
                let across = if parameters.scheme.is_cross_cell() {
                    copies * pairs / COLLISIONS_ACROSS_PER_SECOND
                } else {
                    0.0
                };
                across.max(tried)
                    + self.expected_steps(parameters)
                        * (particles * copies + CELL_STEPS * self.cells(parameters))
                        / SIMULATOR_STEPS_PER_SECOND
            }
            EngineKind::Homogeneous(selection) => {
                let rate = match selection {
                    SelectionSpec::AliasTables => 3e6,
                    SelectionSpec::LowRank => 1.5e6,
                    SelectionSpec::SingleMajorant => 2e5,
                };
                (pairs / rate).max(tried)
            }
        }
    }
}
