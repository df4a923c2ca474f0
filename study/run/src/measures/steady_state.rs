//! The steady state of a driven gas: its temperature, averaged over quarters of the run, against Enskog's theory.

use schemars::Schema;
use serde::{Deserialize, Serialize};
use stosszahl_results::{Axis, Figure, Table, Verdict};

use super::over;
use crate::judge::{Pair, Places, still_moving, title};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, Stop, keeps_record};
use crate::plan::{EnginePlan, Plan};

/// The steady state of a driven gas.
pub struct SteadyState;

/// It has no options.
#[derive(Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {}

/// Parts of the run over which the temperature is averaged.
const PARTS: usize = 4;

/// The temperature averaged over quarters of the run.
///
/// Between two kicks the gas cools by a few per cent, so the mean of the temperature after one and before the next is
/// the mean over time to second order in that.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Record {
    start: f64,
    after: f64,
    sums: [f64; PARTS],
    intervals: [u64; PARTS],
}

impl Record {
    /// Notes a kick that took the temperature from `before` to `after`, in the middle of an interval at the share
    /// `share` of the run.
    fn kick(&mut self, share: f64, before: f64, after: f64) {
        let part = ((share * PARTS as f64) as usize).min(PARTS - 1);
        self.sums[part] += 0.5 * (self.after + before);
        self.intervals[part] += 1;
        self.after = after;
    }

    /// Mean temperature over that of the start, from part `first` to before part `end`; none without a kick there.
    fn temperature(&self, first: usize, end: usize) -> Option<f64> {
        let intervals: u64 = self.intervals[first..end].iter().sum();
        let sum: f64 = self.sums[first..end].iter().sum();
        (intervals > 0).then(|| sum / (self.start * intervals as f64))
    }
}

struct SteadyProbe {
    /// Half the interval between kicks, and the end of the run [engine time].
    half: f64,
    until: f64,
    record: Record,
}

impl Probe for SteadyProbe {
    fn begin(&mut self, moment: &mut Moment<'_>) {
        let temperature = moment.simulation.temperature();
        (self.record.start, self.record.after) = (temperature, temperature);
    }

    fn stop(&mut self, stop: &Stop) {
        if let Some(before) = stop.kicked_from {
            let share = (stop.time - self.half) / self.until;
            self.record.kick(share, before, stop.temperature);
        }
    }

    fn sample(&mut self, _moment: &mut Moment<'_>) {}

    keeps_record!();
}

impl Measure for SteadyState {
    fn name(&self) -> &'static str {
        "steady_state"
    }

    fn about(&self) -> &'static str {
        "Temperature of a driven gas over quarters of the run, against the steady state of Enskog's theory."
    }

    fn schema(&self) -> Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.case.drive.is_some()
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        let driven = plan.case.drive.is_some();
        measure::require(driven, "", "a driven gas, by [drive]; this one is not")?;
        measure::options::<Options>(plan, self.name()).map(|_| ())
    }

    fn times(&self, _plan: &Plan) -> Vec<f64> {
        Vec::new()
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let interval = plan.case.drive.map_or(0.0, |drive| drive.interval);
        Box::new(SteadyProbe {
            half: 0.5 * plan.engine_time(interval),
            until: plan.engine_time(plan.case.run.until),
            record: Record::default(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut table = Table::new(
            "steady_state",
            "Temperature of a driven gas, averaged over quarters of the run.",
        )
        .key("engine", "", "Engine")
        .key("window_start", "time", "Start of the quarter")
        .key("window_end", "time", "End of the quarter")
        .with_theory(
            "temperature_ratio",
            "1",
            "Mean temperature over that of the start; theory is Enskog's steady state",
        )
        .note("replicas", "1", "Replicas")
        .figure(Figure::curves(
            "Steady state",
            Axis::linear("window_end", "end of the quarter"),
            Axis::linear("temperature_ratio", "T/T(0)"),
        ));
        let edge = |part: usize| plan.case.run.until * part as f64 / PARTS as f64;
        for (engine, known) in plan.engines.iter().enumerate() {
            let records = runs.records::<Record>(engine);
            for part in 0..PARTS {
                let mut ratio = over(records.iter().map(|one| one.temperature(part, part + 1)));
                ratio.theory = plan.steady_temperature();
                table
                    .row()
                    .text(known.name)
                    .number(edge(part))
                    .number(edge(part + 1))
                    .estimate(ratio)
                    .count(records.len() as u64);
            }
        }
        vec![table]
    }

    fn verdicts(&self, plan: &Plan, runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        let false_alarm = plan.case.verdict.false_alarm;
        let mut list = Vec::new();
        for (engine, known) in plan.engines.iter().enumerate() {
            let (name, records) = (title(known.name), runs.records::<Record>(engine));
            let mean = |first, end| -> Option<Vec<f64>> {
                records
                    .iter()
                    .map(|one| one.temperature(first, end))
                    .collect()
            };
            let topic = format!("steady state, {name}");
            if let (Some(before), Some(last)) = (mean(PARTS - 2, PARTS - 1), mean(PARTS - 1, PARTS))
            {
                let pairs: Vec<(f64, f64)> = before.into_iter().zip(last).collect();
                let subject = format!("The temperature of {name}");
                list.extend(still_moving(&topic, &subject, &pairs, false_alarm));
            }
            if let (Some(law), Some(found)) = (plan.steady_temperature(), mean(PARTS / 2, PARTS)) {
                let pair = Pair {
                    topic: &format!("{topic} against theory"),
                    a: &name,
                    b: "the steady state of Enskog's theory",
                    quantity: "temperature",
                    places: Places::Span("in the last half of the run"),
                    false_alarm,
                };
                list.extend(pair.judge(&[found.iter().map(|&ratio| (ratio, law)).collect()]));
            }
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
            record.kick(share, before, after);
        }
        assert_eq!(record.temperature(0, 1), Some(0.75));
        assert_eq!(record.temperature(2, 4), Some(0.5 * (1.0 + 1.25)));
        assert_eq!(record.temperature(3, 4), None);
    }
}
