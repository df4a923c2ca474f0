//! Measure `clusters`: number, energy and sizes of clusters in a gas with aggregation and
//! fragmentation, and their steady state.

mod steady;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stosszahl_case::format::AggregationSpec;
use stosszahl_model::Census;
use stosszahl_results::{Figure, FigureAxis, Table, VerdictText, table};

use super::species_record::{self as record, measured};
use crate::judge::warning;
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, SampleContext, described, keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure of clusters: number, sizes, kinetic energy, and the energy lost in aggregation and
/// fragmentation.
pub struct ClusterMeasure;

const NAME: &str = "clusters";

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct ClusterOptions {
    /// Times at which the distribution of cluster sizes is measured, rising. Default: the end of
    /// the run.
    times: Option<Vec<f64>>,
    /// Time from which on averages over the steady state of sticking and breaking are taken.
    /// Default: half of the run.
    #[schemars(range(min = 0.0))]
    steady_from: Option<f64>,
    /// Smallest and largest number of monomers of the clusters to whose steady numbers a power law
    /// is fitted. Default: 2 and 20.
    fit_monomers: Option<[u32; 2]>,
}

/// Number of times at which the steady state is sampled.
const STEADY_SAMPLES: usize = 200;

/// Sample times of cluster sizes, and the beginning of the steady state.
#[derive(Clone, Debug)]
struct Schedule {
    samples: Vec<f64>,
    sizes: Vec<f64>,
    steady: Option<Steady>,
    until: f64,
}

#[derive(Clone, Copy, Debug)]
struct Steady {
    from: f64,
    fit_monomers: [u32; 2],
}

impl Schedule {
    fn of(plan: &CasePlan) -> Self {
        let options: ClusterOptions = measure::chosen(plan, NAME);
        let until = plan.case.run.until;
        let breaks = plan
            .case
            .aggregation
            .as_ref()
            .is_some_and(AggregationSpec::breaks);
        let steady = breaks.then(|| Steady {
            from: options.steady_from.unwrap_or(0.5 * until),
            fit_monomers: options.fit_monomers.unwrap_or([2, 20]),
        });
        Self {
            samples: plan.sample_times(),
            sizes: options.times.unwrap_or_else(|| vec![until]),
            steady,
            until,
        }
    }

    /// Returns the sample times in the steady state, in the unit of time of the case; the last is
    /// exactly the end of the run.
    fn steady_times(&self) -> Vec<f64> {
        let Some(steady) = self.steady else {
            return Vec::new();
        };
        let span = self.until - steady.from;
        let at = |i| steady.from + span * i as f64 / STEADY_SAMPLES as f64;
        let inner = (1..STEADY_SAMPLES).map(at);
        inner.chain(std::iter::once(self.until)).collect()
    }
}

impl Measure for ClusterMeasure {
    described!(
        NAME,
        "Number, energy and sizes of clusters, where particles stick and break.",
        ClusterOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.case.aggregation.is_some()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        record::homogeneous_only(plan)?;
        let Some(sticking) = &plan.case.aggregation else {
            return measure::require(false, "", "only with [aggregation]");
        };
        let options: ClusterOptions = measure::options(plan, NAME)?;
        let times = options.times.unwrap_or_default();
        let rising = times.is_sorted_by(|a, b| a < b);
        measure::require(rising, "times", "a rising list of times")?;
        let breaks = sticking.breaks();
        for (key, given) in [
            ("steady_from", options.steady_from.is_some()),
            ("fit_monomers", options.fit_monomers.is_some()),
        ] {
            measure::require(
                breaks || !given,
                key,
                "only with aggregation.fragment_above",
            )?;
        }
        let [low, high] = options.fit_monomers.unwrap_or([2, 20]);
        let allowed = "[smallest, largest], two numbers of monomers from 1 on, the first at most half the second";
        let good = low > 0 && high >= low.saturating_mul(2);
        measure::require(good, "fit_monomers", allowed)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let schedule = Schedule::of(plan);
        let steady = schedule.steady_times();
        [schedule.samples, schedule.sizes, steady].concat()
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let schedule = Schedule::of(plan);
        Box::new(ClusterProbe {
            steady_times: schedule.steady_times(),
            schedule,
            record: ClusterRecord::default(),
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let records: Vec<&ClusterRecord> = runs.records(0);
        vec![table(plan, &records), size_table(plan, &records)]
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        usize::from(Schedule::of(plan).steady.is_some())
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let records: Vec<&ClusterRecord> = runs.records(0);
        let mut list = steady::steady_state(plan, &records, &runs.rule(plan));
        let last = records.iter().filter_map(|record| record.samples.last());
        let refused: f64 = last.map(|sample| sample.of("refused")).sum();
        if refused > 0.0 {
            let sentence = format!(
                "{refused} pairs bounced that should have stuck or broken: the gas or a cluster would have become too large."
            );
            list.push(warning("limits", sentence));
        }
        list
    }
}

/// Size distribution: number of clusters by their number of monomers.
type Sizes = BTreeMap<u32, u64>;

/// Sample of the clusters of one replica at one time: counts, energy and counters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Sample {
    particles: usize,
    energy: f64,
    /// Number of monomers: clusters of a single particle.
    single: u64,
    /// Size of the largest cluster \[monomers\].
    largest: u32,
    /// Mean cluster size, averaged over monomers: number of monomers in the cluster of a monomer.
    mean_by_mass: f64,
    /// Counters of aggregation and fragmentation since the start, by name.
    ledger: BTreeMap<String, f64>,
    /// Kinetic energy that a thermostat has added since the start \[energy\].
    heated: f64,
}

impl Sample {
    fn of(&self, name: &str) -> f64 {
        self.ledger.get(name).copied().unwrap_or(f64::NAN)
    }
}

/// Cluster sizes summed over the sample times in one half of the steady state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Half {
    times: u64,
    sizes: Sizes,
}

