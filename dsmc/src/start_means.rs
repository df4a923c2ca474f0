//! Means of size and mass over the initial particles, or over the inflows of an empty box, from
//! which a DSMC run chooses cells and tiles.

use serde::{Deserialize, Serialize};
use stosszahl_model::{ParticleModel, Sizes, Space};

use crate::boundary::{Inflow, MOST_SIMULATORS};
use crate::cross_cell::Spread;

/// Sums over the initial particles from which means follow. The number of simulators may change
/// later; cells, tiles and steps do not follow.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Means {
    /// Number of simulators at the start of the run.
    simulators: usize,
    /// Sum of the statistical weights: one for each initial simulator, or the density of each
    /// inflow.
    count: f64,
    /// Weighted sum of the particle diameters d \[length\].
    diameters: f64,
    /// Weighted sum of d^(D-1), with particle diameters d \[length^(D-1)\].
    lower: f64,
    /// Weighted sum of d^D, with particle diameters d \[length^D\].
    upper: f64,
    /// Weighted sum of the areas or volumes of the particles \[length^D\].
    covered: f64,
    /// Weighted sum of the particle masses \[mass\].
    mass: f64,
    /// Weighted sums of the powers D to 2 D of particle radius over largest radius.
    powers: [f64; 4],
}

impl Means {
    /// Returns the mean diameter \[length\], the moment ratio `M_(D-1)/M_D` of the diameters
    /// \[1/length\], the mean mass \[mass\], and the mean area or volume of a particle
    /// \[length^D\].
    pub(crate) fn averages(&self) -> [f64; 4] {
        [
            self.diameters / self.count,
            self.lower / self.upper,
            self.mass / self.count,
            self.covered / self.count,
        ]
    }

    /// Returns the packing fraction of the initial gas. `share` is the number of particles per
    /// simulator over the box volume.
    pub(crate) fn packing_fraction(&self, share: f64) -> f64 {
        match self.simulators {
            0 => 0.0,
            _ => share * self.covered,
        }
    }

    /// Returns the number of simulators for which tiles are laid out: that of the start, or of an
    /// empty box filled by its inflows. It does not follow the current number, so that a resumed
    /// run has the tiles of its start.
    pub(crate) fn expected(&self, covered: f64) -> usize {
        match self.simulators {
            0 => (covered * self.count / self.covered).min(MOST_SIMULATORS) as usize,
            some => some,
        }
    }

    /// Returns the number of simulators at the start of the run.
    pub(crate) fn simulators(&self) -> usize {
        self.simulators
    }

    /// Returns the moments of unequal sizes that correct the local density for noise; `None` for
    /// equal sizes.
    pub(crate) fn spread<P: ParticleModel>(&self, sizes: &P::Sizes) -> Option<Spread> {
        let powers = self.powers.map(|sum| sum / self.count);
        (!sizes.are_equal()).then(|| Spread::new(P::Space::DIMENSION, powers))
    }

    /// Adds a particle of the size with this index to the sums, with a statistical weight.
    fn add<P: ParticleModel>(&mut self, sizes: &P::Sizes, index: usize, weight: f64) {
        let dimension = P::Space::DIMENSION as i32;
        let tag = sizes.tag_of(index);
        let radius = sizes.radius(tag);
        self.count += weight;
        self.diameters += weight * 2.0 * radius;
        self.lower += weight * (2.0 * radius).powi(dimension - 1);
        self.upper += weight * (2.0 * radius).powi(dimension);
        self.covered += weight * P::Space::particle_volume(radius);
        self.mass += weight * sizes.mass(tag);
        let share = radius / sizes.largest_radius();
        for (power, sum) in (dimension..=2 * dimension).zip(&mut self.powers) {
            *sum += weight * share.powi(power);
        }
    }

    /// Computes the sums over the first `simulators` sizes; for an empty start over the inflows,
    /// weighted by density; without inflows over the first size.
    pub(crate) fn over_simulators<P: ParticleModel>(
        sizes: &P::Sizes,
        simulators: usize,
        inflows: &[Inflow<P::Space>],
    ) -> Self {
        let mut means = Self {
            simulators,
            ..Self::default()
        };
        for index in 0..simulators {
            means.add::<P>(sizes, index, 1.0);
        }
        if simulators > 0 {
            return means;
        }
        // Excessive or NaN densities are refused later.
        let allowed = |inflow: &&Inflow<_>| inflow.density > 0.0 && inflow.density < 1e150;
        for inflow in inflows.iter().filter(allowed) {
            means.add::<P>(sizes, inflow.like, inflow.density);
        }
        if means.count == 0.0 {
            means.add::<P>(sizes, 0, 1.0);
        }
        means
    }
}
