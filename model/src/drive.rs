//! A stochastic drive: random kicks that keep a dissipative gas in motion.
//!
//! After every interval each particle gets a kick, a Gaussian change of velocity that is
//! independent of everything else. In the limit of short intervals this is white noise.
//!
//! - Williams & MacKintosh, Phys. Rev. E 54, R9 (1996), doi:10.1103/PhysRevE.54.R9.
//! - Van Noije & Ernst, Granular Matter 1, 57 (1998), doi:10.1007/s100350050009.
//!
//! Each particle gains the same energy on average, so the variance of a kick is in inverse
//! proportion to the mass. The mean kick, weighted with the masses, is subtracted, so that the
//! total momentum is conserved.
//!
//! The temperature at which dissipation balances heating is
//! [`kinetic::heated_temperature`](crate::kinetic::heated_temperature). Scaling velocities is no
//! drive: it is free cooling in a moving unit of time, in which free cooling is stationary (J. J.
//! Brey, M. J. Ruiz-Montero & F. Moreno, Phys. Rev. E 69, 051303 (2004),
//! doi:10.1103/PhysRevE.69.051303).
//!
//! Kicks are addressed by their number and the index of the particle, so both engines draw the same
//! kicks, and a continued run draws the kicks of an uninterrupted one.

use rand_distr::{Distribution, StandardNormal};

use crate::invalid::Invalid;
use crate::physics::{ParticleModel, VectorOf};
use crate::random::{Purpose, Streams};
use crate::sizes::Sizes;
use crate::space::Space;

/// Random kicks at equal intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    heating: f64,
    interval: f64,
}

impl Drive {
    /// Creates a drive that adds, on average, the energy `heating` to each particle and unit of
    /// time \[energy/time\], by one kick after each `interval` \[time\].
    ///
    /// # Errors
    /// [`Invalid`] unless both are positive and finite, and the energy of one kick too.
    pub fn new(heating: f64, interval: f64) -> Result<Self, Invalid> {
        Invalid::unless_positive("energy of a kick", heating * interval)?;
        Ok(Self {
            heating: Invalid::unless_positive("heating", heating)?,
            interval: Invalid::unless_positive("interval between kicks", interval)?,
        })
    }

    /// Energy per particle and time \[energy/time\].
    pub fn heating(self) -> f64 {
        self.heating
    }

    /// Time between two kicks \[time\].
    pub fn interval(self) -> f64 {
        self.interval
    }

    /// Returns the changes of velocity \[length/time\] in kick number `number`, by the index of the
    /// particle.
    ///
    /// `simulator_start` is the number of gases that stand one after the other in the scene: the momentum of
    /// each is kept by itself, and kicks of the first are those of a gas that stands alone. With N
    /// particles in a gas, each component has the variance `2 heating interval/(D m) . N/(N - 1)`,
    /// where the last factor makes up for what the mean takes away, by the share of its mass from
    /// each. A particle alone stays as it is.
    pub fn kicks<P: ParticleModel>(
        self,
        scene: &P,
        particles: usize,
        copies: usize,
        number: u64,
        streams: &Streams,
    ) -> Vec<VectorOf<P>> {
        let sizes = scene.sizes();
        let mut kicks = vec![VectorOf::<P>::default(); particles];
        let size = particles / copies.max(1);
        if size < 2 {
            return kicks;
        }
        let energy = self.heating * self.interval * size as f64 / (size - 1) as f64;
        for (copy, gas) in kicks.chunks_mut(size).enumerate() {
            let (mut momentum, mut total) = (VectorOf::<P>::default(), 0.0);
            for (place, kick) in gas.iter_mut().enumerate() {
                let index = copy * size + place;
                let mass = sizes.mass(sizes.tag(index));
                let spread = (2.0 * energy / (P::Space::DIMENSION as f64 * mass)).sqrt();
                let mut stream = streams.at(Purpose::StochasticDrive, [number, index as u64]);
                for axis in 0..P::Space::DIMENSION {
                    let normal: f64 = StandardNormal.sample(&mut stream);
                    kick[axis] = spread * normal;
                }
                momentum += *kick * mass;
                total += mass;
            }
            let mean = momentum * (1.0 / total);
            for kick in gas {
                *kick -= mean;
            }
        }
        kicks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;
    use crate::{Constant, Free, Plane, Polydisperse, Scene, Smooth};

    type Mixture = Scene<Plane, Smooth, Constant, Polydisperse, Free>;

    fn mixture(count: usize) -> Mixture {
        let sizes = (0..count).map(|i| (0.5, [1.0, 4.0][i % 2])).collect();
        Scene {
            space: Plane,
            surface: Smooth,
            restitution: Constant::ELASTIC,
            sizes: Polydisperse::new(sizes).expect("positive"),
            field: Free,
        }
    }

    /// Momentum to rounding: N kicks of size 1 sum to at most N roundings of N. Energy within z =
    /// 4.4 standard errors (false alarm 1e-5) of a chi-squared with 2(N - 1) degrees of freedom for
    /// each kick; the error bar, 0.5 %, is small against the 11 % that the factor N/(N - 1) makes
    /// up for.
    #[test]
    fn kicks_keep_momentum_and_heat_as_asked() {
        let (count, kicks) = (10, 5000);
        let scene = mixture(count);
        let drive = Drive::new(3.0, 0.5).expect("positive");
        let streams = Streams::new(4, 1);
        let (mut light, mut heavy) = (0.0, 0.0);
        for number in 0..kicks {
            let all = drive.kicks(&scene, count, 1, number, &streams);
            let mut momentum = VectorOf::<Mixture>::default();
            for (index, kick) in all.iter().enumerate() {
                let mass = scene.sizes().mass(scene.sizes().tag(index));
                momentum += kick * mass;
                let energy = 0.5 * mass * kick.square();
                *[&mut light, &mut heavy][index % 2] += energy;
            }
            assert!(momentum.square().sqrt() < 1e-13, "{momentum}");
        }
        let total = (light + heavy) / (count as f64 * kicks as f64);
        let error = 1.5 * (2.0 / (2.0 * (count as f64 - 1.0) * kicks as f64)).sqrt();
        assert!((total - 1.5).abs() < 4.4 * error, "{total} ± {error}");
        // Taking out the mean takes the share m/M of the mass from each: 1 - 1/25 against 1 - 4/25
        // is left.
        let error = 2.0 / (count as f64 * kicks as f64).sqrt();
        let ratio = light / heavy / (0.96 / 0.84);
        assert!((ratio - 1.0).abs() < 4.4 * error, "{ratio} ± {error}");
    }

    #[test]
    fn copies_keep_their_momentum_and_the_first_is_the_gas_alone() {
        let streams = Streams::new(9, 0);
        let drive = Drive::new(1.0, 0.1).expect("positive");
        let alone = drive.kicks(&mixture(20), 20, 1, 7, &streams);
        let both = drive.kicks(&mixture(40), 40, 2, 7, &streams);
        assert_eq!(alone[..], both[..20]);
        assert_ne!(both[..20], both[20..]);
        assert_ne!(alone, drive.kicks(&mixture(20), 20, 1, 8, &streams));
        assert_eq!(
            drive.kicks(&mixture(1), 1, 1, 0, &streams),
            vec![VectorOf::<Mixture>::default()]
        );
    }

    #[test]
    fn drives_without_meaning_are_refused() {
        for (heating, interval) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (1e200, 1e200)] {
            assert!(Drive::new(heating, interval).is_err());
        }
    }
}
