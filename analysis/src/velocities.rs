//! The distribution of velocities over the thermal speed: histograms that reach into the tails, and their cumulants.
//!
//! Velocities are taken relative to the mean flow u and over the thermal speed of their particle,
//! `c = (v - u) sqrt(m/(2 T))` with `T = <m (v - u)²>/D` of the moment, so that a Maxwellian is `exp(-c²)/pi^(D/2)` in D dimensions.
//! Near to it a distribution is (T. P. C. van Noije & M. H. Ernst, *Granular Matter* **1**, 57 (1998),
//! doi:10.1007/s100350050009)
//!
//! ```text
//! f(c) = pi^(-D/2) exp(-c²) [1 + a2 (c⁴/2 - (D + 2) c²/2 + D (D + 2)/8) + ...]
//! ```
//!
//! and the same with D = 1 for one component, since Sonine's polynomials keep their form when the other components are summed
//! over. The cumulants are
//!
//! ```text
//! a2 = 4 <c⁴>/(D (D + 2)) - 1,   a3 = 1 + 3 a2 - 8 <c⁶>/(D (D + 2) (D + 4))
//! ```
//!
//! N velocities over their own temperature lie on a sphere of n = D (N - 1) dimensions, on which a Maxwellian has `<c⁴>` and `<c⁶>`
//! smaller by n/(n + 2) and n²/((n + 2)(n + 4)): these factors are divided out. N is `(Σ w)²/Σ w²` for particles of weights w. Where
//! masses differ, the mean flow takes the share m/M of the motion of a particle, M being the mass of all: the factors
//! `<(1 - m/M)²>/<1 - m/M>²` and `<(1 - m/M)³>/<1 - m/M>³` are divided out too.

use std::f64::consts::PI;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Each component, of either sign.
    Component,
    /// The speed.
    Speed,
}

/// Equal bins of velocities over the thermal speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bins {
    /// What is counted.
    pub quantity: Quantity,
    /// 2 or 3.
    pub dimension: usize,
    /// Number of bins.
    pub number: usize,
    /// Largest magnitude.
    pub range: f64,
}

/// A particle as the distribution sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Velocity \[length/time\]; beyond the dimension zero.
    pub velocity: Vector3<f64>,
    /// Mass.
    pub mass: f64,
    /// Number of particles that it stands for.
    pub weight: f64,
}

/// What was found at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Density by bin; with what lies beyond the bins its integral is one.
    pub density: Vec<f64>,
    /// Share beyond the bins.
    pub beyond: f64,
    /// Fourth cumulant a2.
    pub fourth_cumulant: f64,
    /// Sixth cumulant a3.
    pub sixth_cumulant: f64,
}

impl Bins {
    /// Lower edge of the first bin.
    fn low(&self) -> f64 {
        match self.quantity {
            Quantity::Component => -self.range,
            Quantity::Speed => 0.0,
        }
    }

    /// Width of a bin.
    pub fn width(&self) -> f64 {
        (self.range - self.low()) / self.number as f64
    }

    /// Edges of a bin.
    pub fn edges(&self, bin: usize) -> [f64; 2] {
        [bin, bin + 1].map(|edge| self.low() + edge as f64 * self.width())
    }

    /// Mean density in a bin of a Maxwellian with the Sonine correction of a fourth cumulant, by Simpson's rule in 16 steps.
    ///
    /// ```
    /// use stosszahl_analysis::velocities::{Bins, Quantity};
    ///
    /// let bins = Bins { quantity: Quantity::Component, dimension: 2, number: 100, range: 5.0 };
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

    /// Density of a Maxwellian with its Sonine correction.
    fn density(&self, c: f64, a2: f64) -> f64 {
        let square = c * c;
        let (d, shell) = match self.quantity {
            Quantity::Component => (1.0, 1.0 / PI.sqrt()),
            Quantity::Speed if self.dimension == 2 => (2.0, 2.0 * c),
            Quantity::Speed => (3.0, 4.0 / PI.sqrt() * square),
        };
        let sonine = 0.5 * square * square - 0.5 * (d + 2.0) * square + d * (d + 2.0) / 8.0;
        shell * (-square).exp() * (1.0 + a2 * sonine)
    }

