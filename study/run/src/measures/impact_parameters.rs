//! Measure `impact_parameters`: impact parameters of collisions in time windows against molecular
//! chaos, and the factors of the dissipation identity.
//!
//! Under chaos P(b/d) is 1 in the plane and 2 b/d in space: (b/d)^(D-1) is uniform, whatever the
//! velocities are. So the test holds for rough grains and in flows too. The dissipation identity
//! ([`stosszahl_analysis::windows`]) needs equal smooth particles with one coefficient of
//! restitution.

use serde::{Deserialize, Serialize};
use stosszahl_analysis::replicas::pseudo_values;
use stosszahl_analysis::statistics::{ChiSquaredTest, chi_squared_test};
use stosszahl_analysis::windows::{
    self, CollisionWindow, CollisionWindows, DissipationFactors, PairBins, merged,
};
use stosszahl_model::{Observer, equation_of_state};
use stosszahl_results::{
    Figure, FigureAxis, PointMark, Table, TableEstimate, VerdictText, format_number, table,
};

use super::energy::pairs_of;
use super::mean_over_replicas;
use crate::judge::power::ReplicaSpread;
use crate::judge::{self, ImpactTest, title};
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, RunStop, SampleContext, described,
    keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `impact_parameters` of collisions in time windows.
pub struct ImpactMeasure;

/// Options of `[measure.impact_parameters]`: time windows and bins.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImpactOptions {
    /// Time windows \[start, end\], or "whole-run" for one. Default: 0 to 1, 5, 20, 100, 400 and so
    /// on up to the end of the run; one window with walls, gravity or spins and in gases without
    /// positions.
    pub windows: Option<Spans>,
    /// Number of bins of b/d.
    pub bins: u64,
}

/// Time windows as given in a case: the whole run, or a list.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "a list of windows [[start, end], ...], or \"whole-run\""
)]
pub enum Spans {
    /// One time window from the start to the end of the run.
    Whole(WholeRun),
    /// List of time windows, each with start and end.
    List(Vec<[f64; 2]>),
}

/// Word that stands for the whole run as a time window.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WholeRun {
    /// Time window from the start to the end of the run.
    WholeRun,
}

impl Default for ImpactOptions {
    fn default() -> Self {
        Self {
            windows: None,
            bins: 20,
        }
    }
}

/// Returns the default time windows, in units of the cooling time: 0 to 1, 5, 20, 100, 400 and so
/// on up to the end.
fn default_windows(until: f64) -> Vec<[f64; 2]> {
    let mut windows = Vec::new();
    let (mut start, mut end) = (0.0, 1.0);
    let mut factors = [5.0, 4.0].into_iter().cycle();
    while end < until {
        windows.push([start, end]);
        start = end;
        end *= factors.next().unwrap_or(5.0);
    }
    windows.push([start, until]);
    windows
}

/// Returns the time windows of a case, as given or by default, in the unit of time of the case.
pub(super) fn spans(plan: &CasePlan, written: Option<Spans>) -> Vec<[f64; 2]> {
    let until = plan.case.run.until;
    match written {
        Some(Spans::List(windows)) => windows,
        None if plan.has_thermal_units() => default_windows(until),
        _ => vec![[0.0, until]],
    }
}

/// Returns an error for an empty list of time windows.
pub(super) fn check_windows(windows: Option<&Spans>) -> Result<(), BadOption> {
    let none = matches!(windows, Some(Spans::List(windows)) if windows.is_empty());
    let allowed = "at least one window, or \"whole-run\"";
    measure::require(!none, "windows", allowed)
}

/// Collision sums of one engine and replica in the time windows.
type Record = CollisionWindows;

struct ImpactProbe {
    spans: Vec<[f64; 2]>,
    bins: usize,
    particles: usize,
    species: Vec<(f64, f64)>,
    record: Record,
}

impl Probe for ImpactProbe {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        Some(&mut self.record)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        let (start, temperature) = (moment.simulation.time(), moment.temperature());
        let windows =
            CollisionWindows::new(&self.spans, self.bins, self.particles, start, temperature);
        self.record = windows.in_dimension(moment.simulation.dimension());
        if self.species.len() > 1 {
            let pairs = PairBins::new(&self.species, self.spans.len(), self.bins);
            self.record.pairs = Some(pairs);
        }
    }

    fn on_stop(&mut self, stop: &RunStop) {
        self.record.synchronise(stop.time, stop.temperature);
    }

    keeps_record!();
}

