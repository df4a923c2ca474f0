//! Velocity distributions, scaled by the thermal speed: histograms that reach into the tails, and
//! the cumulants a2 and a3.
//!
//! Velocities are taken relative to the mean flow u and over the thermal speed of their particle,
//! `c = (v - u) sqrt(m/(2 T))` with `T = <m (v - u)²>/D` of the moment, so that a Maxwellian is
//! `exp(-c²)/pi^(D/2)` in D dimensions. Near to it a distribution is (T. P. C. van Noije & M. H.
//! Ernst, *Granular Matter* **1**, 57 (1998), doi:10.1007/s100350050009)
//!
//! ```text
//! f(c) = pi^(-D/2) exp(-c²) [1 + a2 (c⁴/2 - (D + 2) c²/2 + D (D + 2)/8) + ...]
//! ```
//!
//! and the same with D = 1 for one component, since Sonine's polynomials keep their form when the
//! other components are summed over. The cumulants are
//!
//! ```text
//! a2 = 4 <c⁴>/(D (D + 2)) - 1,   a3 = 1 + 3 a2 - 8 <c⁶>/(D (D + 2) (D + 4))
//! ```
//!
//! N velocities over their own temperature lie on a sphere of n = D (N - 1) dimensions, on which a
//! Maxwellian has `<c⁴>` and `<c⁶>` smaller by n/(n + 2) and n²/((n + 2)(n + 4)): these factors are
//! divided out. N is `(Σ w)²/Σ w²` for particles of weights w. Where masses differ, the mean flow
//! takes the share m/M of the motion of a particle, M being the mass of all: the factors
//! `<(1 - m/M)²>/<1 - m/M>²` and `<(1 - m/M)³>/<1 - m/M>³` are divided out too.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use stosszahl_model::sum::Totals;
use stosszahl_model::{Grouping, Particle, ParticleReduction};

use crate::flow::{AddUp, SpeciesFlow, flows, thermal};

/// Quantity whose distribution a velocity histogram shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum VelocityQuantity {
    /// Single velocity components, with their sign.
    Component,
    /// Speed: the magnitude of the velocity.
    Speed,
}

/// Bins of a velocity histogram: equal widths in units of the thermal speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bins {
    /// Quantity that the histogram counts.
    pub quantity: VelocityQuantity,
    /// Dimension of space: 2 or 3.
    pub dimension: usize,
    /// Number of velocity bins of equal width.
    pub number: usize,
    /// Largest magnitude that the bins cover, over the thermal speed.
    pub range: f64,
}

/// Velocity distribution of a species at one time: histogram and cumulants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityHistogram {
    /// Probability density in each bin. The integral over the bins and `beyond` add up to one.
    pub density: Vec<f64>,
    /// Share of the velocities that lie outside the bins.
    pub beyond: f64,
    /// Fourth cumulant a2 of the velocities; 0 for a Maxwellian.
    pub fourth_cumulant: f64,
    /// Sixth cumulant a3 of the velocities; 0 for a Maxwellian.
    pub sixth_cumulant: f64,
}

impl Bins {
    /// Returns the lower edge of the first bin, over the thermal speed.
    fn low(&self) -> f64 {
        match self.quantity {
            VelocityQuantity::Component => -self.range,
            VelocityQuantity::Speed => 0.0,
        }
    }

    /// Returns the width of a bin, over the thermal speed.
    pub fn width(&self) -> f64 {
        (self.range - self.low()) / self.number as f64
    }

    /// Returns lower and upper edge of a bin, over the thermal speed.
    pub fn edges(&self, bin: usize) -> [f64; 2] {
        [bin, bin + 1].map(|edge| self.low() + edge as f64 * self.width())
    }

