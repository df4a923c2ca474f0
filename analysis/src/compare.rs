//! Equivalence tests of two quantities over time: one decision rule, with simultaneous Student's
//! confidence intervals.
//!
//! A difference has an interval, and the comparison has a margin:
//!
//! - *Agree*: the whole interval lies inside the margin, even if it excludes zero.
//! - *Higher* or *lower*: the whole interval lies on one side of zero, or beyond the margin if
//!   that is requested.
//! - *Undecided*: all else.
//!
//! The tests of equivalence are those of D. J. Schuirmann, *J. Pharmacokinet. Biopharm.* **15**,
//! 657 (1987), with intervals of `1 - level` on two sides. So a true difference of a margin or more
//! is called agreement with a chance of `level / 2` at most, and none is called a difference with a
//! chance of `level` at most.
//!
//! # Several times together
//!
//! Half of the level belongs to the last time, which is chosen before any result is known, and half
//! to all other times together. Their common quantile is that of [`joint_quantile`]: neighbouring
//! times hardly differ, so that they count as few.

use crate::replicas::{of_sums, quantile};
use crate::statistics::{Estimate, RunningMoments, student_t_test};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Outcome of a comparison of two quantities a and b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ComparisonVerdict {
    /// Agreement: the whole interval of the difference lies inside the margin.
    Agree,
    /// a is higher than b: the whole interval of the difference lies above
    /// [`VerdictRule::differ_beyond`].
    Higher,
    /// a is lower than b: the whole interval of the difference lies below minus
    /// [`VerdictRule::differ_beyond`].
    Lower,
    /// Neither agreement nor a difference can be shown, or the interval is unknown.
    Undecided,
}

impl ComparisonVerdict {
    /// Returns the word for the verdict in tables, such as `a higher`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Higher => "a higher",
            Self::Lower => "a lower",
            Self::Undecided => "undecided",
        }
    }

    /// Returns true for `Higher` and `Lower`: a difference is shown.
    pub fn differs(self) -> bool {
        matches!(self, Self::Higher | Self::Lower)
    }
}

/// Decision rule that turns the confidence interval of a difference into a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerdictRule {
    /// Error probability of a comparison: that any of its intervals, at any time, misses the true
    /// value.
    pub level: f64,
    /// Margin: largest difference that counts as agreement, in the unit of the difference.
    pub margin: f64,
    /// Distance from zero beyond which an interval shows a difference: zero, or the margin.
    pub differ_beyond: f64,
}

impl VerdictRule {
    /// Creates a rule in which any significant difference from zero counts as a difference.
    pub fn new(level: f64, margin: f64) -> Self {
        Self {
            level,
            margin,
            differ_beyond: 0.0,
        }
    }

    /// Returns a copy of this rule with another error probability `level`.
    #[must_use]
    pub fn at_level(self, level: f64) -> Self {
        Self { level, ..self }
    }
}

/// Difference of two quantities with its confidence interval, relative or in the unit of the
/// quantities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Estimated difference.
    pub value: f64,
    /// Standard error of the estimated difference; `None` if unknown.
    pub standard_error: Option<f64>,
    /// Degrees of freedom of the standard error; `None` if the error is known without replicas.
    pub degrees_of_freedom: Option<usize>,
    /// Lower and upper end of the confidence interval; `None` without a standard error, or without
    /// degrees of freedom.
    pub ends: Option<[f64; 2]>,
}

impl Interval {
    /// Creates Student's confidence interval at the error probability `level`; a normal one if the
    /// error is known without replicas.
    ///
    /// ```
    /// use stosszahl_analysis::compare::{Interval, VerdictRule, ComparisonVerdict};
    ///
    /// let rule = VerdictRule::new(0.05, 0.05);
    /// let decide = |value| Interval::student(value, Some(0.01), Some(15), 0.05).decide(&rule);
    /// // Student's quantile is 2.13.
    /// assert_eq!(decide(0.02), ComparisonVerdict::Agree);
    /// assert_eq!(decide(0.04), ComparisonVerdict::Higher);
    /// assert_eq!(Interval::student(0.02, None, None, 0.05).decide(&rule), ComparisonVerdict::Undecided);
    /// ```
    pub fn student(
        value: f64,
        standard_error: Option<f64>,
        degrees_of_freedom: Option<usize>,
        level: f64,
    ) -> Self {
        let half = standard_error.map(|error| quantile(level, degrees_of_freedom) * error);
        Self {
            value,
            standard_error,
            degrees_of_freedom,
            ends: half
                .filter(|half| half.is_finite() && value.is_finite())
                .map(|half| [value - half, value + half]),
        }
    }

