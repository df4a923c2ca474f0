//! `series`: the whole gas at equal intervals of time, and its species.

use nalgebra::Vector3;
use stosszahl_analysis::theory::{BarometricColumn, TheoryError, rough::Temperatures};
use stosszahl_results::{
    Figure, FigureAxis, Table, TableEstimate, VerdictKind, VerdictText, table,
};

use super::course::{self, BlockRange, CourseSample, Looking, ReplicaCourse, Share};
use super::mean_over_replicas;
use crate::judge::{
    self, ComparedPair, Comparison, DifferenceUnit, MeasuredPoint, Places, VerdictRule,
    against_theory, holds_zero, in_units, title,
};
use crate::measure::{
    BadOption, Measure, NoOptions, Probe, ReplicaRecords, SampleProbe, described,
};
use crate::plan::{CasePlan, EnginePlan};
use crate::theory::flow;

/// Measure of the whole gas and its species at equal intervals of time.
pub struct TimeSeriesMeasure;

/// Largest relative change of a conserved energy by rounding.
const KEPT: f64 = 1e-10;

impl Measure for TimeSeriesMeasure {
    described!(
        "series",
        "The whole gas at equal intervals: particles, collisions, energies, temperatures and their theory.",
        NoOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        has_energies_apart(plan)
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        self.read_options(plan)?;
        course::check_blocks(plan, 1)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        course::times(plan).split_off(1)
    }

