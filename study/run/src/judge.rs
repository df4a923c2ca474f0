//! Tests of equivalence and their wording: every comparison of a run becomes a verdict here.
//!
//! # One rule
//!
//! Each comparison has a margin, `verdict.tolerance` of the case, or `verdict.absolute_tolerance`
//! for numbers that are zero under chaos, and a simultaneous interval of the difference
//! ([`stosszahl_analysis::compare`]):
//!
//! - *agree*: the whole interval lies inside the margin;
//! - *differ*: the whole interval lies on one side of zero, or of the margin if the case asks for that;
//! - *undecided*: all else. The sentence has the estimate, its error and the bound that holds.
//!
//! Errors come from few replicas, so all intervals are Student's, and sentences name the degrees of
//! freedom. The chance of any false difference in all verdicts of a point is
//! `verdict.family_wise_error_rate`; each verdict has an equal share of it, by Bonferroni
//! ([`ReplicaRecords::level`](crate::measure::ReplicaRecords::level)). Over the points of a sweep
//! the rate of false discoveries is controlled, when all are there (`stosszahl_report`). Within one
//! verdict:
//!
//! - *series over paired replicas* ([`ComparedPair`]) and *impact parameters* ([`impact_parameters`]): half of the level for the last time or
//!   window, half for all others by the path of their statistics;
//! - *points with errors against theory* ([`against_theory`]) and *profiles* ([`profiles`]): all together by Bonferroni;
//! - *what a paper says of a number* ([`claims`]).
//!
//! A sentence states the number that was chosen before the run, the last one, where that decides.
//! Otherwise it states the one whose interval is farthest from zero. The bound holds then; the
//! estimate is too large, as it is the largest of many.

use std::fmt::Display;

use stosszahl_analysis::compare::{Interval, Quotient, quotients};
use stosszahl_analysis::statistics::student_t_test;
use stosszahl_results::{ComparedNumber, VerdictKind, VerdictText, format_number};

pub use stosszahl_analysis::compare::{ComparisonVerdict as Test, VerdictRule};
pub use stosszahl_results::engine_title as title;

pub use claims::{ClaimedValue, claim};
pub use impact::{FEWEST_COLLISIONS, ImpactTest, ImpactWindows, impact_parameters, impact_windows};
pub use points::{
    MeasuredPoint, against_theory, bound, holds_zero, interval_of, profiles, verdict_within, worst,
};
pub use words::{
    DifferenceUnit, format_deviation, format_margin, format_quotient, in_units, with_error,
    with_interval,
};

pub mod claims;
mod impact;
mod points;
pub mod power;
mod words;

/// Creates a verdict of a given kind without a compared number.
pub fn verdict(
    topic: impl Into<String>,
    sentence: impl Into<String>,
    kind: VerdictKind,
) -> VerdictText {
    VerdictText {
        topic: topic.into(),
        sentence: sentence.into(),
        kind,
        number: None,
    }
}

/// Creates a note: an informative sentence without a comparison.
pub fn verdict_note(topic: impl Into<String>, sentence: impl Into<String>) -> VerdictText {
    verdict(topic, sentence, VerdictKind::Note)
}

/// Creates a warning: a sentence about a doubt in the results.
pub fn warning(topic: impl Into<String>, sentence: impl Into<String>) -> VerdictText {
    verdict(topic, sentence, VerdictKind::Warning)
}

/// Turns a verdict into a void one, with a sentence that begins with the reason.
pub fn void(found: VerdictText, reason: &str) -> VerdictText {
    VerdictText {
        sentence: format!("Void, for {reason}: {}", found.sentence),
        kind: VerdictKind::Void,
        ..found
    }
}

/// Creates the warning that theory cannot be computed, with the reason.
pub fn no_theory(topic: impl Into<String>, error: &dyn Display) -> VerdictText {
    warning(topic, format!("Theory cannot be computed: {error}."))
}

/// Converts the outcome of a comparison to the kind of a verdict; higher and lower both differ.
pub fn kind_of(found: Test) -> VerdictKind {
    match found {
        Test::Agree => VerdictKind::Agree,
        Test::Higher | Test::Lower => VerdictKind::Differ,
        Test::Undecided => VerdictKind::Undecided,
    }
}

/// Difference of two quantities at one time, or in one window or cell, with its interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Difference with its confidence interval, simultaneous with all other findings of the
    /// verdict.
    pub interval: Interval,
    /// Time, window or cell of the difference in words: "at t = 20", "in the last half of the run".
    pub place: String,
    /// Probability that the interval misses the true difference.
    pub level: f64,
}

impl Finding {
    fn most(&self) -> f64 {
        self.interval.most().unwrap_or(f64::INFINITY)
    }
}

/// Returns the index, out of `some`, of the finding whose interval is farthest from zero.
fn farthest(findings: &[Finding], some: &[usize]) -> Option<usize> {
    let size = |index: usize| findings[index].interval.least();
    some.iter()
        .copied()
        .max_by(|&i, &j| size(i).total_cmp(&size(j)))
}

