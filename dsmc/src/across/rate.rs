//! Number density times chi, from a count of few.
//!
//! The number in a neighbourhood of a simulator is a noisy measure of the density there, in two ways. It counts the
//! simulator itself, and the others around it are fewer than the mean, as particles that collide with momentum transfer over
//! a distance keep apart: on average n V - 1 + S(0), with the structure factor S at long waves, which is the isothermal
//! compressibility. So S(0), and not 1, is to be taken off the count to be right on average; where sizes differ and what is
//! counted is area or volume, S(0) times that of the simulator itself. And n chi(n) is convex: its mean
//! exceeds that of the mean density by (n chi)''/2 times the variance n S(0)/V, which is taken off too. Both corrections
//! vanish with many simulators in the neighbourhood.

use stosszahl_model::Space;

/// Most entries of the table.
const LARGEST_TABLE: u32 = 1 << 14;

/// Densest packing that chi is taken at: beyond it, the limit stands anyway.
const DENSEST: f64 = 0.9;

/// n chi by the units around, corrected for the noise of their number.
pub(crate) struct Rates<S: Space> {
    limit: f64,
    /// Packing fraction of one unit in the neighbourhood.
    unit: f64,
    /// Area or volume of one particle, on average.
    ball: f64,
    table: Vec<f64>,
    space: std::marker::PhantomData<S>,
}

impl<S: Space> Rates<S> {
    /// `unit`: packing fraction of one simulator in the neighbourhood; `ball`: mean area or volume of a particle;
    /// `limit`: on chi; `uniform`: whether all units are alike, so that their number is a whole one.
    pub(crate) fn new(unit: f64, ball: f64, limit: f64, uniform: bool) -> Self {
        let mut rates = Self {
            limit,
            unit,
            ball,
            table: Vec::new(),
            space: std::marker::PhantomData,
        };
        if uniform {
            let most = ((2.0 / unit) as u32).min(LARGEST_TABLE);
            rates.table = (0..most)
                .map(|units| rates.compute(f64::from(units), 1.0))
                .collect();
        }
        rates
    }

    /// Covered share times chi.
    fn covered_chi(&self, packing: f64) -> f64 {
        packing * S::contact_value(packing.min(DENSEST)).min(self.limit)
    }

    fn compute(&self, units: f64, own: f64) -> f64 {
        let raw = units * self.unit;
        let structure = S::structure_factor_at_zero(raw.clamp(1e-6, 0.7));
        let packing = (raw - structure * own * self.unit).max(0.0);
        let near = 0.02_f64.min(0.5 * packing);
        let curvature = if near > 0.0 {
            let around = self.covered_chi(packing + near) + self.covered_chi(packing - near);
            (around - 2.0 * self.covered_chi(packing)) / (near * near)
        } else {
            0.0
        };
        let variance = self.unit * packing * structure;
        (self.covered_chi(packing) - 0.5 * curvature * variance).max(0.0) / self.ball
    }

    /// n chi where the neighbourhood of a simulator of `own` units holds so many, itself included \[1/length^D\].
    #[inline]
    pub(crate) fn at(&self, units: f64, own: f64) -> f64 {
        let known = if units.fract() == 0.0 && own == 1.0 {
            self.table.get(units as usize)
        } else {
            None
        };
        known.copied().unwrap_or_else(|| self.compute(units, own))
    }

    pub(crate) fn bytes(&self) -> usize {
        8 * self.table.capacity()
    }
}
