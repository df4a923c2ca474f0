//! Means over the particles of a start.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Physics, Sizes, Space};

use crate::boundary::{Inflow, MOST_SIMULATORS};
use crate::cross_cell::Spread;

/// Sums over the particles of the start. Simulators may come and go; cells, tiles and steps stay as they were chosen.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Means {
    /// How many simulators there were.
    simulators: usize,
    /// Sum of the weights of what is averaged: one for each simulator of a start, its density for each inflow.
    count: f64,
    /// Sums of their diameters d, of d^(D-1), of d^D, of their areas or volumes, and of their masses.
    diameters: f64,
    lower: f64,
    upper: f64,
    covered: f64,
    mass: f64,
    /// Sums of the powers D to 2 D of the radius over the largest.
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

    /// Packing fraction of the start, for simulators that count as `share` over the volume of the box.
    pub(crate) fn packing_fraction(&self, share: f64) -> f64 {
        match self.simulators {
            0 => 0.0,
            _ => share * self.covered,
        }
    }

    /// How many simulators tiles are made for, of which all cover `covered`: those of the start, or what flows into an empty
    /// box. Not the number of the moment, so that a continued run has the tiles of its start.
    pub(crate) fn expected(&self, covered: f64) -> usize {
        match self.simulators {
            0 => (covered * self.count / self.covered).min(MOST_SIMULATORS) as usize,
            some => some,
        }
    }

    /// How many simulators there were at the start.
    pub(crate) fn simulators(&self) -> usize {
        self.simulators
    }

    /// What unequal sizes do to the count of a neighbourhood.
    pub(crate) fn spread<P: Physics>(&self, sizes: &P::Sizes) -> Option<Spread> {
        let powers = self.powers.map(|sum| sum / self.count);
        (!sizes.are_equal()).then(|| Spread::new(P::Space::DIMENSION, powers))
    }

    /// Adds the size with an index, `weight` times.
    fn add<P: Physics>(&mut self, sizes: &P::Sizes, index: usize, weight: f64) {
        let dimension = P::Space::DIMENSION as i32;
        let tag = sizes.tag(index);
        let radius = sizes.radius(tag);
        self.count += weight;
        self.diameters += weight * 2.0 * radius;
        self.lower += weight * (2.0 * radius).powi(dimension - 1);
        self.upper += weight * (2.0 * radius).powi(dimension);
        self.covered += weight * P::Space::ball(radius);
        self.mass += weight * sizes.mass(tag);
        let share = radius / sizes.largest_radius();
        for (power, sum) in (dimension..=2 * dimension).zip(&mut self.powers) {
            *sum += weight * share.powi(power);
        }
    }

    /// Of the first `simulators` sizes; of an empty start, of what flows in, each by its density, and if nothing does, of
    /// the first size.
    pub(crate) fn of<P: Physics>(
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
        // What is too much, or no number, is refused later.
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
