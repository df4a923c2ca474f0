//! Estimates with standard errors, and statistical tests with p values: Student's, chi-squared,
//! Holm's.
//!
//! Replicas of a run differ only in their seed, so their results are independent and identically
//! distributed: the mean over replicas and its standard error need no model of correlations in
//! time. With few replicas the error itself is uncertain, and [`student_t_test`] accounts for that
//! exactly when the replicas' results are normal, which averages over many disks are to good
//! approximation. Block averages within one run were rejected: the blocks must be long against a
//! correlation time that a cooling gas keeps changing.
//!
//! All p values are two-sided or upper tails, computed from survival functions and never as one
//! minus a distribution function, so that a p value of 10⁻²⁰⁰ is just that and not 0.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc_inv;

use crate::Error;

/// Largest magnitude of a standard score z that stands for a p value.
///
/// The smallest positive double, 4.9 · 10⁻³²⁴, is the two-sided p value of z = 38.47; a p value
/// that underflows to 0 is reported with this z.
pub const LARGEST_NORMAL_Z: f64 = 38.5;

/// Smallest expected count in a bin of a chi-squared test.
///
/// The rule of W. G. Cochran, *Biometrics* **10**, 417 (1954), doi:10.2307/3001616, in its strict
/// form.
pub const SMALLEST_EXPECTED_COUNT: f64 = 5.0;

/// Largest relative difference between the totals of observed and expected counts.
///
/// A relative difference delta of totals near N adds N delta² to the statistic: below 10⁻³ for 10⁹
/// counts.
const TOTALS_TOLERANCE: f64 = 1e-6;

/// Running mean and variance of a stream of numbers.
///
/// The update of B. P. Welford, *Technometrics* **4**, 419 (1962),
/// doi:10.1080/00401706.1962.10490022. Unlike the difference of mean square and squared mean, it
/// does not cancel when the variance is small against the mean, and equal numbers give a variance
/// of exactly 0.
///
/// ```
/// use stosszahl_analysis::statistics::RunningMoments;
///
/// let moments: RunningMoments = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0].into_iter().collect();
/// assert_eq!(moments.mean(), Some(5.0));
/// assert_eq!(moments.variance(), Some(32.0 / 7.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningMoments {
    count: usize,
    mean: f64,
    squares: f64,
}

impl RunningMoments {
    /// Adds one number to the running mean and variance.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// Returns the number of values added so far.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the mean of the numbers; `None` without numbers.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// Returns the unbiased variance, Σ (x - mean)² / (n - 1); `None` for fewer than two numbers.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.squares / (self.count - 1) as f64)
    }

    /// Returns the standard error of the mean, s / √n; `None` for fewer than two numbers.
    pub fn standard_error(&self) -> Option<f64> {
        self.variance()
            .map(|variance| (variance / self.count as f64).sqrt())
    }
}

impl FromIterator<f64> for RunningMoments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.add(value);
        }
        moments
    }
}

/// Measured mean over independent replicas, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Mean over the replicas, in the unit of the measurement.
    pub value: f64,
    /// Standard error of the mean, s / √R, in the unit of the measurement; `None` for one replica.
    pub standard_error: Option<f64>,
    /// Number of independent replicas R.
    pub replicas: usize,
}

impl Estimate {
    /// Computes the mean over independent replicas and its standard error s / √R, where s² = Σ (x -
    /// mean)² / (R - 1). No replicas give no estimate; a value that is not finite makes the
    /// estimate not finite.
    ///
    /// ```
    /// use stosszahl_analysis::statistics::Estimate;
    ///
    /// let estimate = Estimate::over_replicas(&[1.0, 2.0, 3.0, 6.0]).unwrap();
    /// assert_eq!(estimate.value, 3.0);
    /// assert_eq!(estimate.standard_error, Some((14.0_f64 / 3.0 / 4.0).sqrt()));
    /// assert_eq!(Estimate::over_replicas(&[]), None);
    /// ```
    pub fn over_replicas(values: &[f64]) -> Option<Self> {
        let moments: RunningMoments = values.iter().copied().collect();
        Some(Self {
            value: moments.mean()?,
            standard_error: moments.standard_error(),
            replicas: moments.count(),
        })
    }
}

