//! Error budget of a run: each source of error with its measured value, an estimate of the relative
//! error, and a severity.
//!
//! Estimates are rough and show which numerical choice to refine next; `stosszahl frontier`
//! measures errors. They have the following origin:
//!
//! - *cell*: a collision in a cell of width h carries momentum across the cell. This raises the
//!   viscosity by 16/(45 π) (h/λ)² for the mean free path λ (F. J. Alexander, A. L. Garcia & B. J.
//!   Alder, Phys. Fluids 10, 1540 (1998), doi:10.1063/1.869674, for spheres);
//! - *time step*: flights are cut into steps of length Δt. The Green-Kubo integral of a stress that
//!   relaxes at the rate ν = nT/η is then a sum by the trapezoidal rule. This raises the viscosity
//!   η by (ν Δt)²/12: π/48 (v Δt/λ)² for disks with v = √(2T/m), and 16/(75 π) (v Δt/λ)² for
//!   spheres (N. G. Hadjiconstantinou, Phys. Fluids 12, 2634 (2000)). A displaced partner that
//!   collides again in the same step gives momentum back. The relative error is about half the
//!   number of collisions per simulator and step;
//! - *few simulators*: with displaced cells, the relative error of the collision rate is a third
//!   over the number of simulators in a cell, measured at packing 0.25 and restitution 0.8. With
//!   partners around the contact point, the error of K at `t_0` is
//!   [`Parameters::excess_of_repeated_pairs`];
//! - *limit*, *contact time*: the fraction of wrong collisions, and twice this for the energy of a
//!   cooling gas;
//! - *majorant*, *separation* across cells: no estimate, and a severity by the measured value;
//! - *replicas*: the standard error of the last energy.

use std::f64::consts::PI;

use stosszahl_dsmc::{Parameters, PartnerDisplacement, PartnerSelection};
use stosszahl_results::{Table, table};

use super::mean_over_replicas;
use crate::measure::{
    CompletedRun, Measure, NoOptions, Probe, ReplicaRecords, SampleProbe, described,
};
use crate::plan::{CasePlan, EngineKind, EnginePlan, RATE_ERROR_IN_A_CELL, in_space};

/// Measurement of the sources of error of each engine, with the table `error_budget.csv`.
pub struct ErrorBudget;

/// Largest estimated relative error with green severity, 1 %. The constant `AMBER` is the limit of
/// amber.
const GREEN: f64 = 0.01;
const AMBER: f64 = 0.05;
/// Relative increase of the viscosity by cells as wide as a mean free path, 16/(45 π).
const CELL: f64 = 16.0 / (45.0 * PI);

/// Severity of a source of error: green, amber or red, by its estimated relative error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Green severity: estimated relative error up to 1 %.
    Green,
    /// Amber severity: estimated relative error above 1 %, up to 5 %.
    Amber,
    /// Red severity: estimated relative error above 5 %, or unknown.
    Red,
}

impl Level {
    /// Returns the severity of an estimated relative error; NaN is red.
    pub fn from_error(estimate: f64) -> Self {
        Self::by(estimate, GREEN, AMBER)
    }

    fn by(value: f64, green: f64, amber: f64) -> Self {
        match value {
            _ if value <= green => Self::Green,
            _ if value <= amber => Self::Amber,
            _ => Self::Red,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Green => "green",
            Self::Amber => "amber",
            Self::Red => "red",
        }
    }
}

/// Granular temperatures of one replica at the start and at the end of the run.
type Record = Vec<f64>;

impl Measure for ErrorBudget {
    described!(
        "error_budget",
        "Sources of error of each engine, with rough estimates.",
        NoOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_uniform_box()
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        vec![plan.case.run.until]
    }

    fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(SampleProbe::from_start(Record::new(), |record, moment| {
            record.push(moment.temperature());
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "error_budget", "Sources of error of each engine.";
            key "engine", "", "Engine";
            key "source", "", "Source of error";
            note "value", "", "What was measured of it";
            note "unit", "", "Unit of the value";
            value "estimate", "1", "Rough estimate of the relative error; empty where there is none";
            note "severity", "", "green up to 1 %, amber up to 5 %, red beyond or unknown";
            note "explanation", "", "What goes wrong, and in what";
        };
        for (index, engine) in plan.engines.iter().enumerate() {
            let budget = Budget {
                plan,
                runs: &runs.finished[index],
                records: runs.records(index),
            };
            for source in budget.sources(engine) {
                let finite = |value: f64| value.is_finite().then_some(value);
                let (value, unit) = source.value;
                let mark = source.level.name();
                let about = (finite(source.estimate), mark, source.reason);
                table.add((engine.name, source.name, finite(value), unit, about));
            }
        }
        vec![table]
    }
}

/// Source of error of an engine, with its measured value and its estimated relative error.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    name: &'static str,
    /// Measured value of the source of error, and its unit.
    value: (f64, &'static str),
    /// Estimated relative error of the results; NaN without an estimate.
    estimate: f64,
    level: Level,
    reason: &'static str,
}

impl Source {
    fn new(
        name: &'static str,
        value: (f64, &'static str),
        estimate: f64,
        reason: &'static str,
    ) -> Self {
        Self {
            name,
            value,
            estimate,
            level: Level::from_error(estimate),
            reason,
        }
    }

    /// Returns the source of error with another severity, for sources without an estimate.
    fn marked(self, level: Level) -> Self {
        Self { level, ..self }
    }
}

/// Inputs for the error budget of one engine: the plan, finished runs and temperatures.
struct Budget<'a> {
    plan: &'a CasePlan,
    runs: &'a [CompletedRun],
    records: Vec<&'a Record>,
}

impl Budget<'_> {
    fn sources(&self, engine: &EnginePlan) -> Vec<Source> {
        let mut list = match &engine.kind {
            EngineKind::EventDriven { contact_time, .. } if *contact_time > 0.0 => {
                let share = self.work("share_of_collisions_made_elastic");
                let reason = "contacts within the contact time lose no energy: error of K";
                vec![Source::new(
                    "contact time",
                    (share, "of the collisions"),
                    2.0 * share,
                    reason,
                )]
            }
            EngineKind::MonteCarlo(parameters) => self.monte_carlo(parameters),
            _ => Vec::new(),
        };
        list.push(self.replicas());
        list
    }

    /// Averages a named work counter of the engine over replicas.
    fn work(&self, name: &str) -> f64 {
        let numbers = self.runs.iter().map(|run| run.work.numbers.get(name));
        let sum: f64 = numbers
            .map(|number| number.copied().unwrap_or(f64::NAN))
            .sum();
        sum / self.runs.len() as f64
    }

    fn monte_carlo(&self, parameters: &Parameters) -> Vec<Source> {
        let path = self.plan.mean_free_path();
        let within = !parameters.scheme.is_cross_cell();
        let cell = within.then(|| {
            let width = self.plan.cell(parameters)[0] / path;
            let reason = "cells carry momentum across their width: error of the viscosity";
            Source::new(
                "cell",
                (width, "mean free paths"),
                CELL * width * width,
                reason,
            )
        });
        let share = self.work("share_of_collisions_in_limited_cells");
        let reason = "collisions in cells whose contact value was cut at max_contact_value: error of the rate, about";
        let limited = Source::new("limited cells", (share, "of the collisions"), share, reason);
        let all = [
            cell,
            Some(self.step(parameters)),
            self.simulators(parameters),
            Some(self.separation(within, path)),
            Some(self.majorant()),
            Some(limited),
        ];
        all.into_iter().flatten().collect()
    }