    /// Decides by a rule whether the interval shows agreement, a higher or a lower value, or
    /// neither.
    pub fn decide(&self, rule: &VerdictRule) -> ComparisonVerdict {
        match self.ends {
            Some([low, high]) if -rule.margin <= low && high <= rule.margin => {
                ComparisonVerdict::Agree
            }
            Some([low, _]) if low > rule.differ_beyond => ComparisonVerdict::Higher,
            Some([_, high]) if high < -rule.differ_beyond => ComparisonVerdict::Lower,
            _ => ComparisonVerdict::Undecided,
        }
    }

    /// Returns the largest magnitude of a difference in the interval; `None` if there is no
    /// interval.
    pub fn most(&self) -> Option<f64> {
        self.ends.map(|[low, high]| high.max(-low))
    }

    /// Returns the smallest magnitude of a difference in the interval: zero if the interval
    /// contains zero, or if there is no interval.
    pub fn least(&self) -> f64 {
        self.ends.map_or(0.0, |[low, high]| low.max(-high).max(0.0))
    }
}

/// Comparison of two quantities at one time by their quotient a/b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quotient {
    /// Jackknife estimate over replicas of the quotient of the means, through its logarithm, with
    /// its standard error.
    pub quotient: Estimate,
    /// Standard score of log(a/b), converted from Student's to the normal distribution; `None` for
    /// a single replica.
    pub z: Option<f64>,
    /// Relative difference `a/b - 1` with its confidence interval, simultaneous for all times.
    pub off: Interval,
    /// Verdict at this time, from the interval that is simultaneous for all times.
    pub verdict: ComparisonVerdict,
}

/// Compares two positive quantities at several times by a rule with a relative margin; `pairs[t]`
/// holds (a, b) of each replica.
///
/// Replicas are paired, as both engines start from the same state. The logarithm of the quotient of
/// the means has Student's interval over the pseudo-values of its jackknife ([`crate::replicas`]).
/// Times at which a and b are identical in every replica (the start) agree.
pub fn quotients(pairs: &[Vec<(f64, f64)>], rule: &VerdictRule) -> Vec<Quotient> {
    let log = |replicas: &Vec<(f64, f64)>| {
        let sums: Vec<[f64; 2]> = replicas.iter().map(|&(a, b)| [a, b]).collect();
        of_sums(&sums, |[a, b]| (a / b).ln())
    };
    let logs: Vec<Vec<f64>> = pairs.iter().map(log).collect();
    let equal = |&(a, b): &(f64, f64)| (a / b - 1.0).abs() < 1e-9;
    let same: Vec<bool> = pairs
        .iter()
        .map(|replicas| replicas.iter().all(equal))
        .collect();
    let asked: Vec<&[f64]> = (logs.iter().zip(&same))
        .filter(|(_, same)| !**same)
        .map(|(values, _)| &values[..])
        .collect();
    let mut quantiles = interval_half_widths(&asked, rule.level).into_iter();
    let mut list = Vec::new();
    for (values, same) in logs.iter().zip(same) {
        let quantile = if same { Some(0.0) } else { quantiles.next() };
        let Some(log) = Estimate::over_replicas(values) else {
            continue;
        };
        let value = log.value.exp();
        let half = quantile.zip(log.standard_error).map(|(far, se)| far * se);
        let half = half.filter(|half| half.is_finite() && log.value.is_finite());
        let off = Interval {
            value: value - 1.0,
            standard_error: log.standard_error.map(|error| error * value),
            degrees_of_freedom: Some(log.replicas.saturating_sub(1)),
            ends: half.map(|half| [-half, half].map(|side| (log.value + side).exp_m1())),
        };
        let test = student_t_test(values, 0.0).filter(|_| !same);
        list.push(Quotient {
            quotient: Estimate {
                value,
                standard_error: off.standard_error,
                replicas: log.replicas,
            },
            z: test.map(|test| test.normal_z),
            verdict: if same {
                ComparisonVerdict::Agree
            } else {
                off.decide(rule)
            },
            off,
        });
    }
    list
}

/// Compares numbers that should be zero at several times, by a rule with a margin in their unit;
/// `values[t]` holds the number of each replica at time t, or pseudo-values.
pub fn differences(values: &[Vec<f64>], rule: &VerdictRule) -> Vec<Interval> {
    let rows: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let quantiles = interval_half_widths(&rows, rule.level);
    let one = |(values, far): (&Vec<f64>, f64)| {
        let found = Estimate::over_replicas(values);
        let value = found.map_or(f64::NAN, |found| found.value);
        let standard_error = found.and_then(|found| found.standard_error);
        let half = standard_error.map(|error| far * error);
        Interval {
            value,
            standard_error,
            degrees_of_freedom: Some(values.len().saturating_sub(1)),
            ends: half
                .filter(|half| half.is_finite() && value.is_finite())
                .map(|half| [value - half, value + half]),
        }
    };
    values.iter().zip(quantiles).map(one).collect()
}

