//! Verdicts on flows and on rough gases: agreement of engines, energy conservation, two-temperature
//! theory, and the settled column in gravity.

use stosszahl_results::{TableEstimate, VerdictKind, VerdictText};
use stosszahl_theory::{BarometricColumn, TheoryError, rough::Temperatures};

use super::super::gas_series::{self, GasSample, GasSeries, SpeciesSums, shortest};
use super::super::mean_over_replicas;
use super::super::time_blocks::{self, TimeBlocks};
use super::{times, title};
use crate::judge::{
    self, ComparedPair, Comparison, DifferenceUnit, MeasuredPoint, Places, VerdictRule,
    against_theory, holds_zero, in_units,
};
use crate::measure::ReplicaRecords;
use crate::plan::{CasePlan, EnginePlan};
use crate::theory::flow;

/// Largest relative change of a conserved energy that counts as rounding.
const KEPT: f64 = 1e-10;

/// Returns the largest number of statistical tests: two for each engine against theory, and two for
/// each further engine against the first.
pub(super) fn test_count(plan: &CasePlan) -> usize {
    4 * plan.engines.len() - 2
}

/// Creates the verdicts on each engine, and on each further engine against the first.
pub(super) fn verdicts(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<VerdictText> {
    let steady = time_blocks::steady::<GasSeries>(plan, runs, |series| series);
    let window = TimeBlocks::last(plan, time_blocks::blocks(plan, None), &steady);
    let all: Vec<(&EnginePlan, Vec<&GasSeries>)> = runs.each(plan).collect();
    let (mut list, rule) = (Vec::new(), runs.rule(plan));
    for other in 1..all.len() {
        list.extend(engines_agree(plan, [&all[0], &all[other]], &rule));
    }
    for (engine, runs) in &all {
        let one = One {
            plan,
            engine,
            runs,
            window: &window,
            rule,
        };
        list.extend(one.energy());
        list.extend(one.cooling());
        list.extend(one.column());
    }
    list
}

/// Averages an optional quantity of the gas over replicas at one sample time.
fn mean(
    all_series: &[&GasSeries],
    index: usize,
    of: impl Fn(&GasSample) -> Option<f64>,
) -> TableEstimate {
    mean_over_replicas(all_series.iter().map(|series| of(&series[index])))
}

/// Returns the two-temperature theory of a homogeneous rough gas at the sample times; `None` for
/// other gases. The solution is computed once and kept in the plan.
pub(crate) fn two_temperature_theory<'a>(
    plan: &'a CasePlan,
    engine: &EnginePlan,
) -> Result<Option<&'a [Temperatures]>, &'a TheoryError> {
    let solved = &plan.theory.rough_temperatures[usize::from(flow::is_dilute(engine))];
    let solve = || {
        let times: Vec<f64> = times(plan)
            .into_iter()
            .map(|time| plan.engine_time(time))
            .collect();
        flow::cooling(plan, engine, &times)
    };
    solved.get_or_init(solve).as_ref().map(Option::as_deref)
}

