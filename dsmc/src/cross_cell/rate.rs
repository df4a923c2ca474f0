//! Local collision rate n χ, corrected for the noise of a small neighbour count.
//!
//! The number of simulators in a neighbourhood is a noisy measure of the density in two ways.
//!
//! * It counts the simulator itself, and the others around it are fewer than the mean, because
//!   particles that collide with momentum transfer over a distance keep apart: on average n V - H
//!   ([`super::missing`]). The unbiased count therefore subtracts 1 - H.
//! * n chi(n) is convex, so its mean exceeds the value at the mean density by (n chi)''/2 times the
//!   variance, which is subtracted too.
//!
//! Both corrections vanish with many simulators in the neighbourhood.
//!
//! Beside walls a neighbourhood holds fewer simulators at the same density, so each has a larger
//! weight. The value of chi there is that of the packing fraction in the volume open to particle
//! bodies. The density n is that of centres in the volume open to centres, which is narrower by a
//! radius at each wall. Both volumes matter: in a channel two diameters wide, centres have half of
//! it.
//!
//! For unequal sizes the count is the area or volume a. A simulator i thins its surroundings in
//! proportion to its collision rate, by `c w_i` with `w_i = <a_j (r_i + r_j)^D>_j`; for small
//! particles that exceeds their own a. The variance of a in a neighbourhood is 1 - H of that of
//! independent particles, `<a_i (a_i - c w_i)> = (1 - H) <a^2>`. So `a_i - c w_i` is subtracted
//! with `c = H <a^2>/<a w>`, and `<a^2>/<a>` is the unit of the variance.

use stosszahl_model::Space;

use super::arm;
use super::missing::{CorrelationHole, Window};
use crate::density::{Density, DensityInput, DensityKernel, FreeVolumeFactors};

/// Largest number of table entries.
const LARGEST_TABLE: u32 = 1 << 14;

/// Largest packing fraction at which chi is evaluated; beyond it chi is limited anyway.
const DENSEST: f64 = 0.9;

/// Number of intervals of the table by packing fraction, from 0 to 1.
const PACKINGS: usize = 2048;

/// Tabulated rate for a whole number of units in a neighbourhood without boundaries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TabulatedRate {
    /// n chi \[1/length^D\].
    pub(super) rate: f64,
    /// Packing fraction of the neighbourhood.
    pub(super) packing: f64,
    /// True if chi is limited at this packing fraction.
    pub(super) limited: bool,
    /// Class of the adaptive contact distance.
    pub(super) class: u8,
}

/// Table of n chi by the units in a neighbourhood, corrected for the noise of their number.
pub(crate) struct Rates<S: Space> {
    limit: f64,
    /// Packing fraction of one unit in the neighbourhood.
    unit: f64,
    /// Contribution of a simulator to its own neighbourhood \[units\]; zero if the density leaves
    /// the simulator out.
    own: f64,
    /// Mean of the cell weights w in a density window, weighted by w: sum of w^2 over sum of w.
    mean_weight: f64,
    /// Mean area or volume of a particle \[length^D\].
    ball: f64,
    /// Moments of unequal sizes; `None` for equal ones.
    spread: Option<Spread>,
    missing: CorrelationHole,
    table: Vec<TabulatedRate>,
    /// Values of [`Self::covered_chi_there`] at equally spaced packing fractions; empty where
    /// `table` suffices.
    by_packing: Vec<[f64; 2]>,
    space: std::marker::PhantomData<S>,
}

/// Moments of unequal sizes that enter the noise correction, in units of the largest size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Unit of the variance, `<a^2>/<a>`.
    variance: f64,
    /// Coefficients of the powers of the radius, from the zeroth on, of `<a^2> w/<a w>`.
    thinning: [f64; 4],
}

impl Spread {
    /// Computes the moments. `powers`: means of the powers D to 2 D of radius over largest radius.
    pub(crate) fn new(dimension: usize, powers: [f64; 4]) -> Self {
        let binomials = [[1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]][dimension - 2];
        let all = 0..=dimension;
        let sum: f64 = all
            .clone()
            .map(|k| binomials[k] * powers[k] * powers[dimension - k])
            .sum();
        let mut thinning = [0.0; 4];
        for k in all {
            thinning[dimension - k] = powers[dimension] * binomials[k] * powers[k] / sum;
        }
        Self {
            variance: powers[dimension] / powers[0],
            thinning,
        }
    }

    fn thinned(&self, share: f64) -> f64 {
        self.thinning
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * share + c)
    }
}