/// Outcome of Student's test of one mean, [`student_t_test`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TTest {
    /// Test statistic t = (mean - hypothesis) / (s / √n); infinite if all values are equal, but not
    /// to the hypothesis.
    pub statistic: f64,
    /// Degrees of freedom of the test: n - 1.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic at least this far from 0, on either side, under the hypothesis.
    pub p_value: f64,
    /// Standard score of a normal variable with equal two-sided p value, at most
    /// [`LARGEST_NORMAL_Z`] in magnitude. Positive if the mean lies above the hypothesis.
    pub normal_z: f64,
}

/// Tests whether independent normal values can have the mean `hypothesis`: the two-sided one-sample
/// test of Student, *Biometrika* **6**, 1 (1908), doi:10.2307/2331554.
///
/// For a paired comparison, pass the differences and the hypothesis 0; for a ratio, the logarithms
/// of the ratios. None for fewer than two values, or when a number is not finite. Equal values have
/// no variance to measure against: they either are the hypothesis (p = 1) or exclude it (p = 0).
///
/// ```
/// use stosszahl_analysis::statistics::student_t_test;
///
/// // Two values have one degree of freedom, where p = 1 - (2/pi) atan|t|: t = 1 gives 1/2.
/// let test = student_t_test(&[0.0, 2.0], 0.0).unwrap();
/// assert_eq!((test.statistic, test.degrees_of_freedom), (1.0, 1));
/// assert!((test.p_value - 0.5).abs() < 1e-12);
/// assert!((test.normal_z - 0.674_489_750_196_082).abs() < 1e-11);
/// ```
pub fn student_t_test(values: &[f64], hypothesis: f64) -> Option<TTest> {
    let moments: RunningMoments = values.iter().copied().collect();
    let standard_error = moments.standard_error()?;
    let difference = moments.mean()? - hypothesis;
    if !(difference.is_finite() && standard_error.is_finite()) {
        return None;
    }
    let degrees_of_freedom = moments.count() - 1;
    let statistic = if difference == 0.0 {
        0.0
    } else {
        difference / standard_error
    };
    let p_value = if statistic.is_infinite() {
        0.0
    } else {
        let student = StudentsT::new(0.0, 1.0, degrees_of_freedom as f64).ok()?;
        (2.0 * student.sf(statistic.abs())).min(1.0)
    };
    Some(TTest {
        statistic,
        degrees_of_freedom,
        p_value,
        normal_z: statistic.signum() * normal_z(p_value),
    })
}

/// Returns the z ≥ 0 at which a normal variable has the given two-sided p value, p = erfc(z / √2),
/// at most [`LARGEST_NORMAL_Z`].
fn normal_z(p_value: f64) -> f64 {
    if p_value > 0.0 {
        (std::f64::consts::SQRT_2 * erfc_inv(p_value)).clamp(0.0, LARGEST_NORMAL_Z)
    } else {
        LARGEST_NORMAL_Z
    }
}

/// Outcome of Pearson's chi-squared test, of [`chi_squared_test`] or [`uniform_test`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChiSquaredTest {
    /// Chi-squared statistic Σ (observed - expected)² / expected.
    pub statistic: f64,
    /// Degrees of freedom of the test: bins - 1 - fitted parameters.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic at least this large under the hypothesis.
    pub p_value: f64,
}

