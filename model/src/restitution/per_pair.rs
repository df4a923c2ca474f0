//! Normal contact laws of a mixture: one law for each pair of species.

use std::sync::Arc;

use super::normal_law::{Restitution, Separation};
use crate::invalid::InvalidValue;

/// Normal contact laws of a mixture, one of the same form for each unordered pair of species; cheap
/// to clone, as replicas share the table.
#[derive(Clone, Debug, PartialEq)]
pub struct PerPair<R> {
    laws: Arc<[R]>,
    count: usize,
}

impl<R: Restitution> PerPair<R> {
    /// Creates the contact laws of a mixture of `count` species, by rows: `laws[i * count + j]`
    /// acts between species i and j. Of each unordered pair, the law with i <= j is used.
    ///
    /// # Errors
    /// [`InvalidValue`] unless there are `count * count` laws, at least one.
    pub fn new(count: usize, laws: Vec<R>) -> Result<Self, InvalidValue> {
        let complete = count > 0 && count.checked_mul(count) == Some(laws.len());
        InvalidValue::require(
            complete,
            "number of laws of pairs",
            laws.len() as f64,
            "the square of the number of species, at least 1",
        )?;
        Ok(Self {
            laws: laws.into(),
            count,
        })
    }

    /// Returns the contact law between two species; species beyond the table act as its last.
    #[inline]
    pub fn law(&self, kinds: [u32; 2]) -> &R {
        let last = self.count - 1;
        let [i, j] = kinds.map(|kind| (kind as usize).min(last));
        &self.laws[i.min(j) * self.count + i.max(j)]
    }
}

impl<R: Restitution> Restitution for PerPair<R> {
    /// Returns the coefficient of restitution of the first species with itself, for engines that
    /// know no species.
    #[inline]
    fn normal_restitution(&self, approach: f64) -> f64 {
        self.law([0, 0]).normal_restitution(approach)
    }
    #[inline]
    fn pair_restitution(&self, kinds: [u32; 2], approach: f64) -> f64 {
        self.law(kinds).normal_restitution(approach)
    }
    #[inline]
    fn separation(&self, kinds: [u32; 2], approach: f64) -> Separation {
        self.law(kinds).separation(kinds, approach)
    }
    fn max_added_speed(&self) -> f64 {
        let added = self.laws.iter().map(Restitution::max_added_speed);
        added.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Constant;

    #[test]
    fn laws_are_found_in_either_order() {
        let law = |r| Constant::new(r).expect("a coefficient");
        let table = PerPair::new(2, vec![law(0.1), law(0.2), law(0.9), law(0.4)]).expect("a table");
        assert_eq!(table.pair_restitution([0, 1], 1.0), 0.2);
        assert_eq!(table.pair_restitution([1, 0], 1.0), 0.2);
        assert_eq!(table.pair_restitution([1, 1], 1.0), 0.4);
        assert_eq!(table.normal_restitution(1.0), 0.1);
        assert!(PerPair::new(2, vec![law(0.1)]).is_err());
        assert!(PerPair::<Constant>::new(0, Vec::new()).is_err());
    }
}
