//! Growth and decay rates of amplitudes over replicas, by regression of each value on the one
//! before: viscosity from a shear wave, exponents of an instability, diffusion.
//!
//! An amplitude that obeys `da/dx = -rate a + noise` with noise that is independent of the past has
//! `<a(x + h) a(x)> = exp(-rate h) <a(x)²>`. Its propagator over one step is the slope of the
//! regression of each value on the one before it, through the origin, pooled over replicas, modes
//! and times. It is the maximum-likelihood estimate for Gaussian noise of constant strength. It
//! holds for amplitudes that were set from outside or are thermal noise, and that decay or grow.
//! Fits of the logarithm of the mean amplitude lost: they need a model of how the noise builds up,
//! and weights.
//!
//! Times must be evenly spaced in x, and farther apart than the gas remembers otherwise (a few
//! collisions of a particle), or early memory is taken for a rate. The variable x is the time, or
//! any function of it in which the rate is constant: the thermal path in a gas whose temperature
//! changes, `ln(1 + t/t_0)` in a cooling one, with a over the thermal speed.
//!
//! The standard error is that of the jackknife over replicas (B. Efron & C. Stein, *Annals of
//! Statistics* **9**, 586 (1981), doi:10.1214/aos/1176345462), as the estimate is a ratio.

use crate::Error;
use crate::replicas::{add_terms, of_sums};
use crate::statistics::Estimate;

/// Computes a function of sums over replicas, with its jackknife error. `sums` has the additive
/// terms of each replica, `value` is the function of their totals.
///
/// None without replicas; no error with one.
///
/// ```
/// use stosszahl_analysis::relaxation::jackknife;
///
/// // Of a mean, the jackknife error is s/√R.
/// let found = jackknife(&[[1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [6.0, 1.0]], |[sum, count]| sum / count).unwrap();
/// assert_eq!(found.value, 3.0);
/// assert!((found.standard_error.unwrap() - (14.0_f64 / 3.0 / 4.0).sqrt()).abs() < 1e-14);
/// ```
pub fn jackknife<const N: usize>(
    sums: &[[f64; N]],
    value: impl Fn([f64; N]) -> f64,
) -> Option<Estimate> {
    let replicas = sums.len();
    let total = sums.iter().copied().reduce(|mut total, terms| {
        add_terms(&mut total, &terms);
        total
    })?;
    // The mean of the pseudo-values is the value without its bias of order 1/R; their standard
    // error is the jackknife's.
    let pseudo = Estimate::over_replicas(&of_sums(sums, &value));
    Some(Estimate {
        value: value(total),
        standard_error: pseudo.and_then(|of| of.standard_error),
        replicas,
    })
}

/// Estimates the decay rate of amplitudes per unit of x (negative if they grow), from series of
/// values that are `spacing` apart.
///
/// `replicas` holds for each replica its series: one for each amplitude, real and imaginary parts
/// apart. A rate of zero mean noise would be infinite; it is then not a number.
///
/// # Errors
/// [`Error::FitImpossible`] without two values in any series, or a spacing that is not positive.
///
/// ```
/// use stosszahl_analysis::relaxation::decay_rate;
///
/// let series = vec![vec![vec![8.0, 4.0, 2.0, 1.0]], vec![vec![-4.0, -2.0, -1.0]]];
/// let rate = decay_rate(&series, 0.5)?;
/// assert!((rate.value - 2.0 * 2.0_f64.ln()).abs() < 1e-14);
/// # Ok::<(), stosszahl_analysis::Error>(())
/// ```
pub fn decay_rate(replicas: &[Vec<Vec<f64>>], spacing: f64) -> Result<Estimate, Error> {
    let sums: Vec<[f64; 2]> = replicas
        .iter()
        .map(|series| {
            let pairs = series.iter().flat_map(|values| values.windows(2));
            pairs.fold([0.0; 2], |[products, squares], pair| {
                [products + pair[0] * pair[1], squares + pair[0] * pair[0]]
            })
        })
        .collect();
    let steps: usize = replicas
        .iter()
        .flatten()
        .map(|values| values.len().saturating_sub(1))
        .sum();
    if steps == 0 || !crate::error::is_positive(spacing) {
        return Err(Error::FitImpossible {
            found: steps,
            needed: 1,
        });
    }
    jackknife(&sums, |[products, squares]| {
        -(products / squares).ln() / spacing
    })
    .ok_or(Error::FitImpossible {
        found: 0,
        needed: 1,
    })
}

/// Computes the self-diffusion coefficient `(<R²(t_2)> - <R²(t_1)>)/(2 D (t_2 - t_1))` in the plane
/// (D = 2) over replicas. Each replica gives the mean squared displacement \[length²\] at both
/// times. `None` without replicas.
///
/// Both times must be long after the velocities of the start are forgotten: the displacement then
/// grows by a line.
pub fn diffusion(squares: &[[f64; 2]], times: [f64; 2]) -> Option<Estimate> {
    let slopes: Vec<f64> = squares
        .iter()
        .map(|square| (square[1] - square[0]) / (4.0 * (times[1] - times[0])))
        .collect();
    Estimate::over_replicas(&slopes)
}

