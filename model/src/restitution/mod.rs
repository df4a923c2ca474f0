//! Normal contact laws: the normal speed at which a pair separates as a function of its approach
//! speed, chosen at run time.
//!
//! A law is one file here and one line in [`Law`], which all engines that are chosen at run time
//! use. The choice costs mixtures without positions four hundredths of their speed, and the others
//! less than could be measured. Engines are generic over [`Restitution`] nevertheless, so that a
//! program can use a custom law.

mod constant;
mod delta;
mod material;
mod normal_law;
mod per_pair;
mod threshold;
mod viscoelastic;

pub use constant::Constant;
pub use delta::DeltaModel;
pub use material::Material;
pub use normal_law::{Restitution, Separation};
pub use per_pair::PerPair;
pub use threshold::ThresholdModel;
pub use viscoelastic::Viscoelastic;

/// Declares the normal contact laws that are chosen at run time: one line for each law.
macro_rules! laws {
    ($($(#[$about:meta])* $name:ident($law:ty),)+) => {
        /// Normal contact law, chosen at run time.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Law { $($(#[$about])* $name($law),)+ }

        $(impl From<$law> for Law {
            fn from(law: $law) -> Self {
                Self::$name(law)
            }
        })+

        impl Restitution for Law {
            #[inline]
            fn normal_restitution(&self, approach: f64) -> f64 {
                match self { $(Self::$name(law) => law.normal_restitution(approach),)+ }
            }
            #[inline]
            fn pair_restitution(&self, kinds: [u32; 2], approach: f64) -> f64 {
                match self { $(Self::$name(law) => law.pair_restitution(kinds, approach),)+ }
            }
            #[inline]
            fn separation(&self, kinds: [u32; 2], approach: f64) -> Separation {
                match self { $(Self::$name(law) => law.separation(kinds, approach),)+ }
            }
            fn max_added_speed(&self) -> f64 {
                match self { $(Self::$name(law) => law.max_added_speed(),)+ }
            }
        }
    };
}

laws! {
    /// Constant coefficient of restitution, the same at every approach speed.
    Constant(Constant),
    /// Viscoelastic restitution, which falls with the approach speed.
    Viscoelastic(Viscoelastic),
    /// Delta model: constant restitution with a speed that every contact adds.
    Delta(DeltaModel),
    /// Threshold model: constant restitution, with elastic contacts below a threshold of the
    /// approach speed.
    Threshold(ThresholdModel),
    /// One normal contact law for each pair of species.
    Pairs(PerPair<Law>),
}

impl Law {
    /// Law of elastic contacts for all pairs and speeds.
    pub const ELASTIC: Self = Self::Constant(Constant::ELASTIC);

    /// Returns the coefficient of restitution if it is constant for all pairs and speeds; `None`
    /// otherwise.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(law) => Some(law.coefficient()),
            _ => None,
        }
    }

    /// Returns the Delta model, whose contacts heat, if it is the law of all pairs; `None`
    /// otherwise.
    pub fn delta(&self) -> Option<DeltaModel> {
        match self {
            Self::Delta(law) => Some(*law),
            _ => None,
        }
    }

    /// Returns the coefficient of restitution that stands for the law in theory at a normal
    /// approach speed \[length/time\], without the speed that contacts add. `None` if pairs have
    /// laws of their own.
    pub fn coefficient(&self, approach: f64) -> Option<f64> {
        match self {
            Self::Delta(law) => Some(law.coefficient()),
            Self::Pairs(_) => None,
            other => Some(other.normal_restitution(approach)),
        }
    }

    /// Returns true if contacts never dissipate energy.
    pub fn is_elastic(&self) -> bool {
        self.constant() == Some(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_chosen_at_run_time_is_the_law() {
        let viscoelastic = Viscoelastic::new(0.4).expect("a strength");
        let law = Law::from(viscoelastic);
        assert_eq!(
            law.normal_restitution(0.7),
            viscoelastic.normal_restitution(0.7)
        );
        assert_eq!(law.constant(), None);
        let constant = Law::from(Constant::new(0.8).expect("a coefficient"));
        assert_eq!(constant.pair_restitution([0, 1], 3.0), 0.8);
        assert_eq!(constant.constant(), Some(0.8));
        let laws = vec![law.clone(), constant.clone(), constant, law];
        let pairs = Law::from(PerPair::new(2, laws).expect("a table"));
        assert_eq!(pairs.pair_restitution([1, 0], 2.0), 0.8);
        assert_eq!(
            pairs.pair_restitution([1, 1], 2.0),
            viscoelastic.normal_restitution(2.0)
        );
    }
}
