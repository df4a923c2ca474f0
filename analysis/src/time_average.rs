//! Standard errors of time averages over correlated samples, by joining blocks until the error no
//! longer grows, and by replicas.
//!
//! Values at neighbouring times are correlated, so short blocks of time give errors that are too
//! small. Blocks are joined two by two until the error no longer grows: they are then longer than
//! the correlation time (H. Flyvbjerg & H. G. Petersen, *Journal of Chemical Physics* **91**, 461
//! (1989), doi:10.1063/1.457480). The last step joins all blocks of each replica, which is the
//! spread over replicas. A gas that remembers its start longer than it runs has no other error.

use std::ops::Range;

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Smallest number of joined blocks, in all replicas together, from which an error is computed.
const FEWEST: usize = 4;
/// Number of joined blocks, in all replicas together, that give a reliable standard error. The
/// largest of such errors over several block lengths is then hardly too large.
const MANY: usize = 16;
/// Probability that uncorrelated blocks seem correlated, for each block length tested.
const FALSE_ALARM: f64 = 0.05;
/// Error probability of the test for further growth of the error, once blocks are known to be
/// correlated.
const DOUBT: f64 = 0.3;

/// Standard errors of time averages of N quantities at several points or bins.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeErrors<const N: usize> {
    /// Standard errors of the averages by point or bin; NaN if fewer than two blocks have a value.
    pub standard_errors: Vec<[f64; N]>,
    /// Number of independent parts behind the errors of each quantity: blocks longer than the
    /// correlation time, or else replicas. Student's intervals have one degree of freedom less.
    pub parts: [usize; N],
}

impl<const N: usize> TimeErrors<N> {
    /// Computes the standard errors of averages over `replicas` replicas, each of `blocks` blocks
    /// of equal time. `averages` are the averages over all of them, by point or bin. `part` returns
    /// the values at a point in some blocks of a replica: `None`, or NaN for a quantity, if
    /// unknown.
    ///
    /// The error at a point is the largest of the errors over at least 16 blocks, over the blocks
    /// that are long enough for the quantity at all points together, and over replicas.
    ///
    /// ```
    /// use stosszahl_analysis::time_average::TimeErrors;
    ///
    /// // Two replicas of four blocks, each with a value of its own.
    /// let found = TimeErrors::new([2, 4], &[[2.0]], |_, replica, _| Some([1.0 + 2.0 * replica as f64]));
    /// assert_eq!((found.standard_errors[0][0], found.parts), (1.0, [2]));
    /// ```
    pub fn new(
        [replicas, blocks]: [usize; 2],
        averages: &[[f64; N]],
        part: impl Fn(usize, usize, Range<usize>) -> Option<[f64; N]>,
    ) -> Self {
        let levels: Vec<Level<N>> = block_divisions(replicas, blocks)
            .into_iter()
            .map(|each| {
                let joined = |index: usize| index * blocks / each..(index + 1) * blocks / each;
                let square = |(place, average): (usize, &[f64; N])| {
                    let all = (0..replicas).flat_map(|replica| {
                        let part = &part;
                        (0..each).filter_map(move |index| part(place, replica, joined(index)))
                    });
                    squared_errors(all, average)
                };
                Level {
                    parts: replicas * each,
                    squares: averages.iter().enumerate().map(square).collect(),
                }
            })
            .collect();
        let long_enough: [usize; N] =
            std::array::from_fn(|quantity| long_enough(&levels, quantity));
        let last = levels.len().saturating_sub(1);
        let counts = |level: usize, quantity: usize| {
            let over_replicas = replicas > 1 && level == last;
            level == long_enough[quantity] || over_replicas || levels[level].parts >= MANY
        };
        let largest = |place: usize, quantity: usize| {
            (0..levels.len())
                .filter(|&level| counts(level, quantity))
                .map(|level| levels[level].squares[place][quantity])
                .filter(|square| square.is_finite())
                .reduce(f64::max)
                .map_or(f64::NAN, f64::sqrt)
        };
        Self {
            standard_errors: (0..averages.len())
                .map(|place| std::array::from_fn(|quantity| largest(place, quantity)))
                .collect(),
            parts: long_enough.map(|level| levels.get(level).map_or(1, |level| level.parts)),
        }
    }
}