/// Comparison of two engines, or of an engine with theory, in one quantity at one or more times or
/// windows.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'a> {
    /// Topic of the verdict, such as a measure.
    pub topic: &'a str,
    /// Title of the first engine, as it begins a sentence.
    pub a: &'a str,
    /// Title of the second engine, or name of a theory.
    pub b: &'a str,
    /// Name of the compared quantity in words, such as "energy".
    pub quantity: &'a str,
    /// Unit in which the verdict states the difference.
    pub unit: DifferenceUnit,
    /// Decision rule; its error probability is for all points of the comparison together.
    pub rule: VerdictRule,
}

/// Relative difference below which two series count as equal except for rounding.
const ROUNDING: f64 = 1e-6;

impl Comparison<'_> {
    /// Decides the verdict on findings in the order of time. The sentence states the last, unless
    /// only earlier ones differ; `all` names all of them in words. `None` without findings.
    pub fn judge(&self, findings: &[Finding], all: &str) -> Option<VerdictText> {
        let last = findings.len().checked_sub(1)?;
        let differ = self.differing(findings);
        let shown = match differ[..] {
            [.., end] if end < last => farthest(findings, &differ)?,
            _ => last,
        };
        let count = format!("{} of {}", differ.len(), findings.len());
        let since = match differ[..] {
            [first, ..] if last > 0 => match findings[first].place.strip_prefix("at t = ") {
                Some(time) if differ.len() == findings.len() - first => {
                    format!(" from t = {time} on")
                }
                Some(_) => format!(" at {count} times"),
                None => format!(" in {count} windows"),
            },
            _ => String::new(),
        };
        self.say(findings, &differ, shown, [&since, all])
    }

    /// Decides the verdict on findings without an order in time, such as cells. The sentence states
    /// the largest difference; `all` names all of them in words.
    pub fn at_places(&self, findings: &[Finding], all: &str) -> Option<VerdictText> {
        let differ = self.differing(findings);
        let every: Vec<usize> = (0..findings.len()).collect();
        let shown = match differ[..] {
            [] => every
                .into_iter()
                .rev()
                .max_by(|&i, &j| findings[i].most().total_cmp(&findings[j].most()))?,
            _ => farthest(findings, &differ)?,
        };
        let since = format!(" in {} of {} places", differ.len(), findings.len());
        self.say(findings, &differ, shown, [&since, all])
    }

    fn differing(&self, findings: &[Finding]) -> Vec<usize> {
        let differs = |&index: &usize| findings[index].interval.decide(&self.rule).differs();
        (0..findings.len()).filter(differs).collect()
    }

    fn say(
        &self,
        findings: &[Finding],
        differ: &[usize],
        shown: usize,
        [since, all]: [&str; 2],
    ) -> Option<VerdictText> {
        let Self {
            a,
            b,
            quantity,
            unit,
            rule,
            ..
        } = *self;
        let one = findings.get(shown)?;
        let most = findings.iter().map(Finding::most).fold(0.0, f64::max);
        let number = format!("{} {}", unit.interval(&one.interval), one.place);
        let all = if all.is_empty() {
            String::new()
        } else {
            format!(" {all}")
        };
        let within = unit.bound(rule.margin, true);
        let agree = |one: &Finding| one.interval.decide(&rule) == Test::Agree;
        let (sentence, kind) = if !differ.is_empty() {
            let least = unit.bound(one.interval.least(), false);
            let sentence =
                format!("{a} and {b} differ in {quantity}{since}: {number}, at least {least}.");
            (sentence, VerdictKind::Differ)
        } else if findings.iter().all(agree) {
            let sentence = if most < ROUNDING {
                let place = if all.is_empty() {
                    format!(" {}", one.place)
                } else {
                    all
                };
                format!("{a} and {b} have the same {quantity}{place}.")
            } else {
                let below = unit.bound(most, true);
                format!(
                    "{a} and {b} agree in {quantity} within {within}{all}: {number}, below {below}{}.",
                    if findings.len() > 1 {
                        " everywhere"
                    } else {
                        ""
                    }
                )
            };
            (sentence, VerdictKind::Agree)
        } else {
            let bound = match one.interval.ends {
                None => "; one replica has no error".to_owned(),
                Some(_) if most >= unit.largest() => "; no bound holds".to_owned(),
                Some(_) => format!(
                    ", below {}{}",
                    unit.bound(most, true),
                    if findings.len() > 1 {
                        " everywhere"
                    } else {
                        ""
                    }
                ),
            };
            let a = a
                .strip_prefix("The ")
                .map_or(a.to_owned(), |rest| format!("the {rest}"));
            let sentence = format!(
                "Whether {a} and {b} agree in {quantity} within {within} is undecided: {number}{bound}."
            );
            (sentence, VerdictKind::Undecided)
        };
        let chosen = &findings[findings.len() - 1];
        Some(VerdictText {
            number: Some(self.number(chosen)),
            ..verdict(self.topic, sentence, kind)
        })
    }

    /// Converts a finding to a compared number for tables and sweeps.
    fn number(&self, one: &Finding) -> ComparedNumber {
        ComparedNumber {
            quantity: self.quantity.to_owned(),
            place: one.place.clone(),
            relative: self.unit == DifferenceUnit::Relative,
            difference: one.interval.value,
            standard_error: one.interval.standard_error,
            degrees_of_freedom: one.interval.degrees_of_freedom.map(|count| count as u64),
            margin: self.rule.margin,
            differ_beyond: self.rule.differ_beyond,
            level: one.level,
        }
    }
}

