//! The number of trials in a cell.

use rand::{Rng, RngExt};

/// Largest mean that is drawn at once.
const PART: f64 = 8.0;

/// A number from the Poisson distribution with the given mean, exactly to the rounding of [`exponential`].
///
/// By inversion, which takes one random number and a few additions where the mean is small, as it is here; a large
/// mean is the sum of small ones. The number of trials must follow this law for the law of collisions to hold in each
/// cell by itself: a fixed number with a carried remainder has the right mean, but couples each step to the last.
#[inline]
pub(crate) fn poisson(mean: f64, stream: &mut impl Rng) -> u64 {
    let mut total = 0;
    let mut left = mean;
    while left > 0.0 {
        let part = if left < PART { left } else { PART };
        total += inversion(part, stream.random());
        left -= part;
    }
    total
}

/// The smallest k for which the sum of the first k + 1 probabilities exceeds `uniform`.
#[inline]
fn inversion(mean: f64, uniform: f64) -> u64 {
    let mut probability = exponential(mean);
    let mut left = uniform - probability;
    let mut number = 0;
    // At the mean 8, the probability of more than 63 is below 1e-36.
    while left >= 0.0 && number < 63 {
        number += 1;
        probability *= mean * RECIPROCALS[number];
        left -= probability;
    }
    number as u64
}

/// 1/k; zero for k = 0, which is not used.
const RECIPROCALS: [f64; 64] = {
    let mut table = [0.0; 64];
    let mut k = 1;
    while k < 64 {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// exp(-x) for x from 0 to 8, to 2e-12: the mathematical library's differs from system to system, and with it the
/// bytes of a run would.
#[inline]
fn exponential(x: f64) -> f64 {
    // Taylor's series at x/64, at most 1/8, up to the eighth power; and the 64th power of it.
    let y = x * (1.0 / 64.0);
    let square = y * y;
    let fourth = square * square;
    let low = (1.0 - y) + square * (0.5 - y * (1.0 / 6.0));
    let high = (1.0 / 24.0 - y * (1.0 / 120.0)) + square * (1.0 / 720.0 - y * (1.0 / 5040.0));
    let mut power = low + fourth * (high + fourth * (1.0 / 40320.0));
    for _ in 0..6 {
        power *= power;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoroshiro128PlusPlus;

    #[test]
    fn exponential_is_the_library_s() {
        for i in 0..=800 {
            let x = f64::from(i) / 100.0;
            let error = exponential(x) / (-x).exp() - 1.0;
            assert!(error.abs() < 2e-12, "{x}: {error}");
        }
    }

    /// Frequencies against the exact law for small, middle and divided means; chi-squared of the classes that expect
    /// at least ten, at z = 4.4 (false alarm 1e-5).
    #[test]
    fn numbers_follow_the_law() {
        let mut stream = Xoroshiro128PlusPlus::seed_from_u64(3);
        let count = 400_000;
        for mean in [0.01, 0.7, 1.6, 7.9, 8.0, 20.5] {
            let mut found = [0_u32; 128];
            for _ in 0..count {
                found[poisson(mean, &mut stream) as usize] += 1;
            }
            let (mut chi_squared, mut classes) = (0.0, 0.0);
            let (mut probability, mut rest, mut seen) = (f64::exp(-mean), 1.0, 0);
            for (k, &number) in found.iter().enumerate() {
                let expected = f64::from(count) * probability;
                if expected >= 10.0 {
                    chi_squared += (f64::from(number) - expected).powi(2) / expected;
                    classes += 1.0;
                    rest -= probability;
                    seen += number;
                }
                probability *= mean / (k + 1) as f64;
            }
            let expected = f64::from(count) * rest.max(1e-5);
            chi_squared += (f64::from(count as u32 - seen) - expected).powi(2) / expected;
            // Wilson & Hilferty: the cube root is nearly normal; the classes left over are one more.
            let share: f64 = 2.0 / (9.0 * classes);
            let z = ((chi_squared / classes).cbrt() - (1.0 - share)) / share.sqrt();
            assert!(z < 4.4, "mean {mean}: chi^2 {chi_squared} of {classes}");
        }
        assert_eq!(poisson(0.0, &mut stream), 0);
        assert_eq!(poisson(f64::NAN, &mut stream), 0);
    }
}