/// Compares translational and rotational temperatures of two engines at twelve sample times.
fn engines_agree(
    plan: &CasePlan,
    both: [&(&EnginePlan, Vec<&GasSeries>); 2],
    rule: &VerdictRule,
) -> Vec<VerdictText> {
    const TIMES: usize = 12;
    let freedom = gas_series::freedom(plan);
    let ([a, b], runs) = (both.map(|one| title(one.0.name)), both.map(|one| &one.1));
    let samples = shortest(runs[0]).min(shortest(runs[1])).saturating_sub(1);
    let parts = TIMES.min(samples);
    let chosen: Vec<usize> = (1..=parts).map(|part| samples * part / parts).collect();
    let times: Vec<f64> = chosen
        .iter()
        .map(|&sample| runs[0][0][sample].time)
        .collect();
    let test = |quantity: &str, of: &dyn Fn(&SpeciesSums) -> Option<f64>| {
        let at = |run: &GasSeries, sample: usize| of(&run[sample].total()).unwrap_or(0.0);
        let pairs = chosen.iter().map(|&sample| {
            let both = runs[0].iter().zip(runs[1]);
            both.map(|(a, b)| (at(a, sample), at(b, sample))).collect()
        });
        let pairs: Vec<Vec<(f64, f64)>> = pairs.collect();
        let comparison = Comparison {
            topic: &format!("{quantity}, {a} against {b}"),
            a,
            b,
            quantity,
            unit: DifferenceUnit::Relative,
            rule: *rule,
        };
        let places = Places::Times(&times);
        let pair = ComparedPair { comparison, places };
        let positive = pairs.iter().flatten().all(|&(a, b)| a > 0.0 && b > 0.0);
        pair.judge(&pairs).filter(|_| positive)
    };
    let translation = test("temperature", &|share| Some(share.temperature(freedom)));
    let rotation = test("temperature of rotation", &|share| {
        share.spin_temperature(freedom)
    });
    [translation, rotation].into_iter().flatten().collect()
}

/// Samples of one engine in all replicas, with the rule for verdicts on its flow.
struct One<'a> {
    plan: &'a CasePlan,
    engine: &'a EnginePlan,
    runs: &'a [&'a GasSeries],
    window: &'a TimeBlocks,
    rule: VerdictRule,
}

