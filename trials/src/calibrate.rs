//! Calibration of verdicts, `stosszahl-trials calibrate`: measured rates of false alarms and of
//! detected effects.
//!
//! Verdicts are drawn for replicas with a known truth. *Planted* replicas are random numbers. Their
//! collisions may be correlated within a replica, as in a clustered gas, where tests of independent
//! events fail. *Elastic* replicas are simulated gases: a case file of two equal species with two
//! engines, from its text to its verdicts.
//!
//! Each rate must lie within four binomial standard errors of the stated one. By chance, one of 16
//! 000 does not. A false-alarm rate may also be lower, because the correction for several tests is
//! conservative.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use statrs::distribution::{Binomial, DiscreteCDF};
use stosszahl_analysis::replicas::{power, replicas_needed};
use stosszahl_analysis::windows::{CollisionWindow, CollisionWindows};
use stosszahl_model::Interrupt;
use stosszahl_results::{Existing, VerdictKind, VerdictText};
use stosszahl_study::judge::power::FOUND;
use stosszahl_study::judge::{
    self, ComparedPair, Comparison, DifferenceUnit, ImpactTest, Places, VerdictRule,
};
use stosszahl_study::{RunSummary, run_case};

use crate::terminal::{say, trial_names};
use crate::trial::{ENDLESS, chosen, run_options};
use crate::{Done, Effort, TrialError, TrialLog};

/// Options of `stosszahl-trials calibrate`, the calibration of verdicts.
#[derive(Clone, Debug, Args)]
pub struct Calibrate {
    /// Calibration to run alone; may be repeated [default: all].
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = trial_names(TRIALS))]
    pub part: Vec<String>,
    /// Draw fewer replicas, and run 20 elastic cases instead of 500.
    #[arg(long)]
    pub quick: bool,
}

trials! {
    "energies" => energies,
        "equal energies at five times, 2 to 8 replicas of 3 % spread", "false alarms at 5 % at most", ENDLESS;
    "impact-parameters" => impact_parameters,
        "uniform impact parameters of independent collisions, and of replicas that each bend in their own way, five times more than \
         counting says",
        "false alarms at 5 % at most", ENDLESS;
    "planted-energy" => planted_energy,
        "energies 5 % apart at 3 % spread, 4 replicas and as many as check asks for", "found as often as check says", ENDLESS;
    "planted-slope" => planted_slope,
        "a slope of 0.02, 4 replicas of 10 000 disks with 10 collisions each", "found as often as check says", ENDLESS;
    "elastic" => elastic,
        "elastic gases of two equal species, 4 replicas of 64 disks, exact dynamics and Monte Carlo, from case to verdicts",
        "false alarms of each family and of whole cases at the level of the case at most", ENDLESS;
    "equivalence-cooling" => equivalence::cooling,
        "energies and impact parameters of 4, 8 and 16 replicas from a pool of gases that cool, with differences of none, half, one and two \
         margins",
        "false differ, false agree and missed bounds at 5 % at most", ENDLESS;
    "equivalence-elastic" => equivalence::elastic,
        "impact parameters of replicas from a pool of elastic gases, with slopes of none, half, one and two margins",
        "false differ, false agree and missed bounds at 5 % at most", ENDLESS;
    "equivalence-profiles" => equivalence::profiles,
        "profiles of 20 places and 40 blocks of time, with differences of none, half, one and two margins",
        "false differ, false agree and missed bounds at 5 % at most", ENDLESS;
}

mod equivalence;

/// Runs the requested calibrations of verdicts and prints their reports.
pub(crate) fn command(asked: &Calibrate) -> Done {
    let effort = Effort {
        quick: asked.quick,
        tell: true,
        ..Effort::default()
    };
    let chosen = chosen(TRIALS, |trial| trial.name, "part", &asked.part)?;
    let reports = chosen.iter().map(|trial| trial.run_trial(&effort));
    let bad = reports
        .inspect(|report| say(&report.to_string()))
        .filter(|report| !report.passed());
    match bad.count() {
        0 => Ok(()),
        bad => Err(TrialError::failed(format!(
            "{bad} of {} calibrations failed",
            chosen.len()
        ))),
    }
}

