//! Random rounding of expected numbers to whole numbers, and draws of random pairs of indices.

use rand::{Rng, RngExt};

/// Rounds a mean at random to one of the two adjacent whole numbers, so that the expectation is
/// exact.
///
/// The number of candidate pairs needs the exact mean and a small variance. Poisson numbers, exact
/// for an isolated cell, increase the diffusion in cells with few partners by 0.85 over the number
/// in a cell; random rounding by half as much (`docs/development/monte-carlo.md`). Carrying the
/// remainder to the next step does as well, but must be stored.
#[inline(always)]
pub(crate) fn draw_whole(mean: f64, stream: &mut impl Rng) -> u64 {
    (mean + stream.random::<f64>()) as u64
}

/// Draws two different random indices below `count`, each pair with equal probability to
/// count^2/2^64.
#[inline(always)]
pub(crate) fn draw_pair(count: u64, stream: &mut impl Rng) -> [usize; 2] {
    // The fractional part of the first product is as random as the number it came from.
    let first = u128::from(stream.random::<u64>()) * u128::from(count);
    let second = u128::from(first as u64) * u128::from(count - 1);
    let (i, j) = ((first >> 64) as usize, (second >> 64) as usize);
    [i, j + usize::from(j >= i)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoroshiro128PlusPlus;

    /// Mean within z = 4.4 standard errors of the Bernoulli law, and results are always adjacent
    /// whole numbers.
    #[test]
    fn whole_numbers_have_the_mean_asked_for() {
        let mut stream = Xoroshiro128PlusPlus::seed_from_u64(2);
        let draws = 100_000;
        for mean in [0.0, 1e-3, 0.7, 1.6, 3.0, 20.25] {
            let below = f64::floor(mean);
            let more: f64 = (0..draws)
                .map(|_| {
                    let more = draw_whole(mean, &mut stream) as f64 - below;
                    assert!(more == 0.0 || more == 1.0);
                    more
                })
                .sum();
            let (n, share) = (f64::from(draws), mean - below);
            let error = (share * (1.0 - share) / n).sqrt();
            assert!((more / n - share).abs() <= 4.4 * error, "{mean}: {more}");
        }
        assert_eq!(draw_whole(f64::NAN, &mut stream), 0);
    }

    /// Ordered pairs of seven are equally likely: chi-squared with 41 degrees of freedom exceeds
    /// 93.2 once in 1e5.
    #[test]
    fn pairs_are_equally_likely() {
        let mut stream = Xoroshiro128PlusPlus::seed_from_u64(1);
        let mut found = [[0.0; 7]; 7];
        let draws = 420_000;
        for _ in 0..draws {
            let [i, j] = draw_pair(7, &mut stream);
            found[i][j] += 1.0;
        }
        let expected = f64::from(draws) / 42.0;
        let mut chi_squared = 0.0;
        for (i, row) in found.iter().enumerate() {
            assert_eq!(row[i], 0.0);
            let others = row.iter().enumerate().filter(|(j, _)| *j != i);
            chi_squared += others
                .map(|(_, n)| (n - expected).powi(2) / expected)
                .sum::<f64>();
        }
        assert!(chi_squared < 93.2, "{chi_squared}");
    }
}
