//! Verdicts: statistical tests with a stated false-alarm probability, and their conclusions in
//! words.

use crate::replicas::{of_sums, quantile};
use crate::statistics::{Estimate, TTest, holm, student_t_test};
use serde::{Deserialize, Serialize};

/// Smallest ratio of two quantities that a test must have been able to see for "no difference
/// found" to be called agreement.
pub const SMALLEST_DIFFERENCE: f64 = 7.0 / 6.0;

/// Outcome of a test of two quantities a and b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// No difference found, and the error small enough to have seen one by a sixth.
    Agree,
    /// a is higher.
    Higher,
    /// a is lower.
    Lower,
    /// No difference found, but the error is too wide, or unknown, to speak of agreement.
    Undecided,
}

impl Verdict {
    /// Returns the word for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Higher => "a higher",
            Self::Lower => "a lower",
            Self::Undecided => "undecided",
        }
    }
}

/// Quotient a/b at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quotient {
    /// Quotient of the means over replicas, with its jackknife error.
    pub quotient: Estimate,
    /// Normal-equivalent z of log(a/b); `None` for a single replica.
    pub z: Option<f64>,
    /// Two-sided p value of the hypothesis log(a/b) = 0.
    pub p_value: Option<f64>,
    /// Half the width of the confidence interval of log(a/b) that a single test at `false_alarm`
    /// has; `None` for a single replica.
    pub half_width: Option<f64>,
    /// Outcome of the test at this time, with all times taken together.
    pub verdict: Verdict,
}

/// Compares two positive quantities at several times; `pairs[t]` holds (a, b) of each replica.
///
/// Replicas are paired, as both engines start from the same state, and the logarithm of the
/// quotient of the means is tested by Student's t over the pseudo-values of its jackknife
/// ([`crate::replicas`]). The probability of any false alarm over all times is kept at
/// `false_alarm`, half of it spent on each of two ways to find a difference. One goes from the last
/// time backwards, without correction, until a time shows no difference (the fixed-sequence
/// procedure, Maurer, Hothorn & Lehmacher 1995): it asks since when a and b have parted. The other
/// tests single times by Holm's step-down. Times at which a and b are identical in every replica
/// (the start) agree and count as no test. A time that only a test without correction would call
/// different stays undecided.
pub fn quotients(pairs: &[Vec<(f64, f64)>], false_alarm: f64) -> Vec<Quotient> {
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
    let tests: Vec<_> = logs
        .iter()
        .map(|values| student_t_test(values, 0.0))
        .collect();
    let asked: Vec<usize> = (0..pairs.len()).filter(|&time| !same[time]).collect();
    let p_values: Vec<f64> = asked
        .iter()
        .map(|&time| tests[time].as_ref().map_or(f64::NAN, |test| test.p_value))
        .collect();
    let mut rejected = vec![false; pairs.len()];
    let share = 0.5 * false_alarm;
    let parted = p_values.iter().rev().take_while(|&&p| p <= share).count();
    for (index, (&time, single)) in asked.iter().zip(holm(&p_values, share)).enumerate() {
        rejected[time] = single || index + parted >= asked.len();
    }
    (0..pairs.len())
        .filter_map(|time| {
            let log = Estimate::over_replicas(&logs[time])?;
            let value = log.value.exp();
            let half_width = half_width(&log, tests[time].as_ref(), false_alarm);
            let standard_error = log.standard_error.map(|error| error * value);
            let verdict = if same[time] {
                Verdict::Agree
            } else if rejected[time] {
                if log.value > 0.0 {
                    Verdict::Higher
                } else {
                    Verdict::Lower
                }
            } else if agrees(tests[time].as_ref(), half_width, false_alarm) {
                Verdict::Agree
            } else {
                Verdict::Undecided
            };
            let test = tests[time].as_ref().filter(|_| !same[time]);
            Some(Quotient {
                quotient: Estimate {
                    value,
                    standard_error,
                    replicas: log.replicas,
                },
                z: test.map(|test| test.normal_z),
                p_value: test.map(|test| test.p_value),
                half_width,
                verdict,
            })
        })
        .collect()
}

/// Half width of a confidence interval: Student's quantile times the standard error.
fn half_width(log: &Estimate, test: Option<&TTest>, false_alarm: f64) -> Option<f64> {
    Some(quantile(false_alarm, Some(test?.degrees_of_freedom)) * log.standard_error?)
}

/// Returns true if a single test without correction finds no difference either, and a difference by
/// [`SMALLEST_DIFFERENCE`] would have stood out at its level.
fn agrees(test: Option<&TTest>, half_width: Option<f64>, false_alarm: f64) -> bool {
    test.is_some_and(|test| test.p_value > false_alarm)
        && half_width.is_some_and(|width| width <= SMALLEST_DIFFERENCE.ln())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
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
        let found: Vec<Verdict> = quotients(&pairs, 0.01).iter().map(|q| q.verdict).collect();
        assert_eq!(
            found,
            [
                Verdict::Agree,
                Verdict::Agree,
                Verdict::Higher,
                Verdict::Lower
            ]
        );
    }

    #[test]
    fn one_replica_or_a_wide_error_decides_nothing() {
        let one = quotients(&[vec![(2.0, 1.0)]], 0.01);
        assert_eq!(one[0].verdict, Verdict::Undecided);
        assert_eq!(one[0].z, None);
        let wide = quotients(&[vec![(2.0, 1.0), (0.4, 1.0), (1.7, 1.0)]], 0.01);
        assert_eq!(wide[0].verdict, Verdict::Undecided);
        // 1.15 ± 0.05 over four replicas is no agreement: t = 5.84 standard errors could be a
        // third.
        let four = quotients(
            &[vec![(1.27, 1.0), (1.05, 1.0), (1.2, 1.0), (1.08, 1.0)]],
            0.01,
        );
        assert_eq!(four[0].verdict, Verdict::Undecided);
    }
}
