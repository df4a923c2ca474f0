//! `series`: the whole gas at equal intervals of time, and its species.

use std::any::Any;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::compare::{self, Verdict as Test};
use stosszahl_analysis::theory::{Column, TheoryError};
use stosszahl_case::Kind;
use stosszahl_results::{
    Axis, Estimate, Figure, Table, Verdict, VerdictKind, engine_title as title,
};

use super::course::{self, Course, Looking, Sample, Share, Window, in_units, over};
use super::words::{self, with_error};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs};
use crate::plan::{EnginePlan, Plan};
use crate::theory::flow;

/// The course of the whole gas.
pub struct Series;

/// It has no options.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Options {}

/// Largest relative change of an energy that is kept.
const KEPT: f64 = 1e-10;

/// Largest relative deviation of the temperature of a settled column from theory.
const SETTLED: f64 = 0.01;

impl Measure for Series {
    fn name(&self) -> &'static str {
        "series"
    }

    fn about(&self) -> &'static str {
        "The whole gas at equal intervals: particles, collisions, energies, temperatures and their theory."
    }

    fn schema(&self) -> schemars::Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Flow
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        measure::options::<Options>(plan, self.name())?;
        course::check(plan, 1)
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        course::times(plan).split_off(1)
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(Watch {
            looking: Looking::of(plan),
            course: Course::new(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let (mut series, mut species) = (series_table(plan), species_table(plan));
        for (index, engine) in plan.engines.iter().enumerate() {
            let courses = runs.records::<Course>(index);
            fill_series(&mut series, plan, engine, &courses);
            fill_species(&mut species, plan, engine, &courses);
        }
        // In a periodic gas the measurement of the energy lists the species.
        let several = plan.species.len() > 1 && plan.kind == Kind::Flow;
        let tables = [series].into_iter();
        tables.chain(several.then_some(species)).collect()
    }

    fn verdicts(&self, plan: &Plan, runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        let all: Vec<Vec<&Course>> = (0..plan.engines.len())
            .map(|engine| runs.records(engine))
            .collect();
        let steady: Vec<_> = all
            .iter()
            .map(|runs| course::steady_from(plan, runs))
            .collect();
        let window = Window::last(plan, course::blocks(plan, None), &steady);
        let mut list = Vec::new();
        for other in 1..all.len() {
            list.extend(engines_agree(plan, [0, other], [&all[0], &all[other]]));
        }
        for (engine, runs) in plan.engines.iter().zip(&all) {
            let said = Said {
                plan,
                engine,
                runs,
                window: &window,
            };
            list.extend(said.energy());
            list.extend(said.cooling());
            list.extend(said.column());
        }
        list
    }
}

struct Watch {
    looking: Looking,
    course: Course,
}

impl Probe for Watch {
    fn begin(&mut self, moment: &mut Moment<'_>) {
        self.sample(moment);
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        let sample = Sample::take(&self.looking, moment, |_, _| {});
        self.course.push(sample);
    }

    fn save(&self) -> Result<Vec<u8>, postcard::Error> {
        measure::save(&self.course)
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), postcard::Error> {
        measure::load(&mut self.course, bytes)
    }

    fn record(&self) -> &dyn Any {
        &self.course
    }
}

fn series_table(plan: &Plan) -> Table {
    let mut table = Table::new(
        "series",
        "The whole gas at one time, averaged over the replicas",
    )
    .key("engine", "", "Engine")
    .key("time", "time", "Time")
    .value("grains", "1", "Number of particles")
    .value(
        "collisions_per_grain",
        "1",
        "Collisions that a particle took part in since the start, on average",
    )
    .value(
        "translation",
        "energy",
        "Energy of translation, of all particles",
    )
    .value("rotation", "energy", "Energy of rotation")
    .value(
        "potential",
        "energy",
        "Energy in the field; zero at the origin",
    )
    .estimate("energy", "energy", "Their sum")
    .estimate(
        "temperature",
        "energy",
        "Granular temperature, m <(v - u)^2>/D with the mean velocity u of all particles",
    )
    .theory("theory_temperature", "energy")
    .estimate(
        "spin_temperature",
        "energy",
        "Temperature of rotation, I <w^2> for each rotation; empty for smooth particles",
    )
    .theory("theory_spin_temperature", "energy")
    .note("replicas", "1", "Replicas that the averages run over");
    let time = || Axis::linear("time", "time");
    for (used, column, title) in [
        (true, "energy", "Energy of all particles"),
        (
            plan.grains.gravity.is_some(),
            "translation",
            "Energy of translation",
        ),
        (
            plan.grains.gravity.is_some(),
            "potential",
            "Energy of height",
        ),
        (
            plan.grains.rough.is_some(),
            "rotation",
            "Energy of rotation",
        ),
        (true, "temperature", "Granular temperature"),
        (
            plan.grains.rough.is_some(),
            "spin_temperature",
            "Temperature of rotation",
        ),
    ] {
        if used {
            table = table.figure(Figure::curves(title, time(), Axis::linear(column, title)));
        }
    }
    table
}

fn species_table(_plan: &Plan) -> Table {
    let figure = Figure {
        caption: "Each about its own mean velocity.".into(),
        curves: vec!["species".into()],
        panels: vec!["engine".into()],
        ..Figure::curves(
            "Temperatures of the species",
            Axis::linear("time", "time"),
            Axis::linear("temperature", "granular temperature"),
        )
    };
    Table::new(
        "species",
        "One species at one time, averaged over the replicas",
    )
    .key("engine", "", "Engine")
    .key("time", "time", "Time")
    .key("species", "", "Name of the species")
    .value("grains", "1", "Number of its particles")
    .estimate(
        "temperature",
        "energy",
        "Its temperature, m <v^2>/D about its own mean velocity",
    )
    .estimate(
        "spin_temperature",
        "energy",
        "Its temperature of rotation; empty for smooth particles",
    )
    .figure(figure)
}

/// Mean of a quantity that may be absent over the replicas at one sample.
fn mean(
    courses: &[&Course],
    index: usize,
    of: impl Fn(&Sample) -> Option<f64>,
) -> Option<(f64, Option<f64>)> {
    let values: Option<Vec<f64>> = courses.iter().map(|course| of(&course[index])).collect();
    Some(over(values?.into_iter()))
}

fn shortest(courses: &[&Course]) -> usize {
    courses.iter().map(|course| course.len()).min().unwrap_or(0)
}

fn fill_series(table: &mut Table, plan: &Plan, engine: &EnginePlan, courses: &[&Course]) {
    let (freedom, unit) = (course::freedom(plan), plan.scale.energy);
    let theory = cooling(plan, engine).ok().flatten();
    for index in 0..shortest(courses) {
        let number = |of: &dyn Fn(&Sample) -> f64| {
            mean(courses, index, |sample| Some(of(sample))).map(|(value, _)| value)
        };
        let estimate = |of: &dyn Fn(&Sample) -> Option<f64>, theory: Option<f64>| {
            let found = mean(courses, index, of).map(|found| in_units(found, unit));
            Estimate {
                theory: theory.map(|theory| theory * unit),
                ..found.unwrap_or_default()
            }
        };
        let expected = theory.as_ref().and_then(|all| all.get(index));
        let energy = |of: &dyn Fn(&Sample) -> f64| number(of).map(|value| value * unit);
        table
            .row()
            .text(engine.name)
            .number(courses[0][index].time)
            .number(number(&|sample| sample.total().number))
            .number(number(&|sample| {
                2.0 * sample.collisions / sample.total().number.max(f64::MIN_POSITIVE)
            }))
            .number(energy(&|sample| sample.total().translation))
            .number(energy(&|sample| sample.total().rotation))
            .number(energy(&|sample| sample.potential))
            .estimate(estimate(&|sample| Some(sample.energy()), None))
            .estimate(estimate(
                &|sample| Some(sample.total().temperature(freedom)),
                expected.map(|t| t.translation),
            ))
            .estimate(estimate(
                &|sample| sample.total().spin_temperature(freedom),
                expected.map(|t| t.rotation),
            ))
            .count(courses.len() as u64);
    }
}

fn fill_species(table: &mut Table, plan: &Plan, engine: &EnginePlan, courses: &[&Course]) {
    let (freedom, unit) = (course::freedom(plan), plan.scale.energy);
    for index in 0..shortest(courses) {
        for (species, kind) in plan.species.iter().enumerate() {
            let found = |of: &dyn Fn(&Share) -> Option<f64>| {
                mean(courses, index, |sample| of(&sample.species[species]))
            };
            let estimate = |of: &dyn Fn(&Share) -> Option<f64>| {
                let found = found(of).map(|found| in_units(found, unit));
                found.unwrap_or_default()
            };
            table
                .row()
                .text(engine.name)
                .number(courses[0][index].time)
                .text(kind.name.as_str())
                .number(found(&|share| Some(share.number)).map(|(value, _)| value))
                .estimate(estimate(&|share| Some(share.temperature(freedom))))
                .estimate(estimate(&|share| share.spin_temperature(freedom)));
        }
    }
}

/// Theory of a homogeneous rough gas at the times of the samples.
fn cooling(
    plan: &Plan,
    engine: &EnginePlan,
) -> Result<Option<Vec<stosszahl_analysis::theory::Temperatures>>, TheoryError> {
    let times: Vec<f64> = course::times(plan)
        .into_iter()
        .map(|time| plan.engine_time(time))
        .collect();
    flow::cooling(plan, engine, &times)
}

/// Temperatures of two engines at a dozen times.
fn engines_agree(plan: &Plan, engines: [usize; 2], runs: [&[&Course]; 2]) -> Vec<Verdict> {
    const TIMES: usize = 12;
    let freedom = course::freedom(plan);
    let samples = shortest(runs[0]).min(shortest(runs[1])).saturating_sub(1);
    let parts = TIMES.min(samples);
    let chosen: Vec<usize> = (1..=parts).map(|part| samples * part / parts).collect();
    let false_alarm = plan.case.verdict.false_alarm;
    let [a, b] = engines.map(|engine| title(plan.engines[engine].name));
    let test = |what: &str, of: &dyn Fn(&Sample) -> Option<f64>| {
        let at = |run: &Course, sample: usize| of(&run[sample]).unwrap_or(0.0);
        let pairs: Vec<Vec<(f64, f64)>> = chosen
            .iter()
            .map(|&sample| {
                let both = runs[0].iter().zip(runs[1]);
                both.map(|(a, b)| (at(a, sample), at(b, sample))).collect()
            })
            .collect();
        if pairs.iter().flatten().any(|&(a, b)| a <= 0.0 || b <= 0.0) {
            return None;
        }
        let found = compare::quotients(&pairs, false_alarm);
        let last = found.last()?;
        let quotient = with_error(last.quotient.value, last.quotient.standard_error);
        let topic = format!("{what}, {a} against {b}");
        if last.quotient.standard_error.is_none() {
            return Some(Verdict {
                topic,
                sentence: format!(
                    "At the end the quotient is {quotient}; one replica tells no more."
                ),
                kind: VerdictKind::Note,
            });
        }
        let (kind, word) = if found
            .iter()
            .any(|one| matches!(one.verdict, Test::Higher | Test::Lower))
        {
            (VerdictKind::Differ, "departs from one")
        } else if found.iter().all(|one| one.verdict == Test::Agree) {
            (VerdictKind::Agree, "is one within the errors")
        } else {
            (VerdictKind::Undecided, "is not known well enough")
        };
        let sentence = format!(
            "At the end the quotient is {quotient}; over {} times it {word} (paired t tests over {} replicas, chance of any false alarm {false_alarm}).",
            chosen.len(),
            runs[0].len(),
        );
        Some(Verdict {
            topic,
            sentence,
            kind,
        })
    };
    if plan.kind != Kind::Flow {
        // There the measurement of the energy compares the engines.
        return Vec::new();
    }
    let translation = test("temperature", &|sample| {
        Some(sample.total().temperature(freedom))
    });
    let rotation = (freedom.rotations > 0).then(|| {
        test("temperature of rotation", &|sample| {
            sample.total().spin_temperature(freedom)
        })
    });
    translation.into_iter().chain(rotation.flatten()).collect()
}

/// What is said of one engine.
struct Said<'a> {
    plan: &'a Plan,
    engine: &'a EnginePlan,
    runs: &'a [&'a Course],
    window: &'a Window,
}

