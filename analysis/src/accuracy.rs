//! Accuracy of a method, from repeated runs and a reference: systematic and statistical error, the
//! total error of several runs, and how many runs meet a target.
//!
//! A setting of a method is repeated with independent seeds. The mean of its values less a
//! reference is its systematic error b, which more runs do not lower; their spread s is the
//! statistical error of one run, which n runs lower to s/√n. The total error of the mean of n runs
//! is the root of the mean squared deviation from the truth,
//!
//! ```text
//! e(n)² = b² + s²/n
//! ```
//!
//! so runs of n replicas need not be made to know their error. Both parts are known only as well as
//! the repetitions and the reference allow. Their ranges, of 95 % each, are Student's for b, with
//! the error of the reference in it, and those of the chi-squared distribution for s. Values are
//! taken as normal.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

use crate::statistics::RunningMoments;

/// Probability that the truth lies outside a reported range of an error: 5 %.
const OUTSIDE: f64 = 0.05;
/// Probability, 1 %, that the error of new runs exceeds the bound of `SettingAccuracy::assured`.
const EXCEEDED: f64 = 0.01;

/// Reference value of a measured quantity, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Reference value, in the unit of the measurement.
    pub value: f64,
    /// Standard error of the reference; 0 if it is exact.
    pub standard_error: f64,
}

/// Measured accuracy of a method at one setting, such as a time step or a cell size: systematic and
/// statistical error from repeated runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingAccuracy {
    /// Mean of the measured values, in the unit of the measurement.
    pub mean: f64,
    /// Systematic error: mean of the values less the reference, divided by the unit of the caller.
    pub systematic: f64,
    /// Standard error of the systematic error, with the error of the reference, divided by the unit
    /// of the caller.
    pub systematic_error: f64,
    /// Statistical error of one run: standard deviation of the values, divided by the unit of the
    /// caller.
    pub statistical: f64,
    /// Number of measured values, one from each run.
    pub repetitions: usize,
    reference_error: f64,
    quantiles: Quantiles,
}

/// Quantiles of Student's and of the chi-squared distribution for one number of degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Quantiles {
    /// Two-sided Student's quantile at the error probability [`OUTSIDE`], for reported ranges.
    range: f64,
    /// Two-sided Student's quantile at the error probability [`EXCEEDED`], for assured errors.
    assured: f64,
    /// Lower and upper 95 % bound of the true standard deviation, divided by the measured one.
    spread: [f64; 2],
}

impl Quantiles {
    fn new(degrees_of_freedom: f64) -> Option<Self> {
        let student = StudentsT::new(0.0, 1.0, degrees_of_freedom).ok()?;
        let squares = ChiSquared::new(degrees_of_freedom).ok()?;
        let spread = [1.0 - 0.5 * OUTSIDE, 0.5 * OUTSIDE]
            .map(|share| (degrees_of_freedom / squares.inverse_cdf(share)).sqrt());
        Some(Self {
            range: student.inverse_cdf(1.0 - 0.5 * OUTSIDE),
            assured: student.inverse_cdf(1.0 - 0.5 * EXCEEDED),
            spread,
        })
    }
}

impl SettingAccuracy {
    /// Computes the accuracy from values of single runs, a reference, and the unit of all errors:
    /// the reference itself for relative errors, 1 for absolute ones. None for fewer than two
    /// values, a number that is not finite, or a unit of zero.
    ///
    /// ```
    /// use stosszahl_analysis::accuracy::{SettingAccuracy, Known};
    ///
    /// let truth = Known { value: 2.0, standard_error: 0.0 };
    /// let found = SettingAccuracy::new(&[2.1, 2.3], truth, 2.0).unwrap();
    /// assert!((found.systematic - 0.1).abs() < 1e-15);
    /// assert!((found.statistical - 0.02_f64.sqrt() / 2.0).abs() < 1e-15);
    /// assert!((found.systematic_error - 0.05).abs() < 1e-15);
    /// ```
    pub fn new(values: &[f64], reference: Known, unit: f64) -> Option<Self> {
        let moments: RunningMoments = values.iter().copied().collect();
        let (mean, own) = (moments.mean()?, moments.standard_error()?);
        let unit = unit.abs();
        let systematic = (mean - reference.value) / unit;
        let systematic_error = own.hypot(reference.standard_error) / unit;
        let statistical = moments.variance()?.sqrt() / unit;
        let finite = [systematic, systematic_error, statistical]
            .iter()
            .all(|number| number.is_finite());
        Some(Self {
            mean,
            systematic,
            systematic_error,
            statistical,
            repetitions: moments.count(),
            reference_error: reference.standard_error / unit,
            quantiles: Quantiles::new(moments.count() as f64 - 1.0)?,
        })
        .filter(|_| finite)
    }

