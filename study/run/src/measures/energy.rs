//! The energy in time, engine against engine and against Haff's law: measured in every case with a box.

use schemars::Schema;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::compare::quotients;
use stosszahl_analysis::energy::EnergySample;
use stosszahl_case::Kind;
use stosszahl_results::{Axis, Figure, Table, Verdict};

use super::over;
use crate::judge::{Pair, Places, title};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, keeps_record};
use crate::plan::{EnginePlan, Plan};

/// The energy in time.
pub struct Energy;

/// It has no options.
#[derive(Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {}

/// Moments of the velocities by time.
pub type Record = Vec<(f64, EnergySample)>;

/// Energy over that of the start, K/K(0), at a sample.
pub fn energy_ratio(record: &Record, sample: usize) -> f64 {
    record[sample].1.temperature / record[0].1.temperature
}

#[derive(Default, Serialize, Deserialize)]
struct EnergyProbe {
    record: Record,
}

impl Probe for EnergyProbe {
    fn sample(&mut self, moment: &mut Moment<'_>) {
        let collisions = moment.simulation.work().collisions;
        let sample = EnergySample::of(moment.particles(), collisions);
        self.record.push((moment.time, sample));
    }

    keeps_record!();
}

impl Measure for Energy {
    fn name(&self) -> &'static str {
        "energy"
    }

    fn about(&self) -> &'static str {
        "Kinetic energy, fourth cumulant and collisions in time; engines against each other and against Haff's law."
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
        plan.sample_times()
    }

    fn probe(&self, _plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(EnergyProbe::default())
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut tables = vec![energy(plan, runs)];
        if plan.engines.len() > 1 {
            tables.push(comparison(plan, runs));
        }
        tables.push(replicas(plan, runs));
        tables
    }

    fn verdicts(&self, plan: &Plan, runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        let times = plan.sample_times();
        let judge = |topic: &str, a: &str, b: &str, pairs: &[Vec<(f64, f64)>]| {
            Pair {
                topic,
                a,
                b,
                quantity: "energy",
                places: Places::Times(&times),
                false_alarm: plan.case.verdict.false_alarm,
            }
            .judge(pairs)
        };
        let mut list = Vec::new();
        // Elastic engines in a closed box keep their energy, each by itself.
        let changes = !plan.law.is_elastic() || plan.kind == Kind::Flow;
        for (a, b) in pairs_of(plan).filter(|_| changes) {
            let [x, y] = [a, b].map(|engine| title(plan.engines[engine].name));
            let topic = format!("energy, {x} against {y}");
            list.extend(judge(&topic, &x, &y, &paired(runs, [a, b], times.len())));
        }
        for (engine, known) in plan.engines.iter().enumerate() {
            let laws: Option<Vec<f64>> = times.iter().map(|&time| plan.haff_ratio(time)).collect();
            let Some(laws) = laws.filter(|_| changes) else {
                continue;
            };
            let records = runs.records::<Record>(engine);
            let pairs: Vec<Vec<(f64, f64)>> = (laws.iter().enumerate())
                .map(|(sample, &law)| {
                    let ratio = |record: &&Record| (energy_ratio(record, sample), law);
                    records.iter().map(ratio).collect()
                })
                .collect();
            let name = title(known.name);
            let topic = format!("energy, {name} against theory");
            list.extend(judge(
                &topic,
                &name,
                "Haff's law with its Sonine factor",
                &pairs,
            ));
        }
        list
    }
}

