//! Interface of normal contact laws, and their result for one contact.

use std::fmt::Debug;

/// Result of a normal contact law for one contact: a pair that approaches at the normal speed g
/// separates at `coefficient * g + added_speed`.
///
/// Laws that heat are stated by speeds, because a coefficient alone diverges as g goes to 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Fraction of the normal approach speed that is kept, in \[0, 1\].
    pub coefficient: f64,
    /// Speed that every contact adds to the normal separation \[length/time\]; 0 for laws that only
    /// dissipate.
    pub added_speed: f64,
}

impl Separation {
    /// Result of an elastic contact: the normal speed is kept.
    pub const ELASTIC: Self = Self {
        coefficient: 1.0,
        added_speed: 0.0,
    };

    /// Returns the result in the units of an engine whose velocities are physical ones divided by
    /// `speed`.
    #[must_use]
    #[inline(always)]
    pub fn in_units(self, speed: f64) -> Self {
        Self {
            added_speed: self.added_speed / speed,
            ..self
        }
    }

    /// Returns the normal speed of separation \[length/time\] after an approach at the speed
    /// `approach` \[length/time\].
    #[inline]
    pub fn speed(self, approach: f64) -> f64 {
        self.coefficient * approach + self.added_speed
    }
}

impl From<f64> for Separation {
    /// Creates the result of a contact that keeps the fraction `coefficient` of the normal speed
    /// and adds none.
    #[inline(always)]
    fn from(coefficient: f64) -> Self {
        Self {
            coefficient,
            added_speed: 0.0,
        }
    }
}

/// Normal contact law: the restitution as a function of the normal approach speed.
pub trait Restitution: Clone + Debug + Send + Sync + 'static {
    /// Returns the coefficient of restitution, in \[0, 1\], at a normal approach speed `approach`
    /// >= 0 \[length/time\]. A law that adds speed gives the ratio of the speeds after and before.
    fn normal_restitution(&self, approach: f64) -> f64;

    /// Returns the coefficient of restitution of a pair of species (see
    /// [`crate::Sizes::species_of`]) at a normal approach speed `approach` \[length/time\].
    #[inline]
    fn pair_restitution(&self, _kinds: [u32; 2], approach: f64) -> f64 {
        self.normal_restitution(approach)
    }

    /// Returns the result of a contact of a pair of species at a normal approach speed
    /// \[length/time\], as engines need it. Only laws that add speed override it.
    #[inline]
    fn separation(&self, kinds: [u32; 2], approach: f64) -> Separation {
        self.pair_restitution(kinds, approach).into()
    }

    /// Returns an upper bound of the speed that a contact adds to the normal separation
    /// \[length/time\]; 0 for laws that only dissipate, whose relative speeds never grow.
    #[inline]
    fn max_added_speed(&self) -> f64 {
        0.0
    }
}
