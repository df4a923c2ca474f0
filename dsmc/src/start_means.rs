//! Means over the particles of a start.

use serde::{Deserialize, Serialize};
use stosszahl_model::{ParticleModel, Sizes, Space};

use crate::boundary::{Inflow, MOST_SIMULATORS};
use crate::cross_cell::Spread;

/// Sums over the initial particles. The number of simulators may change later; cells, tiles and
/// steps do not follow.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Means {
    /// Number of simulators at the start.
    simulators: usize,
    /// Sum of the weights in the averages: one per initial simulator, or the density of each
    /// inflow.
    count: f64,
    /// Sum of the diameters d \[length\].
    diameters: f64,
    /// Sum of d^(D-1).
    lower: f64,
    /// Sum of d^D.
    upper: f64,
    /// Sum of the areas or volumes \[length^D\].
    covered: f64,
    /// Sum of the masses \[mass\].
    mass: f64,
    /// Sums of the powers D to 2 D of radius over largest radius.
    powers: [f64; 4],
}

impl Means {
    /// Mean diameter, `M_(D-1)/M_D` of the diameters, mean mass, and mean area or volume.
    pub(crate) fn averages(&self) -> [f64; 4] {
        [
            self.diameters / self.count,
            self.lower / self.upper,
            self.mass / self.count,
            self.covered / self.count,
        ]
    }

    /// Packing fraction of the start. `share`: particles per simulator over the box volume.
    pub(crate) fn packing_fraction(&self, share: f64) -> f64 {
        match self.simulators {
            0 => 0.0,
            _ => share * self.covered,
        }
    }

    /// Number of simulators for which tiles are made: the number of the start, or of an empty box
    /// filled by its inflows, where `covered` is the area or volume of all simulators together. It
    /// does not follow the present number, so that a resumed run has the tiles of its start.
    pub(crate) fn expected(&self, covered: f64) -> usize {
        match self.simulators {
            0 => (covered * self.count / self.covered).min(MOST_SIMULATORS) as usize,
            some => some,
        }
    }

    /// Number of simulators at the start.
    pub(crate) fn simulators(&self) -> usize {
        self.simulators
    }

    /// Moments of unequal sizes that correct the local density; `None` for equal ones.
    pub(crate) fn spread<P: ParticleModel>(&self, sizes: &P::Sizes) -> Option<Spread> {
        let powers = self.powers.map(|sum| sum / self.count);
        (!sizes.are_equal()).then(|| Spread::new(P::Space::DIMENSION, powers))
    }

    /// Adds the size of this index with a weight.
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

    /// Averages over the first `simulators` sizes; for an empty start over the inflows, weighted by
    /// density; without inflows over the first size.
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
