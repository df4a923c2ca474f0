//! Temperatures of the species of a mixture, against Enskog's kinetic equations.

use stosszahl_analysis::flow::{SpeciesFlow, Thermal, thermal};
use stosszahl_analysis::replicas::of_sums;
use stosszahl_model::{Grouping, Simulation};
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, VerdictText, table};

use super::energy::void_for;
use super::mean_over_replicas;
use crate::judge::{MeasuredPoint, against_theory, title};
use crate::measure::{
    self, BadOption, Measure, NoOptions, Probe, ReplicaRecords, SampleProbe, described,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure of the temperature of each species, and of their ratios, against Enskog's equations.
pub struct SpeciesTemperatures;

/// Start and end of the early state, in units of Haff's time, or of the mean free time without
/// dissipation: after the ratios have settled, before the gas can have become inhomogeneous.
const EARLY: [f64; 2] = [1.0, 5.0];

/// Samples of one replica: time, and temperatures of the gas and of each species.
type Record = Vec<(f64, Vec<f64>)>;

/// Temperature <m v^2>/D of each species; 0 of one without particles.
fn temperatures(gas: &dyn Simulation, grouping: Grouping) -> Vec<f64> {
    let still = vec![SpeciesFlow::NONE; grouping.groups()];
    let degrees = gas.dimension() as f64;
    let all = thermal(grouping, &still, &mut |sum| gas.reduce_particles(sum));
    let mean = |one: Thermal| {
        if one.number > 0.0 {
            one.twice_energy / (degrees * one.number)
        } else {
            0.0
        }
    };
    all.into_iter().map(mean).collect()
}

/// Jackknife estimate of the ratio of the means over replicas of two numbers, with its error.
fn ratio(sums: &[[f64; 2]]) -> TableEstimate {
    mean_over_replicas(of_sums(sums, |[a, b]| a / b).into_iter().map(Some))
}

impl Measure for SpeciesTemperatures {
    described!(
        "species_temperatures",
        "Temperature of each species in time, against Enskog's kinetic equations.",
        NoOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_uniform_box() && !plan.is_rough() && plan.species.len() > 1
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let allowed = "several species, by [[species]]; this gas has one";
        measure::require(plan.species.len() > 1, "", allowed)?;
        self.read_options(plan)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        plan.sample_times()
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let grouping = plan.grouping();
        Box::new(SampleProbe::new(Record::new(), move |record, moment| {
            let gas = &*moment.simulation;
            record.push((moment.temperature(), temperatures(gas, grouping)));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let figure = Figure::curves(
            "Temperatures of the species",
            FigureAxis::logarithmic("time", "time"),
            FigureAxis::linear("ratio_to_first", "T of the species over that of the first"),
        );
        let mut table = table! {
            "partial_temperature", "Temperature of each species in time.";
            key "engine", "", "Engine";
            key "time", "time", "Time since the start";
            key "species", "1", "Number of the species, from 1";
            key "species_name", "", "Name of the species";
            with_theory "temperature_ratio", "1", "Its temperature over that of the gas at the start; theory by Enskog's equations";
            with_theory "ratio_to_first", "1", "Its temperature over that of the first species";
            note "replicas", "1", "Replicas";
        }
        .figure(figure.by(&["engine", "species_name"]));
        let times = plan.sample_times();
        let theory = plan.partial_temperatures();
        for (engine, records) in runs.each::<Record>(plan) {
            for (index, &time) in times.iter().enumerate() {
                let expected = theory.map(|all| &all[index]);
                for species in 0..plan.species.len() {
                    let of = |record: &Record, place: usize| record[index].1[place];
                    let own =
                        mean_over_replicas(records.iter().map(|r| Some(of(r, species) / r[0].0)));
                    let own = own.against(expected.map(|all| all[species]));
                    let pairs = records
                        .iter()
                        .map(|record| [of(record, species), of(record, 0)]);
                    let ratio = ratio(&pairs.collect::<Vec<_>>());
                    let ratio = ratio.against(expected.map(|all| all[species] / all[0]));
                    let named = (species + 1, &*plan.species[species].name);
                    table.add((engine.name, time, named, own, ratio, records.len()));
                }
            }
        }
        vec![table]
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        plan.engines.len() * plan.species.len().saturating_sub(1)
    }

    /// Ratios of the temperatures to that of the first in the early state of a cooling gas: of their means, each temperature over
    /// that of the gas by theory, so that early times do not outweigh the rest.
    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let times = plan.sample_times();
        let within = |index: &usize| {
            let time = plan.time_over_haff(times[*index]).unwrap_or(times[*index]);
            (EARLY[0]..=EARLY[1]).contains(&time)
        };
        let early: Vec<usize> = (0..times.len()).filter(within).collect();
        let (Some(theory), false) = (plan.partial_temperatures(), early.is_empty()) else {
            return Vec::new();
        };
        let mut list = Vec::new();
        for (engine, records) in runs.each::<Record>(plan) {
            let name = title(engine.name);
            for species in 1..plan.species.len() {
                let sum = |kind: usize, at: &dyn Fn(usize, usize) -> f64| -> f64 {
                    let scaled = |&index: &usize| at(index, kind) / theory[index][0];
                    early.iter().map(scaled).sum()
                };
                let both = |at: &dyn Fn(usize, usize) -> f64| [sum(species, at), sum(0, at)];
                let sampled = records
                    .iter()
                    .map(|r| both(&|index, kind| r[index].1[kind]));
                let [own, first] = both(&|index, kind| theory[index][kind]);
                let found = ratio(&sampled.collect::<Vec<_>>()).against(Some(own / first));
                let topic = format!("species temperatures, {name}");
                let [one, first] = [species, 0].map(|place| &plan.species[place].name);
                let quantity = format!("T({one})/T({first}) of the early gas");
                let points: Vec<MeasuredPoint> =
                    MeasuredPoint::from_estimate(times[early[0]], &found)
                        .into_iter()
                        .collect();
                let words = [name, "Enskog's equations", &quantity];
                let found = against_theory(&topic, words, &points, &runs.rule(plan));
                list.extend(found.map(|found| void_for(found, plan, &[engine])));
            }
        }
        list
    }
}
