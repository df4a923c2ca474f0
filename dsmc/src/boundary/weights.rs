//! Simulator weights: regions of the box in which a simulator stands for more or fewer particles,
//! by fixed or adaptive factors.

use crate::parameters::DsmcError;

/// Weight factors of simulators in equal blocks of the box: how many particles a simulator stands
/// for, relative to a factor of one. Uniform by default.
///
/// A simulator that crosses from a region of factor a to one of factor b becomes a/b simulators on
/// average: one of the two adjacent whole numbers, drawn so that the mean is exact. A cell belongs
/// to the region that holds its centre, so all simulators of a cell weigh the same.
///
/// Factors are given, or adapt to the number of simulators ([`SimulatorWeights::following`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulatorWeights {
    /// Number of blocks with their own weight factor along each axis.
    regions: [usize; 3],
    /// Weight factor of each block, the first axis running fastest; empty where weights are
    /// uniform.
    factors: Vec<f64>,
    /// True if weight factors adapt to the number of simulators in their blocks.
    follows: bool,
}

/// Largest adaptive weight factor; the smallest is its inverse.
const MOST_FOLLOWED: f64 = 1024.0;

impl SimulatorWeights {
    /// Creates uniform weights, with a factor of one everywhere.
    pub fn uniform() -> Self {
        Self::default()
    }

    /// Creates fixed weight factors of equal slices of the box along an axis.
    ///
    /// # Errors
    /// As [`SimulatorWeights::table`].
    pub fn along(axis: usize, factors: Vec<f64>) -> Result<Self, DsmcError> {
        let mut regions = [1; 3];
        if let Some(region) = regions.get_mut(axis) {
            *region = factors.len();
        }
        Self::table(regions, factors)
    }

    /// Creates adaptive weight factors of equal slices of the box along an axis, all one at the
    /// start.
    ///
    /// A factor doubles where a slice holds more than twice the mean number of simulators at the
    /// start, and halves where it holds fewer than half. Factors are between 1/1024 and 1024.
    /// Dilute regions are then sampled as well as dense ones (T. Kawasaki, thesis, California
    /// Institute of Technology (1985), section 4).
    ///
    /// # Errors
    /// As [`SimulatorWeights::table`].
    pub fn following(axis: usize, slices: usize) -> Result<Self, DsmcError> {
        let uniform = Self::along(axis, vec![1.0; slices])?;
        Ok(Self {
            follows: true,
            ..uniform
        })
    }

    /// Creates fixed weight factors of equal blocks of the box, the first axis running fastest.
    /// `regions` is the number of blocks along each axis, 1 for axes beyond the dimension.
    ///
    /// # Errors
    /// [`DsmcError::BadWeights`] unless there is a factor for each block, from 1e-6 to 1e6.
    pub fn table(regions: [usize; 3], factors: Vec<f64>) -> Result<Self, DsmcError> {
        let blocks = regions
            .iter()
            .try_fold(1_usize, |product, &count| product.checked_mul(count));
        if blocks != Some(factors.len()) || factors.is_empty() {
            return Err(DsmcError::BadWeights {
                found: format!("{} factors for {regions:?} blocks", factors.len()),
                allowed: "a factor for each block",
            });
        }
        let bad = factors
            .iter()
            .find(|factor| !(1e-6..=1e6).contains(*factor));
        if let Some(factor) = bad {
            return Err(DsmcError::BadWeights {
                found: format!("a factor of {factor}"),
                allowed: "1e-6 to 1e6",
            });
        }
        Ok(Self {
            regions,
            factors,
            follows: false,
        })
    }

    /// Returns true if all simulators always have the weight factor one.
    pub fn is_uniform(&self) -> bool {
        !self.follows
            && self.factors.windows(2).all(|pair| pair[0] == pair[1])
            && self.factors.first().is_none_or(|&factor| factor == 1.0)
    }

    /// Returns the number of blocks with their own weight factor along each axis.
    pub fn regions(&self) -> [usize; 3] {
        self.regions
    }

    /// Returns true if weight factors adapt to the number of simulators in their blocks.
    pub fn follows(&self) -> bool {
        self.follows
    }

