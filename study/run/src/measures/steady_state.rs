//! Measure `steady_state`: temperature of a gas heated by a bath or by its contacts, averaged over
//! quarters of the run, against Enskog's theory.

use serde::{Deserialize, Serialize};
use stosszahl_results::{Figure, FigureAxis, Table, VerdictText, table};

use super::mean_over_replicas;
use crate::judge::{ComparedPair, Comparison, DifferenceUnit, Places, still_moving, title};
use crate::measure::{
    self, BadOption, Measure, NoOptions, Probe, ReplicaRecords, RunStop, SampleContext, described,
    keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `steady_state` of the temperature of a heated gas.
pub struct SteadyState;

/// Number of equal parts of the run, quarters, over which the temperature is averaged.
const PARTS: usize = 4;

/// Number of samples over the whole run of a gas without a bath.
const LOOKS: usize = 400;

/// Returns true if a bath or the contacts heat the gas.
fn is_heated(plan: &CasePlan) -> bool {
    plan.case.bath().is_some() || plan.heats_itself()
}

/// Temperature of the gas in one replica, averaged over each quarter of the run.
///
/// Between two kicks the gas cools by a few per cent, so the mean of the temperature after one and
/// before the next is the mean over time to second order in that.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Record {
    start: f64,
    after: f64,
    /// Time of the last stop of the engine \[engine time\].
    last: f64,
    /// Time integral of the temperature in each quarter of the run; `durations` holds the time
    /// covered.
    sums: [f64; PARTS],
    durations: [f64; PARTS],
}

impl Record {
    /// Adds the interval since the last stop, which lies at the share `share` of the run. The
    /// temperature reached `before` at its end, and starts from `after` in the next interval.
    fn add(&mut self, share: f64, duration: f64, before: f64, after: f64) {
        let part = ((share * PARTS as f64) as usize).min(PARTS - 1);
        self.sums[part] += 0.5 * (self.after + before) * duration;
        self.durations[part] += duration;
        self.after = after;
    }

    /// Computes the mean temperature over that of the start, from quarter `first` of the run to
    /// before quarter `end`; `None` without a sample there.
    fn temperature(&self, first: usize, end: usize) -> Option<f64> {
        let duration: f64 = self.durations[first..end].iter().sum();
        let sum: f64 = self.sums[first..end].iter().sum();
        (duration > 0.0).then(|| sum / (self.start * duration))
    }
}

struct SteadyProbe {
    /// End of the run \[engine time\].
    until: f64,
    /// True if a bath kicks the gas. The temperature then jumps, and is sampled at kicks only.
    kicked: bool,
    record: Record,
}

impl Probe for SteadyProbe {
    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        let temperature = moment.temperature();
        (self.record.start, self.record.after) = (temperature, temperature);
        self.record.last = moment.simulation.time();
    }

    fn on_stop(&mut self, stop: &RunStop) {
        let before = match stop.kicked_from {
            None if self.kicked => return,
            before => before.unwrap_or(stop.temperature),
        };
        let duration = stop.time - self.record.last;
        let share = (self.record.last + 0.5 * duration) / self.until;
        self.record.add(share, duration, before, stop.temperature);
        self.record.last = stop.time;
    }

    keeps_record!();
}

impl Measure for SteadyState {
    described!(
        "steady_state",
        "Temperature of a gas that a bath or its contacts heat, over quarters of the run, against the steady state of Enskog's theory.",
        NoOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        is_heated(plan)
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let allowed = "a gas that is heated, by a bath, [thermostat], or by contacts with gas.restitution.delta; this one is not";
        measure::require(is_heated(plan), "", allowed)?;
        self.read_options(plan)
    }

    /// Returns the times at which the temperature is sampled; none with a bath, whose kicks sample
    /// it.
    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        if plan.case.bath().is_some() {
            return Vec::new();
        }
        let looks = (1..=LOOKS).map(|look| look as f64 / LOOKS as f64);
        looks.map(|share| share * plan.case.run.until).collect()
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(SteadyProbe {
            kicked: plan.case.bath().is_some(),
            until: plan.engine_time(plan.case.run.until),
            record: Record::default(),
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "steady_state", "Temperature of a heated gas, averaged over quarters of the run.";
            key "engine", "", "Engine";
            key "window_start", "time", "Start of the quarter";
            key "window_end", "time", "End of the quarter";
            with_theory "temperature_ratio", "1", "Mean temperature over that of the start; theory is Enskog's steady state";
            note "replicas", "1", "Replicas";
        }
        .figure(Figure::curves(
            "Steady state",
            FigureAxis::linear("window_end", "end of the quarter"),
            FigureAxis::linear("temperature_ratio", "T/T(0)"),
        ));
        let edge = |part: usize| plan.case.run.until * part as f64 / PARTS as f64;
        for (engine, records) in runs.each::<Record>(plan) {
            for part in 0..PARTS {
                let ratio =
                    mean_over_replicas(records.iter().map(|one| one.temperature(part, part + 1)));
                let ratio = ratio.against(plan.steady_temperature());
                table.add((
                    engine.name,
                    edge(part),
                    edge(part + 1),
                    ratio,
                    records.len(),
                ));
            }
        }
        vec![table]
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        2 * plan.engines.len()
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let mut list = Vec::new();
        for (engine, records) in runs.each::<Record>(plan) {
            let name = title(engine.name);
            let mean = |first, end| -> Option<Vec<f64>> {
                records
                    .iter()
                    .map(|one| one.temperature(first, end))
                    .collect()
            };
            let topic = format!("steady state, {name}");
            let quarters = mean(PARTS - 2, PARTS - 1).zip(mean(PARTS - 1, PARTS));
            list.extend(quarters.and_then(|(before, last)| {
                let pairs: Vec<(f64, f64)> = before.into_iter().zip(last).collect();
                still_moving(
                    &topic,
                    &format!("The temperature of {name}"),
                    &pairs,
                    runs.level,
                )
            }));
            let half = plan.steady_temperature().zip(mean(PARTS / 2, PARTS));
            list.extend(half.and_then(|(law, found)| {
                let comparison = Comparison {
                    topic: &format!("{topic} against theory"),
                    a: name,
                    b: "the steady state of Enskog's theory",
                    quantity: "temperature",
                    unit: DifferenceUnit::Relative,
                    rule: runs.rule(plan),
                };
                let places = Places::Span("in the last half of the run");
                let pair = ComparedPair { comparison, places };
                pair.judge(&[found.iter().map(|&ratio| (ratio, law)).collect()])
            }));
        }
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_a_saw_tooth() {
        let mut record = Record {
            start: 2.0,
            after: 2.0,
            ..Record::default()
        };
        for (share, before, after) in [(0.1, 1.0, 3.0), (0.6, 1.0, 3.0), (0.7, 2.0, 4.0)] {
            record.add(share, 0.5, before, after);
        }
        assert_eq!(record.temperature(0, 1), Some(0.75));
        assert_eq!(record.temperature(2, 4), Some(0.5 * (1.0 + 1.25)));
        assert_eq!(record.temperature(3, 4), None);
    }
}