    /// Returns this accuracy with a systematic error of zero, whose uncertainty is that of the
    /// reference. It is for a method that is exact by definition, such as the method of the
    /// reference.
    #[must_use]
    pub fn without_systematic_error(self) -> Self {
        Self {
            systematic: 0.0,
            systematic_error: self.reference_error,
            ..self
        }
    }

    /// Computes the 95 % range of the magnitude of the systematic error, divided by the unit of the
    /// caller.
    pub fn systematic_range(&self) -> [f64; 2] {
        let (size, reach) = (
            self.systematic.abs(),
            self.quantiles.range * self.systematic_error,
        );
        [(size - reach).max(0.0), size + reach]
    }

    /// Computes the 95 % range of the statistical error of one run, divided by the unit of the
    /// caller.
    pub fn statistical_range(&self) -> [f64; 2] {
        self.quantiles
            .spread
            .map(|factor| factor * self.statistical)
    }

    /// Computes the total error of the mean of `runs` runs, divided by the unit of the caller. The
    /// squared systematic error contains, on average, its own variance; that is subtracted, down to
    /// zero at least.
    pub fn total(&self, runs: u64) -> f64 {
        let square = self.systematic.powi(2) - self.systematic_error.powi(2);
        (square.max(0.0) + self.statistical.powi(2) / runs as f64).sqrt()
    }

    /// Computes the range of the total error of the mean of `runs` runs, divided by the unit of the
    /// caller: from the low ends to the high ends of systematic and statistical error.
    pub fn total_range(&self, runs: u64) -> [f64; 2] {
        let (bias, noise) = (self.systematic_range(), self.statistical_range());
        [0, 1].map(|end: usize| bias[end].hypot(noise[end] / (runs as f64).sqrt()))
    }

    /// Computes the error that the mean of `runs` new runs exceeds with a probability of 1 % at
    /// most, divided by the unit of the caller. It is the magnitude of the systematic error, plus
    /// Student's quantile times its uncertainty and that of the mean.
    pub fn assured(&self, runs: u64) -> f64 {
        let noise = self.statistical / (runs as f64).sqrt();
        self.systematic.abs() + self.quantiles.assured * self.systematic_error.hypot(noise)
    }