/// Times, or a single time span, of the compared values.
#[derive(Clone, Copy, Debug)]
pub enum Places<'a> {
    /// Times of the values, in the unit of time of the case.
    Times(&'a [f64]),
    /// Single time span of the values in words, such as "in the last half of the run".
    Span(&'a str),
}

impl Places<'_> {
    fn place_at(self, index: usize) -> String {
        match self {
            Self::Times(times) => format!("at t = {}", format_number(times[index])),
            Self::Span(words) => words.to_owned(),
        }
    }
}

/// Comparison of two engines in one quantity, over paired replicas.
#[derive(Clone, Copy, Debug)]
pub struct ComparedPair<'a> {
    /// Engines, quantity and decision rule, with a relative margin.
    pub comparison: Comparison<'a>,
    /// Times, or a single time span, of the compared values.
    pub places: Places<'a>,
}

impl ComparedPair<'_> {
    /// Decides the verdict on paired values: `pairs` holds, for each time, the values (a, b) of all
    /// replicas. `None` without times.
    pub fn judge(&self, pairs: &[Vec<(f64, f64)>]) -> Option<VerdictText> {
        self.judge_quotients(&quotients(pairs, &self.comparison.rule))
    }

    /// Decides the verdict on quotients a/b of two engines that already have confidence intervals,
    /// one for each time.
    pub fn judge_quotients(&self, found: &[Quotient]) -> Option<VerdictText> {
        let level = self.comparison.rule.level;
        let level = if found.len() > 1 { 0.5 * level } else { level };
        let finding = |(index, one): (usize, &Quotient)| Finding {
            interval: one.off,
            place: self.places.place_at(index),
            level,
        };
        let findings: Vec<Finding> = found.iter().enumerate().map(finding).collect();
        let all = match self.places {
            Places::Times([.., last]) if found.len() > 1 => {
                format!("at all times to t = {}", format_number(*last))
            }
            _ => String::new(),
        };
        self.comparison.judge(&findings, &all)
    }
}

/// Combines several verdict kinds: differ if any differs, else undecided if any is undecided, else
/// agree.
pub fn together(kinds: impl IntoIterator<Item = VerdictKind>) -> VerdictKind {
    kinds
        .into_iter()
        .max_by_key(|&kind| rank(kind))
        .unwrap_or(VerdictKind::Note)
}

fn rank(kind: VerdictKind) -> u8 {
    match kind {
        VerdictKind::Differ => 2,
        VerdictKind::Agree => 0,
        _ => 1,
    }
}

/// Tests whether a quantity still changes at the end of the run, and returns a warning if so.
/// `pairs` holds two averages of each replica: over the third and over the last quarter. Their
/// logarithms are compared at the error probability `level`.
pub fn still_moving(
    topic: impl Into<String>,
    subject: &str,
    pairs: &[(f64, f64)],
    level: f64,
) -> Option<VerdictText> {
    let growth: Vec<f64> = pairs.iter().map(|(a, b)| (b / a).ln()).collect();
    let test = student_t_test(&growth, 0.0)?;
    let mean = growth.iter().sum::<f64>() / growth.len() as f64;
    (test.p_value < level).then(|| {
        let change = format_deviation(mean.exp_m1(), Some((mean / test.statistic).abs()));
        let sentence = format!(
            "{subject} is not steady: it changes by {change} from one quarter to the last."
        );
        warning(topic, sentence)
    })
}

/// Decides the verdict on a quantity that should be conserved. `worst` is its largest relative
/// change, and `limit` the largest change by rounding.
pub fn is_kept(topic: impl Into<String>, subject: &str, worst: f64, limit: f64) -> VerdictText {
    let (said, kind) = if worst <= limit {
        ("is kept", VerdictKind::Agree)
    } else {
        ("is not kept", VerdictKind::Differ)
    };
    let sentence =
        format!("{subject} {said}: it changes by {worst:.1e} of itself (limit {limit:.0e}).");
    verdict(topic, sentence, kind)
}

/// Creates the warning about starts that are not equilibrated; `bad` lists replicas with the tests
/// that failed. `None` if the list is empty.
pub fn start(bad: &[(u64, String)]) -> Option<VerdictText> {
    let (replica, why) = bad.first()?;
    let more = match bad.len() {
        1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    let sentence = format!(
        "The start is not equilibrated in replica {replica} ({why}){more}; early differences may be its memory."
    );
    Some(warning("start", sentence))
}

#[cfg(test)]
mod tests;
