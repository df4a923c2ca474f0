//! Statistical tests over independent replicas (Student, Hotelling, jackknife), and the number of
//! replicas that an effect needs.
//!
//! Collisions of one gas are correlated: a cluster, or a shear wave, changes the impact parameters
//! of all its collisions. So counts are never judged as if they were independent events; each
//! replica gives one value, and values are judged by Student's distribution ([`quantile`]), several
//! at once by Hotelling's ([`hotelling_test`]). Both are exact for normal values, whatever the
//! spread within a replica is.
//!
//! Chi-squared of pooled counts over the measured over-dispersion lost: it takes all shapes to be
//! equally over-dispersed. Where one of them dominates, as in clusters, its F test at 1 % with four
//! replicas and 18 shapes gives a false alarm in up to 23 % of all gases.
//!
//! Values that are no sums, such as ratios of means, enter as pseudo-values of the jackknife
//! ([`pseudo_values`]).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

use crate::statistics::Estimate;

/// Computes the pseudo-values of the jackknife, `R θ - (R - 1) θ₍₋ᵢ₎`, of a function θ of sums: one
/// for each replica. Their mean and standard error are those of θ. `add` adds a term to a sum, and
/// `of` is θ.
///
/// The mean is free of the bias of order 1/R that a ratio of means has, which a mean of ratios has
/// in full: J. W. Tukey, *Annals of Mathematical Statistics* **29**, 614 (1958). One replica has
/// the value of the function itself.
///
/// Sums without one replica are put together from those of the replicas before and after it, so
/// that thousands of replicas take thousands of additions, not millions.
///
/// ```
/// use stosszahl_analysis::replicas::pseudo_values;
///
/// // Of a mean, pseudo-values are the values.
/// let values = [1.0, 2.0, 6.0];
/// let terms = values.map(|value| (value, 1.0));
/// let add = |sum: &mut (f64, f64), term: &(f64, f64)| *sum = (sum.0 + term.0, sum.1 + term.1);
/// let mean = |sum: &(f64, f64)| sum.0 / sum.1;
/// for (pseudo, value) in pseudo_values(&terms, add, mean).into_iter().zip(values) {
///     assert!((pseudo - value).abs() < 1e-14);
/// }
/// ```
pub fn pseudo_values<T: Clone>(
    terms: &[T],
    add: impl Fn(&mut T, &T),
    of: impl Fn(&T) -> f64,
) -> Vec<f64> {
    let plus = |sum: Option<&T>, term: &T| {
        let Some(mut sum) = sum.cloned() else {
            return term.clone();
        };
        add(&mut sum, term);
        sum
    };
    // Sums of the last one, two and so on.
    let mut after: Vec<T> = Vec::with_capacity(terms.len());
    for term in terms.iter().rev() {
        after.push(plus(after.last(), term));
    }
    let Some(whole) = after.pop().map(|all| of(&all)) else {
        return Vec::new();
    };
    let count = terms.len() as f64;
    let mut before: Option<T> = None;
    let one = |term: &T| {
        let rest = match (&before, after.pop()) {
            (Some(before), Some(after)) => Some(plus(Some(before), &after)),
            (before, after) => after.or_else(|| before.clone()),
        };
        before = Some(plus(before.as_ref(), term));
        rest.map_or(whole, |rest| count * whole - (count - 1.0) * of(&rest))
    };
    terms.iter().map(one).collect()
}

/// Computes jackknife pseudo-values of the function `of` of N sums, given the sums of each replica.
pub fn of_sums<const N: usize>(sums: &[[f64; N]], of: impl Fn([f64; N]) -> f64) -> Vec<f64> {
    pseudo_values(sums, add_terms, |sums| of(*sums))
}

/// Adds the values of one replica, component by component, to sums over replicas from which a
/// jackknife estimate is made.
pub(crate) fn add_terms<const N: usize>(sums: &mut [f64; N], terms: &[f64; N]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}