    fn kept_per_look(&self, plan: &CasePlan) -> f64 {
        super::KEPT_PER_SPECIES * (1 + plan.species.len()) as f64
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let looking = Looking::from_plan(plan);
        Box::new(SampleProbe::from_start(
            ReplicaCourse::new(),
            move |course, moment| {
                course.push(CourseSample::sample_gas(&looking, moment));
            },
        ))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let (mut series, mut species) = (series_table(plan), species_table());
        for (engine, courses) in runs.each::<ReplicaCourse>(plan) {
            fill_series(&mut series, plan, engine, &courses);
            fill_species(&mut species, plan, engine, &courses);
        }
        // In a periodic gas the measurement of the energy lists the species.
        let several = plan.species.len() > 1 && has_energies_apart(plan);
        [Some(series), several.then_some(species)]
            .into_iter()
            .flatten()
            .collect()
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        // Energy, or two temperatures, or the column of each engine; two temperatures of each with the first.
        if has_energies_apart(plan) {
            4 * plan.engines.len() - 2
        } else {
            2 * plan.engines.len()
        }
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let steady = course::steady::<ReplicaCourse>(plan, runs, |course| course);
        let window = BlockRange::last(plan, course::blocks(plan, None), &steady);
        let all: Vec<(&EnginePlan, Vec<&ReplicaCourse>)> = runs.each(plan).collect();
        let (mut list, rule) = (Vec::new(), runs.rule(plan));
        // In a periodic gas the measurement of the energy compares the engines.
        for other in (1..all.len()).filter(|_| has_energies_apart(plan)) {
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
}

/// Returns true if the kinetic energy of translation is not all there is: walls and gravity give a
/// flow and a height, spins an energy of their own.
pub(super) fn has_energies_apart(plan: &CasePlan) -> bool {
    plan.has_box() && (!plan.is_uniform() || plan.is_rough())
}

fn series_table(plan: &CasePlan) -> Table {
    let mut table = table! {
        "series", "The whole gas at one time, averaged over the replicas";
        key "engine", "", "Engine";
        key "time", "time", "Time";
        value "particles", "1", "Number of particles";
        value "collisions_per_particle", "1", "Collisions that a particle took part in since the start, on average";
        value "translational_energy", "energy", "Energy of translation, of all particles";
        value "rotational_energy", "energy", "Energy of rotation";
        value "potential", "energy", "Energy of height along axes that end at walls or openings; zero at the origin";
        estimate "energy", "energy", "Their sum";
        estimate "temperature", "energy", "Granular temperature, m <(v - u)^2>/D with the mean velocity u of all particles";
        theory "temperature_theory", "energy", "The same by theory; empty where there is none";
        estimate "spin_temperature", "energy", "Temperature of rotation, I <w^2> for each rotation; empty for smooth particles";
        theory "spin_temperature_theory", "energy", "The same by theory; empty where there is none";
        note "replicas", "1", "Replicas that the averages run over";
    };
    let (falls, spins) = (plan.gravity() != Vector3::zeros(), plan.is_rough());
    for (used, column, title) in [
        (true, "energy", "Energy of all particles"),
        (falls, "translational_energy", "Energy of translation"),
        (falls, "potential", "Energy of height"),
        (spins, "rotational_energy", "Energy of rotation"),
        (true, "temperature", "Granular temperature"),
        (spins, "spin_temperature", "Temperature of rotation"),
    ] {
        let (x, y) = (
            FigureAxis::linear("time", "time"),
            FigureAxis::linear(column, title),
        );
        table
            .figures
            .extend(used.then(|| Figure::curves(title, x, y)));
    }
    table
}

fn species_table() -> Table {
    let figure = Figure::curves(
        "Temperatures of the species",
        FigureAxis::linear("time", "time"),
        FigureAxis::linear("temperature", "granular temperature"),
    );
    let figure = figure.caption("Each about its own mean velocity.");
    table! {
        "species", "One species at one time, averaged over the replicas";
        key "engine", "", "Engine";
        key "time", "time", "Time";
        key "species", "", "Name of the species";
        value "particles", "1", "Number of its particles";
        estimate "temperature", "energy", "Its temperature, m <v^2>/D about its own mean velocity";
        estimate "spin_temperature", "energy", "Its temperature of rotation; empty for smooth particles";
    }
    .figure(figure.by(&["species"]).panels(&["engine"]))
}

/// Mean over the replicas at one sample of a quantity that may be absent.
fn mean(
    courses: &[&ReplicaCourse],
    index: usize,
    of: impl Fn(&CourseSample) -> Option<f64>,
) -> TableEstimate {
    mean_over_replicas(courses.iter().map(|course| of(&course[index])))
}

fn shortest(courses: &[&ReplicaCourse]) -> usize {
    courses.iter().map(|course| course.len()).min().unwrap_or(0)
}

fn fill_series(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    courses: &[&ReplicaCourse],
) {
    let (freedom, unit) = (course::freedom(plan), plan.scale.energy);
    if courses.is_empty() {
        return;
    }
    let theory = cooling(plan, engine).ok().flatten();
    for index in 0..shortest(courses) {
        let of =
            |of: &dyn Fn(&CourseSample) -> f64| mean(courses, index, |sample| Some(of(sample)));
        let energy = |energy: &dyn Fn(&CourseSample) -> f64| of(energy).times(unit);
        let expected = theory.and_then(|all| all.get(index));
        let each = |sample: &CourseSample| {
            2.0 * sample.collisions / sample.total().number.max(f64::MIN_POSITIVE)
        };
        let numbers = [of(&|sample| sample.total().number), of(&each)];
        let parts = [
            energy(&|sample| sample.total().translation),
            energy(&|sample| sample.total().rotation),
            energy(&|sample| sample.potential),
        ];
        let temperature = of(&|sample| sample.total().temperature(freedom));
        let spin = mean(courses, index, |sample| {
            sample.total().spin_temperature(freedom)
        });
        table.add((
            (engine.name, courses[0][index].time),
            numbers.map(|one| one.value),
            parts.map(|one| one.value),
            energy(&CourseSample::energy),
            temperature
                .against(expected.map(|t| t.translation))
                .times(unit),
            spin.against(expected.map(|t| t.rotation)).times(unit),
            courses.len(),
        ));
    }
}

fn fill_species(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    courses: &[&ReplicaCourse],
) {
    let (freedom, unit) = (course::freedom(plan), plan.scale.energy);
    for index in 0..shortest(courses) {
        for (species, kind) in plan.species.iter().enumerate() {
            let of = |of: &dyn Fn(&Share) -> Option<f64>| {
                mean(courses, index, |sample| of(&sample.species[species]))
            };
            let temperature = of(&|share| Some(share.temperature(freedom))).times(unit);
            let spin = of(&|share| share.spin_temperature(freedom)).times(unit);
            let (time, number) = (
                courses[0][index].time,
                of(&|share| Some(share.number)).value,
            );
            table.add((engine.name, time, &*kind.name, number, temperature, spin));
        }
    }
}

/// Theory of a homogeneous rough gas at the times of the samples, solved once; none of other gases.
pub(crate) fn cooling<'a>(
    plan: &'a CasePlan,
    engine: &EnginePlan,
) -> Result<Option<&'a [Temperatures]>, &'a TheoryError> {
    let solved = &plan.rough_temperatures[usize::from(flow::is_dilute(engine))];
    let solve = || {
        let times = course::times(plan).into_iter();
        let times: Vec<f64> = times.map(|time| plan.engine_time(time)).collect();
        flow::cooling(plan, engine, &times)
    };
    solved.get_or_init(solve).as_ref().map(Option::as_deref)
}

/// Temperatures of two engines at a dozen times.
fn engines_agree(
    plan: &CasePlan,
    both: [&(&EnginePlan, Vec<&ReplicaCourse>); 2],
    rule: &VerdictRule,
) -> Vec<VerdictText> {
    const TIMES: usize = 12;
    let freedom = course::freedom(plan);
    let ([a, b], runs) = (both.map(|one| title(one.0.name)), both.map(|one| &one.1));
    let samples = shortest(runs[0]).min(shortest(runs[1])).saturating_sub(1);
    let parts = TIMES.min(samples);
    let chosen: Vec<usize> = (1..=parts).map(|part| samples * part / parts).collect();
    let times: Vec<f64> = chosen
        .iter()
        .map(|&sample| runs[0][0][sample].time)
        .collect();
    let test = |quantity: &str, of: &dyn Fn(&Share) -> Option<f64>| {
        let at = |run: &ReplicaCourse, sample: usize| of(&run[sample].total()).unwrap_or(0.0);
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

/// Samples of one engine, and the rule for its verdicts.
struct One<'a> {
    plan: &'a CasePlan,
    engine: &'a EnginePlan,
    runs: &'a [&'a ReplicaCourse],
    window: &'a BlockRange,
    rule: VerdictRule,
}

impl One<'_> {
    fn topic(&self, what: &str) -> String {
        format!("{what}, {}", title(self.engine.name))
    }

