//! The one judge: all tests that end in a verdict, and all of its words.
//!
//! Each sentence is short and names its margin: within what two things are equal, by how much they differ, or below what a
//! difference stays possible. Nothing is called agreement whose error is unknown, and what is compared with nothing is a
//! [`VerdictKind::Note`].
//!
//! Errors come from few replicas, so all intervals are Student's. The chance of any false alarm in all verdicts of a case, and in
//! all points of a sweep, is `verdict.false_alarm`; each verdict has an equal share of it, by Bonferroni
//! ([`Runs::level`](crate::measure::Runs::level)). Within one verdict:
//!
//! - *two series over paired replicas*, or one against theory: Student's t of the logarithm of the quotient of means at each time,
//!   all times together ([`quotients`]). The margin of agreement is the largest difference that any time leaves possible;
//! - *points with errors against theory within a tolerance* ([`Point`]): Student's t, all points together by Bonferroni;
//! - *impact parameters against chaos*: the trend over replicas, then their shape, all windows together by Holm ([`ImpactTest`]);
//! - *numbers that are kept or zero*, within rounding or within Student's interval;
//! - *what a paper says of a number* ([`claims`]).

use std::fmt::Display;

use stosszahl_analysis::compare::{Quotient, Verdict as Test, quotients};
use stosszahl_analysis::replicas::{HotellingTest, hotelling_test, quantile, shape};
use stosszahl_analysis::statistics::{Estimate as Mean, TTest, holm, student_t_test};
use stosszahl_analysis::windows::{Window, pooled};
use stosszahl_results::{Estimate, Verdict, VerdictKind, with_decimals};

pub use stosszahl_results::engine_title as title;

pub use crate::words::short;
pub use claims::{Said, claim, digits};

pub mod claims;

/// What stands for a number that is none, or infinite.
const UNKNOWN: &str = "unknown";
/// From here on numbers are shown with an exponent.
const LARGE: f64 = 1e6;

/// Chance outside the interval of an agreement.
const OUTSIDE: f64 = 0.05;

/// Half the width of an interval of an estimate that the truth leaves with a chance `level`; none without an error. An estimate over
/// replicas has Student's, one whose error is known otherwise a normal one.
fn half_width(found: &Estimate, level: f64) -> Option<f64> {
    let freedom = found.replicas.map(|replicas| replicas.saturating_sub(1));
    Some(quantile(level, freedom) * found.standard_error?)
}

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

/// A comparison with what does not stand for molecular chaos, and why.
pub fn void(found: Verdict, reason: &str) -> Verdict {
    Verdict {
        sentence: format!("{} Void: {reason}.", found.sentence),
        kind: VerdictKind::Void,
        ..found
    }
}

/// Theory that cannot be computed.
pub fn no_theory(topic: impl Into<String>, error: &dyn Display) -> Verdict {
    warning(topic, format!("Theory cannot be computed: {error}."))
}

/// Digits after the point with which an error shows two of its own. An error below a millionth of the value is none: replicas
/// that are all alike differ by rounding.
fn decimals(value: f64, error: f64) -> usize {
    if error > 1e-6 * value.abs() && error.is_finite() {
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
        Some(error) => with_decimals(value, error, decimals(value, error)),
        None => format!("{} (error unknown)", short(value)),
    }
}

/// The same of an estimate, over a unit.
pub fn in_units(found: &Estimate, unit: f64) -> String {
    let error = found.standard_error.map(|error| (error / unit).abs());
    with_error(found.value.unwrap_or(f64::NAN) / unit, error)
}

/// A number over a unit with half its interval of 95 %, Student's where its error comes from few parts of the runs.
pub fn with_interval(found: &Estimate, unit: f64) -> String {
    let half = half_width(found, OUTSIDE).map(|half| (half / unit).abs());
    with_error(found.value.unwrap_or(f64::NAN) / unit, half)
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
            let digits = decimals(deviation, error).saturating_sub(1);
            format!("{deviation:+.digits$} ± {error:.digits$} %")
        }
        _ if deviation.abs() >= LARGE => format!("{deviation:+.1e} % (error unknown)"),
        _ => format!("{deviation:+.2} % (error unknown)"),
    }
}

/// A margin in per cent, rounded up.
pub fn margin(share: f64) -> String {
    let percent = 100.0 * share;
    if percent.is_nan() || percent >= LARGE {
        return UNKNOWN.to_owned();
    }
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
    /// Chance of a false alarm, all times together.
    pub level: f64,
}