/// Computes the jackknife estimate of the ratio of the means of paired values, with its standard
/// error; `None` without pairs.
///
/// ```
/// use stosszahl_analysis::replicas::ratio_of_means;
///
/// let found = ratio_of_means(&[(1.0, 2.0), (3.0, 6.0)]).unwrap();
/// assert!((found.value - 0.5).abs() < 1e-15 && found.standard_error.unwrap() < 1e-15);
/// ```
pub fn ratio_of_means(pairs: &[(f64, f64)]) -> Option<Estimate> {
    let sums: Vec<[f64; 2]> = pairs.iter().map(|&(a, b)| [a, b]).collect();
    Estimate::over_replicas(&of_sums(&sums, |[a, b]| a / b))
}

/// Computes the half width of a two-sided confidence interval in standard errors: Student's
/// quantile, or the normal one without degrees of freedom given. Infinite for zero degrees of
/// freedom.
///
/// ```
/// use stosszahl_analysis::replicas::quantile;
///
/// assert!((quantile(0.05, None) - 1.959_964).abs() < 1e-6);
/// // Student's of one degree of freedom is tan(pi/2 (1 - level)).
/// assert!((quantile(0.5, Some(1)) - 1.0).abs() < 1e-9);
/// assert_eq!(quantile(0.5, Some(0)), f64::INFINITY);
/// ```
pub fn quantile(level: f64, degrees_of_freedom: Option<usize>) -> f64 {
    match degrees_of_freedom {
        None => Normal::new(0.0, 1.0).map(|normal| normal.inverse_cdf(0.5 * level)),
        Some(freedom) => {
            let student =
                StudentsT::new(0.0, 1.0, freedom as f64).map(|t| t.inverse_cdf(0.5 * level));
            return student.map_or(f64::INFINITY, f64::abs);
        }
    }
    .map_or(f64::INFINITY, f64::abs)
}

/// Outcome of Hotelling's test of several means, [`hotelling_test`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotellingTest {
    /// Hotelling's statistic `T² = R m' S⁻¹ m`, of the mean m and the covariance S over R replicas.
    pub statistic: f64,
    /// Number of means that are tested at once.
    pub numbers: usize,
    /// Probability of a statistic at least this large if all means are zero.
    pub p_value: f64,
}

/// Tests whether the means of several normal numbers, correlated in any way, can all be zero: H.
/// Hotelling, *Annals of Mathematical Statistics* **2**, 360 (1931), doi:10.1214/aoms/1177732979.
/// With q numbers and R replicas, `(R - q)/(q (R - 1)) T²` has the distribution F(q, R - q). `rows`
/// has the numbers of each replica.
///
/// `None` unless there are more replicas than numbers, and their covariance is regular.
///
/// ```
/// use stosszahl_analysis::replicas::hotelling_test;
/// use stosszahl_analysis::statistics::student_t_test;
///
/// // Of one number it is Student's test.
/// let test = hotelling_test(&[vec![1.0], vec![2.0], vec![4.0]]).unwrap();
/// let student = student_t_test(&[1.0, 2.0, 4.0], 0.0).unwrap();
/// assert!((test.p_value - student.p_value).abs() < 1e-12);
/// ```
pub fn hotelling_test(rows: &[Vec<f64>]) -> Option<HotellingTest> {
    let (replicas, numbers) = (rows.len(), rows.first()?.len());
    if numbers == 0 || replicas <= numbers {
        return None;
    }
    let count = replicas as f64;
    let all = DMatrix::from_fn(replicas, numbers, |row, column| rows[row][column]);
    let mean = DVector::from_fn(numbers, |column, _| all.column(column).sum() / count);
    let deviations = DMatrix::from_fn(replicas, numbers, |row, column| {
        all[(row, column)] - mean[column]
    });
    let covariance = deviations.transpose() * deviations / (count - 1.0);
    let statistic = count * mean.dot(&covariance.cholesky()?.solve(&mean));
    let (q, free) = (numbers as f64, count - numbers as f64);
    let distribution = FisherSnedecor::new(q, free).ok()?;
    let scaled = statistic * free / (q * (count - 1.0));
    statistic.is_finite().then(|| HotellingTest {
        statistic,
        numbers,
        p_value: distribution.sf(scaled),
    })
}