impl One<'_> {
    fn topic(&self, what: &str) -> String {
        format!("{what}, {}", title(self.engine.name))
    }

    /// Returns the verdict on energy conservation of an elastic gas in a closed box; `None` for
    /// other gases.
    fn energy(&self) -> Option<VerdictText> {
        if !flow::keeps_energy(self.plan) {
            return None;
        }
        let mut worst = 0.0_f64;
        for run in self.runs {
            let start = run.first()?;
            let all = start.total();
            let scale = (all.translation + all.rotation).max(start.energy().abs());
            for change in run
                .iter()
                .map(|sample| (sample.energy() - start.energy()).abs())
            {
                let share = if change == 0.0 { 0.0 } else { change / scale };
                worst = if share.is_nan() {
                    f64::INFINITY
                } else {
                    worst.max(share)
                };
            }
        }
        let falls = self.plan.gas.particles.gravity.is_some();
        let subject = if falls {
            "The energy, with that of height,"
        } else {
            "The energy"
        };
        Some(judge::is_kept(self.topic("energy"), subject, worst, KEPT))
    }

    /// Returns verdicts on the temperatures of a homogeneously cooling rough gas against the
    /// two-temperature theory.
    fn cooling(&self) -> Vec<VerdictText> {
        let topic = self.topic("two-temperature theory");
        let theory = match two_temperature_theory(self.plan, self.engine) {
            Ok(theory) => theory.unwrap_or_default(),
            Err(error) => return vec![judge::no_theory(topic, error)],
        };
        let freedom = gas_series::freedom(self.plan);
        let name = title(self.engine.name);
        let test = |of: &dyn Fn(&SpeciesSums) -> Option<f64>,
                    expected: fn(&Temperatures) -> f64,
                    what: &str| {
            let theory = theory
                .iter()
                .map(expected)
                .enumerate()
                .take(shortest(self.runs));
            let points =
                theory
                    .filter(|&(_, theory)| theory > 0.0)
                    .filter_map(|(index, theory)| {
                        let found = mean(self.runs, index, |sample| of(&sample.total()));
                        MeasuredPoint::from_estimate(
                            self.runs[0][index].time,
                            &found.against(Some(theory)),
                        )
                    });
            let quantity = format!("temperature of {what}");
            let points: Vec<MeasuredPoint> = points.collect();
            let words = [name, "the two-temperature theory", &quantity];
            against_theory(&topic, words, &points, &self.rule)
        };
        let translation = test(
            &|share| Some(share.temperature(freedom)),
            |t| t.translation,
            "translation",
        );
        let rotation = test(
            &|share| share.spin_temperature(freedom),
            |t| t.rotation,
            "rotation",
        );
        [translation, rotation].into_iter().flatten().collect()
    }

    /// Returns verdicts on the gas that has settled in gravity: its temperature against theory, and
    /// the overshoot of its centre of mass.
    fn column(&self) -> Vec<VerdictText> {
        let topic = self.topic("settled column");
        match flow::column(self.plan, self.engine) {
            Ok(column) => {
                let found = column.map(|column| [self.settled(&topic, &column), self.overshoot()]);
                found.into_iter().flatten().flatten().collect()
            }
            Err(error) => vec![judge::no_theory(topic, &error)],
        }
    }

    /// Averages a quantity of the gas over the steady time window and over replicas.
    fn inside(&self, of: impl Fn(&GasSample) -> f64) -> TableEstimate {
        let [start, end] = self.window.times;
        let within = |sample: &&GasSample| sample.time > start && sample.time <= end;
        mean_over_replicas(self.runs.iter().map(|run| {
            let values: Vec<f64> = run.iter().filter(within).map(&of).collect();
            Some(values.iter().sum::<f64>() / values.len().max(1) as f64)
        }))
    }

    fn settled(&self, topic: &str, column: &BarometricColumn) -> Option<VerdictText> {
        let freedom = gas_series::freedom(self.plan);
        let found = self.inside(|sample| sample.total().temperature(freedom));
        let start = self.plan.gas.temperature;
        let found = found.against(Some(column.temperature())).times(1.0 / start);
        let point = MeasuredPoint::from_estimate(self.window.times[0], &found)?;
        let quantity = format!(
            "temperature ({} of the start, {:.4} by theory)",
            in_units(&found, 1.0),
            point.theory
        );
        let words = [title(self.engine.name), "theory", &quantity];
        let mut verdict = against_theory(topic, words, &[point], &self.rule)?;
        if !self.window.steady {
            verdict.kind = VerdictKind::Undecided;
            verdict.sentence += " It is not steady yet.";
        }
        Some(verdict)
    }

    /// Returns the verdict on the overshoot: how far the centre of mass falls below its final
    /// height.
    fn overshoot(&self) -> Option<VerdictText> {
        let mean = |index: usize| mean(self.runs, index, |sample| Some(sample.potential));
        let samples = shortest(self.runs);
        let height = |index: &usize| mean(*index).value.unwrap_or(f64::NAN);
        let lowest = (0..samples).min_by(|a, b| height(a).total_cmp(&height(b)))?;
        let time = self.runs[0][lowest].time;
        let (least, rest) = (mean(lowest), self.inside(|sample| sample.potential));
        let fall = self.runs[0][0].potential - rest.value?;
        let depth = (rest.value? - least.value?) / fall;
        let error = rest.standard_error.zip(least.standard_error);
        let error = error.map(|(a, b)| a.hypot(b) / fall.abs());
        let times = self.plan.engine_time(time) / self.plan.clock.mean_free_time;
        let found = TableEstimate {
            replicas: rest.replicas,
            ..TableEstimate::with_error(depth, error)
        };
        let open = match holds_zero(&found, self.rule.level) {
            _ if lowest + 1 == samples => "; it is still falling at the end",
            _ if !self.window.steady => "; it is not at rest yet",
            Some(true) => "; the error is too wide to tell that from none",
            _ => "",
        };
        let kind = if open.is_empty() {
            VerdictKind::Note
        } else {
            VerdictKind::Undecided
        };
        let depth = in_units(&found, 1.0);
        let sentence = format!(
            "The centre of mass is lowest at t = {time:.3}, {times:.1} mean collision times after the release, {depth} of its \
             whole fall below its rest{open}."
        );
        Some(judge::verdict(self.topic("overshoot"), sentence, kind))
    }
}