/// Errors of time averages from blocks of one length.
struct Level<const N: usize> {
    /// Number of blocks of this length, in all replicas together.
    parts: usize,
    /// Squared standard errors by point or bin.
    squares: Vec<[f64; N]>,
}

/// Returns the block counts per replica that are tried, from all its blocks down to one.
fn block_divisions(replicas: usize, blocks: usize) -> Vec<usize> {
    let mut divisions = Vec::new();
    let mut each = blocks;
    while each > 1 && (divisions.is_empty() || replicas * each >= FEWEST) {
        divisions.push(each);
        each /= 2;
    }
    divisions.extend((replicas > 1).then_some(1));
    divisions
}

/// Computes the squared standard errors of averages from the values of the parts that were
/// averaged.
fn squared_errors<const N: usize>(
    parts: impl Iterator<Item = [f64; N]>,
    averages: &[f64; N],
) -> [f64; N] {
    let (mut counts, mut squares) = ([0.0_f64; N], [0.0; N]);
    for values in parts {
        for quantity in 0..N {
            if values[quantity].is_finite() {
                counts[quantity] += 1.0;
                squares[quantity] += (values[quantity] - averages[quantity]).powi(2);
            }
        }
    }
    std::array::from_fn(|quantity| match counts[quantity] {
        count if count > 1.0 => squares[quantity] / (count * (count - 1.0)),
        _ => f64::NAN,
    })
}