    /// The distribution of some particles; none of fewer than two, or at rest.
    pub fn measure(&self, particles: &[Particle]) -> Option<Distribution> {
        let d = self.dimension as f64;
        let (mut weights, mut squares, mut mass) = (0.0, 0.0, 0.0);
        let mut momentum = Vector3::zeros();
        for one in particles {
            weights += one.weight;
            squares += one.weight * one.weight;
            mass += one.weight * one.mass;
            momentum += one.velocity * (one.weight * one.mass);
        }
        let drift = momentum / mass;
        let energy = |one: &Particle| one.mass * (one.velocity - drift).norm_squared();
        let twice: f64 = particles.iter().map(|one| one.weight * energy(one)).sum();
        let temperature = twice / (d * weights);
        let freedom = d * (weights * weights / squares - 1.0);
        // Of one particle the drift takes all motion, but for rounding.
        if !(temperature > 0.0 && freedom > 0.5) {
            return None;
        }
        let (mut density, mut beyond) = (vec![0.0; self.number], 0.0);
        let (mut fourth, mut sixth, mut free) = (0.0, 0.0, [0.0; 3]);
        let mut count = |value: f64, share: f64| {
            let bin = (value - self.low()) / self.width();
            match density.get_mut(bin as usize) {
                Some(sum) if bin >= 0.0 => *sum += share / self.width(),
                _ => beyond += share,
            }
        };
        for one in particles {
            let share = one.weight / weights;
            let c = (one.velocity - drift) * (0.5 * one.mass / temperature).sqrt();
            let square = c.norm_squared();
            // The drift takes a share of the motion of each particle that grows with its mass.
            let own = 1.0 - one.weight * one.mass / mass;
            for (sum, power) in free.iter_mut().zip(1..) {
                *sum += share * own.powi(power);
            }
            fourth += share * square * square;
            sixth += share * square * square * square;
            match self.quantity {
                Quantity::Speed => count(square.sqrt(), share),
                Quantity::Component => {
                    let axes = c.iter().take(self.dimension);
                    axes.for_each(|&value| count(value, share / d));
                }
            }
        }
        let (n, [one, two, three]) = (freedom, free);
        let fourth = fourth * 4.0 / (d * (d + 2.0)) * (n + 2.0) / n * one * one / two;
        let sixth = sixth * 8.0 / (d * (d + 2.0) * (d + 4.0)) * (n + 2.0) * (n + 4.0) / (n * n);
        let sixth = sixth * one.powi(3) / three;
        Some(Distribution {
            density,
            beyond,
            fourth_cumulant: fourth - 1.0,
            sixth_cumulant: 1.0 + 3.0 * (fourth - 1.0) - sixth,
        })
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::*;
    use crate::statistics::Moments;
    use nalgebra::vector;
    use rand::SeedableRng;
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn bins(quantity: Quantity, dimension: usize) -> Bins {
        Bins {
            quantity,
            dimension,
            number: 64,
            range: 6.0,
        }
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
                mass,
                weight: 3.0,
            }
        };
        (0..count).map(one).collect()
    }

    /// Moments of the densities: one, D/2 (1/2 of a component), and the fourth with 1 + a2. Bins are narrow; the mean of c^k over a bin
    /// differs from that at its middle by second differences, some 1e-3.
    #[test]
    fn densities_have_their_moments() {
        for (quantity, dimension, d) in [
            (Quantity::Component, 2, 1.0),
            (Quantity::Component, 3, 1.0),
            (Quantity::Speed, 2, 2.0),
            (Quantity::Speed, 3, 3.0),
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

    /// A few particles of two masses in a wind, many times: both cumulants are zero without the bias of few. Within z = 4.4 standard
    /// errors (false alarm 1e-5 each); without the factors the first is off by 2/n, ten of them.
    #[test]
    fn cumulants_of_a_maxwellian_are_zero() {
        for dimension in [2, 3] {
            let bins = bins(Quantity::Speed, dimension);
            let (mut fourth, mut sixth) = (Moments::default(), Moments::default());
            for seed in 0..20_000 {
                let found = bins.measure(&maxwellian(10, dimension, seed)).unwrap();
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

    /// Bin by bin: counts of a Maxwellian against its density, the largest of 64 deviations within z = 5.2 (false alarm 1e-5 in all);
    /// the tail is empty where less than one is expected.
    #[test]
    fn histograms_of_a_maxwellian_are_its_density() {
        let count = 40_000;
        let gas = maxwellian(count, 2, 7);
        for quantity in [Quantity::Component, Quantity::Speed] {
            let bins = bins(quantity, 2);
            let found = bins.measure(&gas).unwrap();
            let entries = count as f64
                * if quantity == Quantity::Component {
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
        let bins = bins(Quantity::Speed, 2);
        let still = Particle {
            velocity: Vector3::x(),
            mass: 1.0,
            weight: 1.0,
        };
        assert_eq!(bins.measure(&[]), None);
        assert_eq!(bins.measure(&[still]), None);
        assert_eq!(bins.measure(&[still; 5]), None);
    }
}
