//! Interface of a normal contact law, and its outcome for one contact.

use std::fmt::Debug;

/// Outcome of a normal law for one contact: a pair that approaches at the normal speed g separates
/// at `coefficient * g + added_speed`.
///
/// Laws that heat are stated by speeds, because a coefficient alone diverges as g goes to 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Share of the approach speed that is kept, in \[0, 1\].
    pub coefficient: f64,
    /// Speed that every contact adds \[length/time\]; 0 for laws that only dissipate.
    pub added_speed: f64,
}

impl Separation {
    /// An elastic contact.
    pub const ELASTIC: Self = Self {
        coefficient: 1.0,
        added_speed: 0.0,
    };

    /// Returns this outcome for an engine whose velocities are physical ones over `speed`.
    #[must_use]
    #[inline(always)]
    pub fn in_units(self, speed: f64) -> Self {
        Self {
            added_speed: self.added_speed / speed,
            ..self
        }
    }

    /// Normal speed of separation \[length/time\] after an approach at the speed `approach`.
    #[inline]
    pub fn speed(self, approach: f64) -> f64 {
        self.coefficient * approach + self.added_speed
    }
}

impl From<f64> for Separation {
    /// Creates the outcome of a contact that keeps the share `coefficient` and adds nothing.
    #[inline(always)]
    fn from(coefficient: f64) -> Self {
        Self {
            coefficient,
            added_speed: 0.0,
        }
    }
}

/// Normal restitution as a function of the normal approach speed.
pub trait Restitution: Clone + Debug + Send + Sync + 'static {
    /// Coefficient of restitution, in [0, 1], at a normal approach speed `approach` >= 0
    /// \[length/time\]. A law that adds speed gives the quotient of the speeds after and before.
    fn normal_restitution(&self, approach: f64) -> f64;

    /// Coefficient of restitution of a pair of the given species (see
    /// [`crate::Sizes::species_of`]) at a normal approach speed `approach` \[length/time\].
    #[inline]
    fn pair_restitution(&self, _kinds: [u32; 2], approach: f64) -> f64 {
        self.normal_restitution(approach)
    }

    /// Returns the outcome of a contact of a pair of the given species, as engines need it. Only
    /// laws that add speed override it.
    #[inline]
    fn separation(&self, kinds: [u32; 2], approach: f64) -> Separation {
        self.pair_restitution(kinds, approach).into()
    }

    /// Upper bound of the speed that a contact adds to the separation of a pair \[length/time\]; 0
    /// for laws that only dissipate, whose relative speeds never grow.
    #[inline]
    fn max_added_speed(&self) -> f64 {
        0.0
    }
}