impl<S: Space> Rates<S> {
    /// Tabulates the rates. `ball`: mean area or volume of a particle; `spread`: `None` for equal
    /// sizes, whose number is whole; `radius`: distance from the point of contact within which
    /// partners are drawn.
    pub(crate) fn new(
        density: &Density<S>,
        gas: &DensityInput,
        ball: f64,
        spread: Option<Spread>,
        radius: f64,
    ) -> Self {
        let (unit, limit) = (density.unit(), gas.limit);
        let mut rates = Self {
            limit,
            unit,
            own: match density.weighing() {
                DensityKernel::Flat => 1.0,
                DensityKernel::Triangle => 0.0,
            },
            mean_weight: density.mean_weight(),
            ball,
            spread,
            missing: CorrelationHole::new::<S>(&Window::new(gas, density, radius)),
            table: Vec::new(),
            by_packing: Vec::new(),
            space: std::marker::PhantomData,
        };
        if spread.is_none() {
            let most = ((2.0 / unit) as u32).min(LARGEST_TABLE);
            rates.table = (0..most)
                .map(|units| TabulatedRate {
                    rate: rates.compute(
                        f64::from(units),
                        FreeVolumeFactors::NONE,
                        [rates.own, 1.0],
                    ),
                    packing: f64::from(units) * unit,
                    limited: density.is_limited(f64::from(units)),
                    class: arm::class(f64::from(units) * unit, true),
                })
                .collect();
        }
        if !gas.is_plain {
            let packings = (0..=PACKINGS).map(|entry| entry as f64 / PACKINGS as f64);
            rates.by_packing = packings
                .map(|packing| rates.covered_chi_there(packing))
                .collect();
        }
        rates
    }

    /// Packing fraction times chi, with its limit.
    fn covered_chi(&self, packing: f64) -> f64 {
        packing * S::contact_value(packing.min(DENSEST)).min(self.limit)
    }

    /// Packing fraction times chi, and its second derivative.
    pub(super) fn covered_chi_there(&self, packing: f64) -> [f64; 2] {
        let here = self.covered_chi(packing);
        let near = 0.02_f64.min(0.5 * packing);
        if near > 0.0 {
            let around = self.covered_chi(packing + near) + self.covered_chi(packing - near);
            [here, (around - 2.0 * here) / (near * near)]
        } else {
            [here, 0.0]
        }
    }

    /// Packing fraction times chi, and its second derivative, interpolated where the table reaches.
    #[inline]
    pub(super) fn covered_chi_near(&self, packing: f64) -> [f64; 2] {
        let place = packing * PACKINGS as f64;
        let entry = place as usize;
        match self.by_packing.get(entry..entry + 2) {
            Some([low, high]) => {
                let part = place - entry as f64;
                [0, 1].map(|which| low[which] + part * (high[which] - low[which]))
            }
            _ => self.covered_chi_there(packing),
        }
    }

    /// Corrected rate n chi of a simulator of `own` units that thins its surroundings by `thinned`
    /// units times H.
    fn compute(&self, units: f64, crowding: FreeVolumeFactors, [own, thinned]: [f64; 2]) -> f64 {
        let unit = self.unit * crowding.bodies;
        let raw = units * unit;
        let others = (raw - own * unit).max(0.0);
        let [missing, varies] = self.missing.at(others);
        let packing = others + missing * thinned * unit;
        let [covered_chi, curvature] = self.covered_chi_near(packing);
        let each = self.spread.map_or(1.0, |spread| spread.variance);
        let variance = each * self.mean_weight * unit * packing * varies;
        let covered_chi = (covered_chi - 0.5 * curvature * variance).max(0.0);
        crowding.centres * covered_chi / self.ball
    }

    /// Table entry for a number of units; `None` unless sizes are equal and no boundary is near.
    #[inline(always)]
    pub(super) fn known(&self, units: f64, crowding: FreeVolumeFactors) -> Option<&TabulatedRate> {
        let known = self.table.get(units as u32 as usize)?;
        (f64::from(units as u32) == units && crowding == FreeVolumeFactors::NONE).then_some(known)
    }

    /// Local rate n chi for `units` in the neighbourhood of a simulator \[1/length^D\]: itself
    /// included, or halfway to the contact without itself. `share`: its radius over the largest.
    #[inline]
    pub(crate) fn at(&self, units: f64, crowding: FreeVolumeFactors, share: f64) -> f64 {
        match self.spread {
            None => match self.known(units, crowding) {
                Some(known) => known.rate,
                None => self.compute(units, crowding, [self.own, 1.0]),
            },
            Some(spread) => {
                let own = share.powi(S::DIMENSION as i32);
                self.compute(units, crowding, [own, spread.thinned(share)])
            }
        }
    }

    /// Majorant of [`Self::at`] over all sizes \[1/length^D\].
    #[inline]
    pub(crate) fn most(&self, units: f64, crowding: FreeVolumeFactors) -> f64 {
        match self.spread {
            None => self.at(units, crowding, 1.0),
            Some(spread) => self.compute(units, crowding, [0.0, spread.thinned(1.0)]),
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of::<TabulatedRate>() * self.table.capacity()
            + size_of::<[f64; 2]>() * self.by_packing.capacity()
    }
}