/// Largest deviation of a measured detection rate from the stated one, in binomial standard errors.
const FAR: f64 = 4.0;
/// Probability that a measured false-alarm rate exceeds its bound by chance, although the true rate
/// is the stated one.
const CHANCE: f64 = 1.0 / 16_000.0;
/// Stated false-alarm probability of a verdict.
const LEVEL: f64 = 0.05;

/// Verdict rule with a negligible margin, so that only the sign of a difference decides.
const NARROW: VerdictRule = VerdictRule {
    level: LEVEL,
    margin: 1e-6,
    differ_beyond: 0.0,
};

/// Returns the fraction of random samples for which `found` returns true, from 0 to 1.
fn rate(samples: usize, found: impl Fn(&mut Xoshiro256PlusPlus) -> bool, seed: u64) -> f64 {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..samples).filter(|_| found(&mut stream)).count() as f64 / samples as f64
}

/// Returns the highest false-alarm rate that chance explains at a stated level, by the binomial
/// law, which is skewed for few samples. For example, 5 of 20 at 5 % have a probability of 1 in
/// 390.
fn highest_rate(level: f64, samples: usize) -> Result<f64, TrialError> {
    let law = Binomial::new(level, samples as u64)?;
    Ok(law.inverse_cdf(1.0 - CHANCE) as f64 / samples as f64)
}

/// Records a measured false-alarm rate, which must not exceed the stated level beyond chance.
fn record_alarms(log: &mut TrialLog, what: &str, rate: f64, samples: usize, level: f64) -> Done {
    found!(log; "{what}: {:.1} of 100 (stated {:.1})", 100.0 * rate, 100.0 * level);
    let most = highest_rate(level, samples)?;
    log.at_most(&format!("{what}: false alarms"), rate, most);
    Ok(())
}

/// Records a measured detection rate of a planted effect, which must equal the stated power within
/// errors.
fn record_detections(log: &mut TrialLog, what: &str, rate: f64, samples: usize, stated: f64) {
    let error = (stated * (1.0 - stated) / samples as f64).sqrt();
    found!(log; "{what}: found in {:.1} of 100 (stated {:.1})", 100.0 * rate, 100.0 * stated);
    let off = (rate - stated).abs();
    log.at_most(&format!("{what}: off what is stated"), off, FAR * error);
}

fn samples(log: &TrialLog) -> usize {
    if log.effort.quick { 1000 } else { 20_000 }
}

/// Creates the verdict on the energies of two engines from pairs of replicas at several times.
/// `None` without enough data.
fn judge_energies(
    pairs: &[Vec<(f64, f64)>],
    times: &[f64],
    rule: VerdictRule,
) -> Option<VerdictText> {
    let comparison = Comparison {
        topic: "energy",
        a: "a",
        b: "b",
        quantity: "energy",
        unit: DifferenceUnit::Relative,
        rule,
    };
    let places = Places::Times(times);
    ComparedPair { comparison, places }.judge(pairs)
}

/// Draws energies of two engines whose means have the ratio exp(`log_ratio`), and returns true if
/// the verdict is *differ*. Replicas have a relative standard deviation of 3 %, and a third of the
/// variance is common to all times.
fn energies_differ(
    stream: &mut Xoshiro256PlusPlus,
    log_ratio: f64,
    times: &[f64],
    replicas: usize,
) -> bool {
    const SPREAD: f64 = 0.03;
    let (common, own) = ((1.0_f64 / 3.0).sqrt(), (2.0_f64 / 3.0).sqrt());
    let mean = log_ratio - 0.5 * SPREAD * SPREAD;
    let mut pairs = vec![Vec::new(); times.len()];
    for _ in 0..replicas {
        let shared: f64 = stream.sample(StandardNormal);
        for pairs in &mut pairs {
            let alone: f64 = stream.sample(StandardNormal);
            let energy = (mean + SPREAD * (common * shared + own * alone)).exp();
            pairs.push((energy, 1.0));
        }
    }
    judge_energies(&pairs, times, NARROW).is_some_and(|found| found.kind == VerdictKind::Differ)
}

