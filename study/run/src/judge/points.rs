//! Verdicts on measured values against theory at several times or places, with Bonferroni-corrected
//! intervals.

use stosszahl_analysis::compare::{Interval, VerdictRule};
use stosszahl_results::{TableEstimate, VerdictKind, VerdictText, format_number};

use super::{Comparison, DifferenceUnit, Finding, kind_of, rank};

/// Measured value at one time, with its error and the theoretical value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredPoint {
    /// Time of the sample, in the unit of time of the case.
    pub time: f64,
    /// Measured value, in the unit of the quantity.
    pub measured: f64,
    /// Standard error of the measured value; `None` if it is unknown.
    pub error: Option<f64>,
    /// Number of replicas behind the standard error; `None` if the error is known otherwise.
    pub replicas: Option<usize>,
    /// Theoretical value, in the unit of the quantity.
    pub theory: f64,
    /// Estimated error of the theoretical value: its change by the last order of the expansion;
    /// `None` if unknown.
    pub theory_error: Option<f64>,
}

impl MeasuredPoint {
    /// Creates a measured point from an estimate with its theory; `None` unless both values are
    /// known.
    pub fn from_estimate(time: f64, found: &TableEstimate) -> Option<Self> {
        Some(Self {
            time,
            measured: found.value?,
            error: found.standard_error,
            replicas: found.replicas,
            theory: found.theory?,
            theory_error: found.theory_error,
        })
    }

    /// Returns the relative deviation of the measured value from theory.
    pub fn deviation(&self) -> f64 {
        self.measured / self.theory - 1.0
    }

    /// Returns the standard error of the measured value, combined in quadrature with the error of
    /// the theory.
    pub fn total_error(&self) -> Option<f64> {
        let error = self.error?;
        Some(error.hypot(self.theory_error.unwrap_or(0.0)))
    }

    /// Returns the deviation of the measured value from theory in standard errors; `None` without
    /// an error above zero.
    pub fn z(&self) -> Option<f64> {
        let total = self.total_error().filter(|&error| error > 0.0)?;
        Some((self.measured - self.theory) / total)
    }

    /// Computes the relative deviation from theory with its Student interval; `level` is the
    /// probability that it misses the truth.
    pub fn interval(&self, level: f64) -> Interval {
        let error = self.total_error().map(|error| error / self.theory.abs());
        let freedom = self.replicas.map(|replicas| replicas.saturating_sub(1));
        Interval::student(self.deviation(), error, freedom, level)
    }

    /// Decides the verdict kind of this point alone.
    pub fn outcome(&self, rule: &VerdictRule) -> VerdictKind {
        kind_of(self.interval(rule.level).decide(rule))
    }
}

/// Returns the points that can be compared (theory not zero, values finite), and the decision rule
/// for a single one: the error probability divided by their number (Bonferroni).
fn comparable_points<'a>(
    points: &'a [MeasuredPoint],
    rule: &VerdictRule,
) -> (Vec<&'a MeasuredPoint>, VerdictRule) {
    let some = points.iter();
    let some: Vec<&MeasuredPoint> = some
        .filter(|point| point.theory != 0.0 && point.deviation().is_finite())
        .collect();
    let each = rule.at_level(rule.level / some.len().max(1) as f64);
    (some, each)
}

/// Returns the point that decides the verdict on all points, with its interval and outcome. A point
/// that differs comes before an undecided one, and an undecided one before one that agrees; among
/// equals the largest bound decides.
pub fn worst<'a>(
    points: &'a [MeasuredPoint],
    rule: &VerdictRule,
) -> Option<(&'a MeasuredPoint, Interval, VerdictKind)> {
    let (some, each) = comparable_points(points, rule);
    let judged = some.into_iter().map(|point| {
        let interval = point.interval(each.level);
        let kind = kind_of(interval.decide(&each));
        (point, interval, kind)
    });
    judged.max_by(|a, b| {
        let size = |one: &(&MeasuredPoint, Interval, VerdictKind)| bound(&one.1, one.2);
        rank(a.2).cmp(&rank(b.2)).then(size(a).total_cmp(&size(b)))
    })
}

