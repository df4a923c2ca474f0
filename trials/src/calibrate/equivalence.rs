//! Calibration of the verdicts *agree* and *differ* at true differences of zero, half a margin, one
//! margin and two.
//!
//! Replicas are drawn with replacement from stored real gases. Two samples of one pool do not
//! differ, whatever their distribution. A known difference is then planted on one sample. Profiles
//! are drawn from normal distributions, as means over time blocks.

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use stosszahl_analysis::statistics::Estimate as Mean;
use stosszahl_analysis::windows::CollisionWindow;
use stosszahl_results::{
    KeyCondition::Is, NumberNotFound, Stored, Table, TableEstimate, VerdictKind, VerdictText,
};
use stosszahl_study::judge::{self, ImpactTest, VerdictRule};

use super::{LEVEL, empty_window, highest_rate, judge_energies, run_case_text};
use crate::table::mean;
use crate::{Done, TrialError, TrialLog};

/// True differences planted on replicas, in units of the verdict's margin.
const DIFFERENCES: [f64; 4] = [0.0, 0.5, 1.0, 2.0];
/// Numbers of replicas for which verdicts are drawn.
const REPLICAS: [usize; 3] = [4, 8, 16];

/// Formats the case file of one replica: 100 particles with a coefficient of restitution, and the
/// given engines and measurements.
fn case_text(restitution: f64, engines_and_measures: &str) -> String {
    format!(
        "format = 2
replicas = 1
[gas]
number = 100
restitution = {restitution}
[box]
packing_fraction = 0.2
[start]
equilibration = 10
[run]
until = 20
[engine.ed]
{engines_and_measures}
[measure.impact_parameters]
"
    )
}

/// Stored replica of a real gas, from which calibration samples are drawn.
struct Replica {
    /// K/K(0) of the gas at each sample time after the start.
    energies: Vec<f64>,
    /// Impact parameters of the gas's collisions in time windows.
    windows: Vec<CollisionWindow>,
}

/// Stored replicas of one engine to draw from, with their sample times and time windows.
struct Pool {
    name: String,
    times: Vec<f64>,
    spans: Vec<[f64; 2]>,
    replicas: Vec<Replica>,
}

/// Reads the time windows and counts of impact parameters of one engine from a result table.
fn windows(
    table: &Table,
    engine: &str,
) -> Result<(Vec<[f64; 2]>, Vec<CollisionWindow>), NumberNotFound> {
    let (mut spans, mut windows) = (Vec::new(), Vec::new());
    for row in table.find_rows(&[("engine", Is(engine))])? {
        let span = [row.number("window_start")?, row.number("window_end")?];
        if spans.last() != Some(&span) {
            spans.push(span);
            windows.push(empty_window(span));
        }
        if let Some(window) = windows.last_mut() {
            let bin = (20.0 * row.number("bin_low")?).round() as usize;
            add_collisions(window, bin, row.number("count")? as u64);
        }
    }
    Ok((spans, windows))
}

/// Adds `count` collisions to one bin of impact parameters, with their moments as if uniform within
/// the bin.
fn add_collisions(window: &mut CollisionWindow, bin: usize, count: u64) {
    let place = (bin as f64 + 0.5) / window.bins.len() as f64;
    window.bins[bin] += count;
    window.collisions += count;
    window.impact += count as f64 * place;
    window.impact_square += count as f64 * (place * place + 1.0 / 4800.0);
}

/// Returns the number of gases to store, and the numbers of replicas to draw from them.
fn pool_size(log: &TrialLog) -> (usize, &'static [usize]) {
    if log.effort.quick {
        (24, &REPLICAS[1..2])
    } else {
        (400, &REPLICAS)
    }
}

/// Runs single-replica cases and stores the energies and impact parameters of each engine.
fn pools(
    log: &mut TrialLog,
    text: &str,
    name: &str,
    count: usize,
) -> Result<Vec<Pool>, TrialError> {
    let folder = tempfile::tempdir()?;
    let mut pools: Vec<Pool> = Vec::new();
    for seed in 0..count {
        let summary = run_case_text(text, 1000 + seed, folder.path())?;
        let stored = Stored::read(&summary.folder)?;
        let stored = stored.ok_or_else(|| TrialError::failed("no results"))?;
        for engine in &stored.manifest.engines {
            let (mut times, mut energies) = (Vec::new(), Vec::new());
            if let Ok(energy) = stored.table("energy") {
                for row in energy.find_rows(&[("engine", Is(&engine.engine))])? {
                    let time = row.number("time")?;
                    if time > 0.0 {
                        times.push(time);
                        energies.push(row.number("energy_ratio")?);
                    }
                }
            }
            let (spans, windows) = windows(stored.table("impact_parameter")?, &engine.engine)?;
            let title = format!("{name}, {}", engine.engine);
            let known = pools.iter().position(|pool| pool.name == title);
            let place = known.unwrap_or_else(|| {
                pools.push(Pool {
                    name: title,
                    times,
                    spans,
                    replicas: Vec::new(),
                });
                pools.len() - 1
            });
            pools[place].replicas.push(Replica { energies, windows });
        }
        log.progress((seed + 1) as f64 / count as f64, name);
    }
    Ok(pools)
}

