//! The one judge: all tests that end in a verdict, and all of its words.
//!
//! Each sentence is short and names its margin. Nothing is called agreement whose error is unknown, and what is compared with
//! nothing is a [`VerdictKind::Note`]. The tests:
//!
//! - *two series over paired replicas*, or one against theory: Student's t of log(a/b) at each time, the chance of any
//!   false alarm kept over all times ([`quotients`]). The margin of agreement is the largest difference that any time
//!   leaves possible: size of log(a/b) and half the width of its confidence interval;
//! - *points with errors against theory within a tolerance* ([`Point`]);
//! - *histograms against a uniform density*: chi-squared, all windows together by Holm ([`ImpactTest`]);
//! - *numbers that are kept or zero*, within rounding or within three standard errors.

use std::fmt::Display;

use stosszahl_analysis::compare::{Quotient, Verdict as Test, quotients};
use stosszahl_analysis::statistics::{ChiSquaredTest, holm, student_t_test};
use stosszahl_results::{Estimate, Verdict, VerdictKind};

pub use stosszahl_results::engine_title as title;

pub use crate::words::short;

/// What stands for a number that is none, or infinite.
const UNKNOWN: &str = "unknown";
/// From here on numbers are shown with an exponent.
const LARGE: f64 = 1e6;

/// Standard errors from which a deviation is no chance.
pub const SIGNIFICANT: f64 = 3.0;

/// A verdict.
pub fn verdict(
    topic: impl Into<String>,
    sentence: impl Into<String>,
    kind: VerdictKind,
) -> Verdict {
    Verdict {
        topic: topic.into(),
        sentence: sentence.into(),
        kind,
    }
}

/// A number for information.
pub fn note(topic: impl Into<String>, sentence: impl Into<String>) -> Verdict {
    verdict(topic, sentence, VerdictKind::Note)
}

/// What must be read with care.
pub fn warning(topic: impl Into<String>, sentence: impl Into<String>) -> Verdict {
    verdict(topic, sentence, VerdictKind::Warning)
}

/// Theory that cannot be computed.
pub fn no_theory(topic: impl Into<String>, error: &dyn Display) -> Verdict {
    warning(topic, format!("Theory cannot be computed: {error}."))
}

/// Digits after the point with which an error shows two of its own.
fn decimals(error: f64) -> usize {
    if error > 0.0 && error.is_finite() {
        (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize
    } else {
        4
    }
}

/// A number with its error, in the digits that the error leaves.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error.filter(|error| error.is_finite()) {
        _ if !value.is_finite() => UNKNOWN.to_owned(),
        Some(error) if value.abs().max(error) >= LARGE => {
            format!("{} ± {}", short(value), short(error))
        }
        Some(error) => {
            let digits = decimals(error);
            format!("{value:.digits$} ± {error:.digits$}")
        }
        None => format!("{} (error unknown)", short(value)),
    }
}

/// The same of an estimate, over a unit.
pub fn in_units(found: &Estimate, unit: f64) -> String {
    let error = found.standard_error.map(|error| (error / unit).abs());
    with_error(found.value.unwrap_or(f64::NAN) / unit, error)
}

/// A quotient with its error.
pub fn quotient(a: &Estimate, b: &Estimate) -> String {
    let [x, y] = [a, b].map(|one| one.value.unwrap_or(f64::NAN));
    let errors = a.standard_error.zip(b.standard_error);
    let error = errors.map(|(a, b)| (x / y).abs() * (a / x).hypot(b / y));
    with_error(x / y, error)
}

/// A relative deviation in per cent, with its error.
pub fn percent(deviation: f64, error: Option<f64>) -> String {
    let deviation = 100.0 * deviation;
    match error.map(|error| 100.0 * error) {
        _ if !deviation.is_finite() => UNKNOWN.to_owned(),
        Some(error) if error.is_finite() && deviation.abs().max(error) >= LARGE => {
            format!("{deviation:+.1e} ± {error:.1e} %")
        }
        Some(error) if error.is_finite() => {
            let digits = decimals(error).saturating_sub(1);
            format!("{deviation:+.digits$} ± {error:.digits$} %")
        }
        _ if deviation.abs() >= LARGE => format!("{deviation:+.1e} % (error unknown)"),
        _ => format!("{deviation:+.2} % (error unknown)"),
    }
}