    /// Computes the mean probability density in a bin of a Maxwellian with the Sonine correction of
    /// a fourth cumulant, by Simpson's rule in 16 steps.
    ///
    /// ```
    /// use stosszahl_analysis::velocities::{Bins, VelocityQuantity};
    ///
    /// let bins = Bins { quantity: VelocityQuantity::Component, dimension: 2, number: 100, range: 5.0 };
    /// let sum: f64 = (0..100).map(|bin| bins.sonine(bin, -0.02) * bins.width()).sum();
    /// assert!((sum - 1.0).abs() < 1e-9);
    /// ```
    pub fn sonine(&self, bin: usize, fourth_cumulant: f64) -> f64 {
        const STEPS: usize = 16;
        let [low, high] = self.edges(bin);
        let sum: f64 = (0..=STEPS)
            .map(|step| {
                let weight = match step {
                    0 | STEPS => 1.0,
                    odd if odd % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                let c = low + (high - low) * step as f64 / STEPS as f64;
                weight * self.density(c, fourth_cumulant)
            })
            .sum();
        sum / (3 * STEPS) as f64
    }

    /// Computes the probability density at c of a Maxwellian with the Sonine correction of a2.
    fn density(&self, c: f64, a2: f64) -> f64 {
        let square = c * c;
        let (d, shell) = match self.quantity {
            VelocityQuantity::Component => (1.0, 1.0 / PI.sqrt()),
            VelocityQuantity::Speed if self.dimension == 2 => (2.0, 2.0 * c),
            VelocityQuantity::Speed => (3.0, 4.0 / PI.sqrt() * square),
        };
        let sonine = 0.5 * square * square - 0.5 * (d + 2.0) * square + d * (d + 2.0) / 8.0;
        shell * (-square).exp() * (1.0 + a2 * sonine)
    }

    /// Measures the velocity distribution of each species of a gas; `None` for species of fewer
    /// than two particles, or at rest.
    pub fn measure(
        &self,
        grouping: Grouping,
        reduce_particles: &mut AddUp<'_>,
    ) -> Vec<Option<VelocityHistogram>> {
        let d = self.dimension as f64;
        let flows = flows(grouping, reduce_particles);
        let thermal = thermal(grouping, &flows, reduce_particles);
        let mut counts = VelocityCounts {
            bins: *self,
            grouping,
            species: (flows.iter().zip(&thermal))
                .map(|(flow, thermal)| {
                    let temperature = thermal.twice_energy / (d * flow.number);
                    let freedom = d * (flow.number * flow.number / flow.squares - 1.0);
                    // Of one particle the drift takes all motion, but for rounding.
                    let moves = temperature > 0.0 && freedom > 0.5;
                    moves.then_some((*flow, temperature, freedom))
                })
                .collect(),
            totals: Totals::new(grouping.groups() * (self.number + 3)),
        };
        reduce_particles(&mut counts);
        let sums = counts.totals.values();
        let each = counts.species.iter().zip(&thermal);
        each.zip(sums.chunks(self.number + 3))
            .map(|((known, thermal), sums)| {
                let (flow, _, n) = (*known)?;
                let (seen, sums) = sums.split_at(self.number);
                let all = match self.quantity {
                    VelocityQuantity::Speed => flow.number,
                    VelocityQuantity::Component => d * flow.number,
                };
                let [one, two, three] = thermal.free.map(|sum| sum / flow.number);
                let [fourth, sixth] = [sums[1], sums[2]].map(|sum| sum / flow.number);
                let fourth = fourth * 4.0 / (d * (d + 2.0)) * (n + 2.0) / n * one * one / two;
                let sixth =
                    sixth * 8.0 / (d * (d + 2.0) * (d + 4.0)) * (n + 2.0) * (n + 4.0) / (n * n);
                let sixth = sixth * one.powi(3) / three;
                Some(VelocityHistogram {
                    density: seen.iter().map(|sum| sum / (all * self.width())).collect(),
                    beyond: sums[0] / all,
                    fourth_cumulant: fourth - 1.0,
                    sixth_cumulant: 1.0 + 3.0 * (fourth - 1.0) - sixth,
                })
            })
            .collect()
    }
}

/// Reduction over particles that sums, by species, the weights in each bin and beyond, and the
/// fourth and sixth powers of velocities.
#[derive(Serialize, Deserialize)]
pub struct VelocityCounts {
    bins: Bins,
    grouping: Grouping,
    /// Flow, temperature and degrees of freedom of each species; `None` for species that are not
    /// counted.
    species: Vec<Option<(SpeciesFlow, f64, f64)>>,
    totals: Totals,
}

impl ParticleReduction for VelocityCounts {
    const NAME: &'static str = "velocities";

    fn add_particle(&mut self, particle: &Particle) {
        let Self {
            bins,
            species: all,
            totals,
            ..
        } = self;
        let species = self.grouping.group(particle.species);
        let Some((flow, temperature, _)) = &all[species] else {
            return;
        };
        let c = (particle.velocity - flow.velocity) * (0.5 * particle.mass / temperature).sqrt();
        let (square, number) = (c.norm_squared(), bins.number);
        let sums = &mut totals.open()[species * (number + 3)..][..number + 3];
        let mut count = |value: f64| {
            let bin = (value - bins.low()) / bins.width();
            let is_inside = bin >= 0.0 && bin < number as f64;
            sums[if is_inside { bin as usize } else { number }] += particle.weight;
        };
        match bins.quantity {
            VelocityQuantity::Speed => count(square.sqrt()),
            VelocityQuantity::Component => c
                .iter()
                .take(bins.dimension)
                .for_each(|&value| count(value)),
        }
        sums[number + 1] += particle.weight * square * square;
        sums[number + 2] += particle.weight * square * square * square;
    }

    fn close_group(&mut self, _group: u32) {
        self.totals.close();
    }

