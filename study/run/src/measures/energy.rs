//! Energy in time, of engines against each other and against Haff's law; measured in every case
//! with a box.

use stosszahl_analysis::compare::quotients;
use stosszahl_analysis::energy::EnergySample;
use stosszahl_results::{Figure, FigureAxis, Table, VerdictKind, VerdictText, table};

use super::mean_over_replicas;
use crate::judge::{self, ComparedPair, Comparison, DifferenceUnit, Places, title};
use crate::measure::{Measure, NoOptions, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan};
use crate::power::ReplicaSpread;
use crate::theory::flow;

/// Measure of the energy in time.
pub struct EnergyMeasure;

/// Moments of the velocities by time.
pub type EnergyRecord = Vec<(f64, EnergySample)>;

/// Energy over the energy of the start, K/K(0), at a sample.
pub fn energy_ratio(record: &EnergyRecord, sample: usize) -> f64 {
    record[sample].1.temperature / record[0].1.temperature
}

impl Measure for EnergyMeasure {
    described!(
        "energy",
        "Kinetic energy, fourth cumulant and collisions in time; engines against each other and against Haff's law.",
        NoOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.has_box() && !super::series::has_energies_apart(plan)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        plan.sample_times()
    }

    fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(SampleProbe::new(EnergyRecord::new(), |record, moment| {
            let sample = EnergySample::of_gas(&*moment.simulation, moment.moments());
            record.push((moment.time, sample));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let several = (plan.engines.len() > 1).then(|| comparison(plan, runs));
        let tables = [
            Some(energy(plan, runs)),
            several,
            Some(replicas(plan, runs)),
        ];
        tables.into_iter().flatten().collect()
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        let engines = plan.engines.len();
        let laws = if plan.haff_ratio(0.0).is_some() {
            engines
        } else {
            0
        };
        if flow::keeps_energy(plan) || plan.case.rescaling().is_some() {
            0
        } else {
            pairs_of(plan).count() + laws
        }
    }

    fn quantity_spreads(&self, plan: &CasePlan) -> Vec<ReplicaSpread> {
        if self.test_count(plan) == 0 {
            return Vec::new();
        }
        // Of K of N Maxwellian particles, 2/(D N).
        let square =
            |engine: &EnginePlan| 2.0 / (plan.dimension * plan.count() * engine.copies()) as f64;
        let pairs = pairs_of(plan).map(|(a, b)| {
            let [x, y] = [a, b].map(|one| &plan.engines[one]);
            let names = format!("energy, {} against {}", title(x.name), title(y.name));
            (names, square(x) + square(y))
        });
        let against = |engine: &EnginePlan| {
            (
                format!("energy, {} against theory", title(engine.name)),
                square(engine),
            )
        };
        let alone = plan
            .engines
            .iter()
            .filter(|_| plan.haff_ratio(0.0).is_some());
        let all = pairs.chain(alone.map(against));
        let spread = |(quantity, square): (String, f64)| ReplicaSpread {
            quantity,
            of_one: square.sqrt(),
            source: "that of as many independent particles; clusters make it several times wider"
                .into(),
            wanted: plan.case.verdict.tolerance,
            // Half of the level belongs to the last time.
            tests: 2,
            relative: true,
        };
        all.map(spread).collect()
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        // Elastic engines in a closed box keep their energy, each by itself; a thermostat gives all the same.
        if flow::keeps_energy(plan) || plan.case.rescaling().is_some() {
            return Vec::new();
        }
        let times = plan.sample_times();
        let judge = |topic: String, a: &str, b: &str, pairs: &[Vec<(f64, f64)>]| {
            let comparison = Comparison {
                topic: &topic,
                a,
                b,
                quantity: "energy",
                unit: DifferenceUnit::Relative,
                rule: runs.rule(plan),
            };
            let places = Places::Times(&times);
            ComparedPair { comparison, places }.judge(pairs)
        };
        let mut list = Vec::new();
        for (a, b) in pairs_of(plan) {
            let [x, y] = [a, b].map(|engine| title(plan.engines[engine].name));
            let pairs = paired(runs, [a, b], times.len());
            let found = judge(format!("energy, {x} against {y}"), x, y, &pairs);
            let engines = [&plan.engines[a], &plan.engines[b]];
            list.extend(
                found.map(|found| with_rates(void_for(found, plan, &engines), plan, engines)),
            );
        }
        for (engine, records) in runs.each::<EnergyRecord>(plan) {
            let laws: Option<Vec<f64>> = (times.iter())
                .map(|&time| plan.haff_ratio(time * plan.rate_ratio(engine)))
                .collect();
            let Some(laws) = laws else { continue };
            let laws = laws.iter().enumerate();
            let at = |(sample, &law): (usize, &f64)| {
                let ratio = |record: &&EnergyRecord| (energy_ratio(record, sample), law);
                records.iter().map(ratio).collect()
            };
            let pairs: Vec<Vec<(f64, f64)>> = laws.map(at).collect();
            let (name, law) = (title(engine.name), "Haff's law with its Sonine factor");
            let found = judge(format!("energy, {name} against theory"), name, law, &pairs);
            list.extend(found.map(|found| void_for(found, plan, &[engine])));
        }
        list
    }
}

/// Makes a comparison of two engines void if the numerical error of one of them is larger than the
/// margin.
pub(super) fn void_for(
    found: VerdictText,
    plan: &CasePlan,
    engines: &[&EnginePlan],
) -> VerdictText {
    let mut reasons = (engines.iter()).filter_map(|engine| plan.numerical_error(engine));
    match reasons.next() {
        Some(reason) => judge::void(found, &reason),
        None => found,
    }
}

/// Adds to a verdict the part of the difference that follows from the theoretical collision rates
/// of the two engines.
fn with_rates(found: VerdictText, plan: &CasePlan, engines: [&EnginePlan; 2]) -> VerdictText {
    let last = plan.sample_times().last().copied();
    let rates = last.and_then(|time| plan.stated_rates(engines, time));
    match rates {
        Some(rates) if matches!(found.kind, VerdictKind::Differ | VerdictKind::Undecided) => {
            VerdictText {
                sentence: format!("{} {rates}", found.sentence),
                ..found
            }
        }
        _ => found,
    }
}

/// Returns the index pairs of the engines of a case, each pair once.
pub(super) fn pairs_of(plan: &CasePlan) -> impl Iterator<Item = (usize, usize)> + use<> {
    let count = plan.engines.len();
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

/// Returns the energies of two engines at each sample, in pairs of each replica.
fn paired(runs: &ReplicaRecords<'_>, engines: [usize; 2], samples: usize) -> Vec<Vec<(f64, f64)>> {
    let [first, second] = engines.map(|engine| runs.records::<EnergyRecord>(engine));
    let at = |sample| {
        let both = first.iter().zip(&second);
        both.map(|(a, b)| (energy_ratio(a, sample), energy_ratio(b, sample)))
            .collect()
    };
    (0..samples).map(at).collect()
}

fn energy(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Table {
    let axis = || FigureAxis::logarithmic("time", "time");
    let mut table = table! {
        "energy", "Energy and velocity distribution in time, means over the replicas.";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        value "collisions_per_particle", "1", "Collisions of a particle since the start; two for each pair collision";
        with_theory "energy_ratio", "1",
            "Kinetic energy per particle over that of the start, K/K(0); theory is Haff's law with its Sonine factor, \
             (1 + (1 + 3 a2/16) t/t0)^-2, at the collision rate that the scheme sets";
        estimate "fourth_cumulant", "1", "Fourth cumulant a2 of the velocities; zero for a Maxwellian";
        note "replicas", "1", "Replicas";
    }
    .figure(Figure::curves("Energy", axis(), FigureAxis::logarithmic("energy_ratio", "K/K(0)")))
    .figure(Figure::curves("Fourth cumulant", axis(), FigureAxis::linear("fourth_cumulant", "a2")));
    for (engine, records) in runs.each::<EnergyRecord>(plan) {
        for (sample, time) in plan.sample_times().into_iter().enumerate() {
            let of = |value: fn(&EnergySample) -> f64| {
                mean_over_replicas(records.iter().map(|record| Some(value(&record[sample].1))))
            };
            let collisions = of(|sample| sample.collisions_per_particle)
                .value
                .unwrap_or(0.0);
            let ratio = mean_over_replicas(
                records
                    .iter()
                    .map(|record| Some(energy_ratio(record, sample))),
            );
            let law = plan.haff_ratio(time * plan.rate_ratio(engine));
            let ratio = ratio.against(law);
            let cumulant = of(|sample| sample.fourth_cumulant);
            table.add((
                engine.name,
                time,
                collisions,
                ratio,
                cumulant,
                records.len(),
            ));
        }
    }
    table
}

fn comparison(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Table {
    let (x, y) = (
        FigureAxis::logarithmic("time", "time"),
        FigureAxis::linear("energy_ratio_a_over_b", "quotient of the energies"),
    );
    let mut table = table! {
        "comparison", "Energies of two engines at the same time.";
        key "engine_a", "", "First engine, the numerator";
        key "engine_b", "", "Second engine, the denominator";
        key "time", "time", "Time since the start";
        value "energy_ratio_a", "1", "K/K(0) of the first";
        value "energy_ratio_b", "1", "K/K(0) of the second";
        estimate "energy_ratio_a_over_b", "1", "Jackknife estimate of the quotient of the means over replicas, through its logarithm";
        note "energy_ratio_a_over_b_low", "1", "Lower end of its interval, all times together at the level of the verdict";
        note "energy_ratio_a_over_b_high", "1", "Upper end";
        note "z", "1", "Difference from one in standard errors of a normal number: paired t test";
        note "verdict", "", "agree, a higher, a lower or undecided; all times together";
        note "replicas", "1", "Replicas";
    }
    .figure(Figure::curves("Energies of two engines", x, y).by(&["engine_a", "engine_b"]));
    let times = plan.sample_times();
    for (a, b) in pairs_of(plan) {
        let pairs = paired(runs, [a, b], times.len());
        let found = quotients(&pairs, &runs.rule(plan));
        for ((&time, pairs), found) in times.iter().zip(&pairs).zip(found) {
            let mean = |of: fn(&(f64, f64)) -> f64| {
                mean_over_replicas(pairs.iter().map(|pair| Some(of(pair))))
            };
            let names = [a, b].map(|engine| plan.engines[engine].name);
            let ratios = (mean(|pair| pair.0).value, mean(|pair| pair.1).value);
            let [low, high] =
                (found.off.ends).map_or([None; 2], |ends| ends.map(|end| Some(1.0 + end)));
            let estimate = (found.quotient.value, found.quotient.standard_error);
            let quotient = (estimate, (low, high), found.z);
            table.add((
                names[0],
                names[1],
                time,
                ratios,
                quotient,
                found.verdict.name(),
                pairs.len(),
            ));
        }
    }
    table
}

fn replicas(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Table {
    let mut table = table! {
        "replicas", "Samples of single replicas.";
        key "replica", "1", "Number of the replica, from zero";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        value "energy_ratio", "1", "K/K(0)";
        value "fourth_cumulant", "1", "Fourth cumulant a2 of the velocities";
        value "collisions_per_particle", "1", "Collisions of a particle since the start";
    };
    for (engine, records) in runs.each::<EnergyRecord>(plan) {
        for (replica, record) in records.into_iter().enumerate() {
            for (index, (time, sample)) in record.iter().enumerate() {
                let found = (sample.fourth_cumulant, sample.collisions_per_particle);
                table.add((
                    replica,
                    engine.name,
                    *time,
                    energy_ratio(record, index),
                    found,
                ));
            }
        }
    }
    table
}
