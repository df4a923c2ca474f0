//! The error budget of a run: each source of error with what was measured of it, an estimate, and a mark.
//!
//! Estimates are rough, for a reader who must decide which choice to refine next; `stosszahl frontier` measures errors. Where they
//! come from:
//!
//! - *cell*: a collision in a cell of width h carries momentum across it, which raises the viscosity by 16/(45 π) (h/λ)²
//!   for the mean free path λ (F. J. Alexander, A. L. Garcia & B. J. Alder, Phys. Fluids 10, 1540 (1998),
//!   doi:10.1063/1.869674, for spheres);
//! - *time step*: flights are cut into steps. The Green-Kubo integral of a stress that relaxes at the rate ν = nT/η is then a
//!   sum by the trapezoidal rule, which raises the viscosity by (ν Δt)²/12: π/48 (v Δt/λ)² for disks with v = √(2T/m), and
//!   16/(75 π) for spheres (N. G. Hadjiconstantinou, Phys. Fluids 12, 2634 (2000)). Where partners are displaced, one that
//!   collides again in the same step gives momentum back: about half a collision per step of it;
//! - *few simulators*: the rate of displaced cells errs by a third over the number in a cell, K at `t_0` with partners
//!   around the point of contact by 0.4 over their number, both measured at packing 0.25 and restitution 0.8;
//! - *limit*, *contact time*: the share of collisions that are not what they should be, twice that for the energy of a gas
//!   that cools at a rate that is wrong by it;
//! - *majorant*, *separation* across cells: no estimate, and a mark by the size of what was measured;
//! - *replicas*: the standard error of the last energy.

use std::f64::consts::PI;

use schemars::Schema;
use serde::{Deserialize, Serialize};
use stosszahl_case::Kind;
use stosszahl_dsmc::{Displacement, Parameters, Scheme};
use stosszahl_model::{Domain, Plane, Space, Volume};
use stosszahl_results::Table;

use super::over;
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, keeps_record};
use crate::plan::{EngineKind, EnginePlan, Plan};

/// The error budget.
pub struct ErrorBudget;

/// It has no options.
#[derive(Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {}

/// Estimates up to these are green and amber.
const GREEN: f64 = 0.01;
const AMBER: f64 = 0.05;
/// Share by which cells of a mean free path raise the viscosity, 16/(45 π).
const CELL: f64 = 16.0 / (45.0 * PI);

/// How far a source of error is to be minded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Up to 1 %.
    Green,
    /// Up to 5 %.
    Amber,
    /// More, or unknown.
    Red,
}

impl Level {
    /// Of an estimated relative error; what is no number is red.
    pub fn of(estimate: f64) -> Self {
        if estimate <= GREEN {
            Self::Green
        } else if estimate <= AMBER {
            Self::Amber
        } else {
            Self::Red
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

/// Temperatures of the start and of the end.
#[derive(Default, Serialize, Deserialize)]
struct Record {
    start: f64,
    end: f64,
}

#[derive(Default)]
struct BudgetProbe {
    record: Record,
}

impl Probe for BudgetProbe {
    fn begin(&mut self, moment: &mut Moment<'_>) {
        self.record.start = moment.simulation.temperature();
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        self.record.end = moment.simulation.temperature();
    }

    keeps_record!();
}

impl Measure for ErrorBudget {
    fn name(&self) -> &'static str {
        "error_budget"
    }

    fn about(&self) -> &'static str {
        "Sources of error of each engine, with rough estimates."
    }

    fn schema(&self) -> Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Comparison
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        measure::options::<Options>(plan, self.name()).map(|_| ())
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        vec![plan.case.run.until]
    }

    fn probe(&self, _plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(BudgetProbe::default())
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut table = Table::new("error_budget", "Sources of error of each engine.")
            .key("engine", "", "Engine")
            .key("source", "", "Source of error")
            .note("value", "", "What was measured of it")
            .note("unit", "", "Unit of the value")
            .value(
                "estimate",
                "1",
                "Rough estimate of the relative error; empty where there is none",
            )
            .note(
                "mark",
                "",
                "green up to 1 %, amber up to 5 %, red beyond or unknown",
            )
            .note("reason", "", "What goes wrong, and in what");
        for (engine, known) in plan.engines.iter().enumerate() {
            let budget = Budget { plan, runs, engine };
            for source in budget.sources(known) {
                let finite = |value: f64| value.is_finite().then_some(value);
                table
                    .row()
                    .text(known.name)
                    .text(source.name)
                    .number(finite(source.value))
                    .text(source.unit)
                    .number(finite(source.estimate))
                    .text(source.level.name())
                    .text(source.reason);
            }
        }
        vec![table]
    }
}

