//! Moments of velocities and displacements in a gas without positions, by species.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Sizes, Space, Vector, VectorOf};

use super::gas::{HomogeneousGas, SmoothPhysics};
use super::motion::DisplacementRecord;

/// Moments of velocities and displacements of one species, computed by [`moments`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeciesMoments {
    /// Number of particles of the species.
    pub count: usize,
    /// Granular temperature `T = m <v^2>/D` of the species \[energy\]; zero without particles.
    pub temperature: f64,
    /// Fourth velocity cumulant `a2 = D <v^4>/((D + 2) <v^2>^2) - 1` of the species.
    pub fourth_cumulant: f64,
    /// Mean squared displacement of the species \[length^2\]; zero unless displacements are
    /// tracked.
    pub displacement: f64,
    /// Mean fourth power of the displacement R of the species, `<R^4>` \[length^4\]; zero unless
    /// displacements are tracked.
    pub displacement_fourth: f64,
    /// Mean `<R . v>` of displacement R and velocity v \[length^2/time\], zero unless displacements
    /// are tracked; D times the diffusion coefficient in the diffusive regime.
    pub displacement_velocity: f64,
    /// Mean `<(R . v)^2>` of displacement R and velocity v \[length^4/time^2\]; zero unless
    /// displacements are tracked.
    pub displacement_velocity_square: f64,
    /// Velocity correlation `<v(0) . v(t)>` of the species \[length^2/time^2\]; zero unless the
    /// initial velocities are given.
    pub velocity_correlation: f64,
}

/// Computes the moments of velocities and displacements of every species, in one pass over the gas.
///
/// `displacement` has the paths and the current time, `start` the velocities at the start, by the
/// indices of the gas.
pub fn moments<P: SmoothPhysics>(
    gas: &HomogeneousGas<P>,
    displacement: Option<(&DisplacementRecord<P>, f64)>,
    start: Option<&[VectorOf<P>]>,
) -> Vec<SpeciesMoments> {
    moments_by(gas, |kind| kind as usize, displacement, start)
}

/// Computes the moments of velocities and displacements, see [`moments`], for groups of species:
/// `group` maps a species to its group. Temperature is the mean of `m v^2/D`, the cumulant that of
/// `sqrt(m) v`.
pub fn moments_by<P: SmoothPhysics>(
    gas: &HomogeneousGas<P>,
    group: impl Fn(u32) -> usize,
    displacement: Option<(&DisplacementRecord<P>, f64)>,
    start: Option<&[VectorOf<P>]>,
) -> Vec<SpeciesMoments> {
    #[derive(Clone, Copy, Default)]
    struct Sums {
        count: usize,
        second: f64,
        fourth: f64,
        displacement: f64,
        displacement_fourth: f64,
        displacement_velocity: f64,
        displacement_velocity_square: f64,
        correlation: f64,
    }
    let sizes = gas.scene.sizes();
    let mut sums: Vec<Sums> = Vec::new();
    for (index, particle) in gas.particles.iter().enumerate() {
        if particle.is_gone() {
            continue;
        }
        let number = group(sizes.species_of(particle.tag));
        if number >= sums.len() {
            sums.resize(number + 1, Sums::default());
        }
        let own = &mut sums[number];
        let square = sizes.mass(particle.tag) * particle.velocity.square();
        own.count += 1;
        own.second += square;
        own.fourth += square * square;
        if let Some((paths, time)) = displacement {
            let place = paths.displacement_at(index, &particle.velocity, time);
            let (square, along) = (place.square(), place.inner(&particle.velocity));
            own.displacement += square;
            own.displacement_fourth += square * square;
            own.displacement_velocity += along;
            own.displacement_velocity_square += along * along;
        }
        if let Some(before) = start.and_then(|start| start.get(index)) {
            own.correlation += before.inner(&particle.velocity);
        }
    }
    let d = P::Space::DIMENSION as f64;
    sums.into_iter()
        .map(|sums| {
            if sums.count == 0 {
                return SpeciesMoments::default();
            }
            let n = sums.count as f64;
            let mean = sums.second / n;
            SpeciesMoments {
                count: sums.count,
                temperature: mean / d,
                fourth_cumulant: if mean > 0.0 {
                    d * (sums.fourth / n) / ((d + 2.0) * mean * mean) - 1.0
                } else {
                    0.0
                },
                displacement: sums.displacement / n,
                displacement_fourth: sums.displacement_fourth / n,
                displacement_velocity: sums.displacement_velocity / n,
                displacement_velocity_square: sums.displacement_velocity_square / n,
                velocity_correlation: sums.correlation / n,
            }
        })
        .collect()
}