    /// Returns the verdict on the energy of an elastic gas in a closed box, which is conserved;
    /// `None` for other gases.
    fn energy(&self) -> Option<VerdictText> {
        if !flow::keeps_energy(self.plan) || !has_energies_apart(self.plan) {
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
        let falls = self.plan.grains.gravity.is_some();
        let subject = if falls {
            "The energy, with that of height,"
        } else {
            "The energy"
        };
        Some(judge::is_kept(self.topic("energy"), subject, worst, KEPT))
    }

    /// Returns verdicts on the temperatures of a homogeneous gas of rough particles against theory.
    fn cooling(&self) -> Vec<VerdictText> {
        let topic = self.topic("two-temperature theory");
        let theory = match cooling(self.plan, self.engine) {
            Ok(theory) => theory.unwrap_or_default(),
            Err(error) => return vec![judge::no_theory(topic, error)],
        };
        let freedom = course::freedom(self.plan);
        let name = title(self.engine.name);
        let test =
            |of: &dyn Fn(&Share) -> Option<f64>, expected: fn(&Temperatures) -> f64, what: &str| {
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
            "translational_energy",
        );
        let rotation = test(
            &|share| share.spin_temperature(freedom),
            |t| t.rotation,
            "rotational_energy",
        );
        [translation, rotation].into_iter().flatten().collect()
    }

    /// Returns verdicts on a settled column in gravity.
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

    /// Mean of a number over the samples in the time window, and over the replicas.
    fn inside(&self, of: impl Fn(&CourseSample) -> f64) -> TableEstimate {
        let [start, end] = self.window.times;
        let within = |sample: &&CourseSample| sample.time > start && sample.time <= end;
        mean_over_replicas(self.runs.iter().map(|run| {
            let values: Vec<f64> = run.iter().filter(within).map(&of).collect();
            Some(values.iter().sum::<f64>() / values.len().max(1) as f64)
        }))
    }

    fn settled(&self, topic: &str, column: &BarometricColumn) -> Option<VerdictText> {
        let freedom = course::freedom(self.plan);
        let found = self.inside(|sample| sample.total().temperature(freedom));
        let start = self.plan.temperature;
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

    /// Tests whether the centre of mass falls lower than its final height: the potential energy
    /// then has a minimum before the end.
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
        let times = self.plan.engine_time(time) / self.plan.mean_free_time;
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