impl ImpactMeasure {
    fn options(&self, plan: &CasePlan) -> (Vec<[f64; 2]>, usize) {
        let options: ImpactOptions = measure::chosen(plan, self.name());
        (spans(plan, options.windows), options.bins as usize)
    }
}

impl Measure for ImpactMeasure {
    described!(
        "impact_parameters",
        "Impact parameters of collisions against molecular chaos, and the factors of the cooling rate.",
        ImpactOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_uniform_box() && !plan.is_rough()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let ImpactOptions { windows, bins } = measure::options(plan, self.name())?;
        let allowed = "a whole number from 2 to 1000";
        measure::require((2..=1000).contains(&bins), "bins", allowed)?;
        check_windows(windows.as_ref())
    }

    /// Returns the edges of the time windows as sample times, so that no time step of an engine
    /// lies across them.
    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        self.options(plan).0.into_flattened()
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let (windows, bins) = self.options(plan);
        let spans = windows
            .iter()
            .map(|span| span.map(|edge| plan.engine_time(edge)));
        let species = plan.gas.species.iter().map(|one| (one.radius, one.mass));
        Box::new(ImpactProbe {
            spans: spans.collect(),
            bins,
            particles: plan.count(),
            species: species.collect(),
            record: CollisionWindows::new(&[], bins, plan.count(), 0.0, 1.0),
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let (spans, _) = self.options(plan);
        let mut tables = histograms(plan, runs, &spans);
        if plan.has_theory() {
            tables.push(dissipation(plan, runs, &spans));
        }
        if plan.gas.species.len() > 1 {
            tables.push(pairs(plan, runs, &spans));
        }
        tables
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        plan.engines.len()
    }

    fn quantity_spreads(&self, plan: &CasePlan) -> Vec<ReplicaSpread> {
        let until = plan.case.run.until;
        let [start, end] = self.options(plan).0.last().copied().unwrap_or([0.0, until]);
        let each = plan.expected_collisions(end) - plan.expected_collisions(start);
        let spread = |engine: &EnginePlan| {
            ReplicaSpread {
            quantity: format!("slope of P(b/d), {}, last window", title(engine.name)),
            // Of a uniform number it is 12 times that of its mean, sqrt(1/12).
            of_one: (12.0 / (0.5 * each * (plan.count() * engine.copies()) as f64)).sqrt(),
            source: "that of as many independent collisions as theory expects; clusters make it 2 to 9 times wider".into(),
            wanted: plan.case.verdict.absolute_tolerance,
            // Slopes have half of the level, and the last window half of that.
            tests: if self.options(plan).0.len() > 1 { 4 } else { 2 },
            relative: false,
        }
        };
        plan.engines.iter().map(spread).collect()
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let (spans, _) = self.options(plan);
        let mut list = Vec::new();
        for (engine, records) in runs.each::<Record>(plan) {
            let tests = tests(&spans, &records);
            let name = title(engine.name);
            let topic = format!("impact parameters, {name}");
            let rule = runs.absolute_rule(plan);
            list.push(judge::impact_parameters(&topic, name, &tests, &rule));
        }
        if plan.has_theory() {
            list.extend(
                pairs_of(plan)
                    .filter_map(|pair| explain_difference(plan, runs, &spans, pair.into())),
            );
        }
        list
    }
}

/// Returns the sums of one time window in every replica.
fn window<'a>(records: &[&'a Record], window: usize) -> Vec<&'a CollisionWindow> {
    records.iter().map(|one| &one.windows[window]).collect()
}

/// Returns the number of collisions in each bin of b/d, summed over all replicas.
fn counts(windows: &[&CollisionWindow]) -> Vec<u64> {
    let bins = windows.first().map_or(0, |window| window.bins.len());
    let count = |bin: usize| windows.iter().map(|window| window.bins[bin]).sum();
    (0..bins).map(count).collect()
}

/// Estimates a number from one time window of all replicas, with its jackknife error.
fn pooled(
    windows: &[&CollisionWindow],
    of: impl Fn(&CollisionWindow) -> Option<f64>,
) -> TableEstimate {
    mean_over_replicas(windows::pooled(windows, of).into_iter().map(Some))
}

