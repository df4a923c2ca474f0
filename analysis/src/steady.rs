//! Detection of the time after which a flow is steady, by the marginal standard error rule.
//!
//! The marginal standard error rule (White, *Simulation* 69, 323 (1997),
//! doi:10.1177/003754979706900601): the beginning left out is the one after which the standard
//! error of the mean of the remaining values, taken as if they were independent, is smallest. A
//! drift makes the sum of squares grow faster than the number that it is divided by.

/// Computes the number of initial values to discard from a series, at most half; `None` if the
/// series is not steady. Then the series is too short, or the best choice discards as many as
/// allowed.
///
/// Values are averaged in groups of five, as in the MSER-5 variant (White, Cobb & Spratt 2000),
/// which keeps a few equal values from looking steady.
pub fn beginning(series: &[f64]) -> Option<usize> {
    const GROUP: usize = 5;
    let means: Vec<f64> = series
        .chunks_exact(GROUP)
        .map(|group| group.iter().sum::<f64>() / GROUP as f64)
        .collect();
    let n = means.len();
    if n < 4 || !means.iter().all(|value| value.is_finite()) {
        return None;
    }
    // From the end, so that sums are built once.
    let (mut count, mut mean, mut squares) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut best: Option<(f64, usize)> = None;
    for (index, &value) in means.iter().enumerate().rev() {
        count += 1.0;
        let step = value - mean;
        mean += step / count;
        squares += step * (value - mean);
        // Few values may be equal by chance, so the last half always stays.
        if 2 * index <= n {
            let statistic = squares / (count * count);
            if best.is_none_or(|(least, _)| statistic <= least) {
                best = Some((statistic, index));
            }
        }
    }
    let (_, index) = best?;
    (20 * index < 9 * n).then_some(index * GROUP)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..count)
            .map(|_| StandardNormal.sample(&mut stream))
            .collect()
    }

    /// A relaxation with time 20 that begins thirty standard deviations away is left out until it
    /// is a standard deviation or less: noise alone mostly loses little; a drift is never steady.
    /// The rule is right for nine series in ten.
    #[test]
    fn finds_where_the_relaxation_ends() {
        let (mut found, mut whole) = (0, 0);
        for seed in 0..100 {
            let plain = noise(400, seed);
            let relaxing: Vec<f64> = (plain.iter().enumerate())
                .map(|(i, noise)| noise + 30.0 * (-(i as f64) / 20.0).exp())
                .collect();
            if let Some(begin) = beginning(&relaxing) {
                assert!((40..=200).contains(&begin), "{seed}: {begin}");
                found += 1;
            }
            whole += usize::from(beginning(&plain).is_some_and(|begin| begin <= 100));
            let drifting: Vec<f64> = (plain.iter().enumerate())
                .map(|(i, noise)| noise + 0.5 * i as f64)
                .collect();
            assert_eq!(beginning(&drifting), None, "{seed}");
        }
        assert!(found >= 85 && whole >= 75, "{found} {whole}");
        assert_eq!(beginning(&[1.0; 10]), None);
        assert_eq!(beginning(&[f64::NAN; 100]), None);
        assert_eq!(beginning(&[2.0; 100]), Some(0));
    }
}