impl Pair<'_> {
    /// Tests the values of the replicas, `pairs[place]` of (a, b), and says what follows; none without places.
    pub fn judge(&self, pairs: &[Vec<(f64, f64)>]) -> Option<Verdict> {
        self.of(&quotients(pairs, self.level))
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
            let open = (0..found.len()).filter(|&index| found[index].verdict == Test::Undecided);
            let reach = |index: usize| Some(size(&found[index]) + found[index].half_width?);
            let widest = open.filter_map(|index| Some((reach(index)?, index)));
            let widest = widest.max_by(|x, y| x.0.total_cmp(&y.0));
            let sentence = match widest {
                // An interval that reaches to twice the value, or to none of it, says nothing.
                Some((reach, index)) if reach > 2_f64.ln() => format!(
                    "{a} and {b} cannot be told apart in {quantity}: {} replicas are too few for any bound {}; {} {}.",
                    found[index].quotient.replicas,
                    self.places.at(index),
                    off(last),
                    self.places.at(last)
                ),
                Some((reach, index)) => format!(
                    "{a} and {b} cannot be told apart in {quantity}: < {} with {} replicas {}; {} {}.",
                    margin(reach.exp_m1()),
                    found[index].quotient.replicas,
                    self.places.at(index),
                    off(last),
                    self.places.at(last)
                ),
                None => format!(
                    "Whether {a} and {b} differ in {quantity} is open, one replica has no error: {} {}.",
                    off(last),
                    self.places.at(last)
                ),
            };
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
    /// Replicas that the error is from; none if it is known otherwise.
    pub replicas: Option<usize>,
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
            replicas: found.replicas,
            theory: found.theory?,
            theory_error: found.theory_error,
        })
    }

    /// Relative deviation from theory.
    pub fn deviation(&self) -> f64 {
        self.measured / self.theory - 1.0
    }

    /// Its error, to which what is unknown of the theory adds up.
    pub fn total_error(&self) -> Option<f64> {
        let error = self.error?;
        Some(error.hypot(self.theory_error.unwrap_or(0.0)))
    }

    /// Deviation in standard errors.
    pub fn z(&self) -> Option<f64> {
        let total = self.total_error().filter(|&error| error > 0.0)?;
        Some((self.measured - self.theory) / total)
    }

    /// The largest relative deviation that an interval at `level` leaves possible.
    pub fn reach(&self, level: f64) -> Option<f64> {
        let total = Estimate {
            replicas: self.replicas,
            ..Estimate::of(self.measured, self.total_error())
        };
        Some(self.deviation().abs() + half_width(&total, level)? / self.theory.abs())
    }

    /// A deviation is a difference if it is larger than the tolerance and than the interval at `level`; it is agreement if
    /// it is within the tolerance, and half its interval of 95 % is too.
    pub fn outcome(&self, tolerance: f64, level: f64) -> VerdictKind {
        let (Some(reach), Some(usual)) = (self.reach(level), self.reach(OUTSIDE)) else {
            return VerdictKind::Undecided;
        };
        let size = self.deviation().abs();
        let far = size > tolerance;
        match (far, reach - size < size, usual - size <= tolerance) {
            (true, true, _) => VerdictKind::Differ,
            (false, _, true) => VerdictKind::Agree,
            _ => VerdictKind::Undecided,
        }
    }
}

/// The point that decides what all say, with its outcome: differences before doubts before agreement, the largest deviation of those.
/// All points together ring with a chance `level`, by Bonferroni.
pub fn worst(points: &[Point], tolerance: f64, level: f64) -> Option<(&Point, VerdictKind)> {
    let usable = points
        .iter()
        .filter(|point| point.theory != 0.0 && point.deviation().is_finite());
    let each = level / usable.clone().count().max(1) as f64;
    let judged = usable.map(|point| (point, point.outcome(tolerance, each)));
    judged.max_by(|a, b| {
        let size = |point: &Point| point.deviation().abs();
        rank(a.1)
            .cmp(&rank(b.1))
            .then(size(a.0).total_cmp(&size(b.0)))
    })
}

/// What a relative deviation with its error says of a margin.
pub fn within(off: &Estimate, margin: f64, level: f64) -> VerdictKind {
    let found = Estimate {
        value: off.value.map(|off| 1.0 + off),
        theory: Some(1.0),
        ..*off
    };
    let point = Point::of(0.0, &found).filter(|point| point.measured.is_finite());
    point.map_or(VerdictKind::Undecided, |point| point.outcome(margin, level))
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
    level: f64,
) -> Option<Verdict> {
    let (point, kind) = worst(points, tolerance, level)?;
    let error = point.error.map(|error| error / point.theory.abs());
    let (off, time) = (percent(point.deviation(), error), short(point.time));
    let sentence = match (kind, point.reach(OUTSIDE)) {
        (VerdictKind::Agree, Some(reach)) => {
            let within = margin(reach);
            format!(
                "{subject} agrees with {theory} within {within}; most off by {off} at t = {time}."
            )
        }
        (VerdictKind::Differ, _) => {
            let beyond = margin(tolerance);
            format!("{subject} differs from {theory} by {off} at t = {time}, beyond {beyond}.")
        }
        (_, Some(reach)) => {
            let (below, over) = (margin(reach), over(point.replicas));
            format!(
                "{subject} cannot be told from {theory}: < {below}{over} at t = {time}, where it is off by {off}."
            )
        }
        (_, None) => {
            format!("Whether {subject} differs from {theory} is open: {off} at t = {time}.")
        }
    };
    Some(verdict(topic, sentence, kind))
}

