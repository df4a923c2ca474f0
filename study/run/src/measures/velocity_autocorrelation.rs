//! The velocity autocorrelation C(t) = <v(0) . v(t)>/<v(0)^2>: how long particles remember their velocity.
//!
//! Time runs from a chosen moment of the run. Particles are known by their index, so an engine must keep it: event-driven
//! dynamics, and Monte Carlo gases in which no simulators come, go, split or merge.

use nalgebra::Vector3;
use schemars::Schema;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::Weights;
use stosszahl_results::{Axis, Figure, Line, Table};

use super::{grid, over};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, keeps_record};
use crate::plan::{EnginePlan, Plan};

/// The velocity autocorrelation.
pub struct VelocityAutocorrelation;

/// From when on.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// The time to which velocities are compared.
    pub from: f64,
}

#[derive(Default, Serialize, Deserialize)]
struct Record {
    /// Velocities at the beginning.
    first: Vec<[f64; 3]>,
    /// C(t) by time since then.
    correlations: Vec<(f64, f64)>,
}

struct AutocorrelationProbe {
    from: f64,
    record: Record,
}

impl Probe for AutocorrelationProbe {
    fn sample(&mut self, moment: &mut Moment<'_>) {
        let particles = &moment.particles().all;
        if moment.time == self.from {
            self.record.first = particles.iter().map(|one| one.velocity.into()).collect();
        }
        let pairs = particles.iter().zip(&self.record.first);
        let (mut both, mut own) = (0.0, 0.0);
        for (particle, &first) in pairs {
            let first = Vector3::from(first);
            both += first.dot(&particle.velocity);
            own += first.norm_squared();
        }
        let elapsed = moment.time - self.from;
        self.record.correlations.push((elapsed, both / own));
    }

    keeps_record!();
}

impl VelocityAutocorrelation {
    fn from(&self, plan: &Plan) -> f64 {
        measure::options(plan, self.name()).map_or(0.0, |options: Options| options.from)
    }
}

impl Measure for VelocityAutocorrelation {
    fn name(&self) -> &'static str {
        "velocity_autocorrelation"
    }

    fn about(&self) -> &'static str {
        "Velocity autocorrelation C(t) = <v(0).v(t)>/<v(0)^2> of the particles since a chosen time."
    }

    fn kept_per_particle(&self, _plan: &Plan) -> f64 {
        size_of::<[f64; 3]>() as f64
    }

    fn schema(&self) -> Schema {
        schemars::schema_for!(Options)
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        let Options { from } = measure::options(plan, self.name())?;
        let until = plan.case.run.until;
        let allowed = format!("a time from 0 to below run.until = {until}; found {from}");
        measure::require((0.0..until).contains(&from), "from", allowed)?;
        let closed = plan.case.inflow.is_empty() && plan.case.sticking.is_none();
        let allowed =
            "a gas whose particles neither come nor go nor stick: they are known by their index";
        measure::require(closed, "", allowed)?;
        let mut weighted = plan
            .engines
            .iter()
            .filter(|engine| engine.weights != Weights::uniform());
        let weighted = weighted.next();
        let allowed = weighted.map_or(String::new(), |engine| {
            let name = engine.name;
            format!(
                "engines that keep particles; {name} splits and merges simulators by its weights"
            )
        });
        measure::require(weighted.is_none(), "", allowed)
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        let from = self.from(plan);
        let later = grid(plan, plan.case.run.until - from).map(|elapsed| from + elapsed);
        std::iter::once(from).chain(later).collect()
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(AutocorrelationProbe {
            from: self.from(plan),
            record: Record::default(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut figure = Figure::curves(
            "Velocity autocorrelation",
            Axis::logarithmic("elapsed", "time"),
            Axis::linear("correlation", "C(t)"),
        );
        figure.lines.push(Line {
            label: "forgotten".into(),
            y: 0.0,
        });
        let mut table = Table::new(
            "velocity_autocorrelation",
            "Velocity autocorrelation in time.",
        )
        .key("engine", "", "Engine")
        .key(
            "elapsed",
            "time",
            "Time since the beginning of the measurement",
        )
        .estimate(
            "correlation",
            "1",
            "C(t) = <v(0).v(t)>/<v(0)^2>; one at the beginning",
        )
        .note("replicas", "1", "Replicas")
        .figure(figure);
        for (engine, known) in plan.engines.iter().enumerate() {
            let records = runs.records::<Record>(engine);
            let times = records.first().map_or(&[][..], |one| &one.correlations);
            for (index, &(elapsed, _)) in times.iter().enumerate() {
                let values = records
                    .iter()
                    .map(|one| one.correlations.get(index).map(|at| at.1));
                table
                    .row()
                    .text(known.name)
                    .number(elapsed)
                    .estimate(over(values))
                    .count(records.len() as u64);
            }
        }
        vec![table]
    }
}