/// Returns the index of the shortest blocks beyond which the error of a quantity does not grow, by
/// Fisher's test of the quotient of its squares, averaged over all points. These are the shortest
/// blocks if no longer ones show a correlation, otherwise the first after which no growth is
/// likely.
fn long_enough<const N: usize>(levels: &[Level<N>], quantity: usize) -> usize {
    let Some(first) = levels.first() else {
        return 0;
    };
    // Over the errors of the shortest blocks, so that all places count alike.
    let size = |level: &Level<N>| {
        let both = level.squares.iter().zip(&first.squares);
        let ratios = both.map(|(own, first)| own[quantity] / first[quantity]);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for ratio in ratios.filter(|ratio| ratio.is_finite()) {
            sum += ratio;
            count += 1.0;
        }
        sum / count
    };
    let sizes: Vec<f64> = levels.iter().map(size).collect();
    let grows = |short: usize, long: usize, chance: f64| {
        let freedom = [long, short].map(|level| (levels[level].parts - 1) as f64);
        let (ratio, fisher) = (
            sizes[long] / sizes[short],
            FisherSnedecor::new(freedom[0], freedom[1]),
        );
        ratio.is_finite() && fisher.is_ok_and(|fisher| fisher.sf(ratio) < chance)
    };
    let last = levels.len() - 1;
    let grows_after = |short, chance| (short + 1..=last).any(|long| grows(short, long, chance));
    if !grows_after(0, FALSE_ALARM) {
        return 0;
    }
    (0..last)
        .find(|&short| !grows_after(short, DOUBT))
        .unwrap_or(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replicas::quantile;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Block values of a replica: a constant offset, and noise that is correlated from block to
    /// block by a factor.
    fn replica(
        stream: &mut Xoshiro256PlusPlus,
        blocks: usize,
        offset: f64,
        memory: f64,
    ) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(&mut *stream) };
        let own = offset * normal();
        let mut value = normal();
        std::iter::repeat_with(|| {
            value = memory * value + (1.0 - memory * memory).sqrt() * normal();
            own + value
        })
        .take(blocks)
        .collect()
    }

    struct Found {
        mean: f64,
        error: f64,
        parts: usize,
    }

    fn measured(runs: &[Vec<f64>]) -> Found {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let all = mean(&runs.concat());
        let part = |_, replica: usize, blocks| Some([mean(&runs[replica][blocks])]);
        let found = TimeErrors::new([runs.len(), runs[0].len()], &[[all]], part);
        Found {
            mean: all,
            error: found.standard_errors[0][0],
            parts: found.parts[0],
        }
    }

    /// Intervals of 95 % hold the true mean, zero, in some 95 % of 2000 runs, three binomial errors
    /// of .005 less: for noise, for noise that remembers some blocks, and for replicas that never
    /// forget their start. One replica of ten correlation times knows its error worse. Errors are
    /// at most a third too wide.
    #[test]
    fn intervals_hold_the_truth() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(3);
        for (replicas, blocks, offset, memory, least) in [
            (1, 40, 0.0, 0.0, 0.935),
            (2, 40, 0.0, 0.0, 0.935),
            (2, 40, 0.0, 0.5, 0.93),
            (4, 40, 0.0, 0.6, 0.935),
            (2, 200, 0.0, 0.9, 0.93),
            (1, 200, 0.0, 0.9, 0.87),
            (8, 40, 1.0, 0.0, 0.93),
            (12, 40, 3.0, 0.5, 0.93),
        ] {
            let runs = 2000;
            let (mut held, mut errors, mut squares) = (0, 0.0, 0.0);
            for _ in 0..runs {
                let all: Vec<Vec<f64>> = (0..replicas)
                    .map(|_| replica(&mut stream, blocks, offset, memory))
                    .collect();
                let found = measured(&all);
                let half = quantile(0.05, Some(found.parts - 1)) * found.error;
                held += usize::from(found.mean.abs() <= half);
                errors += found.error.powi(2);
                squares += found.mean.powi(2);
            }
            let share = f64::from(held as u32) / f64::from(runs);
            let size = (errors / squares).sqrt();
            let what = format!("{replicas} {blocks} {offset} {memory}: {share} {size}");
            assert!(share >= least && (0.8..1.35).contains(&size), "{what}");
        }
    }

    /// The error is never below that of the replicas.
    #[test]
    fn errors_are_at_least_those_of_replicas() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(4);
        for replicas in [2, 3, 12] {
            for _ in 0..200 {
                let all: Vec<Vec<f64>> = (0..replicas)
                    .map(|_| replica(&mut stream, 10, 0.5, 0.3))
                    .collect();
                let means = all.iter().map(|run| run.iter().sum::<f64>() / 10.0);
                let means: Vec<f64> = means.collect();
                let over = crate::statistics::Estimate::over_replicas(&means);
                let least = over.and_then(|over| over.standard_error).expect("replicas");
                let found = measured(&all);
                // Two sums of ten terms.
                assert!(
                    found.error >= least * (1.0 - 1e-12),
                    "{} {least}",
                    found.error
                );
            }
        }
    }

    #[test]
    fn what_has_no_parts_has_no_error() {
        let one = TimeErrors::new([1, 1], &[[1.0]], |_, _, _| Some([1.0]));
        assert!(one.standard_errors[0][0].is_nan() && one.parts == [1]);
        let none = TimeErrors::new([2, 8], &[[1.0]], |_, _, _| None);
        assert!(none.standard_errors[0][0].is_nan());
        // Place at which one block has no value.
        let gap =
            |_, _, blocks: Range<usize>| Some([if blocks.start == 0 { f64::NAN } else { 1.0 }]);
        let found = TimeErrors::new([1, 8], &[[1.0]], gap);
        assert_eq!(found.standard_errors[0][0], 0.0);
        assert_eq!(block_divisions(2, 40), [40, 20, 10, 5, 2, 1]);
        assert_eq!(block_divisions(1, 40), [40, 20, 10, 5]);
        assert_eq!(block_divisions(3, 1), [1]);
    }
}