    /// Returns the fewest runs for which `assured` is at most `target`; `None` if even `most` runs
    /// do not suffice.
    pub fn runs_for(&self, target: f64, most: u64) -> Option<u64> {
        let noise = (target - self.systematic.abs()) / self.quantiles.assured;
        let rest = noise.powi(2) - self.systematic_error.powi(2);
        if noise.is_nan() || noise <= 0.0 || rest <= 0.0 {
            return None;
        }
        let wanted = (self.statistical.powi(2) / rest).ceil().max(1.0);
        // Rounding may leave the last run short.
        let wanted = [wanted, wanted + 1.0]
            .into_iter()
            .find(|&runs| runs <= most as f64 && self.assured(runs as u64) <= target)?;
        Some(wanted as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const TRUTH: f64 = 3.0;

    /// Normal values by the sum of twelve uniform ones.
    fn normal(stream: &mut Xoshiro256PlusPlus) -> f64 {
        (0..12).map(|_| stream.random::<f64>()).sum::<f64>() - 6.0
    }

    fn sample(stream: &mut Xoshiro256PlusPlus, bias: f64, noise: f64, count: usize) -> Vec<f64> {
        (0..count)
            .map(|_| TRUTH * (1.0 + bias) + TRUTH * noise * normal(stream))
            .collect()
    }

    /// The true bias, noise and total error lie within their ranges as often as stated. Of 2000
    /// trials these are 1900 ± 9.7 for bias and noise, of which five standard errors are allowed.
    /// They are more for the total, whose range is at least as wide.
    #[test]
    fn ranges_hold_the_truth() {
        let (bias, noise, count) = (0.02, 0.05, 8);
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(1);
        let mut held = [0; 3];
        for _ in 0..2000 {
            // The reference is uncertain as well.
            let known = Known {
                value: TRUTH * (1.0 + 0.005 * normal(stream)),
                standard_error: TRUTH * 0.005,
            };
            let values = sample(stream, bias, noise, count);
            let found = SettingAccuracy::new(&values, known, TRUTH).expect("values");
            let within =
                |range: [f64; 2], value: f64| usize::from(range[0] <= value && value <= range[1]);
            held[0] += within(found.systematic_range(), bias);
            held[1] += within(found.statistical_range(), noise);
            held[2] += within(found.total_range(4), bias.hypot(noise / 2.0));
        }
        let allowed = 5.0 * (2000.0_f64 * 0.05 * 0.95).sqrt();
        // The lower end of a size is cut at zero, so a bias may be held a little more often.
        assert!((held[0] as f64 - 1900.0) > -allowed, "{held:?}");
        assert!((held[1] as f64 - 1900.0).abs() < allowed, "{held:?}");
        assert!(held[2] as f64 > 1900.0 - allowed, "{held:?}");
    }

    /// New means of the recommended number of runs miss the target in at most 1 % of 2000 trials,
    /// and five standard errors of that count (20 + 22).
    #[test]
    fn assured_errors_are_kept() {
        let (bias, noise, target) = (0.004, 0.02, 0.01);
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(2);
        let exact = Known {
            value: TRUTH,
            standard_error: 0.0,
        };
        let (mut missed, mut tried) = (0, 0);
        while tried < 2000 {
            let found = SettingAccuracy::new(&sample(stream, bias, noise, 200), exact, TRUTH)
                .expect("values");
            let Some(runs) = found.runs_for(target, 10_000) else {
                continue;
            };
            assert!(found.assured(runs) <= target);
            assert!(runs == 1 || found.assured(runs - 1) > target);
            let again = sample(stream, bias, noise, runs as usize);
            let mean = again.iter().sum::<f64>() / again.len() as f64;
            missed += i32::from((mean / TRUTH - 1.0).abs() > target);
            tried += 1;
        }
        assert!(missed <= 42, "{missed} of {tried}");
    }

    /// A bias beyond the target cannot be averaged away, and noise that is not known well enough is
    /// not trusted.
    #[test]
    fn some_targets_cannot_be_met() {
        let exact = Known {
            value: 1.0,
            standard_error: 0.0,
        };
        let biased = SettingAccuracy::new(&[1.019, 1.02, 1.021], exact, 1.0).expect("values");
        assert_eq!(biased.runs_for(0.01, u64::MAX), None);
        let vague = SettingAccuracy::new(&[0.98, 1.02], exact, 1.0).expect("values");
        assert_eq!(vague.runs_for(0.01, u64::MAX), None);
        let few = SettingAccuracy::new(&[0.999, 1.0, 1.001], exact, 1.0).expect("values");
        assert_eq!(few.runs_for(1e-5, 10), None);
    }

    /// A method known to be unbiased needs fewer runs, as only the reference is uncertain.
    #[test]
    fn known_lack_of_bias_saves_runs() {
        let known = Known {
            value: 1.0,
            standard_error: 0.001,
        };
        let values: Vec<f64> = (0..50).map(|i| 1.0 + 0.001 * f64::from(i - 24)).collect();
        let found = SettingAccuracy::new(&values, known, 1.0).expect("values");
        let free = found.without_systematic_error();
        assert_eq!((free.systematic, free.systematic_error), (0.0, 0.001));
        let [runs, fewer] = [found, free].map(|one| one.runs_for(0.01, 1000).expect("runs"));
        assert!(fewer < runs, "{fewer} {runs}");
    }

    #[test]
    fn numbers_that_are_none_give_no_accuracy() {
        let exact = Known {
            value: 1.0,
            standard_error: 0.0,
        };
        assert_eq!(SettingAccuracy::new(&[1.0], exact, 1.0), None);
        assert_eq!(SettingAccuracy::new(&[1.0, f64::NAN], exact, 1.0), None);
        assert_eq!(SettingAccuracy::new(&[1.0, 1.1], exact, 0.0), None);
    }
}