/// Pairs of engines, each once.
pub(super) fn pairs_of(plan: &Plan) -> impl Iterator<Item = (usize, usize)> + use<> {
    let count = plan.engines.len();
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

/// Energies of two engines at each sample, replica by replica.
fn paired(runs: &Runs<'_>, engines: [usize; 2], samples: usize) -> Vec<Vec<(f64, f64)>> {
    let [first, second] = engines.map(|engine| runs.records::<Record>(engine));
    (0..samples)
        .map(|sample| {
            let both = first.iter().zip(&second);
            both.map(|(a, b)| (energy_ratio(a, sample), energy_ratio(b, sample)))
                .collect()
        })
        .collect()
}

fn energy(plan: &Plan, runs: &Runs<'_>) -> Table {
    let axis = || Axis::logarithmic("time", "time");
    let mut table = Table::new("energy", "Energy and velocity distribution in time, means over the replicas.")
        .key("engine", "", "Engine")
        .key("time", "time", "Time since the start")
        .value("collisions_per_particle", "1", "Collisions of a particle since the start; two for each pair collision")
        .with_theory(
            "energy_ratio",
            "1",
            "Kinetic energy per particle over that of the start, K/K(0); theory is Haff's law with its Sonine factor, \
             (1 + (1 + 3 a2/16) t/t0)^-2",
        )
        .estimate("fourth_cumulant", "1", "Fourth cumulant a2 of the velocities; zero for a Maxwellian")
        .note("replicas", "1", "Replicas")
        .figure(Figure::curves("Energy", axis(), Axis::logarithmic("energy_ratio", "K/K(0)")))
        .figure(Figure::curves("Fourth cumulant", axis(), Axis::linear("fourth_cumulant", "a2")));
    for (engine, known) in plan.engines.iter().enumerate() {
        let records = runs.records::<Record>(engine);
        for (sample, time) in plan.sample_times().into_iter().enumerate() {
            let of = |value: fn(&EnergySample) -> f64| {
                over(records.iter().map(|record| Some(value(&record[sample].1))))
            };
            let mut ratio = over(
                records
                    .iter()
                    .map(|record| Some(energy_ratio(record, sample))),
            );
            ratio.theory = plan.haff_ratio(time);
            table
                .row()
                .text(known.name)
                .number(time)
                .number(
                    of(|sample| sample.collisions_per_particle)
                        .value
                        .unwrap_or(0.0),
                )
                .estimate(ratio)
                .estimate(of(|sample| sample.fourth_cumulant))
                .count(records.len() as u64);
        }
    }
    table
}

fn comparison(plan: &Plan, runs: &Runs<'_>) -> Table {
    let times = plan.sample_times();
    let mut figure = Figure::curves(
        "Energies of two engines",
        Axis::logarithmic("time", "time"),
        Axis::linear("quotient", "quotient of the energies"),
    );
    figure.curves = vec!["engine_a".into(), "engine_b".into()];
    let mut table = Table::new("comparison", "Energies of two engines at the same time.")
        .key("engine_a", "", "First engine, the numerator")
        .key("engine_b", "", "Second engine, the denominator")
        .key("time", "time", "Time since the start")
        .value("energy_ratio_a", "1", "K/K(0) of the first")
        .value("energy_ratio_b", "1", "K/K(0) of the second")
        .estimate(
            "quotient",
            "1",
            "Geometric mean over replicas of the quotient of both",
        )
        .note(
            "z",
            "1",
            "Difference from one in standard errors of a normal number: paired t test",
        )
        .note(
            "verdict",
            "",
            "agree, a higher, a lower or undecided; all times together",
        )
        .figure(figure);
    for (a, b) in pairs_of(plan) {
        let pairs = paired(runs, [a, b], times.len());
        let found = quotients(&pairs, plan.case.verdict.false_alarm);
        for ((time, pairs), quotient) in times.iter().zip(&pairs).zip(found) {
            let mean = |of: fn(&(f64, f64)) -> f64| over(pairs.iter().map(|pair| Some(of(pair))));
            table
                .row()
                .text(plan.engines[a].name)
                .text(plan.engines[b].name)
                .number(*time)
                .number(mean(|pair| pair.0).value)
                .number(mean(|pair| pair.1).value)
                .number(quotient.quotient.value)
                .number(quotient.quotient.standard_error)
                .number(quotient.z)
                .text(quotient.verdict.name());
        }
    }
    table
}

fn replicas(plan: &Plan, runs: &Runs<'_>) -> Table {
    let mut table = Table::new("replicas", "Samples of single replicas.")
        .key("replica", "1", "Number of the replica, from zero")
        .key("engine", "", "Engine")
        .key("time", "time", "Time since the start")
        .value("energy_ratio", "1", "K/K(0)")
        .value(
            "fourth_cumulant",
            "1",
            "Fourth cumulant a2 of the velocities",
        )
        .value(
            "collisions_per_particle",
            "1",
            "Collisions of a particle since the start",
        );
    for (engine, known) in plan.engines.iter().enumerate() {
        for (replica, record) in runs.records::<Record>(engine).into_iter().enumerate() {
            for (index, (time, sample)) in record.iter().enumerate() {
                table
                    .row()
                    .count(replica as u64)
                    .text(known.name)
                    .number(*time)
                    .number(energy_ratio(record, index))
                    .number(sample.fourth_cumulant)
                    .number(sample.collisions_per_particle);
            }
        }
    }
    table
}
