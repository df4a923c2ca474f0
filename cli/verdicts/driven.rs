//! What is said of a driven gas: whether it is steady, and whether theory has its temperature.

use stosszahl_analysis::compare::{Verdict as Test, quotients};
use stosszahl_analysis::statistics::student_t_test;

use super::{kind, with_error};
use crate::manifest::{Verdict, VerdictKind};
use crate::run::{Finished, PARTS};
use crate::setup::Setup;

/// The verdicts on one engine; none in a gas that cools freely.
pub(super) fn verdicts(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<Verdict> {
    let mut list = Vec::new();
    list.extend(unsteady(setup, engine, runs));
    list.extend(theory(setup, engine, runs));
    list
}

/// Mean temperature over that of the start in parts of each run.
fn temperatures(runs: &[&Finished], first: usize, end: usize) -> Option<Vec<f64>> {
    let each = runs
        .iter()
        .map(|run| run.record.driven.as_ref()?.temperature(first, end));
    each.collect()
}

/// The last quarter against the one before, by a paired t test.
fn unsteady(setup: &Setup, engine: &str, runs: &[&Finished]) -> Option<Verdict> {
    let before = temperatures(runs, PARTS - 2, PARTS - 1)?;
    let last = temperatures(runs, PARTS - 1, PARTS)?;
    let growth: Vec<f64> = last
        .iter()
        .zip(&before)
        .map(|(b, a)| (b / a).ln())
        .collect();
    let test = student_t_test(&growth, 0.0)?;
    let mean = growth.iter().sum::<f64>() / growth.len() as f64;
    (test.p_value < setup.case.verdict.false_alarm).then(|| Verdict {
        topic: format!("steady state, {engine}"),
        sentence: format!(
            "The temperature of {engine} is not steady: in the last quarter of the run it is {:.4} times that of the \
             quarter before (paired t test over replicas, chance of a false alarm {}).",
            mean.exp(),
            setup.case.verdict.false_alarm
        ),
        kind: VerdictKind::Warning,
    })
}

/// The last half of the run against the steady state of theory.
fn theory(setup: &Setup, engine: &str, runs: &[&Finished]) -> Option<Verdict> {
    let law = setup.steady_temperature()?;
    let found = temperatures(runs, PARTS / 2, PARTS)?;
    let pairs = vec![found.iter().map(|&ratio| (ratio, law)).collect()];
    let all = quotients(&pairs, setup.case.verdict.false_alarm);
    let quotient = all.first()?;
    let outcome = match quotient.verdict {
        Test::Agree => "no difference",
        Test::Higher => "hotter",
        Test::Lower => "colder",
        Test::Undecided => "undecided",
    };
    let value = with_error(quotient.quotient.value, quotient.quotient.standard_error);
    Some(Verdict {
        topic: format!("steady state, {engine} against theory"),
        sentence: format!(
            "{engine} against the steady state of Enskog's theory, T/T(0) = {law:.4}: {outcome}; in the last half of the run \
             T/T_theory = {value}. (t test over replicas, chance of a false alarm {}.)",
            setup.case.verdict.false_alarm
        ),
        kind: kind(&[quotient.verdict]),
    })
}