/// Number of quadrature points over the sample standard deviation in [`power`].
const SPREADS: usize = 400;

/// Computes the power of Student's test: the probability that it finds an effect, given in standard
/// deviations of one replica. It is that of the non-central t distribution, `∫ P(|z + effect √R| >
/// t s) dP(s)` over the sample spread s.
///
/// ```
/// use stosszahl_analysis::replicas::power;
///
/// // Without an effect, it is the chance of a false alarm.
/// assert!((power(0.0, 4, 0.01) - 0.01).abs() < 2e-4);
/// // Tables: two-sided at 5 %, ten values, one standard deviation: 0.803.
/// assert!((power(1.0, 10, 0.05) - 0.803).abs() < 2e-3);
/// ```
pub fn power(effect: f64, replicas: usize, level: f64) -> f64 {
    power_within(&limits(replicas, level), effect, replicas)
}

/// Computes the thresholds of Student's test on a mean, in true standard errors, at equally
/// probable sample standard deviations.
fn limits(replicas: usize, level: f64) -> Vec<f64> {
    let freedom = replicas.saturating_sub(1);
    let Ok(squares) = ChiSquared::new(freedom as f64) else {
        return Vec::new();
    };
    let far = quantile(level, Some(freedom));
    let at = |point: usize| {
        let share = (point as f64 + 0.5) / SPREADS as f64;
        far * (squares.inverse_cdf(share) / freedom as f64).sqrt()
    };
    (0..SPREADS).map(at).collect()
}

/// Computes [`power`] from the thresholds of [`limits`], which are the costly part.
fn power_within(limits: &[f64], effect: f64, replicas: usize) -> f64 {
    let Ok(normal) = Normal::new(0.0, 1.0) else {
        return 0.0;
    };
    let shift = effect.abs() * (replicas as f64).sqrt();
    let found = |limit: &f64| normal.sf(limit - shift) + normal.sf(limit + shift);
    limits.iter().map(found).sum::<f64>() / SPREADS as f64
}

