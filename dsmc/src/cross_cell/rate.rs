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

/// Largest number of entries in the table of collision rates by number of neighbours.
const LARGEST_TABLE: u32 = 1 << 14;

/// Largest packing fraction at which the contact value chi is evaluated; beyond it chi is limited
/// anyway.
const DENSEST: f64 = 0.9;

/// Number of intervals in the table of packing fraction times chi, over packing fractions from 0 to
/// 1.
const PACKINGS: usize = 2048;

/// Table entry of the local collision rate for a whole number of neighbours in a neighbourhood
/// without boundaries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TabulatedRate {
    /// Local collision rate n chi, corrected for noise of the neighbour count \[1/length^D\].
    pub(super) rate: f64,
    /// Packing fraction of the neighbourhood, uncorrected.
    pub(super) packing: f64,
    /// True if the contact value chi is at its limit at this packing fraction.
    pub(super) limited: bool,
    /// Class of packing fraction for the adaptive contact distance.
    pub(super) class: u8,
}

/// Local collision rate n chi as a function of the neighbour count, corrected for the noise of that
/// count.
pub(crate) struct Rates<S: Space> {
    limit: f64,
    /// Packing fraction that one unit, the area or volume of a largest particle, contributes to the
    /// neighbourhood.
    unit: f64,
    /// Contribution of a simulator to the count in its own neighbourhood \[units of the largest
    /// particle\]; zero if the density leaves the simulator out.
    own: f64,
    /// Mean of the cell weights w in a density window, weighted by w: sum of w^2 over sum of w.
    mean_weight: f64,
    /// Mean area or volume of a particle \[length^D\].
    ball: f64,
    /// Moments of the size distribution that enter the noise correction; `None` for equal sizes.
    spread: Option<Spread>,
    missing: CorrelationHole,
    table: Vec<TabulatedRate>,
    /// Packing fraction times chi, and its second derivative, at equally spaced packing fractions;
    /// empty where `table` suffices.
    by_packing: Vec<[f64; 2]>,
    space: std::marker::PhantomData<S>,
}

/// Moments of an unequal size distribution that enter the noise correction, in units of the largest
/// size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Unit of the variance of the covered area or volume a, `<a^2>/<a>`.
    variance: f64,
    /// Coefficients of the polynomial in the radius of a simulator by which its own presence lowers
    /// the packing fraction around it, from the zeroth power on: `<a^2> w/<a w>` with the covered
    /// area or volume a and the weight w of a radius.
    thinning: [f64; 4],
}

impl Spread {
    /// Computes the moments of a size distribution for the noise correction. `powers` are the means
    /// of the powers D to 2 D of radius over largest radius.
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
    /// Tabulates local collision rates. `ball` is the mean area or volume of a particle, `spread`
    /// is `None` for equal sizes, `radius` is the distance from the contact point within which
    /// partners are drawn \[length\].
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

    /// Returns the packing fraction times the contact value chi, with the limit of chi.
    fn covered_chi(&self, packing: f64) -> f64 {
        packing * S::contact_value(packing.min(DENSEST)).min(self.limit)
    }

    /// Computes the packing fraction times the contact value chi, and its second derivative by the
    /// packing fraction.
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

    /// Returns phi chi(phi), the packing fraction `packing` times the contact value, and its second
    /// derivative by phi: interpolated in the table of packing fractions, computed beyond the table.
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

    /// Computes the corrected rate n chi of a simulator \[1/length^D\]. `own` is its contribution
    /// to its neighbourhood, `thinned` the factor of the deficit H, both in units of the largest
    /// particle.
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

    /// Returns the table entry for a number of neighbours; `None` unless sizes are equal and no
    /// boundary is near.
    #[inline(always)]
    pub(super) fn known(&self, units: f64, crowding: FreeVolumeFactors) -> Option<&TabulatedRate> {
        let known = self.table.get(units as u32 as usize)?;
        (f64::from(units as u32) == units && crowding == FreeVolumeFactors::NONE).then_some(known)
    }

    /// Returns the local collision rate n chi of a simulator \[1/length^D\] for the neighbour count
    /// `units`, which includes itself, unless counted halfway to the contact. `share` is its radius
    /// over the largest.
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

    /// Returns a majorant over all sizes of the local collision rate [`Self::at`] \[1/length^D\].
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