/// A margin in per cent, rounded up.
fn margin(share: f64) -> String {
    let percent = 100.0 * share;
    let scale = 10_f64.powf((1.0 - percent.log10().floor()).clamp(0.0, 6.0));
    format!("{} %", short((percent * scale - 1e-9).ceil() / scale))
}

/// Where values are compared.
#[derive(Clone, Copy, Debug)]
pub enum Places<'a> {
    /// At times.
    Times(&'a [f64]),
    /// Once, over a span that the words name, such as "in the last half of the run".
    Span(&'a str),
}

impl Places<'_> {
    fn at(self, index: usize) -> String {
        match self {
            Self::Times(times) => format!("at t = {}", short(times[index])),
            Self::Span(words) => words.to_owned(),
        }
    }

    fn all(self) -> String {
        match self {
            Self::Times(times) => {
                let last = times.last().copied().unwrap_or(0.0);
                format!("at all times to t = {}", short(last))
            }
            Self::Span(words) => words.to_owned(),
        }
    }
}

/// Two things that are compared in one quantity.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// What it is about.
    pub topic: &'a str,
    /// The first, at the beginning of a sentence: an engine's title.
    pub a: &'a str,
    /// The second: an engine's title or the name of a theory.
    pub b: &'a str,
    /// The quantity: "energy".
    pub quantity: &'a str,
    /// Where.
    pub places: Places<'a>,
    /// Chance of any false alarm.
    pub false_alarm: f64,
}

impl Pair<'_> {
    /// Tests the values of the replicas, `pairs[place]` of (a, b), and says what follows; none without places.
    pub fn judge(&self, pairs: &[Vec<(f64, f64)>]) -> Option<Verdict> {
        self.of(&quotients(pairs, self.false_alarm))
    }

    /// The verdict on quotients that are tested already.
    pub fn of(&self, found: &[Quotient]) -> Option<Verdict> {
        let Self { a, b, quantity, .. } = *self;
        let last = found.len().checked_sub(1)?;
        let off = |index: usize| {
            let Quotient { quotient, .. } = found[index];
            percent(quotient.value - 1.0, quotient.standard_error)
        };
        let differs = |one: &Quotient| matches!(one.verdict, Test::Higher | Test::Lower);
        let size = |one: &Quotient| one.quotient.value.ln().abs();
        let different: Vec<usize> = (0..found.len())
            .filter(|&index| differs(&found[index]))
            .collect();
        let (sentence, kind) = if let [first, ..] = different[..] {
            let largest = different
                .iter()
                .copied()
                .max_by(|&i, &j| size(&found[i]).total_cmp(&size(&found[j])))?;
            let since = if found.len() == 1 {
                String::new()
            } else if different.len() == found.len() - first {
                format!(" from t = {} on", self.time(first))
            } else {
                format!(" at {} of {} times", different.len(), found.len())
            };
            let most = if found.len() == 1 { "" } else { ", most" };
            let (at, off) = (self.places.at(largest), off(largest));
            let sentence = format!("{a} and {b} differ in {quantity}{since}{most} by {off} {at}.");
            (sentence, VerdictKind::Differ)
        } else if found.iter().all(|one| one.verdict == Test::Agree) {
            let reach = found
                .iter()
                .map(|one| size(one) + one.half_width.unwrap_or(0.0));
            let reach = reach.fold(0.0, f64::max).exp_m1();
            let all = self.places.all();
            if reach < 1e-6 {
                let sentence = format!("{a} and {b} have the same {quantity} {all}.");
                (sentence, VerdictKind::Agree)
            } else {
                let within = margin(reach);
                let sentence = format!("{a} and {b} agree in {quantity} within {within} {all}.");
                (sentence, VerdictKind::Agree)
            }
        } else {
            let open = found.iter().filter(|one| one.verdict == Test::Undecided);
            let widest = open.filter_map(|one| one.half_width).reduce(f64::max);
            let (at, off) = (self.places.at(last), off(last));
            let why = match widest {
                Some(_) => "its error is too wide to tell",
                None => "one replica has no error",
            };
            let sentence =
                format!("Whether {a} and {b} differ in {quantity} is open, {why}: {off} {at}.");
            (sentence, VerdictKind::Undecided)
        };
        Some(verdict(self.topic, sentence, kind))
    }

    fn time(&self, index: usize) -> String {
        match self.places {
            Places::Times(times) => short(times[index]),
            Places::Span(_) => String::new(),
        }
    }
}