/// Record of the clusters of one replica, at all sample times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClusterRecord {
    samples: Vec<Sample>,
    /// Cluster size distributions, in the order of the requested times.
    sizes: Vec<Sizes>,
    steady: [Half; 2],
}

struct ClusterProbe {
    schedule: Schedule,
    steady_times: Vec<f64>,
    record: ClusterRecord,
}

/// Returns true if a time is in a rising list of times.
fn is_due(times: &[f64], time: f64) -> bool {
    times.binary_search_by(|one| one.total_cmp(&time)).is_ok()
}

impl Probe for ClusterProbe {
    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let Some(census) = moment.simulation.cluster_sizes() else {
            return;
        };
        let time = moment.time;
        if is_due(&self.schedule.samples, time) {
            let particles = moment.simulation.particle_count();
            let [twice_energy, _] = moment.moments().means();
            let energy = 0.5 * particles as f64 * twice_energy;
            let sample = sample(&census, particles, energy, moment.heated);
            self.record.samples.push(sample);
        }
        if is_due(&self.schedule.sizes, time) {
            self.record
                .sizes
                .push(census.sizes.iter().copied().collect());
        }
        if is_due(&self.steady_times, time) {
            let from = self.schedule.steady.map_or(0.0, |steady| steady.from);
            let late = time > 0.5 * (from + self.schedule.until);
            let half = &mut self.record.steady[usize::from(late)];
            half.times += 1;
            for (monomers, count) in census.sizes {
                *half.sizes.entry(monomers).or_default() += count;
            }
        }
    }

    keeps_record!();
}

fn sample(census: &Census, particles: usize, energy: f64, heated: f64) -> Sample {
    let (mut monomers, mut squares) = (0.0, 0.0);
    for &(size, count) in &census.sizes {
        monomers += f64::from(size) * count as f64;
        squares += f64::from(size) * f64::from(size) * count as f64;
    }
    let single = census.sizes.first().filter(|&&(size, _)| size == 1);
    Sample {
        particles,
        energy,
        single: single.map_or(0, |&(_, count)| count),
        largest: census.sizes.last().map_or(0, |&(size, _)| size),
        mean_by_mass: squares / f64::max(monomers, 1.0),
        ledger: census.ledger.clone(),
        heated,
    }
}

fn table(plan: &CasePlan, records: &[&ClusterRecord]) -> Table {
    let about = "Clusters at the sample times; energies are over that of the start";
    let mut table = table! {
        NAME, about;
        key "time", "unit of time", "Time";
        estimate "clusters_ratio", "1", "Clusters over those of the start";
        value "monomer_ratio", "1", "Clusters of one monomer over those of the start";
        estimate "mean_monomers", "1", "Monomers of the cluster that a monomer is in, on average over monomers";
        value "largest_monomers", "1", "Monomers of the largest cluster, on average over replicas";
        estimate "energy_ratio", "1", "Kinetic energy";
        value "aggregation_loss", "1", "Energy lost in sticking since the start";
        value "fragmentation_loss", "1", "Energy lost in breaking since the start";
        value "heating_energy", "1", "Energy put in by a thermostat since the start";
        value "aggregations_per_monomer", "1", "Pairs that stuck since the start, for each monomer";
        value "fragmentations_per_monomer", "1", "Pairs that broke since the start, for each monomer";
        note "refused", "1", "Pairs that should have stuck or broken, but bounced because of limits on numbers, in all replicas";
    };
    for (index, time) in plan.sample_times().into_iter().enumerate() {
        let of = |record: &&'_ ClusterRecord| {
            Some((
                record.samples.get(index)?.clone(),
                record.samples.first()?.clone(),
            ))
        };
        let pairs: Vec<(Sample, Sample)> = records.iter().filter_map(of).collect();
        let mean = |value: &dyn Fn(&Sample, &Sample) -> f64| {
            measured(&pairs, |(now, start)| value(now, start), None)
        };
        let energy = |value: &dyn Fn(&Sample) -> f64| mean(&|now, start| value(now) / start.energy);
        let each = |value: &dyn Fn(&Sample) -> f64| {
            mean(&|now, start| value(now) / start.particles as f64)
        };
        let refused: f64 = pairs.iter().map(|(now, _)| now.of("refused")).sum();
        table.add((
            (
                time,
                each(&|now| now.particles as f64),
                each(&|now| now.single as f64).value,
            ),
            (
                mean(&|now, _| now.mean_by_mass),
                mean(&|now, _| f64::from(now.largest)).value,
            ),
            energy(&|now| now.energy),
            ["aggregation_loss", "fragmentation_loss"]
                .map(|name| energy(&|now| now.of(name)).value),
            energy(&|now| now.heated).value,
            ["mergers", "shatterings"].map(|name| each(&|now| now.of(name)).value),
            refused as u64,
        ));
    }
    let size = "The size is the mean over monomers of the number of monomers in their cluster.";
    for (title, column, label, caption) in [
        ("Number of clusters", "clusters_ratio", "N/N(0)", ""),
        ("Energy of the clusters", "energy_ratio", "E/E(0)", ""),
        ("Size of the clusters", "mean_monomers", "monomers", size),
    ] {
        table = table.figure(record::against_time(
            title,
            FigureAxis::logarithmic(column, label),
            caption,
        ));
    }
    table
}