/// Computes chi-squared of the impact parameters of all replicas against molecular chaos, as if
/// collisions were independent.
fn against_chaos(windows: &[&CollisionWindow]) -> Option<ChiSquaredTest> {
    let all = merged(windows)?;
    let observed: Vec<f64> = all.bins.iter().map(|&count| count as f64).collect();
    let chances = all.chances().into_iter();
    let expected = chances.map(|chance| chance * all.collisions as f64);
    chi_squared_test(&observed, &expected.collect::<Vec<f64>>(), 0).ok()
}

/// Tests the impact parameters of one engine in each time window, over replicas.
fn tests(spans: &[[f64; 2]], records: &[&Record]) -> Vec<ImpactTest> {
    let one = |(number, &span)| ImpactTest::test_window(span, &window(records, number));
    spans.iter().enumerate().map(one).collect()
}

/// Returns the lower and upper edge of a bin of b/d.
fn edges(bin: usize, bins: usize) -> [f64; 2] {
    [bin, bin + 1].map(|edge| edge as f64 / bins as f64)
}

/// Builds the table of impact parameters by bin, and the table of their summary.
fn histograms(plan: &CasePlan, runs: &ReplicaRecords<'_>, spans: &[[f64; 2]]) -> Vec<Table> {
    let figure = Figure::curves(
        "Impact parameters",
        FigureAxis::linear("bin_low", "b/d"),
        FigureAxis::linear("density", "P(b/d)"),
    );
    let figure = figure
        .panels(&["window_start", "window_end"])
        .mark(PointMark::Bars);
    let mut bins = table! {
        "impact_parameter", "Distribution of the impact parameter in windows of time.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "bin_low", "1", "Lower edge of the bin, b/d";
        key "bin_high", "1", "Upper edge of the bin, b/d";
        note "count", "1", "Collisions in the bin, over all replicas";
        with_theory "density", "1", "Probability density P(b/d); theory is molecular chaos: 1 of disks, 2 b/d of spheres";
    }
    .figure(figure.caption("The dashed line is molecular chaos."));
    let mut summary = table! {
        "impact_parameter_summary", "The distribution of the impact parameter in a few numbers.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        note "collisions", "1", "Collisions in the window, over all replicas";
        estimate "slope", "1", "Slope of the density of (b/d)^(D-1); zero under chaos, positive where grazing collisions prevail";
        value "mean_b_over_d", "1", "Mean of b/d; under chaos 1/2 of disks, 2/3 of spheres";
        note "trend_p_value", "1", "Chance of so large a slope under chaos: Student's t over the replicas";
        note "shape_p_value", "1", "Chance of so large a curvature, and of further shapes where there are enough replicas: Hotelling's test";
        note "over_dispersion", "1", "Squared spread of the slopes of replicas over that of independent collisions";
        note "chi_squared", "1", "Chi-squared against chaos, as if collisions were independent; it grows with the over-dispersion";
        note "degrees_of_freedom", "1", "Its degrees of freedom";
        note "verdict", "", "uniform, grazing excess, central excess, uneven, undecided, one replica or too few collisions; all windows together";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves(
            "Slope of P(b/d)",
            FigureAxis::logarithmic("window_end", "end of the window"),
            FigureAxis::linear("slope", "slope of P(b/d)"),
        )
        .line("molecular chaos", 0.0),
    );
    for (engine, records) in runs.each::<Record>(plan) {
        let tests = tests(spans, &records);
        let judged = judge::impact_windows(&tests, &runs.absolute_rule(plan));
        for (number, (one, word)) in tests.iter().zip(judged.words).enumerate() {
            let (windows, total) = (window(&records, number), one.collisions);
            let (counts, key) = (counts(&windows), (engine.name, one.window));
            let width = counts.len() as f64;
            let density = |count: u64, total: u64| count as f64 * width / total as f64;
            for (bin, &count) in counts.iter().enumerate() {
                let some = windows.iter().filter(|window| window.collisions > 0);
                let each = some.map(|window| Some(density(window.bins[bin], window.collisions)));
                let estimate = TableEstimate {
                    value: Some(if total > 0 {
                        density(count, total)
                    } else {
                        0.0
                    }),
                    theory: windows.first().map(|window| window.chaos(bin)),
                    ..mean_over_replicas(each)
                };
                bins.add((key, edges(bin, counts.len()), count, estimate));
            }
            let mean = pooled(&windows, CollisionWindow::mean_impact).value;
            let pearson = against_chaos(&windows);
            let alone = merged(&windows).and_then(|window| window.slope_error());
            let dispersion = one
                .slope
                .standard_error
                .zip(alone)
                .map(|(a, b)| (a / b).powi(2));
            let p_values = (
                one.trend.map(|test| test.p_value),
                one.shape.map(|test| test.p_value),
            );
            let pearson = (
                pearson.map(|test| test.statistic),
                pearson.map_or(0, |test| test.degrees_of_freedom),
            );
            summary.add((
                (key, total, one.slope),
                (mean, p_values, dispersion),
                (pearson, word, windows.len()),
            ));
        }
    }
    vec![bins, summary]
}

