//! Temperatures of the species of a mixture, against Enskog's kinetic equations.

use schemars::Schema;
use serde::Deserialize;
use stosszahl_analysis::energy::EnergySample;
use stosszahl_case::Kind;
use stosszahl_model::{GrainSizes, Particles};
use stosszahl_results::{Axis, Figure, Table, Verdict};

use super::over;
use crate::judge::{Point, against_theory, title};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, keeps_record};
use crate::plan::{EnginePlan, Plan};

/// Temperatures of the species.
pub struct SpeciesTemperatures;

/// It has no options.
#[derive(Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {}

/// The early state, in units of Haff's time, or of the mean free time without dissipation: after the ratios have settled, before the gas can have become inhomogeneous.
const EARLY: [f64; 2] = [1.0, 5.0];

/// Temperature of the gas and of each species, by sample.
type Record = Vec<(f64, Vec<f64>)>;

struct SpeciesProbe {
    /// Number of species, and that of each index, or of each kind of the engine.
    species: usize,
    by_index: bool,
    groups: Vec<u32>,
    record: Record,
}

impl Probe for SpeciesProbe {
    fn sample(&mut self, moment: &mut Moment<'_>) {
        let particles = moment.particles();
        let whole = EnergySample::of(particles, 0).temperature;
        let of = |index: usize, kind: u32| {
            let known = if self.by_index {
                index % self.groups.len()
            } else {
                kind as usize % self.groups.len()
            };
            self.groups[known] as usize
        };
        let temperatures = temperatures(particles, self.species, of);
        self.record.push((whole, temperatures));
    }

    keeps_record!();
}

/// Kinds of particle in an engine: the species, or every particle of a gas of continuous sizes.
fn kinds(plan: &Plan) -> usize {
    let each = plan.case.continuous.as_ref();
    each.map_or(plan.species.len(), |one| one.number as usize)
}

/// Temperature <m v^2>/D of each species; 0 of one without particles. Weights count by their ratio to the first.
fn temperatures(
    particles: &Particles,
    species: usize,
    of: impl Fn(usize, u32) -> usize,
) -> Vec<f64> {
    let first = particles.all.first().map_or(1.0, |one| one.weight);
    let mut sums = vec![(0.0_f64, 0.0); species];
    for (index, one) in particles.all.iter().enumerate() {
        let (count, twice) = &mut sums[of(index, one.species)];
        let weight = one.weight / first;
        *count += weight;
        *twice += weight * one.mass * one.velocity.norm_squared();
    }
    let degrees = particles.dimension as f64;
    let each = sums.into_iter();
    each.map(|(count, twice)| {
        if count > 0.0 {
            twice / (degrees * count)
        } else {
            0.0
        }
    })
    .collect()
}

impl Measure for SpeciesTemperatures {
    fn name(&self) -> &'static str {
        "species_temperatures"
    }

    fn about(&self) -> &'static str {
        "Temperature of each species in time, against Enskog's kinetic equations."
    }

    fn schema(&self) -> Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Comparison && plan.species.len() > 1
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        let several = plan.species.len() > 1;
        measure::require(
            several,
            "",
            "several species, by [[species]]; this gas has one",
        )?;
        measure::options::<Options>(plan, self.name()).map(|_| ())
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        plan.sample_times()
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        // Particles that each have their own size carry no species; their indices tell it.
        let by_index = matches!(plan.grains.sizes, GrainSizes::Each(_));
        Box::new(SpeciesProbe {
            species: plan.species.len(),
            by_index,
            groups: if by_index {
                let all = 0..plan.count();
                all.map(|index| plan.species_of(index) as u32).collect()
            } else {
                let (of, kinds) = (plan.species.len(), kinds(plan));
                (0..kinds).map(|kind| (kind * of / kinds) as u32).collect()
            },
            record: Vec::new(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut figure = Figure::curves(
            "Temperatures of the species",
            Axis::logarithmic("time", "time"),
            Axis::linear("ratio_to_first", "T of the species over that of the first"),
        );
        figure.curves.push("species".into());
        let mut table = Table::new(
            "partial_temperature",
            "Temperature of each species in time.",
        )
        .key("engine", "", "Engine")
        .key("time", "time", "Time since the start")
        .key("species", "1", "Number of the species, from 1")
        .with_theory(
            "temperature_ratio",
            "1",
            "Its temperature over that of the gas at the start; theory by Enskog's equations",
        )
        .with_theory(
            "ratio_to_first",
            "1",
            "Its temperature over that of the first species",
        )
        .note("replicas", "1", "Replicas")
        .figure(figure);
        let times = plan.sample_times();
        let theory = plan.partial_temperatures(&times);
        for (engine, known) in plan.engines.iter().enumerate() {
            let records = runs.records::<Record>(engine);
            for (index, &time) in times.iter().enumerate() {
                let expected = theory.as_ref().map(|all| &all[index]);
                for species in 0..plan.species.len() {
                    let at = |record: &&Record| record[index].1.clone();
                    let start = |record: &&Record| record[0].0;
                    let mut own = over(records.iter().map(|r| Some(at(r)[species] / start(r))));
                    let mut ratio = over(records.iter().map(|r| Some(at(r)[species] / at(r)[0])));
                    own.theory = expected.map(|all| all[species]);
                    ratio.theory = expected.map(|all| all[species] / all[0]);
                    table
                        .row()
                        .text(known.name)
                        .number(time)
                        .count(species as u64 + 1)
                        .estimate(own)
                        .estimate(ratio)
                        .count(records.len() as u64);
                }
            }
        }
        vec![table]
    }

    /// Ratios of the temperatures to that of the first, averaged over the early state of a cooling gas.
    fn verdicts(&self, plan: &Plan, runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        let times = plan.sample_times();
        let within = |index: &usize| {
            let time = plan.time_over_haff(times[*index]).unwrap_or(times[*index]);
            (EARLY[0]..=EARLY[1]).contains(&time)
        };
        let early: Vec<usize> = (0..times.len()).filter(within).collect();
        let (Some(theory), false) = (plan.partial_temperatures(&times), early.is_empty()) else {
            return Vec::new();
        };
        let mut list = Vec::new();
        for (engine, known) in plan.engines.iter().enumerate() {
            let name = title(known.name);
            let records = runs.records::<Record>(engine);
            for species in 1..plan.species.len() {
                let mean = |ratio: &dyn Fn(usize) -> f64| {
                    early.iter().map(|&index| ratio(index)).sum::<f64>() / early.len() as f64
                };
                let ratio = |temperatures: &[f64]| temperatures[species] / temperatures[0];
                let measured = records
                    .iter()
                    .map(|r| Some(mean(&|index| ratio(&r[index].1))));
                let measured = over(measured);
                let point = Point {
                    time: times[early[0]],
                    measured: measured.value.unwrap_or(f64::NAN),
                    error: measured.standard_error,
                    theory: mean(&|index| ratio(&theory[index])),
                    theory_error: None,
                };
                let topic = format!("species temperatures, {name}");
                let subject = format!("{name}, T_{}/T_1 of the early gas,", species + 1);
                let tolerance = plan.case.verdict.tolerance;
                let theory = "Enskog's equations";
                list.extend(against_theory(
                    &topic,
                    &subject,
                    theory,
                    &[point],
                    tolerance,
                ));
            }
        }
        list
    }
}