/// A measured value at one time and what theory says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// When.
    pub time: f64,
    /// The value.
    pub measured: f64,
    /// Its standard error.
    pub error: Option<f64>,
    /// What theory says.
    pub theory: f64,
    /// Change of the theory from one order less.
    pub theory_error: Option<f64>,
}

impl Point {
    /// An estimate with its theory; none unless both are known.
    pub fn of(time: f64, found: &Estimate) -> Option<Self> {
        Some(Self {
            time,
            measured: found.value?,
            error: found.standard_error,
            theory: found.theory?,
            theory_error: found.theory_error,
        })
    }

    /// Relative deviation from theory.
    pub fn deviation(&self) -> f64 {
        self.measured / self.theory - 1.0
    }

    /// Deviation in standard errors, to which what is unknown of the theory adds up.
    pub fn z(&self) -> Option<f64> {
        let error = self.error.filter(|&error| error > 0.0)?;
        let total = error.hypot(self.theory_error.unwrap_or(0.0));
        Some((self.measured - self.theory) / total)
    }

    /// A deviation is a difference if it is larger than the tolerance and than three standard errors; it is agreement if it is
    /// within the tolerance, and its error is too.
    pub fn outcome(&self, tolerance: f64) -> VerdictKind {
        let Some(error) = self.error else {
            return VerdictKind::Undecided;
        };
        let far = self.deviation().abs() > tolerance;
        let significant = self.z().is_none_or(|z| z.abs() > SIGNIFICANT);
        let narrow = error.max(self.theory_error.unwrap_or(0.0)) <= tolerance * self.theory.abs();
        match (far, significant, narrow) {
            (true, true, _) => VerdictKind::Differ,
            (false, _, true) => VerdictKind::Agree,
            _ => VerdictKind::Undecided,
        }
    }
}

/// The point that decides what all say: differences before doubts before agreement, the largest deviation of those.
pub fn worst(points: &[Point], tolerance: f64) -> Option<&Point> {
    let usable = points
        .iter()
        .filter(|point| point.theory != 0.0 && point.deviation().is_finite());
    usable.max_by(|a, b| {
        let size = |point: &Point| point.deviation().abs();
        let ranks = [a, b].map(|point| rank(point.outcome(tolerance)));
        ranks[0].cmp(&ranks[1]).then(size(a).total_cmp(&size(b)))
    })
}

/// What a relative deviation says of a margin.
pub fn within(off: f64, error: Option<f64>, margin: f64) -> VerdictKind {
    let found = Estimate::of(1.0 + off, error).against(Some(1.0));
    let point = Point::of(0.0, &found).filter(|_| off.is_finite());
    point.map_or(VerdictKind::Undecided, |point| point.outcome(margin))
}

/// What several comparisons say together: differences before doubts before agreement.
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

/// Fewest blocks of all replicas from which errors are known well enough for a normal test.
const FEWEST_PARTS: usize = 10;

/// What a test says whose errors come from some blocks of time, and a remark where they are too few.
pub fn by_parts(holds: bool, parts: usize) -> (VerdictKind, String) {
    match holds {
        _ if parts < FEWEST_PARTS => {
            let few = format!(
                "; errors come from {parts} blocks only, {FEWEST_PARTS} are needed to tell"
            );
            (VerdictKind::Undecided, few)
        }
        true => (VerdictKind::Agree, String::new()),
        false => (VerdictKind::Differ, String::new()),
    }
}