/// Tests by chi-squared whether observed counts in bins agree with expected counts: K. Pearson,
/// *Philosophical Magazine* **50**, 157 (1900), doi:10.1080/14786440009463897.
///
/// `fitted` is the number of parameters of the distribution that were fitted to the same counts.
/// The counts must be of independent events; the statistic then follows the chi-squared
/// distribution with bins - 1 - fitted degrees of freedom.
///
/// Bins that expect too little are refused, not merged: the result of a merge depends on which bins
/// are taken together, and which are neighbours depends on the quantity.
///
/// # Errors
/// [`Error::BinsDiffer`], [`Error::BinsTooFew`], [`Error::ObservedInvalid`];
/// [`Error::ExpectedTooSmall`] below [`SMALLEST_EXPECTED_COUNT`]; [`Error::TotalsDiffer`] when the
/// totals differ by more than a millionth, since the number of degrees of freedom counts on their
/// agreement.
///
/// ```
/// use stosszahl_analysis::statistics::chi_squared_test;
///
/// // Mendel's peas (1866): 315, 108, 101 and 32 against 9 : 3 : 3 : 1.
/// let expected = [9.0, 3.0, 3.0, 1.0].map(|part| part * 556.0 / 16.0);
/// let test = chi_squared_test(&[315.0, 108.0, 101.0, 32.0], &expected, 0).unwrap();
/// assert!((test.statistic - 0.470_023_980_815_348).abs() < 1e-12);
/// assert_eq!(test.degrees_of_freedom, 3);
/// assert!((test.p_value - 0.925_4).abs() < 5e-5);
/// ```
#[allow(
    clippy::missing_panics_doc,
    reason = "the number of degrees of freedom was checked"
)]
pub fn chi_squared_test(
    observed: &[f64],
    expected: &[f64],
    fitted: usize,
) -> Result<ChiSquaredTest, Error> {
    let bins = observed.len();
    if bins != expected.len() {
        return Err(Error::BinsDiffer {
            observed: bins,
            expected: expected.len(),
        });
    }
    let degrees_of_freedom = bins
        .checked_sub(fitted.saturating_add(1))
        .filter(|&freedom| freedom > 0)
        .ok_or(Error::BinsTooFew { bins, fitted })?;
    let mut statistic = 0.0;
    for (bin, (&found, &expectation)) in observed.iter().zip(expected).enumerate() {
        if !(found >= 0.0 && found.is_finite()) {
            return Err(Error::ObservedInvalid { bin, found });
        }
        if !(expectation >= SMALLEST_EXPECTED_COUNT && expectation.is_finite()) {
            return Err(Error::ExpectedTooSmall {
                bin,
                found: expectation,
                allowed: SMALLEST_EXPECTED_COUNT,
            });
        }
        statistic += (found - expectation).powi(2) / expectation;
    }
    let totals = [observed.iter().sum::<f64>(), expected.iter().sum::<f64>()];
    if (totals[0] - totals[1]).abs() > TOTALS_TOLERANCE * totals[1] {
        return Err(Error::TotalsDiffer {
            observed: totals[0],
            expected: totals[1],
        });
    }
    let distribution = ChiSquared::new(degrees_of_freedom as f64)
        .expect("the number of degrees of freedom is positive");
    Ok(ChiSquaredTest {
        statistic,
        degrees_of_freedom,
        p_value: distribution.sf(statistic),
    })
}

/// Tests by chi-squared whether counts agree with bins of equal probability: [`chi_squared_test`]
/// against their mean.
///
/// # Errors
/// As [`chi_squared_test`].
pub fn uniform_test(counts: &[u64]) -> Result<ChiSquaredTest, Error> {
    let observed: Vec<f64> = counts.iter().map(|&count| count as f64).collect();
    let mean = observed.iter().sum::<f64>() / observed.len() as f64;
    chi_squared_test(&observed, &vec![mean; observed.len()], 0)
}

