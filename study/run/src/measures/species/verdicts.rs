//! Verdicts on the temperature ratios of the species of a cooling mixture in a box, against
//! Enskog's kinetic equations.

use stosszahl_results::VerdictText;

use super::super::energy::void_for;
use super::super::gas_series::GasSeries;
use super::rows::{mean_ratio, temperature};
use crate::judge::{MeasuredPoint, against_theory, title};
use crate::measure::ReplicaRecords;
use crate::plan::CasePlan;

/// Start and end of the time window for temperature ratios, in Haff times, or mean free times if
/// elastic. The ratios have settled by then, and the gas is still homogeneous.
const EARLY: [f64; 2] = [1.0, 5.0];

/// Returns the number of temperature-ratio verdicts: one for each species but the first, for each
/// engine.
pub(super) fn test_count(plan: &CasePlan) -> usize {
    if plan.is_uniform_box() && !plan.is_rough() && !plan.is_sheared() {
        plan.engines.len() * plan.gas.species.len().saturating_sub(1)
    } else {
        0
    }
}

/// Creates the verdicts on the temperatures of species over that of the first species in the early
/// cooling state. Temperatures are averaged over time relative to the theoretical one of the first
/// species, so that early times do not dominate.
pub(super) fn verdicts(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<VerdictText> {
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
    for (index, engine) in plan.engines.iter().enumerate() {
        let all_series: Vec<&GasSeries> = runs.records_of(index);
        let name = title(engine.name);
        for species in 1..plan.gas.species.len() {
            let sum = |kind: usize, at: &dyn Fn(usize, usize) -> f64| -> f64 {
                let scaled = |&index: &usize| at(index, kind) / theory[index][0];
                early.iter().map(scaled).sum()
            };
            let both = |at: &dyn Fn(usize, usize) -> f64| [sum(species, at), sum(0, at)];
            let sampled = all_series
                .iter()
                .map(|series| both(&|index, kind| temperature(plan, &series[index].species[kind])));
            let [own, first] = both(&|index, kind| theory[index][kind]);
            let found = mean_ratio(&sampled.collect::<Vec<_>>()).against(Some(own / first));
            let topic = format!("species temperatures, {name}");
            let [one, first] = [species, 0].map(|place| &plan.gas.species[place].name);
            let quantity = format!("T({one})/T({first}) of the early gas");
            let points: Vec<MeasuredPoint> = MeasuredPoint::from_estimate(times[early[0]], &found)
                .into_iter()
                .collect();
            let words = [name, "Enskog's equations", &quantity];
            let found = against_theory(&topic, words, &points, &runs.rule(plan));
            list.extend(found.map(|found| void_for(found, plan, &[engine])));
        }
    }
    list
}