/// Accessors of the factors of the dissipation identity, in the order of their columns.
const FACTORS: [fn(&DissipationFactors) -> f64; 6] = [
    |d| d.rate,
    |d| d.speed,
    |d| d.impact,
    |d| d.correlation,
    |d| d.dissipation,
    DissipationFactors::at_pair_speed,
];

/// Computes the factors of the dissipation identity in one time window of one replica, or of
/// several merged.
fn known_factors(plan: &CasePlan, window: &CollisionWindow) -> Option<DissipationFactors> {
    // Collisions per particle and unit of sqrt(T/m) under molecular chaos, for Maxwellian
    // velocities.
    let chaos = if plan.gas.dimension == 2 {
        equation_of_state::collision_rate(plan.gas.packing_fraction, plan.gas.contact_value, 0.0)
    } else {
        equation_of_state::spheres::collision_rate(
            plan.gas.packing_fraction,
            plan.gas.contact_value,
        )
    };
    window.dissipation(chaos, plan.count())
}

/// Estimates the factors of the dissipation identity in one time window, with jackknife errors over
/// the replicas.
fn factors(plan: &CasePlan, records: &[&Record], number: usize) -> [TableEstimate; 6] {
    let windows = window(records, number);
    FACTORS.map(|of| pooled(&windows, |window| Some(of(&known_factors(plan, window)?))))
}

fn dissipation(plan: &CasePlan, runs: &ReplicaRecords<'_>, spans: &[[f64; 2]]) -> Table {
    let mut table = table! {
        "dissipation", "The cooling rate over that of Maxwellian velocities under molecular chaos at the total kinetic energy, flow included, as the product of four ratios.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        note "collisions", "1", "Collisions in the window, over all replicas";
        estimate "rate_ratio", "1", "Collision rate over its Enskog value";
        estimate "speed_ratio", "1", "Mean squared relative speed of colliding pairs over its Enskog value at the total kinetic energy";
        estimate "impact_ratio", "1", "Mean of 1 - b^2/d^2 over its value under chaos";
        estimate "correlation_ratio", "1", "What is left: the correlation of relative speed and impact parameter";
        estimate "dissipation_ratio", "1", "Cooling rate over its Enskog value: the product of the four";
        estimate "at_pair_speed", "1", "Cooling rate over that of chaos at the squared speed of the colliding pairs: dissipation_ratio/speed_ratio^(3/2)";
        note "replicas", "1", "Replicas";
    }
    .figure(Figure::curves(
        "Cooling rate over Enskog's",
        FigureAxis::logarithmic("window_end", "end of the window"),
        FigureAxis::linear("dissipation_ratio", "cooling rate over Enskog's"),
    ));
    for (engine, records) in runs.each::<Record>(plan) {
        for (number, &span) in spans.iter().enumerate() {
            let collisions = records.iter().map(|one| one.windows[number].collisions);
            let factors = factors(plan, &records, number);
            table.add((
                engine.name,
                span,
                collisions.sum::<u64>(),
                factors,
                records.len(),
            ));
        }
    }
    table
}