/// Computes the half widths of simultaneous confidence intervals at several times, in standard
/// errors. Half of the level is for the last time, half for all others together.
fn interval_half_widths(rows: &[&[f64]], level: f64) -> Vec<f64> {
    let student = |values: &[f64], level| quantile(level, Some(values.len().saturating_sub(1)));
    let Some((last, others)) = rows.split_last() else {
        return Vec::new();
    };
    if others.is_empty() {
        return vec![student(last, level)];
    }
    let joint = joint_quantile(others, 0.5 * level);
    let several = others
        .iter()
        .map(|values| joint.max(student(values, 0.5 * level)));
    several.chain([student(last, 0.5 * level)]).collect()
}

/// Computes the half width, in standard errors, within which Student's statistics of several times
/// all lie with probability `1 - level` at least. `rows[t]` holds the values of the replicas,
/// normal and with any correlation between times.
///
/// This is the tube formula of H. Hotelling, *Am. J. Math.* **61**, 440 (1939), for Student's
/// statistic. Seen from zero, the values of R replicas at one time are a direction in R dimensions.
/// The statistic is beyond c where this direction lies in a cap around the diagonal, or in the
/// opposite cap. The distribution does not change under rotations of the replicas, so a path of
/// directions of length L enters the two caps `L/π (1 + c²/ν)^(-(ν-1)/2)` times on average,
/// `ν = R - 1`.
///
/// The chance to be in a cap at any time is at most the chance to begin in one, plus that number. A
/// step counts at most as a test of its own, so that the quantile is never above that of
/// Bonferroni. L is the length for deviations from the means, in one dimension less; the factor
/// `ν/√((ν+1)(ν-1))` corrects for that at small steps.
///
/// ```
/// use stosszahl_analysis::compare::joint_quantile;
/// use stosszahl_analysis::replicas::quantile;
///
/// // One number at many times is one test.
/// let values = [0.3, -0.2, 0.5, 0.1];
/// let alike = joint_quantile(&[&values[..]; 20], 0.05);
/// assert!((alike - quantile(0.05, Some(3))).abs() < 1e-6);
/// // Numbers that have nothing to do with each other are as many as there are.
/// let (one, other) = ([1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0]);
/// let apart = joint_quantile(&[&one, &other], 0.05);
/// assert!(apart <= quantile(0.025, Some(3)) + 1e-6 && apart > 1.2 * alike);
/// ```
pub fn joint_quantile(rows: &[&[f64]], level: f64) -> f64 {
    let Some(first) = rows.first() else {
        return 0.0;
    };
    let fewest = rows.iter().map(|row| row.len()).min().unwrap_or(0);
    let freedom = fewest.saturating_sub(1);
    let bonferroni = quantile(level / rows.len() as f64, Some(freedom));
    let alike = rows.iter().all(|row| row.len() == first.len());
    // Two replicas have one deviation, whose direction says nothing.
    if freedom < 2 || !alike || !bonferroni.is_finite() {
        return bonferroni;
    }
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom as f64) else {
        return bonferroni;
    };
    let nu = freedom as f64;
    let factor = nu / ((nu + 1.0) * (nu - 1.0)).sqrt() / std::f64::consts::PI;
    let steps: Vec<f64> = rows
        .windows(2)
        .map(|pair| factor * angle_between(pair[0], pair[1]))
        .collect();
    let chance = |far: f64| {
        let alone = 2.0 * student.sf(far);
        let entered = (1.0 + far * far / nu).powf(-0.5 * (nu - 1.0));
        alone
            + steps
                .iter()
                .map(|step| alone.min(step * entered))
                .sum::<f64>()
    };
    let (mut low, mut high) = (quantile(level, Some(freedom)), bonferroni);
    while high - low > 1e-9 * high {
        let middle = 0.5 * (low + high);
        if chance(middle) > level {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Computes the angle \[rad\] between two rows of values, each taken as a vector of deviations from
/// its mean; infinite if a row has no deviations.
fn angle_between(a: &[f64], b: &[f64]) -> f64 {
    let mean = |row: &[f64]| row.iter().copied().collect::<RunningMoments>().mean();
    let (mean_a, mean_b) = (mean(a).unwrap_or(0.0), mean(b).unwrap_or(0.0));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - mean_a, y - mean_b);
        aa += x * x;
        bb += y * y;
        ab += x * y;
    }
    let cosine = ab / (aa * bb).sqrt();
    if cosine.is_finite() {
        cosine.clamp(-1.0, 1.0).acos()
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn differences_are_found_with_their_direction() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut noisy = |factor: f64| -> Vec<(f64, f64)> {
            (0..8)
                .map(|_| (factor * (1.0 + 0.01 * (stream.random::<f64>() - 0.5)), 1.0))
                .collect()
        };
        let pairs = vec![vec![(1.0, 1.0); 8], noisy(1.0), noisy(1.1), noisy(0.9)];
        let rule = VerdictRule::new(0.01, 0.05);
        let found: Vec<ComparisonVerdict> =
            quotients(&pairs, &rule).iter().map(|q| q.verdict).collect();
        assert_eq!(
            found,
            [
                ComparisonVerdict::Agree,
                ComparisonVerdict::Agree,
                ComparisonVerdict::Higher,
                ComparisonVerdict::Lower
            ]
        );
    }

    #[test]
    fn one_replica_or_a_wide_error_decides_nothing() {
        let rule = VerdictRule::new(0.01, 0.05);
        let one = quotients(&[vec![(2.0, 1.0)]], &rule);
        assert_eq!(one[0].verdict, ComparisonVerdict::Undecided);
        assert_eq!((one[0].z, one[0].off.ends), (None, None));
        let wide = quotients(&[vec![(2.0, 1.0), (0.4, 1.0), (1.7, 1.0)]], &rule);
        assert_eq!(wide[0].verdict, ComparisonVerdict::Undecided);
        // 1.15 ± 0.05 over four replicas is neither: t = 5.84 standard errors could be a third.
        let four = vec![(1.27, 1.0), (1.05, 1.0), (1.2, 1.0), (1.08, 1.0)];
        assert_eq!(
            quotients(&[four], &rule)[0].verdict,
            ComparisonVerdict::Undecided
        );
    }

    #[test]
    fn a_difference_inside_the_margin_agrees_and_one_across_it_differs() {
        let of = |value: f64, half: f64| Interval {
            value,
            standard_error: Some(half),
            degrees_of_freedom: Some(3),
            ends: Some([value - half, value + half]),
        };
        let rule = VerdictRule::new(0.05, 0.05);
        assert_eq!(of(0.03, 0.01).decide(&rule), ComparisonVerdict::Agree);
        assert_eq!(of(-0.04, 0.02).decide(&rule), ComparisonVerdict::Lower);
        assert_eq!(of(0.03, 0.04).decide(&rule), ComparisonVerdict::Undecided);
        assert_eq!(of(0.0, 0.06).decide(&rule), ComparisonVerdict::Undecided);
        let beyond = VerdictRule {
            differ_beyond: 0.05,
            ..rule
        };
        assert_eq!(
            of(-0.04, 0.02).decide(&beyond),
            ComparisonVerdict::Undecided
        );
        assert_eq!(of(-0.08, 0.02).decide(&beyond), ComparisonVerdict::Lower);
        assert_eq!(of(-0.08, 0.02).most(), Some(0.1));
        assert!((of(-0.08, 0.02).least() - 0.06).abs() < 1e-15);
        assert!(of(-0.01, 0.02).least().abs() < 1e-15);
    }

    /// Tests Gaussian paths of 30 times whose correlation falls as exp(-|i - j|/length). All their
    /// Student's statistics must lie within the quantile in 95 of 100 samples; four binomial errors
    /// of 4000 are 1.4. The quantile is tighter than Bonferroni's by a stated part.
    #[test]
    fn the_joint_quantile_holds_at_all_times_together() {
        const SAMPLES: usize = 4000;
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(3);
        for (replicas, length, narrower) in [
            (3, 100.0, 0.86),
            (4, 100.0, 0.82),
            (8, 30.0, 0.92),
            (16, 1000.0, 0.72),
            (16, 3.0, 1.0),
        ] {
            let keep = f64::exp(-1.0 / length);
            let (mut missed, mut ratio) = (0, 0.0);
            for _ in 0..SAMPLES {
                let mut state: Vec<f64> = (0..replicas)
                    .map(|_| stream.sample(StandardNormal))
                    .collect();
                let mut rows = Vec::new();
                for _ in 0..30 {
                    rows.push(state.clone());
                    for one in &mut state {
                        let kick: f64 = stream.sample(StandardNormal);
                        *one = keep * *one + (1.0 - keep * keep).sqrt() * kick;
                    }
                }
                let views: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
                let far = joint_quantile(&views, 0.05);
                ratio += far / quantile(0.05 / 30.0, Some(replicas - 1)) / SAMPLES as f64;
                let beyond = |row: &Vec<f64>| {
                    student_t_test(row, 0.0).is_some_and(|test| test.statistic.abs() > far)
                };
                missed += usize::from(rows.iter().any(beyond));
            }
            let rate = missed as f64 / SAMPLES as f64;
            assert!(rate <= 0.05 + 0.014, "{replicas}, {length}: {rate}");
            assert!(ratio <= narrower, "{replicas}, {length}: {ratio}");
        }
    }
}
