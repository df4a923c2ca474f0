//! Expected work of the engines of a case: collisions, candidate pairs, time steps, cells.

use stosszahl_case::format::SelectionSpec;
use stosszahl_model::SizeDistribution;

use super::data::{CasePlan, EngineKind, EnginePlan, SizeGroup};

/// Candidate pairs per collision of equal particles: for partners in one cell, and for partners
/// across cells, whose speed bound is wider.
const TRIALS: [f64; 2] = [2.0, 4.0];
/// Largest number of size classes whose pairs are all summed for the cost estimate; of more
/// classes, a sample is used.
const MOST_KINDS: usize = 200;

impl CasePlan {
    /// Returns the cell crossings per pair collision of event-driven disks in a uniform gas.
    pub(crate) fn crossings_per_collision(&self) -> f64 {
        let [width, height, _] = self.gas.lengths;
        let diameters = self.gas.species.iter().map(|one| 2.0 * one.radius);
        stosszahl_ed::crossings_per_collision(
            [width, height],
            self.count(),
            diameters.fold(0.0, f64::max),
            self.dilute_mean_free_path(),
            !self.case.obstacle.is_empty(),
        )
    }

    /// Estimates the number of pair collisions of one engine in one replica.
    pub fn collisions(&self, engine: &EnginePlan) -> f64 {
        let copies = engine.copies() as f64;
        0.5 * copies * self.count() as f64 * self.expected_collisions(self.case.run.until)
    }

    /// Estimates the candidate pairs per collision; `None` for event-driven dynamics. Candidates
    /// are drawn for the largest diameter and the largest thermal speed, so it is that bound over
    /// the mean of `sigma^(D-1) v`.
    pub fn trials_per_collision(&self, engine: &EnginePlan) -> Option<f64> {
        let trials = match &engine.kind {
            EngineKind::EventDriven { .. } => return None,
            EngineKind::Homogeneous(SelectionSpec::AliasTables | SelectionSpec::LowRank) => {
                return Some(TRIALS[0]);
            }
            EngineKind::Homogeneous(SelectionSpec::SingleMajorant) => TRIALS[1],
            EngineKind::MonteCarlo(parameters) => {
                TRIALS[usize::from(parameters.scheme.is_cross_cell())]
            }
        };
        // Diameter, square of the speed, and share of each class; the largest of all particles may
        // exceed its class.
        let largest = match &self.gas.particles.sizes {
            SizeDistribution::Equal(_) => return Some(trials),
            SizeDistribution::Each(all) => all
                .pairs()
                .iter()
                .map(|one| 2.0 * one.0)
                .fold(0.0, f64::max),
            SizeDistribution::Species(_) => 0.0,
        };
        let kind = |one: &SizeGroup| [one.diameter, one.temperature / one.mass, one.count as f64];
        let most = |index: usize| {
            let all = self.gas.classes.iter().map(|one| kind(one)[index]);
            all.fold(if index == 0 { largest } else { 0.0 }, f64::max)
        };
        let power = self.gas.dimension as i32 - 1;
        let bound = most(0).powi(power) * (2.0 * most(1)).sqrt();
        let kinds: Vec<[f64; 3]> = sampled(&self.gas.classes).map(kind).collect();
        let pairs = kinds.iter().flat_map(|a| kinds.iter().map(move |b| (a, b)));
        let (mut sum, mut weight) = (0.0, 0.0);
        for (a, b) in pairs {
            let share = a[2] * b[2];
            sum += share * (0.5 * (a[0] + b[0])).powi(power) * (a[1] + b[1]).sqrt();
            weight += share;
        }
        Some((trials * bound * weight / sum).max(trials))
    }

    /// Returns the number of cells of a Monte Carlo engine.
    pub(crate) fn cells(&self, parameters: &stosszahl_dsmc::Parameters) -> f64 {
        let cell: f64 = self.cell(parameters)[..self.gas.dimension].iter().product();
        self.box_volume() / cell
    }

    /// Estimates the number of time steps of a Monte Carlo engine until the end of the run.
    pub fn expected_steps(&self, parameters: &stosszahl_dsmc::Parameters) -> f64 {
        // The fastest of many simulators has about 4.5 thermal speeds, a mean one 1.25.
        let mut step = self.scheme_path(parameters) / 1.25;
        if !parameters.scheme.is_cross_cell() {
            step = step.min(self.cell(parameters)[0] / 4.5);
        }
        let until = self.case.run.until;
        let masses = self.gas.species.iter().map(|one| one.mass);
        let lightest = masses.fold(f64::INFINITY, f64::min);
        let thermal = (self.gas.temperature / lightest).sqrt();
        let time = self.expected_collisions(until) * self.clock.mean_free_time;
        time * thermal * parameters.steps_per_cell_crossing / step
    }
}

/// Returns at most 200 evenly spaced elements of a list, for sums over all pairs of size classes.
fn sampled<T>(all: &[T]) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(MOST_KINDS).max(1))
}