/// Computes the fourth cumulant a2 of particles in the plane, `<v⁴>/(2 <v²>²) - 1`, without the
/// bias of a finite number of particles with zero momentum: `(1 + a2) N/(N - 1) - 1`.
///
/// N velocities of fixed energy and momentum lie on a sphere of n = 2 (N - 1) dimensions, where
/// `<v⁴>/(2 <v²>²)` of a Maxwellian is n/(n + 2) = (N - 1)/N. Both `<v⁴>` and `<v²>` are means over
/// the N particles.
///
/// ```
/// // A sphere of two dimensions: two particles of opposite velocity, whose speed is always the same.
/// assert_eq!(stosszahl_analysis::relaxation::unbiased_cumulant(-0.5, 2), 0.0);
/// ```
pub fn unbiased_cumulant(fourth_cumulant: f64, particles: usize) -> f64 {
    let others = particles.saturating_sub(1).max(1) as f64;
    (1.0 + fourth_cumulant) * (1.0 + others.recip()) - 1.0
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::*;
    use crate::statistics::RunningMoments;
    use rand::{Rng, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn normal(stream: &mut impl Rng) -> f64 {
        StandardNormal.sample(stream)
    }

    /// Tests that amplitudes that grow or decay, set from outside or thermal, have their known rate
    /// within 4.4 standard errors (false alarm 1e-5 each). These are small enough to see 7 %. Over
    /// repeated experiments the scatter is the jackknife's error within a quarter (4.4 standard
    /// errors of 160 variances).
    #[test]
    fn known_rates_are_found() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(2);
        let spacing = 0.2_f64;
        for (rate, start, noise) in [(1.0_f64, 0.0, 1.0), (1.0, 10.0, 1.0), (-0.8, 3.0, 0.3)] {
            let [mut errors, mut found] = [RunningMoments::default(); 2];
            for _ in 0..160 {
                let replicas: Vec<_> = (0..16)
                    .map(|_| {
                        let series = |_| {
                            let factor: f64 = (-rate * spacing).exp();
                            let mut value = start + normal(&mut stream);
                            let mut next = || {
                                let now = value;
                                value = factor * value + noise * normal(&mut stream);
                                now
                            };
                            (0..8).map(|_| next()).collect()
                        };
                        (0..4).map(series).collect()
                    })
                    .collect();
                let estimate = decay_rate(&replicas, spacing).unwrap();
                errors.add(estimate.standard_error.unwrap().powi(2));
                found.add(estimate.value);
            }
            let [mean, error] = [found.mean().unwrap(), found.standard_error().unwrap()];
            assert!(error < 0.07 / 4.4, "{error}");
            // The logarithm of a noisy propagator b is off by half its relative variance.
            let single = found.variance().unwrap();
            let bias = 0.5 * single * spacing;
            assert!(
                (mean - rate).abs() < 4.4 * error + bias,
                "{rate}: {mean} {error}"
            );
            let ratio = errors.mean().unwrap() / single;
            assert!(
                (ratio - 1.0).abs() < 4.4 * (2.0 / 160.0_f64).sqrt(),
                "{ratio}"
            );
        }
    }

    #[test]
    fn diffusion_of_a_random_walk() {
        // <R²> = 4 D t with D = 0.7, after an offset that a slope does not see.
        let squares = [[2.0 + 2.8, 2.0 + 8.4], [1.0 + 2.8, 1.0 + 8.4]];
        let found = diffusion(&squares, [1.0, 3.0]).unwrap();
        assert!((found.value - 0.7).abs() < 1e-14);
        assert!(diffusion(&[], [1.0, 2.0]).is_none());
    }

    /// Tests that Maxwellian samples without mean velocity have no cumulant: 40 000 of 12
    /// particles; 4.4 standard errors, small enough to see a tenth of the correction 1/N.
    #[test]
    fn few_maxwellian_particles_have_no_cumulant() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut moments = RunningMoments::default();
        for _ in 0..40_000 {
            let mut velocities: Vec<[f64; 2]> = (0..12)
                .map(|_| [0, 1].map(|_| normal(&mut stream)))
                .collect();
            for axis in [0, 1] {
                let mean = velocities.iter().map(|v| v[axis]).sum::<f64>() / 12.0;
                for velocity in &mut velocities {
                    velocity[axis] -= mean;
                }
            }
            let squares = velocities.iter().map(|v| v[0] * v[0] + v[1] * v[1]);
            let (second, fourth) = squares.fold((0.0, 0.0), |sums, square| {
                (sums.0 + square / 12.0, sums.1 + square * square / 12.0)
            });
            let raw = fourth / (2.0 * second * second) - 1.0;
            moments.add(unbiased_cumulant(raw, 12));
        }
        let [mean, error] = [moments.mean().unwrap(), moments.standard_error().unwrap()];
        assert!(
            error < 0.1 / 12.0 / 4.4 && mean.abs() < 4.4 * error,
            "{mean} {error}"
        );
    }

    #[test]
    fn nothing_to_fit_is_refused() {
        assert!(decay_rate(&[], 1.0).is_err());
        assert!(decay_rate(&[vec![vec![1.0]]], 1.0).is_err());
        assert!(decay_rate(&[vec![vec![1.0, 0.5]]], 0.0).is_err());
    }
}
