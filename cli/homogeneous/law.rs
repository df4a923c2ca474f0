//! Restitution as a case says it.

use stosszahl_model::{Constant, PerPair, Restitution, Viscoelastic};

use super::case;

/// Restitution of one pair of species.
///
/// Chosen while the program runs, for each pair if need be: the law is asked once for each collision, not for each pair
/// that is looked at, and what the choice costs cannot be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PairLaw {
    /// The same at every speed.
    Constant(Constant),
    /// Falling with the approach speed.
    Viscoelastic(Viscoelastic),
}

impl PairLaw {
    /// The law that a case means; `None` if its number is out of range.
    fn new(written: case::Restitution) -> Option<Self> {
        match written {
            case::Restitution::Constant(coefficient) => {
                Constant::new(coefficient).map(Self::Constant)
            }
            case::Restitution::Viscoelastic(law) => {
                Viscoelastic::new(law.viscoelastic).map(Self::Viscoelastic)
            }
        }
    }
}

impl Restitution for PairLaw {
    #[inline]
    fn normal(&self, approach: f64) -> f64 {
        match self {
            Self::Constant(law) => law.normal(approach),
            Self::Viscoelastic(law) => law.normal(approach),
        }
    }
}

/// Restitution of all pairs.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Law {
    /// One law for all.
    All(PairLaw),
    /// A law for each pair of species.
    Pairs(PerPair<PairLaw>),
}

impl Law {
    /// The law of a case with the given number of species; `None` if a number is out of range.
    pub fn new(case: &case::Case, species: usize) -> Option<Self> {
        let general = PairLaw::new(case.restitution)?;
        if case.pairs.is_empty() {
            return Some(Self::All(general));
        }
        let mut laws = vec![general; species.checked_mul(species)?];
        for &([first, second], written) in &case.pairs {
            *laws.get_mut(first * species + second)? = PairLaw::new(written)?;
        }
        PerPair::new(species, laws).map(Self::Pairs)
    }

    /// The coefficient of restitution, if it is the same for all pairs and speeds.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::All(PairLaw::Constant(law)) => Some(law.coefficient()),
            _ => None,
        }
    }
}

impl Restitution for Law {
    #[inline]
    fn normal(&self, approach: f64) -> f64 {
        match self {
            Self::All(law) => law.normal(approach),
            Self::Pairs(laws) => laws.normal(approach),
        }
    }
    #[inline]
    fn between(&self, kinds: [u32; 2], approach: f64) -> f64 {
        match self {
            Self::All(law) => law.normal(approach),
            Self::Pairs(laws) => laws.between(kinds, approach),
        }
    }
}