/// One source of error.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    name: &'static str,
    value: f64,
    unit: &'static str,
    /// Relative error; not a number where there is no estimate.
    estimate: f64,
    level: Level,
    reason: &'static str,
}

impl Source {
    fn new(
        name: &'static str,
        value: f64,
        unit: &'static str,
        estimate: f64,
        reason: &'static str,
    ) -> Self {
        let level = Level::of(estimate);
        Self {
            name,
            value,
            unit,
            estimate,
            level,
            reason,
        }
    }

    /// A source without an estimate, by a mark of its value.
    fn marked(
        level: Level,
        name: &'static str,
        value: f64,
        unit: &'static str,
        reason: &'static str,
    ) -> Self {
        Self {
            level,
            ..Self::new(name, value, unit, f64::NAN, reason)
        }
    }
}

/// One engine of a run.
struct Budget<'a> {
    plan: &'a Plan,
    runs: &'a Runs<'a>,
    engine: usize,
}

impl Budget<'_> {
    fn sources(&self, engine: &EnginePlan) -> Vec<Source> {
        let mut list = match &engine.kind {
            EngineKind::EventDriven { contact_time, .. } if *contact_time > 0.0 => {
                let share = self.work("share_of_collisions_made_elastic");
                let reason = "contacts within the contact time lose no energy: error of K";
                vec![Source::new(
                    "contact time",
                    share,
                    "of the collisions",
                    2.0 * share,
                    reason,
                )]
            }
            EngineKind::MonteCarlo(parameters) if self.plan.dimension == 2 => {
                self.monte_carlo::<Plane>(parameters)
            }
            EngineKind::MonteCarlo(parameters) => self.monte_carlo::<Volume>(parameters),
            _ => Vec::new(),
        };
        list.push(self.replicas());
        list
    }

    /// Mean of a number of work over the replicas.
    fn work(&self, name: &str) -> f64 {
        let runs = &self.runs.finished[self.engine];
        let numbers = runs.iter().map(|run| run.work.numbers.get(name).copied());
        let sum: f64 = numbers.map(|number| number.unwrap_or(f64::NAN)).sum();
        sum / runs.len() as f64
    }

    fn monte_carlo<S: Space>(&self, parameters: &Parameters) -> Vec<Source> {
        let path = self.plan.mean_free_path();
        let mut list = Vec::new();
        let within = !parameters.scheme.is_across();
        let sides = self.cell::<S>(parameters);
        if let (true, Some(sides)) = (within, &sides) {
            let width = sides[0] / path;
            let reason = "cells carry momentum across their width: error of the viscosity";
            list.push(Source::new(
                "cell",
                width,
                "mean free paths",
                CELL * width * width,
                reason,
            ));
        }
        list.push(self.step(parameters));
        list.extend(self.simulators::<S>(parameters, sides));
        list.push(self.separation(within, path));
        list.push(self.majorant());
        let share = self.work("share_of_collisions_in_limited_cells");
        let reason = "collisions in cells whose contact value was cut at largest_contact_value: error of the rate, about";
        list.push(Source::new(
            "limited cells",
            share,
            "of the collisions",
            share,
            reason,
        ));
        list
    }

    /// Sides of a cell.
    fn cell<S: Space>(&self, parameters: &Parameters) -> Option<Vec<f64>> {
        let lengths = self.plan.lengths;
        let domain = Domain::<S>::periodic(S::vector(|axis| lengths[axis])).ok()?;
        let cells = parameters.cells(&domain, self.plan.packing_fraction, 1.0);
        let sides = (0..S::DIMENSION).map(|axis| lengths[axis] / cells[axis] as f64);
        Some(sides.collect())
    }

    fn step(&self, parameters: &Parameters) -> Source {
        // Each simulator collides so often in a step: the step over the mean free time.
        let step = self.work("collisions_per_simulator_and_step");
        if parameters.displacement != Displacement::None {
            let reason = "displaced partners that collide again in the step give momentum back: error of the collisional pressure";
            return Source::new("step", step, "mean free times", 0.5 * step, reason);
        }
        // The most probable speed over the mean one.
        let speeds = 2.0 / PI.sqrt();
        let share = if self.plan.dimension == 2 {
            PI / 48.0
        } else {
            16.0 / (75.0 * PI)
        };
        let reason = "flights are cut into steps: error of the viscosity";
        Source::new(
            "step",
            step,
            "mean free times",
            share * (speeds * step).powi(2),
            reason,
        )
    }

    fn simulators<S: Space>(
        &self,
        parameters: &Parameters,
        cell: Option<Vec<f64>>,
    ) -> Option<Source> {
        let plan = self.plan;
        let copies = f64::from(parameters.simulators_per_disk);
        if let Scheme::ContactPoint { .. } = parameters.scheme {
            let radius = parameters.partner_radius::<S>(plan.packing_fraction, 1.0);
            let shell = S::ball(1.0 + radius) - S::ball((1.0 - radius).max(0.0));
            let density = plan.packing_fraction / S::ball(0.5);
            // With radius 0 the nearest is taken.
            let partners = (density * shell * copies).max(1.0);
            let reason =
                "simulators that collided meet again and lose less energy: error of K at t0";
            return Some(Source::new(
                "partners",
                partners,
                "simulators",
                0.4 / partners,
                reason,
            ));
        }
        if parameters.scheme.is_across() {
            return None;
        }
        let share = cell?.iter().product::<f64>() / plan.volume;
        let count = share * plan.count() as f64 * copies;
        let reason = "pairs of a cell are few and meet again: error of the collision rate";
        Some(Source::new(
            "simulators per cell",
            count,
            "simulators",
            1.0 / (3.0 * count),
            reason,
        ))
    }

    fn separation(&self, within: bool, path: f64) -> Source {
        /// Mean distance of two random points of a square and of a cube, over the side.
        const APART: [f64; 2] = [0.5214, 0.6617];
        let separation = self.work("collision_separation");
        if within {
            let value = separation / path;
            let estimate = CELL * (value / APART[self.plan.dimension - 2]).powi(2);
            let reason = "partners are apart by this: error of the viscosity, as measured rather than by the width of cells";
            return Source::new("separation", value, "mean free paths", estimate, reason);
        }
        let level = if (separation - 1.0).abs() <= 0.5 {
            Level::Green
        } else {
            Level::Amber
        };
        let reason = "partners are apart by this and not by one diameter: mean distance, not along the line of centres";
        Source::marked(level, "separation", separation, "diameters", reason)
    }

    fn majorant(&self) -> Source {
        /// Shares from which the bound is looked at, and from which it is no bound.
        const SOME: f64 = 0.01;
        const MANY: f64 = 0.1;
        let share = self.work("majorant_violations_per_trial");
        let level = if share <= SOME {
            Level::Green
        } else if share <= MANY {
            Level::Amber
        } else {
            Level::Red
        };
        let reason = "trials faster than the bound of their cell, accepted as if at it; it is raised then, so the rate lacks their \
                      share times an excess that is not recorded";
        Source::marked(level, "majorant", share, "of the trials", reason)
    }

    fn replicas(&self) -> Source {
        let records = self.runs.records::<Record>(self.engine);
        let ratio = over(records.iter().map(|one| Some(one.end / one.start)));
        let error = ratio
            .standard_error
            .zip(ratio.value)
            .map(|(error, value)| error / value);
        let reason = if error.is_some() {
            "standard error of the last energy"
        } else {
            "one replica cannot tell its own error"
        };
        let count = records.len() as f64;
        Source::new(
            "replicas",
            count,
            "replicas",
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
        let levels = [0.0, 0.01, 0.02, 0.05, 0.06, f64::NAN].map(Level::of);
        assert_eq!(levels, [Green, Green, Amber, Amber, Red, Red]);
    }
}