/// Largest cluster size \[monomers\] with a bin of its own; larger clusters have ten bins in a
/// decade.
const SINGLE: u64 = 16;

/// Returns the smallest and largest cluster size of the bin that holds a cluster size \[monomers\].
fn bin(monomers: u64) -> (u64, u64) {
    if monomers <= SINGLE {
        return (monomers, monomers);
    }
    let edge = |number: i32| (SINGLE as f64 * 10_f64.powf(f64::from(number) / 10.0)).floor() as u64;
    let mut number = (10.0 * (monomers as f64 / SINGLE as f64).log10()).floor() as i32;
    // Edges are whole numbers: rounding may have put the number beside its bin.
    while edge(number) >= monomers {
        number -= 1;
    }
    while edge(number + 1) < monomers {
        number += 1;
    }
    (edge(number) + 1, edge(number + 1))
}

fn size_table(plan: &CasePlan, records: &[&ClusterRecord]) -> Table {
    let about = "Numbers of clusters by their monomers, for each monomer of the gas";
    let mut table = table! {
        "size_distribution", about;
        key "average", "", "instant: at the time; steady: averaged from it to the end of the run";
        key "time", "unit of time", "Time";
        key "monomers_low", "1", "Smallest number of monomers of the bin";
        key "monomers_high", "1", "Largest number of monomers of the bin";
        estimate "clusters_per_monomer", "1", "Clusters of one size in the bin, on average over its sizes, for each monomer of the gas";
        note "counted", "1", "Clusters counted, in all replicas and times";
    };
    let schedule = Schedule::of(plan);
    let monomers = plan.count() as f64;
    for (index, &time) in schedule.sizes.iter().enumerate() {
        let sizes = records.iter().filter_map(|record| record.sizes.get(index));
        let replicas: Vec<(&Sizes, f64)> = sizes.map(|sizes| (sizes, monomers)).collect();
        size_rows(&mut table, "instant", time, &replicas);
    }
    if let Some(steady) = schedule.steady {
        let sums: Vec<(Sizes, u64)> = records.iter().map(|one| steady::all_steady(one)).collect();
        let norm = |times: u64| monomers * times.max(1) as f64;
        let replicas: Vec<_> = sums
            .iter()
            .map(|(sizes, times)| (sizes, norm(*times)))
            .collect();
        size_rows(&mut table, "steady", steady.from, &replicas);
    }
    let figure = record::against_time(
        "Sizes of the clusters",
        FigureAxis::logarithmic("clusters_per_monomer", "clusters of k monomers per monomer"),
        "Numbers of clusters by their monomers, for each monomer of the gas; beyond 16 monomers in bins of ten to a decade.",
    );
    let x = FigureAxis::logarithmic("monomers_low", "monomers k");
    let curves = figure.by(&["average", "time"]);
    table.figure(Figure { x, ..curves })
}

/// Adds the rows of one cluster size distribution to the table. Counts of each replica are divided
/// by the number given with them.
fn size_rows(table: &mut Table, average: &str, time: f64, replicas: &[(&Sizes, f64)]) {
    let sizes = replicas.iter().flat_map(|(sizes, _)| sizes.keys());
    let mut bins: Vec<(u64, u64)> = sizes.map(|&size| bin(u64::from(size))).collect();
    bins.sort_unstable();
    bins.dedup();
    for (low, high) in bins {
        let count = |sizes: &Sizes| -> u64 {
            let range = low as u32..=high.min(u64::from(u32::MAX)) as u32;
            sizes.range(range).map(|(_, count)| count).sum()
        };
        let width = (high - low + 1) as f64;
        let density = |(sizes, norm): &(&Sizes, f64)| count(sizes) as f64 / width / norm;
        table.add((
            average,
            time,
            low,
            high,
            measured(replicas, density, None),
            replicas.iter().map(|(sizes, _)| count(sizes)).sum::<u64>(),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_of_sizes_leave_no_gap() {
        let mut next = 1;
        while next < 1_000_000 {
            let (low, high) = bin(next);
            assert_eq!(low, next);
            assert!(high >= low && bin(high) == (low, high));
            next = high + 1;
        }
    }
}