/// " with 4 replicas", where errors come from them.
fn over(replicas: Option<usize>) -> String {
    replicas.map_or(String::new(), |replicas| {
        format!(" with {replicas} replicas")
    })
}

/// The tests of one histogram of impact parameters against chaos. Replicas are independent, collisions within one are not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactTest {
    /// Start and end of the window.
    pub window: [f64; 2],
    /// Collisions of all replicas.
    pub collisions: u64,
    /// Collisions of the replica with the fewest.
    pub fewest: u64,
    /// Slope of the density, zero under chaos, of all collisions; its error is of the jackknife over replicas.
    pub slope: Estimate,
    /// Student's test of the slope; none with one replica.
    pub trend: Option<TTest>,
    /// Hotelling's test of as many further shapes as the replicas allow.
    pub shape: Option<HotellingTest>,
}

/// Most shapes beyond the trend that are tested at once: a contact value or a cluster bends the density, it does not ripple it.
const SHAPES: usize = 4;

impl ImpactTest {
    /// Tests one window of all replicas.
    pub fn of(span: [f64; 2], all: &[&Window]) -> Self {
        let values = pooled(all, Window::slope);
        let slope = Mean::over_replicas(&values);
        // Half as many as replicas leaves each a spread that is known; one at least, which is Student's test of the curvature.
        let orders = (values.len().saturating_sub(1) / 2).clamp(1, SHAPES);
        let some = all.iter().filter(|window| window.collisions > 0);
        let shapes = some.map(|window| {
            let found = shape(&window.bins, &window.chances(), orders + 1);
            found.into_iter().skip(1).collect()
        });
        let shapes: Vec<Vec<f64>> = shapes.collect();
        Self {
            window: span,
            collisions: all.iter().map(|window| window.collisions).sum(),
            fewest: all
                .iter()
                .map(|window| window.collisions)
                .min()
                .unwrap_or(0),
            slope: slope.map_or(Estimate::default(), |slope| Estimate {
                replicas: Some(slope.replicas),
                ..Estimate::of(slope.value, slope.standard_error)
            }),
            trend: student_t_test(&values, 0.0),
            shape: hotelling_test(&shapes),
        }
    }
}

/// Largest slope that may stay possible where impact parameters are called uniform: it moves the outer of 20 bins by 2.4 %.
const FLAT: f64 = 0.05;

/// Fewest collisions of a replica whose slope is normal: that of 30 uniform numbers is, to 1 % of the chance beyond three standard
/// errors.
pub const FEWEST_COLLISIONS: u64 = 30;

/// The words of the table for all windows of one engine, trends and shapes of all together by Holm: `uniform`, `grazing excess`,
/// `central excess`, `uneven`, `undecided`, `one replica` or `too few collisions`.
pub fn impact_words(tests: &[ImpactTest], level: f64) -> Vec<&'static str> {
    let enough = |one: &ImpactTest| one.fewest >= FEWEST_COLLISIONS;
    let trends = tests.iter().map(|one| one.trend.map(|test| test.p_value));
    let shapes = tests.iter().map(|one| one.shape.map(|test| test.p_value));
    let places = tests.iter().chain(tests).map(enough);
    let p_values: Vec<f64> = trends
        .chain(shapes)
        .zip(places)
        .map(|(p_value, enough)| p_value.filter(|_| enough).unwrap_or(f64::NAN))
        .collect();
    let rejected = holm(&p_values, level);
    let (trends, shapes) = rejected.split_at(tests.len());
    let judged = tests.iter().zip(trends.iter().zip(shapes));
    judged
        .map(|(one, (&trend, &shape))| {
            let slope = one.slope.value.unwrap_or(0.0);
            let flat = reach(one, level).is_some_and(|reach| reach <= FLAT);
            match (trend, shape) {
                _ if !enough(one) => "too few collisions",
                _ if one.trend.is_none() => "one replica",
                (true, _) if slope > 0.0 => "grazing excess",
                (true, _) => "central excess",
                (_, true) => "uneven",
                _ if flat => "uniform",
                _ => "undecided",
            }
        })
        .collect()
}