/// Returns the bound by which points are ranked: the lower bound on the magnitude of a difference
/// that was found, else the upper bound.
pub fn bound(interval: &Interval, kind: VerdictKind) -> f64 {
    match kind {
        VerdictKind::Differ => interval.least(),
        _ => interval.most().unwrap_or(f64::INFINITY),
    }
}

/// Decides the verdict on measured points against a theory. `subject` names the engine, such as "ED
/// (exact)", and `quantity` the measured quantity.
pub fn against_theory(
    topic: &str,
    [subject, theory, quantity]: [&str; 3],
    points: &[MeasuredPoint],
    rule: &VerdictRule,
) -> Option<VerdictText> {
    let (some, each) = comparable_points(points, rule);
    let finding = |point: &&MeasuredPoint| Finding {
        interval: point.interval(each.level),
        place: format!("at t = {}", format_number(point.time)),
        level: each.level,
    };
    let findings: Vec<Finding> = some.iter().map(finding).collect();
    let all = match some.last() {
        Some(last) if some.len() > 1 => format!("at all times to t = {}", format_number(last.time)),
        _ => String::new(),
    };
    let comparison = Comparison {
        topic,
        a: subject,
        b: theory,
        quantity,
        unit: DifferenceUnit::Relative,
        rule: *rule,
    };
    comparison.judge(&findings, &all)
}

/// Decides the verdict kind of a relative deviation with its standard error.
pub fn verdict_within(off: &TableEstimate, rule: &VerdictRule) -> VerdictKind {
    kind_of(interval_of(off, rule.level).decide(rule))
}

/// Computes Student's confidence interval of an estimated difference that should be zero.
pub fn interval_of(off: &TableEstimate, level: f64) -> Interval {
    let freedom = off.replicas.map(|replicas| replicas.saturating_sub(1));
    let value = off.value.unwrap_or(f64::NAN);
    Interval::student(value, off.standard_error, freedom, level)
}

/// Returns true if the confidence interval of a number contains zero; `None` without an error. As
/// this is no equivalence test, it is used for remarks only.
pub fn holds_zero(found: &TableEstimate, level: f64) -> Option<bool> {
    let [low, high] = interval_of(found, level).ends?;
    Some(low <= 0.0 && high >= 0.0)
}

/// Decides the verdict on the relative difference of two profiles, over all points together by
/// Bonferroni. `places` holds the values of both profiles at each point, and the position in words.
/// Errors come from `parts` blocks of time; points without errors are left out, and `None` is
/// returned without points.
pub fn profiles(
    topic: &str,
    [a, b, quantity]: [&str; 3],
    places: &[([TableEstimate; 2], String)],
    parts: usize,
    rule: &VerdictRule,
) -> Option<VerdictText> {
    let differences = places.iter().filter_map(|([a, b], at)| {
        let [x, y] = [a.value?, b.value?];
        let off = x / y - 1.0;
        let error = (a.standard_error? / x).hypot(b.standard_error? / y) * (x / y).abs();
        (error > 0.0 && off.is_finite()).then_some((off, error, at))
    });
    let all: Vec<_> = differences.collect();
    let level = rule.level / all.len().max(1) as f64;
    let freedom = Some(parts.saturating_sub(1));
    let finding = |&(off, error, at): &(f64, f64, &String)| Finding {
        interval: Interval::student(off, Some(error), freedom, level),
        place: format!("at {at}"),
        level,
    };
    let findings: Vec<Finding> = all.iter().map(finding).collect();
    let comparison = Comparison {
        topic,
        a,
        b,
        quantity,
        unit: DifferenceUnit::Relative,
        rule: *rule,
    };
    let everywhere = format!("in all of {} places", findings.len());
    comparison.at_places(&findings, &everywhere)
}
