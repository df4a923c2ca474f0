//! Measure `velocity_autocorrelation`: the function `C(t) = <v(0) . v(t)>/<v(0)^2>`, which shows
//! how long particles remember their velocity.
//!
//! Time runs from a chosen moment of the run. Particles are known by their index, so an engine must
//! keep it: event-driven dynamics, and Monte Carlo gases in which no simulators come, go, split or
//! merge.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_results::{Figure, FigureAxis, Table, table};

use super::{grid, mean_over_replicas, require_kept};
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `velocity_autocorrelation` of the function C(t).
pub struct VelocityAutocorrelation;

/// Options of `[measure.velocity_autocorrelation]`: begin of the measurement.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AutocorrelationOptions {
    /// Time of the velocities with which later ones are correlated.
    pub from: f64,
}

#[derive(Default, Serialize, Deserialize)]
struct Record {
    /// Velocities of the particles at the start of the measurement, in the order of particles.
    first: Vec<[f64; 3]>,
    /// Autocorrelation C(t), with the time t since the start of the measurement.
    correlations: Vec<(f64, f64)>,
}

impl VelocityAutocorrelation {
    fn from(&self, plan: &CasePlan) -> f64 {
        measure::chosen::<AutocorrelationOptions>(plan, self.name()).from
    }
}

impl Measure for VelocityAutocorrelation {
    described!(
        "velocity_autocorrelation",
        "Velocity autocorrelation C(t) = <v(0).v(t)>/<v(0)^2> of the particles since a chosen time.",
        AutocorrelationOptions
    );

    fn gathers_particles(&self, _plan: &CasePlan) -> bool {
        true
    }

    fn kept_per_particle(&self, _plan: &CasePlan) -> f64 {
        size_of::<[f64; 3]>() as f64
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        measure::options::<AutocorrelationOptions>(plan, self.name())?;
        let closed = plan.case.inflow.is_empty() && plan.case.aggregation.is_none();
        let allowed =
            "a gas whose particles neither come nor go nor stick: they are known by their index";
        measure::require(closed, "", allowed)?;
        require_kept(plan)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let from = self.from(plan);
        let later = grid(plan, plan.case.run.until - from).map(|elapsed| from + elapsed);
        std::iter::once(from).chain(later).collect()
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let from = self.from(plan);
        Box::new(SampleProbe::new(
            Record::default(),
            move |record, moment| {
                let particles = &moment.particles().all;
                if moment.time == from {
                    record.first = particles.iter().map(|one| one.velocity.into()).collect();
                }
                let (mut both, mut own) = (0.0, 0.0);
                for (particle, &first) in particles.iter().zip(&record.first) {
                    let first = Vector3::from(first);
                    both += first.dot(&particle.velocity);
                    own += first.norm_squared();
                }
                record.correlations.push((moment.time - from, both / own));
            },
        ))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let figure = Figure::curves(
            "Velocity autocorrelation",
            FigureAxis::logarithmic("lag", "time"),
            FigureAxis::linear("correlation", "C(t)"),
        );
        let mut table = table! {
            "velocity_autocorrelation", "Velocity autocorrelation in time.";
            key "engine", "", "Engine";
            key "lag", "time", "Time since the beginning of the measurement";
            estimate "correlation", "1", "C(t) = <v(0).v(t)>/<v(0)^2>; one at the beginning";
            note "replicas", "1", "Replicas";
        }
        .figure(figure.line("forgotten", 0.0));
        for (engine, records) in runs.each::<Record>(plan) {
            let times = records.first().map_or(&[][..], |one| &one.correlations);
            for (index, &(elapsed, _)) in times.iter().enumerate() {
                let values = records
                    .iter()
                    .map(|one| Some(one.correlations.get(index)?.1));
                table.add((
                    engine.name,
                    elapsed,
                    mean_over_replicas(values),
                    records.len(),
                ));
            }
        }
        vec![table]
    }
}