/// Counts of *agree* and *differ* verdicts at one true difference.
#[derive(Clone, Copy, Debug, Default)]
struct Rates {
    samples: usize,
    agree: usize,
    differ: usize,
    /// Number of *differ* verdicts whose stated lower bound exceeds the true difference.
    missed: usize,
    /// Sum over *differ* verdicts of the estimated difference over the true one.
    inflation: f64,
}

impl Rates {
    fn count_verdict(&mut self, found: &VerdictText, truth: f64) {
        self.samples += 1;
        match found.kind {
            VerdictKind::Agree => self.agree += 1,
            VerdictKind::Differ => self.differ += 1,
            _ => {}
        }
        let said = bound(&found.sentence);
        if found.kind == VerdictKind::Differ {
            self.missed += usize::from(said.is_some_and(|said| said > truth.abs() + 1e-9));
            let number = found.number.as_ref().map_or(0.0, |one| one.difference);
            self.inflation += number / truth;
        }
    }
}

/// Parses the lower bound of the difference from the sentence of a *differ* verdict.
fn bound(sentence: &str) -> Option<f64> {
    let (_, said) = sentence.rsplit_once("at least ")?;
    let (value, scale) = match said.trim_end_matches('.').strip_suffix(" %") {
        Some(value) => (value, 0.01),
        None => (said.trim_end_matches('.'), 1.0),
    };
    Some(scale * value.parse::<f64>().ok()?)
}

/// Draws verdicts for each true difference and number of replicas, and checks that wrong verdicts
/// are no more frequent than stated.
fn measure(
    log: &mut TrialLog,
    what: &str,
    margin: f64,
    counts: &[usize],
    mut draw: impl FnMut(&mut Xoshiro256PlusPlus, usize, f64) -> Option<VerdictText>,
) -> Done {
    let samples = if log.effort.quick { 200 } else { 1000 };
    let most = highest_rate(LEVEL, samples)?;
    for &count in counts {
        for difference in DIFFERENCES {
            let mut stream = Xoshiro256PlusPlus::seed_from_u64(7);
            let truth = difference * margin;
            let mut rates = Rates::default();
            for _ in 0..samples {
                if let Some(found) = draw(&mut stream, count, truth) {
                    rates.count_verdict(&found, truth);
                }
            }
            let share = |number: usize| number as f64 / rates.samples.max(1) as f64;
            let [agree, differ, missed] = [rates.agree, rates.differ, rates.missed].map(share);
            let row = format!("{what}, {count} replicas, {difference} margins");
            let inflation = match rates.inflation / rates.differ as f64 {
                mean if mean.is_finite() => format!(", estimate over truth {mean:.2}"),
                _ => String::new(),
            };
            let undecided = 1.0 - agree - differ;
            let [a, b, c, d] = [agree, differ, undecided, missed].map(|share| 100.0 * share);
            found!(log; "{row}: agree {a:.1}, differ {b:.1}, undecided {c:.1}, bound missed {d:.1} of 100{inflation}");
            must!(log, rates.samples == samples; "{row}: {} verdicts", rates.samples);
            log.at_most(&format!("{row}: bounds missed"), missed, most);
            if difference == 0.0 {
                log.at_most(&format!("{row}: false differ"), differ, most);
            }
            if difference >= 1.0 {
                log.at_most(&format!("{row}: false agree"), agree, most);
            }
        }
    }
    Ok(())
}

/// Calibrates the energy verdict on replicas of cooling gases: one of two samples from the same
/// engine is raised by the planted difference.
pub(super) fn cooling(log: &mut TrialLog) -> Done {
    let (count, counts) = pool_size(log);
    let chaos = "[engine.dsmc-contact-point]\nsimulators_per_particle = 1\n[measure.energy]";
    let pools = pools(log, &case_text(0.8, chaos), "cooling", count)?;
    for pool in &pools {
        let last = |one: &Replica| Some(one.energies.last()?.ln());
        let spread = mean(pool.replicas.iter().filter_map(last))?;
        let spread = spread.standard_error.unwrap_or(f64::NAN) * (count as f64).sqrt();
        // Margin of two spreads of one replica: eight replicas find a difference of two margins in
        // most cases.
        let margin = 2.0 * spread;
        found!(log; "{}: spread of one replica {:.1} %, margin {:.1} %", pool.name, 100.0 * spread, 100.0 * margin);
        let what = format!("energies, {}", pool.name);
        measure(log, &what, margin, counts, |stream, replicas, truth| {
            let mut draw = || &pool.replicas[stream.random_range(0..pool.replicas.len())].energies;
            let both: Vec<_> = (0..replicas).map(|_| (draw(), draw())).collect();
            let at = |time: usize| {
                let pair = |(a, b): &(&Vec<f64>, &Vec<f64>)| (a[time] * (1.0 + truth), b[time]);
                both.iter().map(pair).collect()
            };
            let pairs: Vec<Vec<(f64, f64)>> = (0..pool.times.len()).map(at).collect();
            judge_energies(&pairs, &pool.times, VerdictRule::new(LEVEL, margin))
        })?;
        // Monte Carlo only: the impact parameters of clustered exact disks have a slope.
        if pool.name.contains("contact-point") {
            impact(log, pool, counts)?;
        }
    }
    Ok(())
}