/// Returns true for each hypothesis that Holm's method rejects, so that any true one is rejected
/// with probability `false_alarm` at most: S. Holm, *Scandinavian Journal of Statistics* **6**, 65
/// (1979).
///
/// The p values are taken from the smallest up; the one with i smaller ones before it is rejected
/// while p ≤ `false_alarm` / (n - i), and the first that is not ends the search. The tests need not
/// be independent, and no hypothesis is treated worse than by Bonferroni's p ≤ `false_alarm` / n. A
/// p value that is not a number counts as a test and is never rejected.
///
/// ```
/// use stosszahl_analysis::statistics::holm;
///
/// assert_eq!(holm(&[0.01, 0.04, 0.03, 0.005], 0.05), [true, false, false, true]);
/// ```
pub fn holm(p_values: &[f64], false_alarm: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].abs().total_cmp(&p_values[b].abs()));
    let mut rejected = vec![false; p_values.len()];
    for (smaller, &index) in order.iter().enumerate() {
        let allowed = false_alarm / (p_values.len() - smaller) as f64;
        // A comparison with a p value that is not a number fails, and ends the search.
        if p_values[index] <= allowed {
            rejected[index] = true;
        } else {
            break;
        }
    }
    rejected
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Number of samples without an effect, from which a false-alarm rate is measured.
    const SAMPLES: usize = 4000;

    /// Checks that a false-alarm rate measured on [`SAMPLES`] samples lies within z = 4 binomial
    /// standard errors of the nominal one, which fails by chance once in 16 000 seeds.
    fn assert_rate(alarms: usize, nominal: f64) {
        let rate = alarms as f64 / SAMPLES as f64;
        let standard_error = (nominal * (1.0 - nominal) / SAMPLES as f64).sqrt();
        let z = (rate - nominal) / standard_error;
        assert!(z.abs() < 4.0, "rate {rate} against {nominal}: z = {z}");
    }

    fn normal(stream: &mut Xoshiro256PlusPlus, count: usize) -> Vec<f64> {
        (0..count).map(|_| stream.sample(StandardNormal)).collect()
    }

    fn assert_close(found: f64, wanted: f64, relative: f64) {
        assert!(
            (found - wanted).abs() <= relative * wanted.abs(),
            "{found} against {wanted}"
        );
    }

    #[test]
    fn one_replica_has_no_error() {
        let estimate = Estimate::over_replicas(&[3.5]).unwrap();
        assert_eq!(
            estimate,
            Estimate {
                value: 3.5,
                standard_error: None,
                replicas: 1
            }
        );
    }

    #[test]
    fn variance_survives_a_large_mean() {
        // 10^9 + {4, 7, 13, 16}: variance 30. Each deviation is exact to 2^-24 = 6e-8 of an ulp at
        // 10^9.
        let moments: RunningMoments = [4.0, 7.0, 13.0, 16.0].iter().map(|x| 1e9 + x).collect();
        assert_close(moments.variance().unwrap(), 30.0, 1e-6);
        assert_eq!(moments.mean(), Some(1e9 + 10.0));
    }

    #[test]
    fn student_matches_closed_forms() {
        // One degree of freedom is Cauchy: p = (2/pi) atan(1/|t|). Values -1 +- 1/t give t.
        for t in [0.5, 1.0, 10.0, 1e3, 1e6, 1e60] {
            let test = student_t_test(&[t + 1.0, t - 1.0], 0.0).unwrap();
            if t < 1e15 {
                assert_close(test.statistic, t, 1e-9);
                assert_close(
                    test.p_value,
                    std::f64::consts::FRAC_2_PI * (1.0 / t).atan(),
                    1e-9,
                );
            } else {
                assert_eq!(test.p_value, 0.0, "the two values round to the same number");
            }
        }
        // Two degrees of freedom: p = 1 - |t| / sqrt(2 + t^2), from Student's closed form; here t =
        // 2 sqrt 3.
        let test = student_t_test(&[1.0, 2.0, 3.0], 0.0).unwrap();
        assert_close(test.statistic, 12.0_f64.sqrt(), 1e-14);
        assert_close(test.p_value, 1.0 - (12.0_f64 / 14.0).sqrt(), 1e-12);
        // Tables: p = 0.05 at t = 2.262 with 9 degrees of freedom; three decimals there are 1e-3 in
        // p.
        let student = StudentsT::new(0.0, 1.0, 9.0).unwrap();
        assert_close(2.0 * student.sf(2.262), 0.05, 1e-3);
    }

    #[test]
    fn student_handles_no_variance_and_bad_input() {
        let equal = [0.1; 7];
        let test = student_t_test(&equal, 0.1).unwrap();
        assert_eq!(
            (test.statistic, test.p_value, test.normal_z),
            (0.0, 1.0, 0.0)
        );
        let test = student_t_test(&equal, 0.2).unwrap();
        assert_eq!(test.statistic, f64::NEG_INFINITY);
        assert_eq!((test.p_value, test.normal_z), (0.0, -LARGEST_NORMAL_Z));
        assert_eq!(student_t_test(&[1.0], 1.0), None);
        assert_eq!(student_t_test(&[], 1.0), None);
        assert_eq!(student_t_test(&[1.0, f64::NAN], 1.0), None);
        assert_eq!(student_t_test(&[1.0, f64::INFINITY], 1.0), None);
        assert_eq!(student_t_test(&[1.0, 2.0], f64::NAN), None);
    }

    #[test]
    fn tiny_p_values_are_not_lost() {
        // 200 values of mean 1 and spread 10^-3: t = 14 142 with 199 degrees of freedom. The tail
        // is p ~ 0.8 nu^((nu-1)/2) t^-nu, some 10^-598, which underflows; a spread of 0.1 gives
        // some 10^-201.
        let far: Vec<f64> = (0..200)
            .map(|i| 1.0 + if i % 2 == 0 { 1e-3 } else { -1e-3 })
            .collect();
        let test = student_t_test(&far, 0.0).unwrap();
        assert_eq!((test.p_value, test.normal_z), (0.0, LARGEST_NORMAL_Z));
        let near: Vec<f64> = far.iter().map(|x| 1.0 + (x - 1.0) * 100.0).collect();
        let test = student_t_test(&near, 0.0).unwrap();
        // Quoted from the incomplete beta function and the inverse of erfc at 40 digits. The values
        // are right to 2^-52, the statistic to 200 times that, and p to 199 times the statistic:
        // 10^-11.
        assert_close(test.p_value, 2.109_260_991_759_596e-201, 1e-10);
        assert_close(test.normal_z, 30.279_891_121_140_086, 1e-12);
    }

    #[test]
    fn normal_z_matches_published_quantiles() {
        // Two-sided p values of 1 to 7 standard deviations, and of 1.96; the published digits are
        // the tolerance.
        for (z, p) in [
            (1.0, 0.317_310_507_863),
            (2.0, 0.045_500_263_896),
            (3.0, 0.002_699_796_063),
            (5.0, 5.733_031_438e-7),
            (7.0, 2.559_625_088e-12),
            (1.959_963_984_540, 0.05),
        ] {
            assert_close(normal_z(p), z, 1e-9);
        }
        assert_eq!(normal_z(1.0), 0.0);
        assert!(normal_z(f64::from_bits(1)) > 38.4);
        assert_eq!(normal_z(0.0), LARGEST_NORMAL_Z);
    }

    #[test]
    fn chi_squared_matches_closed_forms() {
        // Two degrees of freedom: p = exp(-chi^2 / 2). Counts 60, 30, 30 against 40 each:
        // chi^2 = 15.
        let test = chi_squared_test(&[60.0, 30.0, 30.0], &[40.0; 3], 0).unwrap();
        assert_eq!((test.statistic, test.degrees_of_freedom), (15.0, 2));
        assert_close(test.p_value, (-7.5_f64).exp(), 1e-12);
        // One fitted parameter less: p = erfc(sqrt(chi^2 / 2)), 1.0751e-4 at 15.
        let test = chi_squared_test(&[60.0, 30.0, 30.0], &[40.0; 3], 1).unwrap();
        assert_eq!(test.degrees_of_freedom, 1);
        assert_close(
            test.p_value,
            statrs::function::erf::erfc(7.5_f64.sqrt()),
            1e-9,
        );
        // A far tail: chi^2 = 800 with two degrees of freedom is exp(-400), not 0.
        let test = chi_squared_test(&[700.0, 100.0, 100.0], &[300.0; 3], 0).unwrap();
        assert_close(test.statistic, 800.0, 1e-14);
        assert_close(test.p_value, (-400.0_f64).exp(), 1e-11);
        // Exact agreement.
        assert_eq!(uniform_test(&[50; 8]).unwrap().p_value, 1.0);
    }

    #[test]
    fn chi_squared_refuses_what_it_cannot_judge() {
        assert_eq!(
            chi_squared_test(&[1.0], &[10.0, 10.0], 0),
            Err(Error::BinsDiffer {
                observed: 1,
                expected: 2
            })
        );
        assert_eq!(
            chi_squared_test(&[10.0, 10.0], &[10.0, 10.0], 1),
            Err(Error::BinsTooFew { bins: 2, fitted: 1 })
        );
        assert_eq!(
            chi_squared_test(&[10.0; 3], &[10.0; 3], usize::MAX),
            Err(Error::BinsTooFew {
                bins: 3,
                fitted: usize::MAX
            })
        );
        assert_eq!(
            uniform_test(&[]),
            Err(Error::BinsTooFew { bins: 0, fitted: 0 })
        );
        assert_eq!(
            chi_squared_test(&[16.0, 4.0], &[16.0, 4.0], 0),
            Err(Error::ExpectedTooSmall {
                bin: 1,
                found: 4.0,
                allowed: 5.0
            })
        );
        assert!(matches!(
            chi_squared_test(&[16.0, f64::NAN], &[8.0, 8.0], 0),
            Err(Error::ObservedInvalid { bin: 1, .. })
        ));
        assert!(matches!(
            chi_squared_test(&[8.0, 8.0], &[8.0, f64::INFINITY], 0),
            Err(Error::ExpectedTooSmall { bin: 1, .. })
        ));
        assert_eq!(
            chi_squared_test(&[16.0, 16.0], &[8.0, 8.0], 0),
            Err(Error::TotalsDiffer {
                observed: 32.0,
                expected: 16.0
            })
        );
    }

    #[test]
    fn holm_steps_down() {
        // Holm's procedure rejects a second p value that Bonferroni's 0.05 / 3 would not.
        assert_eq!(holm(&[0.02, 0.01, 0.6], 0.05), [true, true, false]);
        // A first p value that stays ends the search, however the rest compare with their own
        // bounds.
        assert_eq!(holm(&[0.02, 0.02, 0.02], 0.05), [false; 3]);
        assert_eq!(holm(&[f64::NAN, 0.01], 0.05), [false, true]);
        assert_eq!(holm(&[-f64::NAN, 0.03], 0.05), [false, false]);
        assert!(holm(&[], 0.05).is_empty());
    }

    #[test]
    fn student_false_alarms_are_nominal() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(11);
        for replicas in [2, 5, 30] {
            let mut alarms = [0; 3];
            let nominal = [0.3, 0.05, 0.01];
            for _ in 0..SAMPLES {
                let values: Vec<f64> = normal(&mut stream, replicas)
                    .iter()
                    .map(|x| 7.0 + 3.0 * x)
                    .collect();
                let test = student_t_test(&values, 7.0).unwrap();
                for (count, level) in alarms.iter_mut().zip(nominal) {
                    *count += usize::from(test.p_value <= level);
                }
            }
            for (count, level) in alarms.into_iter().zip(nominal) {
                assert_rate(count, level);
            }
        }
    }

    #[test]
    fn chi_squared_false_alarms_are_nominal() {
        // 2000 counts over 20 bins; the steps of the discrete statistic move the rates by less than
        // 1e-3.
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(12);
        let nominal = [0.3, 0.05, 0.01];
        let mut alarms = [0; 3];
        for _ in 0..SAMPLES {
            let mut counts = [0_u64; 20];
            for _ in 0..2000 {
                counts[stream.random_range(0..20)] += 1;
            }
            let test = uniform_test(&counts).unwrap();
            for (count, level) in alarms.iter_mut().zip(nominal) {
                *count += usize::from(test.p_value <= level);
            }
        }
        for (count, level) in alarms.into_iter().zip(nominal) {
            assert_rate(count, level);
        }
    }

    #[test]
    fn holm_false_alarms_are_nominal() {
        // Ten true hypotheses with independent p values: the smallest decides, so that the rate of
        // any false alarm is exactly 1 - (1 - 0.05/10)^10 = 0.0489.
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(13);
        let alarms = (0..SAMPLES)
            .filter(|_| {
                let p_values: Vec<f64> = (0..10).map(|_| stream.random()).collect();
                holm(&p_values, 0.05).contains(&true)
            })
            .count();
        assert_rate(alarms, 1.0 - 0.995_f64.powi(10));
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(14), failure_persistence: None, ..ProptestConfig::default() })]

        /// Tests that Welford's update agrees with the two-pass formula. Rounding: n additions of
        /// terms no larger than the largest squared deviation, each with relative error below
        /// 2^-52, times the n of the sum.
        #[test]
        fn moments_match_two_passes(values in prop::collection::vec(-1e3_f64..1e3, 2..60)) {
            let moments: RunningMoments = values.iter().copied().collect();
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
            prop_assert!((moments.mean().unwrap() - mean).abs() <= 4.0 * n * 1e3 * f64::EPSILON);
            prop_assert!((moments.variance().unwrap() - variance).abs() <= 8.0 * n * 4e6 * f64::EPSILON);
        }

        /// Tests that mirrored values give the mirrored Student's test, bit for bit.
        #[test]
        fn student_is_odd(values in prop::collection::vec(-1e3_f64..1e3, 2..20)) {
            let mirrored: Vec<f64> = values.iter().map(|x| -x).collect();
            let test = student_t_test(&values, 0.0).unwrap();
            let mirror = student_t_test(&mirrored, 0.0).unwrap();
            prop_assert_eq!(test.p_value, mirror.p_value);
            prop_assert_eq!(test.normal_z, -mirror.normal_z);
            prop_assert!((0.0..=1.0).contains(&test.p_value));
        }

        /// Tests that Holm's method rejects all that Bonferroni's rejects, and only p values below
        /// the false-alarm rate.
        #[test]
        fn holm_lies_between_bonferroni_and_none(p_values in prop::collection::vec(0.0_f64..0.1, 0..12)) {
            let n = p_values.len() as f64;
            for (p, rejected) in p_values.iter().zip(holm(&p_values, 0.05)) {
                prop_assert!(rejected || *p > 0.05 / n);
                prop_assert!(!rejected || *p <= 0.05);
            }
        }
    }
}