fn energies(log: &mut TrialLog) -> Done {
    let (samples, times) = (samples(log), [1.0, 2.0, 3.0, 4.0, 5.0]);
    for replicas in [2, 4, 8] {
        let differ = |stream: &mut _| energies_differ(stream, 0.0, &times, replicas);
        let rate = rate(samples, differ, 1);
        record_alarms(log, &format!("{replicas} replicas"), rate, samples, LEVEL)?;
    }
    Ok(())
}

/// Creates an empty time window of collisions, for the distribution of impact parameters.
fn empty_window(span: [f64; 2]) -> CollisionWindow {
    CollisionWindows::new(&[span], 20, 1, 0.0, 1.0)
        .windows
        .remove(0)
}

/// Draws the collisions of one replica. Impact parameters u = b/d have the density 1 + slope (u -
/// 1/2) + curvature (6 (u - 1/2)² - 1/2).
fn window(
    stream: &mut Xoshiro256PlusPlus,
    collisions: u64,
    slope: f64,
    curvature: f64,
) -> CollisionWindow {
    let mut window = empty_window([0.0, 1.0]);
    let highest = 1.0 + 0.5 * slope.abs() + curvature.abs();
    while window.collisions < collisions {
        let (u, height): (f64, f64) = (stream.random(), stream.random());
        let from = u - 0.5;
        if height * highest <= 1.0 + slope * from + curvature * (6.0 * from * from - 0.5) {
            window.bins[(20.0 * u) as usize] += 1;
            window.collisions += 1;
            window.impact += u;
            window.impact_square += u * u;
        }
    }
    window
}

/// Draws impact parameters of replicas, each with its own random slope and curvature, and returns
/// true if the verdict is that they are not uniform.
fn is_not_uniform(
    stream: &mut Xoshiro256PlusPlus,
    [replicas, collisions]: [usize; 2],
    slope: f64,
    own: f64,
) -> bool {
    let draw = |_| {
        let [a, b]: [f64; 2] =
            std::array::from_fn(|_| own * stream.sample::<f64, _>(StandardNormal));
        window(stream, collisions as u64, slope + a, 0.5 * b)
    };
    let windows: Vec<CollisionWindow> = (0..replicas).map(draw).collect();
    let all: Vec<_> = windows.iter().collect();
    let tests = [ImpactTest::test_window([0.0, 1.0], &all)];
    judge::impact_parameters("topic", "engine", &tests, &NARROW).kind == VerdictKind::Differ
}

fn impact_parameters(log: &mut TrialLog) -> Done {
    const COLLISIONS: usize = 1000;
    let samples = samples(log) / 5;
    // Squared spread of the slopes five times that of independent collisions, 12/n.
    let own = (4.0 * 12.0 / COLLISIONS as f64).sqrt();
    for (what, own) in [("independent", 0.0), ("over-dispersed", own)] {
        for replicas in [2, 4, 12] {
            let bends = |stream: &mut _| is_not_uniform(stream, [replicas, COLLISIONS], 0.0, own);
            let (what, rate) = (
                format!("{what}, {replicas} replicas"),
                rate(samples, bends, 2),
            );
            record_alarms(log, &what, rate, samples, LEVEL)?;
        }
    }
    Ok(())
}