    /// Returns the weight factor of each block, the first axis running fastest; empty where weights
    /// are uniform.
    pub fn factors(&self) -> &[f64] {
        &self.factors
    }

    /// Returns a copy with the given weight factors of the blocks; unchanged if their number
    /// differs.
    pub(crate) fn with_factors(&self, factors: &[f64]) -> Self {
        let mut changed = self.clone();
        if factors.len() == changed.factors.len() {
            changed.factors.copy_from_slice(factors);
        }
        changed
    }

    /// Returns the factor by which each adaptive weight factor changes: 2, 1/2 or 1, from the
    /// number of simulators in each block and the mean at the start.
    pub(crate) fn changes(&self, counts: &[usize], mean: f64) -> Vec<f64> {
        let change = |(&factor, &count): (&f64, &usize)| {
            let count = count as f64;
            if count > 2.0 * mean && factor < MOST_FOLLOWED {
                2.0
            } else if count > 0.0 && 2.0 * count < mean && factor > 1.0 / MOST_FOLLOWED {
                0.5
            } else {
                1.0
            }
        };
        self.factors.iter().zip(counts).map(change).collect()
    }

    /// Returns the weight factor at a point of the box, given as fractions of its sides.
    pub fn factor_at(&self, shares: [f64; 3]) -> f64 {
        let block = self.block(shares);
        self.factors.get(block).copied().unwrap_or(1.0)
    }

    /// Returns the index of the block of weights that contains a point, given as fractions of the
    /// box sides.
    pub(crate) fn block(&self, shares: [f64; 3]) -> usize {
        let mut block = 0;
        for axis in (0..3).rev() {
            let count = self.regions[axis];
            let at = (shares[axis] * count as f64) as usize;
            block = block * count + at.min(count.max(1) - 1);
        }
        block
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_found_by_their_place() {
        let weights =
            SimulatorWeights::table([2, 3, 1], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).expect("fit");
        assert_eq!(weights.factor_at([0.2, 0.1, 0.0]), 1.0);
        assert_eq!(weights.factor_at([0.7, 0.1, 0.0]), 2.0);
        assert_eq!(weights.factor_at([0.2, 0.99, 0.0]), 5.0);
        assert_eq!(weights.factor_at([1.0, 1.0, 1.0]), 6.0);
        assert_eq!(SimulatorWeights::uniform().factor_at([0.5; 3]), 1.0);
        let slices = SimulatorWeights::along(1, vec![1.0, 4.0]).expect("fit");
        assert_eq!(slices.factor_at([0.9, 0.6, 0.0]), 4.0);
        assert!(!slices.is_uniform() && SimulatorWeights::uniform().is_uniform());
    }

    #[test]
    fn factors_follow_the_number() {
        let weights = SimulatorWeights::following(1, 5).expect("slices");
        assert!(weights.follows() && !weights.is_uniform());
        let changes = weights.changes(&[0, 49, 50, 200, 201], 100.0);
        assert_eq!(changes, [1.0, 0.5, 1.0, 1.0, 2.0]);
        let far = weights.with_factors(&[1.0, 1.0 / 1024.0, 1.0, 1.0, 1024.0]);
        assert_eq!(far.changes(&[0, 1, 9, 9, 900], 10.0), [1.0; 5]);
        assert_eq!(far.factor_at([0.0, 0.99, 0.0]), 1024.0);
        assert!(SimulatorWeights::following(0, 0).is_err());
    }

    #[test]
    fn what_is_no_weight_is_refused() {
        assert!(SimulatorWeights::table([2, 2, 1], vec![1.0; 3]).is_err());
        assert!(SimulatorWeights::along(0, Vec::new()).is_err());
        let refused = SimulatorWeights::along(0, vec![1.0, 0.0]).expect_err("zero");
        assert!(refused.to_string().contains("a factor of 0"), "{refused}");
        assert!(SimulatorWeights::along(7, vec![1.0, 2.0]).is_err());
        assert!(SimulatorWeights::along(0, vec![f64::NAN]).is_err());
    }
}