/// Computes the smallest effect, in standard deviations of one replica, that Student's test finds
/// with probability `found`; infinite for fewer than two replicas.
pub fn smallest_effect(replicas: usize, level: f64, found: f64) -> f64 {
    if replicas < 2 {
        return f64::INFINITY;
    }
    let limits = limits(replicas, level);
    let power = |effect| power_within(&limits, effect, replicas);
    let mut high = 1.0;
    while power(high) < found {
        high *= 2.0;
    }
    let mut low = 0.0;
    while high - low > 1e-4 * high {
        let middle = 0.5 * (low + high);
        if power(middle) < found {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Largest number of replicas that [`replicas_needed`] returns.
pub const MOST_REPLICAS: usize = 1_000_000;

/// Returns the fewest replicas with which Student's test finds an effect, given in standard
/// deviations of one replica, with probability `found`; at most [`MOST_REPLICAS`].
///
/// ```
/// use stosszahl_analysis::replicas::{power, replicas_needed};
///
/// let needed = replicas_needed(1.5, 0.01, 0.9);
/// assert!(power(1.5, needed, 0.01) >= 0.9 && power(1.5, needed - 1, 0.01) < 0.9);
/// ```
pub fn replicas_needed(effect: f64, level: f64, found: f64) -> usize {
    let enough = |replicas: usize| power(effect, replicas, level) >= found;
    // Gauss's law says how many if the spread is known; that it is found too costs a few more.
    let reach = quantile(level, None) + quantile(2.0 * (1.0 - found), None);
    let known = (reach / effect).powi(2).min(MOST_REPLICAS as f64) as usize;
    let mut low = known.saturating_sub(1).max(1);
    if enough(low) {
        low = 1;
    }
    let (mut high, mut step) = (low + 1, 1);
    while !enough(high) {
        if high >= MOST_REPLICAS {
            return MOST_REPLICAS;
        }
        step *= 2;
        (low, high) = (high, (high + step).min(MOST_REPLICAS));
    }
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        if enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Computes components of Neyman's smooth test: means of polynomials of the bin number, orthonormal
/// for the bin probabilities `chances`. All are zero on average if counts follow the probabilities;
/// for n independent events each has the variance 1/n. The first is the trend, the second the
/// curvature and so on: Legendre's for equal probabilities (J. Neyman, *Skandinavisk
/// Aktuarietidskrift* **20**, 149 (1937)).
pub fn shape(counts: &[u64], chances: &[f64], orders: usize) -> Vec<f64> {
    let bins = chances.len();
    let total = counts.iter().sum::<u64>().max(1) as f64;
    let dot = |a: &[f64], b: &[f64]| -> f64 {
        let terms = a.iter().zip(b).zip(chances);
        terms.map(|((x, y), chance)| x * y * chance).sum()
    };
    let mut found: Vec<Vec<f64>> = vec![vec![1.0; bins]];
    for _ in 0..orders.min(bins.saturating_sub(1)) {
        // The next power is the last polynomial times the place, which keeps rounding away from
        // high orders.
        let last = &found[found.len() - 1];
        let place = |bin: usize| (2 * bin + 1) as f64 / bins as f64 - 1.0;
        let mut next: Vec<f64> = (0..bins).map(|bin| last[bin] * place(bin)).collect();
        for known in &found {
            let along = dot(&next, known);
            for (value, known) in next.iter_mut().zip(known) {
                *value -= along * known;
            }
        }
        let size = dot(&next, &next).sqrt();
        for value in &mut next {
            *value /= size;
        }
        found.push(next);
    }
    let mean = |polynomial: &Vec<f64>| {
        let terms = polynomial.iter().zip(counts);
        terms
            .map(|(value, &count)| value * count as f64)
            .sum::<f64>()
            / total
    };
    found[1..].iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::student_t_test;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Against sums that leave one out in the plain way; rounding is that of sums of a hundred
    /// terms, a hundredfold in pseudo-values.
    #[test]
    fn pseudo_values_are_those_of_plain_sums() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(12);
        for replicas in [0, 1, 2, 3, 100] {
            let terms: Vec<[f64; 2]> = (0..replicas)
                .map(|_| [stream.random(), 1.0 + stream.random::<f64>()])
                .collect();
            let ratio = |[a, b]: [f64; 2]| a / b;
            let without = |left_out: usize| {
                let kept = (0..replicas).filter(|&index| index != left_out);
                ratio(kept.fold([0.0; 2], |sum, index| {
                    [sum[0] + terms[index][0], sum[1] + terms[index][1]]
                }))
            };
            let count = replicas as f64;
            let plain = (0..replicas).map(|index| match replicas {
                1 => without(replicas),
                _ => count * without(replicas) - (count - 1.0) * without(index),
            });
            let found = of_sums(&terms, ratio);
            assert_eq!(found.len(), replicas);
            for (found, plain) in found.into_iter().zip(plain) {
                let rounding = 100.0 * count * f64::EPSILON;
                assert!((found - plain).abs() <= rounding, "{found} {plain}");
            }
        }
    }

    /// Against counting one by one; where hardly anything is needed, and where far more than is
    /// counted to.
    #[test]
    fn the_fewest_replicas_are_those_of_a_plain_count() {
        for (effect, level, found) in [
            (0.5, 0.01, 0.9),
            (1.0, 1e-4, 0.5),
            (3.0, 0.05, 0.99),
            (2.0, 0.5, 0.51),
            (50.0, 0.1, 0.6),
        ] {
            let plain = (2..100).find(|&count| power(effect, count, level) >= found);
            let fast = replicas_needed(effect, level, found);
            assert_eq!(Some(fast), plain, "{effect} {level} {found}");
        }
        for effect in [0.0, 1e-5, f64::NAN] {
            assert_eq!(replicas_needed(effect, 0.01, 0.9), MOST_REPLICAS);
        }
    }

    /// Checks that a rate is within four binomial errors of a chance; that fails by chance once in
    /// 16 000 seeds.
    fn assert_rate(found: usize, of: usize, chance: f64) {
        let error = (chance * (1.0 - chance) / of as f64).sqrt();
        let rate = found as f64 / of as f64;
        assert!(
            (rate - chance).abs() < 4.0 * error,
            "{rate} against {chance}"
        );
    }

    /// Three correlated numbers of very different spreads: one in a hundred tests at 1 % gives a
    /// false alarm.
    #[test]
    fn hotelling_rings_at_its_level_whatever_the_covariance() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(3);
        for replicas in [4, 7, 20] {
            let rings = (0..4000).filter(|_| {
                let row = |_| {
                    let [a, b, c]: [f64; 3] =
                        std::array::from_fn(|_| stream.sample(StandardNormal));
                    vec![10.0 * a, a + 0.1 * b, b - 0.01 * c]
                };
                let rows: Vec<Vec<f64>> = (0..replicas).map(row).collect();
                hotelling_test(&rows).is_some_and(|test| test.p_value <= 0.01)
            });
            assert_rate(rings.count(), 4000, 0.01);
        }
        assert_eq!(hotelling_test(&[vec![1.0, 2.0], vec![2.0, 1.0]]), None);
        assert_eq!(hotelling_test(&[]), None);
    }

    /// The stated power against tests that are made; 4000 of them see a difference of 2 %.
    #[test]
    fn power_is_the_share_of_tests_that_find_the_effect() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(4);
        for (replicas, level) in [(2, 0.2), (4, 0.01), (12, 0.001)] {
            let effect = smallest_effect(replicas, level, 0.7);
            let finds = (0..4000).filter(|_| {
                let values: Vec<f64> = (0..replicas)
                    .map(|_| effect + stream.sample::<f64, _>(StandardNormal))
                    .collect();
                student_t_test(&values, 0.0).is_some_and(|test| test.p_value <= level)
            });
            assert_rate(finds.count(), 4000, 0.7);
        }
        assert_eq!(smallest_effect(1, 0.01, 0.9), f64::INFINITY);
        assert_eq!(power(3.0, 1, 0.01), 0.0);
    }

    /// A ratio of means does not know the bias of a mean of ratios: of a = 1 and b uniform in 0.5
    /// to 1.5 the latter is ln 3 = 1.099, the former 1 within four standard errors.
    #[test]
    fn ratios_are_of_means() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
        let pairs: Vec<(f64, f64)> = (0..400)
            .map(|_| (1.0, 0.5 + stream.random::<f64>()))
            .collect();
        let found = ratio_of_means(&pairs).expect("pairs");
        let error = found.standard_error.expect("an error");
        assert!(
            (found.value - 1.0).abs() < 4.0 * error && error < 0.02,
            "{found:?}"
        );
        // Spread of b is 1/sqrt(12): the error is that over sqrt(400), known to 1/sqrt(2 * 400) of
        // itself, four times.
        assert!((error * 20.0 * 12.0_f64.sqrt() - 1.0).abs() < 0.15);
    }

    /// A straight density has a trend and nothing else: 12 steps of rounding at most of 2^-52 each.
    #[test]
    fn shapes_tell_trend_from_curvature() {
        let counts: Vec<u64> = (0..20).map(|bin| 1000 + 10 * bin).collect();
        let found = shape(&counts, &[0.05; 20], 6);
        assert!(found[0] > 0.0);
        assert!(
            found[1..].iter().all(|value| value.abs() < 1e-13),
            "{found:?}"
        );
        // Chances of spheres, and counts that follow them.
        let chances: Vec<f64> = (0..20).map(|bin| f64::from(2 * bin + 1) / 400.0).collect();
        let counts: Vec<u64> = (0..20).map(|bin| 2 * bin + 1).collect();
        assert!(
            shape(&counts, &chances, 6)
                .iter()
                .all(|value| value.abs() < 1e-13)
        );
        assert_eq!(shape(&[1, 2], &[0.5; 2], 6).len(), 1);
    }
}