/// The verdict on points against a theory within a tolerance, stated at the worst of them; `subject` begins the sentence:
/// "The temperature of species 2".
pub fn against_theory(
    topic: impl Into<String>,
    subject: &str,
    theory: &str,
    points: &[Point],
    tolerance: f64,
) -> Option<Verdict> {
    let point = worst(points, tolerance)?;
    let kind = point.outcome(tolerance);
    let error = point.error.map(|error| error / point.theory.abs());
    let (off, time) = (percent(point.deviation(), error), short(point.time));
    let within = margin(tolerance);
    let sentence = match kind {
        VerdictKind::Agree => {
            format!(
                "{subject} agrees with {theory} within {within}; most off by {off} at t = {time}."
            )
        }
        VerdictKind::Differ => {
            format!("{subject} differs from {theory} by {off} at t = {time}, beyond {within}.")
        }
        _ => format!(
            "Whether {subject} differs from {theory} by {within} is open: {off} at t = {time}."
        ),
    };
    Some(verdict(topic, sentence, kind))
}

/// The test of one histogram of impact parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactTest {
    /// Start and end of the window.
    pub window: [f64; 2],
    /// Collisions.
    pub collisions: u64,
    /// Slope of the density, zero under chaos, and its standard error.
    pub slope: Option<(f64, Option<f64>)>,
    /// Chi-squared against chaos; none with too few collisions.
    pub test: Option<ChiSquaredTest>,
}

/// Largest standard error of a slope with which it is called uniform: a slope of 2 % moves the outer of 20 bins by 1 %.
const SEEN: f64 = 0.02;

/// The words of the table for all windows of one engine: `uniform`, `grazing excess`, `central excess`, `undecided` or `too
/// few collisions`.
pub fn impact_words(tests: &[ImpactTest], false_alarm: f64) -> Vec<&'static str> {
    let p_values: Vec<f64> = tests
        .iter()
        .map(|one| one.test.map_or(f64::NAN, |test| test.p_value))
        .collect();
    let judged = tests.iter().zip(holm(&p_values, false_alarm));
    judged
        .map(|(one, rejected)| {
            let (slope, error) = one.slope.unwrap_or((0.0, None));
            // Few replicas may lie close together by chance, so the spread of the collisions counts too.
            let counting = (12.0 / one.collisions.max(1) as f64).sqrt();
            let seen = error.is_some_and(|error| error.max(counting) < SEEN);
            match (one.test, rejected) {
                (None, _) => "too few collisions",
                (_, true) if slope > 0.0 => "grazing excess",
                (_, true) => "central excess",
                (_, false) if seen => "uniform",
                (_, false) => "undecided",
            }
        })
        .collect()
}

/// The verdict on the impact parameters of one engine, by the words of [`impact_words`].
pub fn impact_parameters(
    topic: impl Into<String>,
    engine: &str,
    tests: &[ImpactTest],
    words: &[&str],
) -> Verdict {
    let slope = |one: &ImpactTest| one.slope.map_or(0.0, |(slope, _)| slope);
    let largest = |filter: &dyn Fn(&str) -> bool| {
        let some = tests.iter().zip(words).filter(|(_, word)| filter(word));
        some.max_by(|a, b| slope(a.0).abs().total_cmp(&slope(b.0).abs()))
    };
    let span = |one: &ImpactTest| {
        let [start, end] = one.window.map(short);
        format!("from t = {start} to {end}")
    };
    if let Some((one, word)) = largest(&|word| word.ends_with("excess")) {
        let (value, error) = one.slope.unwrap_or((f64::NAN, None));
        let (value, span) = (with_error(value, error), span(one));
        let sentence = format!(
            "The impact parameters of {engine} are not uniform: {word}, slope {value} {span}."
        );
        return verdict(topic, sentence, VerdictKind::Differ);
    }
    if !words.is_empty() && words.iter().all(|&word| word == "uniform") {
        let reach = tests.iter().filter_map(|one| {
            let (slope, error) = one.slope?;
            Some(slope.abs() + SIGNIFICANT * error?)
        });
        let reach = reach.fold(0.0, f64::max);
        let windows = if tests.len() == 1 {
            format!("to t = {}", short(tests[0].window[1]))
        } else {
            format!("in all {} windows", tests.len())
        };
        let sentence = format!(
            "The impact parameters of {engine} are uniform {windows}: the slope of their density is below {reach:.3}."
        );
        return verdict(topic, sentence, VerdictKind::Agree);
    }
    let sentence = match largest(&|word| word != "uniform") {
        Some((one, _)) if one.collisions > 0 => format!(
            "Whether the impact parameters of {engine} are uniform is open: {} collisions are too few {}.",
            one.collisions,
            span(one)
        ),
        _ => format!("{engine} has no collisions whose impact parameters could be tested."),
    };
    verdict(topic, sentence, VerdictKind::Undecided)
}