    fn step(&self, parameters: &Parameters) -> Source {
        // Each simulator collides so often in a step: the step over the mean free time.
        let step = self.work("collisions_per_simulator_and_step");
        // The most probable speed over the mean one.
        let speeds = 2.0 / PI.sqrt();
        let (estimate, reason) = if parameters.displacement == PartnerDisplacement::None {
            let share = [PI / 48.0, 16.0 / (75.0 * PI)][self.plan.gas.dimension - 2];
            let reason = "flights are cut into steps: error of the viscosity";
            (share * (speeds * step).powi(2), reason)
        } else {
            let reason = "displaced partners that collide again in the step give momentum back: error of the collisional pressure";
            (0.5 * step, reason)
        };
        Source::new("step", (step, "mean free times"), estimate, reason)
    }

    fn simulators(&self, parameters: &Parameters) -> Option<Source> {
        let plan = self.plan;
        if parameters.scheme.partners() == PartnerSelection::AroundContact {
            let packing = plan.gas.packing_fraction;
            let (partners, excess) = in_space!(plan.gas.dimension, S => (
                parameters.partners::<S>(packing, 1.0),
                parameters.excess_of_repeated_pairs::<S>(packing, 1.0, plan.gas.restitution),
            ));
            let reason =
                "simulators that collided meet again and lose less energy: error of K at t0";
            return Some(Source::new(
                "partners",
                (partners, "simulators"),
                excess,
                reason,
            ));
        }
        let count = plan.simulators_per_cell(parameters);
        let (value, estimate) = ((count, "simulators"), RATE_ERROR_IN_A_CELL / count);
        let reason = "pairs of a cell are few and meet again: error of the collision rate";
        let source = Source::new("simulators per cell", value, estimate, reason);
        (!parameters.scheme.is_cross_cell()).then_some(source)
    }

    fn separation(&self, within: bool, path: f64) -> Source {
        /// Mean distance of two random points in a square and in a cube, over the side.
        const APART: [f64; 2] = [0.5214, 0.6617];
        let separation = self.work("collision_separation");
        if within {
            let value = separation / path;
            let estimate = CELL * (value / APART[self.plan.gas.dimension - 2]).powi(2);
            let reason = "partners are apart by this: error of the viscosity, as measured rather than by the width of cells";
            return Source::new("separation", (value, "mean free paths"), estimate, reason);
        }
        let near = (separation - 1.0).abs() <= 0.5;
        let reason = "partners are apart by this and not by one diameter: mean distance, not along the line of centres";
        Source::new("separation", (separation, "diameters"), f64::NAN, reason).marked(if near {
            Level::Green
        } else {
            Level::Amber
        })
    }

    fn majorant(&self) -> Source {
        /// Fraction of candidate pairs faster than the majorant above which the severity is amber.
        const SOME: f64 = 0.01;
        /// Fraction of candidate pairs faster than the majorant above which the severity is red.
        const MANY: f64 = 0.1;
        let share = self.work("majorant_violations_per_trial");
        let reason = "trials faster than the bound of their cell, accepted as if at it; it is raised then, so the rate lacks their \
                      share times an excess that is not recorded";
        let level = Level::by(share, SOME, MANY);
        Source::new("majorant", (share, "of the trials"), f64::NAN, reason).marked(level)
    }

    fn replicas(&self) -> Source {
        let ratio = mean_over_replicas(self.records.iter().map(|one| Some(one[1] / one[0])));
        let error = ratio
            .standard_error
            .zip(ratio.value)
            .map(|(error, value)| error / value);
        let reason = match error {
            Some(_) => "standard error of the last energy",
            None => "one replica cannot tell its own error",
        };
        let count = self.records.len() as f64;
        Source::new(
            "replicas",
            (count, "replicas"),
            error.unwrap_or(f64::NAN),
            reason,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_estimates_and_no_number_is_red() {
        use Level::{Amber, Green, Red};
        let levels = [0.0, 0.01, 0.02, 0.05, 0.06, f64::NAN].map(Level::from_error);
        assert_eq!(levels, [Green, Green, Amber, Amber, Red, Red]);
    }
}