impl Said<'_> {
    fn topic(&self, what: &str) -> String {
        format!("{what}, {}", title(self.engine.name))
    }

    /// Whether an elastic gas in a closed box keeps its energy.
    fn energy(&self) -> Option<Verdict> {
        if !flow::keeps_energy(self.plan) || self.plan.kind != Kind::Flow {
            return None;
        }
        let mut worst = 0.0_f64;
        for run in self.runs {
            let start = run.first()?;
            let all = start.total();
            let scale = (all.translation + all.rotation).max(start.energy().abs());
            for sample in *run {
                let change = (sample.energy() - start.energy()).abs();
                let share = if change == 0.0 { 0.0 } else { change / scale };
                worst = if share.is_nan() {
                    f64::INFINITY
                } else {
                    worst.max(share)
                };
            }
        }
        let height = if self.plan.grains.gravity.is_some() {
            ", with that of height,"
        } else {
            ""
        };
        Some(Verdict {
            topic: self.topic("energy"),
            sentence: format!(
                "The energy{height} is kept to {worst:.1e} of itself (limit {KEPT:.0e})."
            ),
            kind: if worst <= KEPT {
                VerdictKind::Agree
            } else {
                VerdictKind::Differ
            },
        })
    }

    /// Temperatures of a homogeneous gas of rough particles against theory.
    fn cooling(&self) -> Option<Verdict> {
        let topic = self.topic("two-temperature theory");
        let theory = match cooling(self.plan, self.engine) {
            Ok(theory) => theory?,
            Err(error) => return Some(words::no_theory(topic, &error)),
        };
        let (freedom, tolerance) = (course::freedom(self.plan), self.plan.case.verdict.tolerance);
        let worst = |found: &dyn Fn(&Sample) -> Option<f64>, expected: &[f64]| {
            let mut worst = (0.0_f64, None, 0.0);
            for (index, &theory) in expected.iter().enumerate().take(shortest(self.runs)) {
                if let Some((value, error)) = mean(self.runs, index, found)
                    && theory > 0.0
                {
                    let off = value / theory - 1.0;
                    if off.abs() > worst.0.abs() || index == 0 {
                        worst = (off, error.map(|e| e / theory), self.runs[0][index].time);
                    }
                }
            }
            worst
        };
        let expected: [Vec<f64>; 2] = [
            theory.iter().map(|t| t.translation).collect(),
            theory.iter().map(|t| t.rotation).collect(),
        ];
        let translation = worst(
            &|sample| Some(sample.total().temperature(freedom)),
            &expected[0],
        );
        let rotation = worst(
            &|sample| sample.total().spin_temperature(freedom),
            &expected[1],
        );
        let say = |(off, error, time): (f64, Option<f64>, f64)| {
            format!("{} at t = {time:.3}", words::percent(off, error))
        };
        let kinds =
            [translation, rotation].map(|(off, error, _)| words::within(off, error, tolerance));
        Some(Verdict {
            topic,
            sentence: format!(
                "The largest deviation from theory is {} in translation and {} in rotation (margin {} %).",
                say(translation),
                say(rotation),
                100.0 * tolerance
            ),
            kind: words::worst(kinds),
        })
    }

    /// A column that has settled.
    fn column(&self) -> Vec<Verdict> {
        let topic = self.topic("settled column");
        match flow::column(self.plan, self.engine) {
            Ok(None) => Vec::new(),
            Ok(Some(column)) => [self.settled(topic, &column)]
                .into_iter()
                .chain(self.overshoot())
                .collect(),
            Err(error) => vec![words::no_theory(topic, &error)],
        }
    }

    /// Mean over the samples of the window of one run.
    fn inside(&self, run: &Course, of: impl Fn(&Sample) -> f64) -> f64 {
        let [start, end] = self.window.times;
        let within = |sample: &&Sample| sample.time > start && sample.time <= end;
        let values: Vec<f64> = run.iter().filter(within).map(of).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    }

    fn settled(&self, topic: String, column: &Column) -> Verdict {
        let freedom = course::freedom(self.plan);
        let temperature = |sample: &Sample| sample.total().temperature(freedom);
        let (found, error) = over(self.runs.iter().map(|run| self.inside(run, temperature)));
        let (start, expected) = (self.plan.temperature, column.temperature());
        let off = found / expected - 1.0;
        let mut kind = words::within(off, error.map(|e| e / expected), SETTLED);
        let mut unsteady = "";
        if !self.window.steady {
            (kind, unsteady) = (VerdictKind::Undecided, "; it is not steady yet");
        }
        Verdict {
            topic,
            sentence: format!(
                "The temperature is {} times that of the start; theory says {:.4} ({:+.2} %, margin {} %){unsteady}.",
                with_error(found / start, error.map(|e| e / start)),
                expected / start,
                100.0 * off,
                100.0 * SETTLED
            ),
            kind,
        }
    }

    /// Whether the centre of mass falls lower than where it comes to rest: the energy of height has a minimum.
    fn overshoot(&self) -> Option<Verdict> {
        let mean = |index: usize| over(self.runs.iter().map(|run| run[index].potential));
        let samples = shortest(self.runs);
        let lowest = (0..samples).min_by(|&a, &b| mean(a).0.total_cmp(&mean(b).0))?;
        let time = self.runs[0][lowest].time;
        let (steady, steady_error) =
            over((self.runs.iter()).map(|run| self.inside(run, |sample| sample.potential)));
        let (least, least_error) = mean(lowest);
        let fall = self.runs[0][0].potential - steady;
        let depth = (steady - least) / fall;
        let error = steady_error
            .zip(least_error)
            .map(|(a, b)| a.hypot(b) / fall.abs());
        let mean_times = self.plan.engine_time(time) / self.plan.mean_free_time;
        let (kind, seen) = match error {
            _ if lowest + 1 == samples => {
                (VerdictKind::Undecided, "; it is still falling at the end")
            }
            _ if !self.window.steady => (VerdictKind::Undecided, "; it is not at rest yet"),
            None => (VerdictKind::Note, ""),
            Some(error) if depth > words::ERRORS * error => (VerdictKind::Note, ""),
            Some(_) => (
                VerdictKind::Undecided,
                "; the error is too wide to tell that from none",
            ),
        };
        Some(Verdict {
            topic: self.topic("overshoot"),
            sentence: format!(
                "The centre of mass is lowest at t = {time:.3}, {mean_times:.1} mean collision times after the release, {} of its whole fall below its rest{seen}.",
                with_error(depth, error)
            ),
            kind,
        })
    }
}