/// Calibrates the impact-parameter verdict on replicas of elastic gases of exact disks.
pub(super) fn elastic(log: &mut TrialLog) -> Done {
    let (count, counts) = pool_size(log);
    let pools = pools(log, &case_text(1.0, ""), "elastic", count)?;
    pools.iter().try_for_each(|pool| impact(log, pool, counts))
}

/// Calibrates the impact-parameter verdict on stored replicas. Each is mirrored at random, which
/// removes any slope, and then tilted by the planted slope.
fn impact(log: &mut TrialLog, pool: &Pool, counts: &[usize]) -> Done {
    // Margin of twice the root mean square slope of one replica: eight replicas find a slope of two
    // margins in most cases.
    let last = |one: &Replica| one.windows.last().and_then(CollisionWindow::slope);
    let slopes: Vec<f64> = pool.replicas.iter().filter_map(last).collect();
    let squares: f64 = slopes.iter().map(|slope| slope * slope).sum();
    let margin = 2.0 * (squares / slopes.len().max(1) as f64).sqrt();
    found!(log; "{}: margin of the slope {margin:.3}", pool.name);
    let what = format!("P(b/d), {}", pool.name);
    measure(log, &what, margin, counts, |stream, replicas, truth| {
        let mut draw = || {
            let one = &pool.replicas[stream.random_range(0..pool.replicas.len())];
            let over: bool = stream.random();
            let tilt = |window: &CollisionWindow| tilted(window, over, truth);
            one.windows.iter().map(tilt).collect::<Vec<_>>()
        };
        let drawn: Vec<Vec<CollisionWindow>> = (0..replicas).map(|_| draw()).collect();
        let test = |(place, &span): (usize, &[f64; 2])| {
            let all: Vec<&CollisionWindow> = drawn.iter().map(|one| &one[place]).collect();
            ImpactTest::test_window(span, &all)
        };
        let tests: Vec<ImpactTest> = pool.spans.iter().enumerate().map(test).collect();
        let rule = VerdictRule::new(LEVEL, margin);
        Some(judge::impact_parameters("P(b/d)", "a", &tests, &rule))
    })
}

/// Returns the collisions of a window with the density of u = b/d multiplied by `1 + slope (u -
/// 1/2)`. If `over` is true, the density is mirrored before.
fn tilted(window: &CollisionWindow, over: bool, slope: f64) -> CollisionWindow {
    let bins = window.bins.len();
    let mut tilted = CollisionWindow {
        bins: vec![0; bins],
        collisions: 0,
        impact: 0.0,
        impact_square: 0.0,
        ..window.clone()
    };
    for (bin, &count) in window.bins.iter().enumerate() {
        let bin = if over { bins - 1 - bin } else { bin };
        let place = (bin as f64 + 0.5) / bins as f64;
        let factor = (1.0 + slope * (place - 0.5)).max(0.0);
        add_collisions(&mut tilted, bin, (count as f64 * factor).round() as u64);
    }
    tilted
}

/// Calibrates the profile verdict on two drawn profiles of twenty positions, each a mean over forty
/// time blocks.
pub(super) fn profiles(log: &mut TrialLog) -> Done {
    const BLOCKS: usize = 40;
    const PLACES: usize = 20;
    const SPREAD: f64 = 0.06;
    const MARGIN: f64 = 0.05;
    let rule = VerdictRule::new(LEVEL, MARGIN);
    measure(
        log,
        "profiles",
        MARGIN,
        &[BLOCKS],
        |stream, blocks, truth| {
            let mut drawn = |centre: f64| {
                let mut value =
                    || centre * (1.0 + SPREAD * stream.sample::<f64, _>(StandardNormal));
                let values: Vec<f64> = (0..blocks).map(|_| value()).collect();
                let mean = Mean::over_replicas(&values);
                mean.map_or(TableEstimate::default(), |mean| {
                    TableEstimate::with_error(mean.value, mean.standard_error)
                })
            };
            let place = |place: usize| {
                let centre = 1.0 + 0.1 * place as f64;
                // Difference at all places, so that agreement is false at each.
                let pair = [drawn(centre * (1.0 + truth)), drawn(centre)];
                (pair, format!("y = {place}"))
            };
            let places: Vec<_> = (0..PLACES).map(place).collect();
            judge::profiles("profile", ["a", "b", "density"], &places, blocks, &rule)
        },
    )
}