    fn merge_sum(&mut self, other: Self) {
        self.totals.merge(&other.totals);
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::*;
    use crate::statistics::RunningMoments;
    use nalgebra::{Vector3, vector};
    use rand::SeedableRng;
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use stosszahl_model::DynReduction;

    fn bins(quantity: VelocityQuantity, dimension: usize) -> Bins {
        Bins {
            quantity,
            dimension,
            number: 64,
            range: 6.0,
        }
    }

    /// Measures the velocity distribution of particles of one species, added in groups, for tests.
    fn measure(bins: Bins, particles: &[Particle]) -> Option<VelocityHistogram> {
        let mut reduce = |sum: &mut dyn DynReduction| {
            for (group, some) in particles.chunks(1000).enumerate() {
                for one in some {
                    sum.add_particle(one);
                }
                sum.close_group(group as u32);
            }
        };
        bins.measure(Grouping::new(1, None), &mut reduce).remove(0)
    }

    fn maxwellian(count: usize, dimension: usize, seed: u64) -> Vec<Particle> {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
        let one = |index: usize| {
            let mass: f64 = [1.0, 4.0][index % 2];
            let mut part = |axis: usize| -> f64 {
                let normal: f64 = StandardNormal.sample(&mut stream);
                if axis < dimension {
                    normal / mass.sqrt()
                } else {
                    0.0
                }
            };
            let thermal: Vector3<f64> = vector![part(0), part(1), part(2)];
            Particle {
                velocity: thermal + vector![2.0, 1.0, 0.0],
                weight: 3.0,
                ..Particle::at_rest(0.5, mass)
            }
        };
        (0..count).map(one).collect()
    }

    /// Tests the moments of the Sonine densities: one, D/2 (1/2 of a component), and the fourth
    /// with 1 + a2. Bins are narrow; the mean of c^k over a bin differs from that at its middle by
    /// second differences, some 1e-3.
    #[test]
    fn densities_have_their_moments() {
        for (quantity, dimension, d) in [
            (VelocityQuantity::Component, 2, 1.0),
            (VelocityQuantity::Component, 3, 1.0),
            (VelocityQuantity::Speed, 2, 2.0),
            (VelocityQuantity::Speed, 3, 3.0),
        ] {
            let bins = Bins {
                number: 600,
                ..bins(quantity, dimension)
            };
            let moment = |power: i32| -> f64 {
                (0..bins.number)
                    .map(|bin| {
                        let [low, high] = bins.edges(bin);
                        bins.sonine(bin, 0.1) * bins.width() * (0.5 * (low + high)).powi(power)
                    })
                    .sum()
            };
            assert!((moment(0) - 1.0).abs() < 1e-9, "{quantity:?}");
            assert!((moment(2) / (0.5 * d) - 1.0).abs() < 1e-3, "{quantity:?}");
            let fourth = d * (d + 2.0) / 4.0 * 1.1;
            assert!((moment(4) / fourth - 1.0).abs() < 1e-3, "{quantity:?}");
        }
    }

    /// Tests that both cumulants are zero for a few particles of two masses in a wind, many times.
    /// Within z = 4.4 standard errors (false alarm 1e-5 each); without the factors the first is off
    /// by 2/n, ten of them.
    #[test]
    fn cumulants_of_a_maxwellian_are_zero() {
        for dimension in [2, 3] {
            let bins = bins(VelocityQuantity::Speed, dimension);
            let (mut fourth, mut sixth) = (RunningMoments::default(), RunningMoments::default());
            for seed in 0..20_000 {
                let found = measure(bins, &maxwellian(10, dimension, seed)).unwrap();
                fourth.add(found.fourth_cumulant);
                sixth.add(found.sixth_cumulant);
                let all = found.density.iter().sum::<f64>() * bins.width() + found.beyond;
                assert!((all - 1.0).abs() < 1e-12);
            }
            for moments in [fourth, sixth] {
                let [mean, error] = [moments.mean().unwrap(), moments.standard_error().unwrap()];
                assert!(mean.abs() < 4.4 * error, "{mean} {error}");
                assert!(error < 0.2 / freedom(dimension), "{error}");
            }
        }
    }

    fn freedom(dimension: usize) -> f64 {
        9.0 * dimension as f64
    }

    /// Tests, bin by bin, the counts of a Maxwellian against its density: the largest of 64
    /// deviations is within z = 5.2 (false alarm 1e-5 in all); the tail is empty where less than
    /// one is expected.
    #[test]
    fn histograms_of_a_maxwellian_are_its_density() {
        let count = 40_000;
        let gas = maxwellian(count, 2, 7);
        for quantity in [VelocityQuantity::Component, VelocityQuantity::Speed] {
            let bins = bins(quantity, 2);
            let found = measure(bins, &gas).unwrap();
            let entries = count as f64
                * if quantity == VelocityQuantity::Component {
                    2.0
                } else {
                    1.0
                };
            for (bin, density) in found.density.iter().enumerate() {
                let expected = bins.sonine(bin, 0.0) * bins.width() * entries;
                let seen = density * bins.width() * entries;
                let good = (seen - expected).abs() < 5.2 * expected.sqrt() + 5.2;
                assert!(good, "{quantity:?} {bin}: {seen} {expected}");
            }
        }
    }

    #[test]
    fn what_does_not_move_has_no_distribution() {
        let bins = bins(VelocityQuantity::Speed, 2);
        let still = Particle {
            velocity: Vector3::x(),
            ..Particle::at_rest(0.5, 1.0)
        };
        assert_eq!(measure(bins, &[]), None);
        assert_eq!(measure(bins, &[still]), None);
        assert_eq!(measure(bins, &[still; 5]), None);
    }
}