/// Creates a note on the factors that make up the difference of two engines in cooling, or in
/// collisions, in the last time window. Both engines have the same starts, so the jackknife leaves
/// out a replica of both together.
fn explain_difference(
    plan: &CasePlan,
    runs: &ReplicaRecords<'_>,
    spans: &[[f64; 2]],
    engines: [usize; 2],
) -> Option<VerdictText> {
    let number = spans.len().checked_sub(1)?;
    let records = engines.map(|engine| runs.records::<Record>(engine));
    let windows = [window(&records[0], number), window(&records[1], number)];
    let replicas = windows[0].len().min(windows[1].len());
    let both: Vec<[CollisionWindow; 2]> = (0..replicas)
        .map(|replica| [0, 1].map(|engine| windows[engine][replica].clone()))
        .collect();
    let add = |sum: &mut [CollisionWindow; 2], both: &[CollisionWindow; 2]| {
        for (sum, one) in sum.iter_mut().zip(both) {
            sum.merge(one);
        }
    };
    let quotient = |index: usize| {
        let of = |window: &CollisionWindow| Some(FACTORS[index](&known_factors(plan, window)?));
        let value = |[one, other]: &[CollisionWindow; 2]| Some(of(one)? / of(other)?);
        let values = pseudo_values(&both, add, |both| value(both).unwrap_or(f64::NAN));
        let known = values.iter().all(|value| !value.is_nan());
        (known && !values.is_empty())
            .then(|| judge::in_units(&mean_over_replicas(values.into_iter().map(Some)), 1.0))
    };
    let [a, b] = engines.map(|engine| title(plan.engines[engine].name));
    let [start, end] = spans[number].map(format_number);
    let (rate, speed) = (quotient(0)?, quotient(1)?);
    let factors = if plan.gas.law.is_elastic() {
        format!("collision rate {rate}, squared speed of pairs {speed}")
    } else {
        format!(
            "cooling {} = rate {rate}, speed {speed}, impact {}, correlation {}",
            quotient(4)?,
            quotient(2)?,
            quotient(3)?
        )
    };
    let sentence =
        format!("{a} over {b}, t = {start} to {end}, at equal total kinetic energy: {factors}.");
    Some(judge::verdict_note(
        format!("cooling rate, {a} over {b}"),
        sentence,
    ))
}

fn pairs(plan: &CasePlan, runs: &ReplicaRecords<'_>, spans: &[[f64; 2]]) -> Table {
    let mut table = table! {
        "impact_parameter_pairs", "Distribution of the impact parameter by kinds of pairs.";
        key "engine", "", "Engine";
        key "species_a", "1", "Number of one species, from 1";
        key "species_b", "1", "Number of the other, not below the first";
        key "pair", "", "Names of both species";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "bin_low", "1", "Lower edge of the bin, b/d; d is the distance at contact";
        key "bin_high", "1", "Upper edge of the bin, b/d";
        note "count", "1", "Collisions in the bin, over all replicas";
        with_theory "density", "1", "Probability density P(b/d), with the error of counting; theory is molecular chaos";
    };
    for (engine, records) in runs.each::<Record>(plan) {
        let all: Vec<&PairBins> = records
            .iter()
            .filter_map(|one| one.pairs.as_ref())
            .collect();
        let kinds = all.first().map_or(&[][..], |first| first.kinds());
        for (kind, pair) in kinds.iter().enumerate() {
            for (window, &span) in spans.iter().enumerate() {
                let bins = all[0].counts(window, kind).len();
                let count = |bin: usize| all.iter().map(|one| one.counts(window, kind)[bin]).sum();
                let counts: Vec<u64> = (0..bins).map(count).collect();
                let scale = bins as f64 / counts.iter().sum::<u64>().max(1) as f64;
                for (bin, &count) in counts.iter().enumerate() {
                    let error = (count > 0).then(|| (count as f64).sqrt() * scale);
                    let theory = records.first().map(|one| one.windows[window].chaos(bin));
                    let found =
                        TableEstimate::with_error(count as f64 * scale, error).against(theory);
                    let numbers = pair.species.map(|number| number as u64 + 1);
                    let species = (numbers, plan.pair_name(pair.species));
                    table.add((engine.name, species, span, edges(bin, bins), count, found));
                }
            }
        }
    }
    table
}

#[cfg(test)]
mod tests_of_windows {
    use super::*;

    #[test]
    fn default_windows_end_with_the_run() {
        let expected = [
            [0.0, 1.0],
            [1.0, 5.0],
            [5.0, 20.0],
            [20.0, 100.0],
            [100.0, 400.0],
        ];
        assert_eq!(default_windows(400.0), expected);
        assert_eq!(default_windows(0.5), [[0.0, 0.5]]);
        assert_eq!(default_windows(7.0), [[0.0, 1.0], [1.0, 5.0], [5.0, 7.0]]);
        assert!(default_windows(f64::MAX).len() < 1000);
    }
}
