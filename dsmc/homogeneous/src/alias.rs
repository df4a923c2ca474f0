//! Alias tables: random draws from a discrete distribution in constant time.

use rand::Rng;
use serde::{Deserialize, Serialize};

/// Alias table of Walker, ACM Trans. Math. Softw. 3, 253 (1977), doi:10.1145/355744.355749, filled
/// in linear time by the method of Vose, IEEE Trans. Softw. Eng. 17, 972 (1991),
/// doi:10.1109/32.92917.
///
/// One random word per draw: its product with the number of entries is the column (high half) and
/// the height within the column (low half). So a weight is met to 2^-64 of the mean weight, apart
/// from the rounding of the table (1e-16).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Alias {
    /// Threshold and alias of each column of the table: a random height below the threshold draws
    /// the column's own index, above it the alias.
    columns: Vec<(u64, u32)>,
    small: Vec<u32>,
    large: Vec<u32>,
    scaled: Vec<f64>,
}

/// Returns the high and the low 64 bits of `word` times `count`: a uniform integer below `count`,
/// and an independent uniform fraction.
#[inline]
pub(crate) fn split(word: u64, count: u32) -> (u32, u64) {
    let product = u128::from(word) * u128::from(count);
    ((product >> 64) as u32, product as u64)
}

impl Alias {
    /// Fills the alias table with non-negative weights. Returns their sum; 0 if the table is empty
    /// or all weights are zero.
    pub fn fill(&mut self, weights: impl Iterator<Item = f64>) -> f64 {
        self.scaled.clear();
        self.scaled.extend(weights);
        self.columns.clear();
        let total: f64 = self.scaled.iter().sum();
        // Also refuses an infinite or NaN sum.
        if !(total > 0.0 && total < f64::INFINITY) {
            return if total == 0.0 { 0.0 } else { total };
        }
        let count = self.scaled.len();
        let factor = count as f64 / total;
        self.small.clear();
        self.large.clear();
        for (index, weight) in self.scaled.iter_mut().enumerate() {
            *weight *= factor;
            if *weight < 1.0 {
                self.small.push(index as u32);
            } else {
                self.large.push(index as u32);
            }
        }
        self.columns
            .extend((0..count).map(|own| (u64::MAX, own as u32)));
        while let (Some(&low), Some(&high)) = (self.small.last(), self.large.last()) {
            self.small.pop();
            let share = self.scaled[low as usize];
            self.columns[low as usize] = ((share * 2.0_f64.powi(64)) as u64, high);
            let rest = &mut self.scaled[high as usize];
            *rest -= 1.0 - share;
            if *rest < 1.0 {
                self.large.pop();
                self.small.push(high);
            }
        }
        // Remaining entries weigh one but for rounding. Where rounding emptied the large ones too
        // early they weigh next to nothing, and may not be drawn.
        let heaviest = (0..count as u32)
            .max_by(|&a, &b| self.scaled[a as usize].total_cmp(&self.scaled[b as usize]));
        for &left in &self.small {
            let share = self.scaled[left as usize];
            if share < 0.5 {
                self.columns[left as usize] =
                    ((share * 2.0_f64.powi(64)) as u64, heaviest.unwrap_or(left));
            }
        }
        total
    }

    /// Returns the memory that the alias table occupies \[bytes\].
    pub fn memory_bytes(&self) -> usize {
        self.columns.capacity() * size_of::<(u64, u32)>()
            + (self.small.capacity() + self.large.capacity()) * size_of::<u32>()
            + self.scaled.capacity() * size_of::<f64>()
    }

    /// Draws a random index with probability proportional to its weight; the table must not be
    /// empty.
    #[inline]
    pub fn draw(&self, stream: &mut impl Rng) -> u32 {
        let (column, place) = split(stream.next_u64(), self.columns.len() as u32);
        let (own, other) = self.columns[column as usize];
        if place < own { column } else { other }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use stosszahl_model::random::Stream;

    /// Probabilities of the table agree with the weights. Tolerance: one rounding for each entry
    /// that passed through a column.
    #[test]
    fn tables_hold_their_weights() {
        let mut alias = Alias::default();
        for weights in [
            vec![1.0],
            vec![0.0, 3.0, 0.0, 1e-9, 5.0, 0.1],
            (1..1000).map(|k| f64::from(k).powi(-3)).collect(),
        ] {
            let total = alias.fill(weights.iter().copied());
            let count = weights.len() as f64;
            let mut found = vec![0.0; weights.len()];
            for (column, &(own, other)) in alias.columns.iter().enumerate() {
                let own = own as f64 / 2.0_f64.powi(64);
                found[column] += own / count;
                found[other as usize] += (1.0 - own) / count;
            }
            for (found, weight) in found.iter().zip(&weights) {
                assert!((found - weight / total).abs() < 1e-15, "{found} {weight}");
            }
        }
        assert_eq!(alias.fill([0.0, 0.0].into_iter()), 0.0);
        assert!(alias.fill([f64::NAN].into_iter()).is_nan());
    }

    #[test]
    fn entries_without_weight_are_never_drawn() {
        let mut alias = Alias::default();
        alias.fill([0.0, 1.0, 0.0, 1e-3].into_iter());
        let mut stream = Stream::seed_from_u64(3);
        let mut counts = [0_u32; 4];
        for _ in 0..100_000 {
            counts[alias.draw(&mut stream) as usize] += 1;
        }
        assert_eq!((counts[0], counts[2]), (0, 0));
        // 99.9 expected; Poisson, z = 4.4 for a false alarm rate of 1e-5.
        assert!((f64::from(counts[3]) - 99.9).abs() < 44.0, "{counts:?}");
    }
}