#[expect(clippy::unnecessary_wraps, reason = "as every trial")]
fn planted_energy(log: &mut TrialLog) -> Done {
    let samples = samples(log);
    let effect = 1.05_f64.ln() / 0.03;
    for replicas in [4, replicas_needed(effect, LEVEL, FOUND)] {
        let differ = |stream: &mut _| energies_differ(stream, 1.05_f64.ln(), &[1.0], replicas);
        let (what, rate) = (format!("{replicas} replicas"), rate(samples, differ, 3));
        record_detections(log, &what, rate, samples, power(effect, replicas, LEVEL));
    }
    Ok(())
}

#[expect(clippy::unnecessary_wraps, reason = "as every trial")]
fn planted_slope(log: &mut TrialLog) -> Done {
    const COLLISIONS: usize = 50_000;
    let samples = samples(log) / 40;
    // Half of the level is that of the slope, half that of the shape.
    let effect = 0.02 / (12.0 / COLLISIONS as f64).sqrt();
    for replicas in [4, replicas_needed(effect, 0.5 * LEVEL, FOUND)] {
        let bends = |stream: &mut _| is_not_uniform(stream, [replicas, COLLISIONS], 0.02, 0.0);
        let rate = rate(samples, bends, 4);
        let stated = power(effect, replicas, 0.5 * LEVEL);
        // False alarms of the shape where the trend is not found: at most half the level more.
        let error = (stated * (1.0 - stated) / samples as f64).sqrt();
        let most = 0.5 * LEVEL * (1.0 - stated) + FAR * error;
        found!(log; "{replicas} replicas: found in {:.1} of 100 (stated {:.1})", 100.0 * rate, 100.0 * stated);
        log.at_most("below what is stated", stated - rate, FAR * error);
        log.at_most("above what is stated", rate - stated, most);
    }
    Ok(())
}

/// Runs a case file text with a seed and writes the results to `folder`, which is overwritten.
fn run_case_text(text: &str, seed: usize, folder: &Path) -> Result<RunSummary, TrialError> {
    let set = [format!("seed={seed}")];
    let file = stosszahl_study::format().from_text(Path::new("case.toml"), text, &set)?;
    let (out, stop) = (folder.join("case"), Interrupt::default());
    let options = run_options(Some(&out), Existing::Replace, &stop, "");
    Ok(run_case(&file, &options)?)
}

/// False-alarm probability of one elastic case, shared by two engines and two families of tests.
const STATED: f64 = 0.2;

/// Case file text of an elastic gas of two equal species with two engines.
const ELASTIC: &str = "format = 2
title = \"An elastic gas\"
replicas = 4
[gas]
number = 64
restitution = 1
[[species]]
share = 0.5
[[species]]
share = 0.5
[box]
packing_fraction = 0.2
[start]
equilibration = 10
[run]
until = 6
[engine.ed]
[engine.dsmc-contact-point]
simulators_per_particle = 1
[measure.impact_parameters]
windows = \"whole-run\"
[verdict]
family_wise_error_rate = 0.2
";

fn elastic(log: &mut TrialLog) -> Done {
    let cases = if log.effort.quick { 20 } else { 500 };
    let folder = tempfile::tempdir()?;
    let mut families: BTreeMap<String, usize> = BTreeMap::new();
    let (mut any, mut verdicts) = (0, 0);
    for seed in 0..cases {
        let summary = run_case_text(ELASTIC, seed, folder.path())?;
        let mut rings = false;
        for verdict in &summary.points[0].verdicts {
            verdicts += 1;
            let rung = verdict.kind == VerdictKind::Differ;
            *families.entry(verdict.topic.clone()).or_default() += usize::from(rung);
            rings |= rung;
        }
        any += usize::from(rings);
        log.progress((seed + 1) as f64 / cases as f64, "");
    }
    must!(log, verdicts >= 4 * cases; "{verdicts} verdicts of {cases} cases");
    let share = |count: usize| count as f64 / cases as f64;
    for (topic, count) in families {
        record_alarms(log, &topic, share(count), cases, STATED / 4.0)?;
    }
    record_alarms(log, "any in a case", share(any), cases, STATED)
}