/// The largest slope that one window leaves possible.
fn reach(one: &ImpactTest, level: f64) -> Option<f64> {
    Some(one.slope.value?.abs() + half_width(&one.slope, level)?)
}

/// The verdict on the impact parameters of one engine, by the words of [`impact_words`].
pub fn impact_parameters(
    topic: impl Into<String>,
    engine: &str,
    tests: &[ImpactTest],
    words: &[&str],
    level: f64,
) -> Verdict {
    let slope = |one: &ImpactTest| one.slope.value.unwrap_or(0.0);
    let said = |one: &ImpactTest| in_units(&one.slope, 1.0);
    let largest = |filter: &dyn Fn(&str) -> bool| {
        let some = tests.iter().zip(words).filter(|(_, word)| filter(word));
        some.max_by(|a, b| slope(a.0).abs().total_cmp(&slope(b.0).abs()))
    };
    let span = |one: &ImpactTest| {
        let [start, end] = one.window.map(short);
        format!("from t = {start} to {end}")
    };
    let excess = largest(&|word| word.ends_with("excess"));
    let (sentence, kind) = if let Some((one, word)) = excess {
        let sentence = format!(
            "The impact parameters of {engine} are not uniform: {word}, slope {} {}.",
            said(one),
            span(one)
        );
        (sentence, VerdictKind::Differ)
    } else if let Some((one, _)) = largest(&|word| word == "uneven") {
        let p_value = one.shape.map_or(f64::NAN, |test| test.p_value);
        let sentence = format!(
            "The impact parameters of {engine} are not uniform: their density is curved (p = {p_value:.1e}), its slope {} {}.",
            said(one),
            span(one)
        );
        (sentence, VerdictKind::Differ)
    } else if !words.is_empty() && words.iter().all(|&word| word == "uniform") {
        let reach = tests.iter().filter_map(|one| reach(one, level));
        let reach = reach.fold(0.0, f64::max);
        let windows = match tests {
            [one] => format!("to t = {}", short(one.window[1])),
            _ => format!("in all {} windows", tests.len()),
        };
        let sentence = format!(
            "The impact parameters of {engine} are uniform {windows}: the slope of their density is below {reach:.3}."
        );
        (sentence, VerdictKind::Agree)
    } else {
        let sentence = match largest(&|word| word != "uniform") {
            Some((one, &"too few collisions")) if one.collisions > 0 => format!(
                "Whether the impact parameters of {engine} are uniform is open: {} collisions, at least {} in a replica, are too few {}.",
                one.collisions,
                one.fewest,
                span(one)
            ),
            Some((one, &"one replica")) => format!(
                "Whether the impact parameters of {engine} are uniform is open: collisions of one gas hang together, and one replica does not show how much; slope {} {}.",
                said(one),
                span(one)
            ),
            Some((one, &"undecided")) => format!(
                "The impact parameters of {engine} cannot be told from uniform ones: a slope below {:.2} stays possible with {} replicas {}, where it is {}.",
                reach(one, level).unwrap_or(f64::NAN),
                one.slope.replicas.unwrap_or(0),
                span(one),
                said(one)
            ),
            _ => format!("{engine} has no collisions whose impact parameters could be tested."),
        };
        (sentence, VerdictKind::Undecided)
    };
    verdict(topic, sentence, kind)
}

/// Whether the last of two averages of each replica, (before, last), is still moving; a warning or nothing.
pub fn still_moving(
    topic: impl Into<String>,
    subject: &str,
    pairs: &[(f64, f64)],
    level: f64,
) -> Option<Verdict> {
    let growth: Vec<f64> = pairs.iter().map(|(a, b)| (b / a).ln()).collect();
    let test = student_t_test(&growth, 0.0)?;
    let mean = growth.iter().sum::<f64>() / growth.len() as f64;
    (test.p_value < level).then(|| {
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

/// Whether a number is zero within its interval.
pub fn zero(found: &Estimate, level: f64) -> VerdictKind {
    match found.value.zip(half_width(found, level)) {
        None => VerdictKind::Undecided,
        Some((value, half)) if value.abs() <= half => VerdictKind::Agree,
        Some(_) => VerdictKind::Differ,
    }
}

/// Whether two profiles differ: the largest difference in standard errors against Student's quantile, all places together by
/// Bonferroni at a chance `level`. `places` are both values and where they are, in words; those without errors are left out, and there
/// is no verdict where all are. Errors come from `parts` blocks of time.
pub fn profiles(
    topic: impl Into<String>,
    pair: [&str; 2],
    places: &[([Estimate; 2], String)],
    parts: usize,
    level: f64,
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
    let limit = quantile(level / all.len() as f64, Some(parts.saturating_sub(1)));
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