/// Whether the last of two averages of each replica, (before, last), is still moving; a warning or nothing.
pub fn still_moving(
    topic: impl Into<String>,
    subject: &str,
    pairs: &[(f64, f64)],
    false_alarm: f64,
) -> Option<Verdict> {
    let growth: Vec<f64> = pairs.iter().map(|(a, b)| (b / a).ln()).collect();
    let test = student_t_test(&growth, 0.0)?;
    let mean = growth.iter().sum::<f64>() / growth.len() as f64;
    (test.p_value < false_alarm).then(|| {
        let change = percent(mean.exp_m1(), Some((mean / test.statistic).abs()));
        let sentence = format!(
            "{subject} is not steady: it changes by {change} from one quarter to the last."
        );
        warning(topic, sentence)
    })
}

/// Whether a quantity is kept: `worst` is its largest relative change.
pub fn kept(topic: impl Into<String>, subject: &str, worst: f64, limit: f64) -> Verdict {
    let (said, kind) = if worst <= limit {
        ("is kept", VerdictKind::Agree)
    } else {
        ("is not kept", VerdictKind::Differ)
    };
    let sentence =
        format!("{subject} {said}: it changes by {worst:.1e} of itself (limit {limit:.0e}).");
    verdict(topic, sentence, kind)
}

/// Whether a number is zero within three standard errors.
pub fn zero(value: f64, error: Option<f64>) -> VerdictKind {
    match error {
        None => VerdictKind::Undecided,
        Some(error) if value.abs() <= SIGNIFICANT * error => VerdictKind::Agree,
        Some(_) => VerdictKind::Differ,
    }
}

/// Whether two profiles differ: the largest difference in standard errors against the largest of as many normal numbers, at
/// a chance `false_alarm`. `places` are both values and where they are, in words; those without errors are left out, and there
/// is no verdict where all are. Errors come from `parts` blocks of time.
pub fn profiles(
    topic: impl Into<String>,
    pair: [&str; 2],
    places: &[([Estimate; 2], String)],
    parts: usize,
    false_alarm: f64,
) -> Option<Verdict> {
    let differences = places.iter().filter_map(|([a, b], at)| {
        let error = a.standard_error?.hypot(b.standard_error?);
        let values = [a.value?, b.value?];
        (error > 0.0).then_some(((values[0] - values[1]) / error, values, at))
    });
    let all: Vec<_> = differences.collect();
    let (z, values, at) = all
        .iter()
        .rev()
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let limit = (2.0 * (all.len() as f64 / false_alarm).ln()).sqrt();
    let (kind, few) = by_parts(z.abs() <= limit, parts);
    let ([a, b], [x, y]) = (pair, values.map(short));
    let sentence = format!(
        "{a} and {b} are at most {z:+.1} standard errors apart in {} places (limit {limit:.1}{few}): {x} against {y} at {at}.",
        all.len(),
    );
    Some(verdict(topic, sentence, kind))
}

/// A start that is not equilibrated: replicas with the tests that failed.
pub fn start(bad: &[(u64, String)]) -> Option<Verdict> {
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
