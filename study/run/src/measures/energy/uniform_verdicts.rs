//! Verdicts on the energy of a uniform smooth gas: engines against each other, and each engine
//! against Haff's law.

use stosszahl_analysis::compare::quotients;
use stosszahl_results::{Figure, FigureAxis, Table, VerdictKind, VerdictText, table};

use super::super::gas_series::GasSeries;
use super::super::mean_over_replicas;
use super::{energy_ratio, title};
use crate::judge::power::ReplicaSpread;
use crate::judge::{self, ComparedPair, Comparison, DifferenceUnit, Places};
use crate::measure::ReplicaRecords;
use crate::plan::{CasePlan, EnginePlan};
use crate::theory::flow;

/// Returns true if the energy is prescribed: conserved by elastic particles in a closed box, or
/// fixed by a rescaling thermostat. Energies then need no verdict.
fn has_given_energy(plan: &CasePlan) -> bool {
    flow::keeps_energy(plan) || plan.case.rescaling().is_some()
}

/// Returns the number of statistical tests: one for each pair of engines, and one for each engine
/// against Haff's law.
pub(super) fn test_count(plan: &CasePlan) -> usize {
    let with_law = plan.haff_ratio(0.0).is_some();
    let laws = if with_law { plan.engines.len() } else { 0 };
    if has_given_energy(plan) {
        0
    } else {
        pairs_of(plan).count() + laws
    }
}

/// Returns the expected spread of compared energies over replicas, as for independent particles.
pub(super) fn quantity_spreads(plan: &CasePlan) -> Vec<ReplicaSpread> {
    // Of K of N Maxwellian particles, 2/(D N).
    let square =
        |engine: &EnginePlan| 2.0 / (plan.gas.dimension * plan.count() * engine.copies()) as f64;
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

/// Creates the verdicts on the energies of all pairs of engines, and of each engine against Haff's
/// law.
pub(super) fn verdicts(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<VerdictText> {
    if has_given_energy(plan) {
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
        let pairs = paired(plan, runs, [a, b], times.len());
        let found = judge(format!("energy, {x} against {y}"), x, y, &pairs);
        let engines = [&plan.engines[a], &plan.engines[b]];
        list.extend(found.map(|found| with_rates(void_for(found, plan, &engines), plan, engines)));
    }
    for (engine, records) in runs.each::<GasSeries>(plan) {
        let laws: Option<Vec<f64>> = (times.iter())
            .map(|&time| plan.haff_ratio(time * plan.rate_ratio(engine)))
            .collect();
        let Some(laws) = laws else { continue };
        let laws = laws.iter().enumerate();
        let at = |(sample, &law): (usize, &f64)| {
            let ratio = |series: &&GasSeries| (energy_ratio(plan, series, sample), law);
            records.iter().map(ratio).collect()
        };
        let pairs: Vec<Vec<(f64, f64)>> = laws.map(at).collect();
        let (name, law) = (title(engine.name), "Haff's law with its Sonine factor");
        let found = judge(format!("energy, {name} against theory"), name, law, &pairs);
        list.extend(found.map(|found| void_for(found, plan, &[engine])));
    }
    list
}

/// Sets a verdict on engines to void if the numerical error of one of the engines exceeds the
/// margin.
pub(crate) fn void_for(
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

/// Adds to a verdict on two engines how much of their difference follows from their theoretical
/// collision rates.
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

/// Returns each pair of engines of a case once, as indices.
pub(crate) fn pairs_of(plan: &CasePlan) -> impl Iterator<Item = (usize, usize)> + use<> {
    let count = plan.engines.len();
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

/// Returns the energies of two engines at each sample time, paired by replica.
fn paired(
    plan: &CasePlan,
    runs: &ReplicaRecords<'_>,
    engines: [usize; 2],
    samples: usize,
) -> Vec<Vec<(f64, f64)>> {
    let [first, second] = engines.map(|engine| runs.records::<GasSeries>(engine));
    let at = |sample| {
        let both = first.iter().zip(&second);
        both.map(|(a, b)| {
            [a, b]
                .map(|series| energy_ratio(plan, series, sample))
                .into()
        })
        .collect()
    };
    (0..samples).map(at).collect()
}

/// Creates the table `comparison.csv` of the energies of each pair of engines at equal times.
pub(super) fn comparison(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Table {
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
        let pairs = paired(plan, runs, [a, b], times.len());
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
