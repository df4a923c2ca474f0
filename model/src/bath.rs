//! Thermal bath: random kicks of all particles at equal intervals, as white noise or as a Langevin
//! bath with drag.
//!
//! **White noise.** After every interval each particle gets a kick, a Gaussian change of velocity
//! that is independent of everything else. In the limit of short intervals this is white noise.
//!
//! Source of the bath: Williams & MacKintosh, Phys. Rev. E 54, R9 (1996),
//! doi:10.1103/PhysRevE.54.R9. Source of its kinetic theory: van Noije & Ernst, Granular Matter 1,
//! 57 (1998), doi:10.1007/s100350050009.
//!
//! Each particle gains the same energy on average, so the variance of a kick is in inverse
//! proportion to the mass. The mean kick, weighted with the masses, is subtracted, so that the bath
//! conserves the total momentum.
//!
//! **Langevin.** Between collisions `m dv/dt = -m gamma v + sqrt(2 gamma m T_b) xi(t)`, with the
//! drag gamma and the temperature of the bath `T_b` (Puglisi, Loreto, Marconi, Petri & Vulpiani,
//! Phys. Rev. Lett. 81, 3848 (1998), doi:10.1103/PhysRevLett.81.3848; Gradenigo, Sarracino,
//! Villamaina & Puglisi, J. Stat. Mech. (2011) P08017, doi:10.1088/1742-5468/2011/08/P08017). A
//! kick is the exact Ornstein-Uhlenbeck step of one interval tau, `v -> v e^(-gamma tau) +
//! sqrt((T_b/m)(1 - e^(-2 gamma tau))) xi`: velocities are multiplied by [`Bath::damping`], then
//! [`Bath::kicks`] are added. Each particle has noise of its own, and the total momentum fluctuates
//! like the velocity of a particle with the mass of the gas.
//!
//! Both act on translation alone, as in Vega Reyes & Santos, Phys. Fluids 27, 113301 (2015),
//! doi:10.1063/1.4934727: spins are heated by rough contacts.
//!
//! Particles fly and collide as without a bath for one interval around each kick: from half an
//! interval before it to half an interval after it. This splitting is symmetric, so that states at
//! whole multiples of the interval differ from those of the continuous bath by the square of the
//! interval.
//!
//! Scaling velocities is no bath: it is free cooling in a moving unit of time, in which free
//! cooling is stationary (J. J. Brey, M. J. Ruiz-Montero & F. Moreno, Phys. Rev. E 69, 051303
//! (2004), doi:10.1103/PhysRevE.69.051303).
//!
//! Kicks are addressed by their number and the index of the particle, so both engines draw the same
//! kicks, and a resumed run draws the kicks of an uninterrupted one.

use nalgebra::Vector3;
use rand_distr::{Distribution, StandardNormal};

use crate::invalid::InvalidValue;
use crate::random::{Purpose, Streams};

/// Thermal bath that kicks all particles at equal intervals: white noise, or a Langevin bath with
/// drag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bath {
    noise: Noise,
    interval: f64,
}

/// Kind and strength of the noise of a thermal bath.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Noise {
    /// White noise without drag, with the mean energy gain per particle and time \[energy/time\].
    White { heating: f64 },
    /// Noise with drag, with the drag coefficient \[1/time\] and the temperature of the bath
    /// \[energy\].
    Langevin { drag: f64, temperature: f64 },
}

impl Bath {
    /// Largest drag times interval of a Langevin bath: velocities are forgotten in one kick long
    /// before.
    pub const LARGEST_DAMPING: f64 = 100.0;

    /// Creates a white-noise bath. It adds, on average, the energy `heating` to each particle per
    /// unit of time \[energy/time\], by one kick in each `interval` \[time\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless both are positive and finite, and the energy of one kick too.
    pub fn white_noise(heating: f64, interval: f64) -> Result<Self, InvalidValue> {
        InvalidValue::unless_positive("energy of a kick", heating * interval)?;
        let heating = InvalidValue::unless_positive("heating", heating)?;
        Ok(Self {
            noise: Noise::White { heating },
            interval: InvalidValue::unless_positive("interval between kicks", interval)?,
        })
    }

    /// Creates a Langevin bath with the drag `drag` \[1/time\] and the temperature `temperature`
    /// \[energy\], which acts once in each `interval` \[time\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless all are positive and finite, and drag times interval at most
    /// [`Self::LARGEST_DAMPING`].
    pub fn langevin(drag: f64, temperature: f64, interval: f64) -> Result<Self, InvalidValue> {
        let damping = InvalidValue::unless_positive("drag times interval", drag * interval)?;
        let allowed = "a number above 0 and at most 100";
        let fits = damping <= Self::LARGEST_DAMPING;
        InvalidValue::require(fits, "drag times interval", damping, allowed)?;
        let noise = Noise::Langevin {
            drag: InvalidValue::unless_positive("drag", drag)?,
            temperature: InvalidValue::unless_positive("temperature of the bath", temperature)?,
        };
        Ok(Self {
            noise,
            interval: InvalidValue::unless_positive("interval between kicks", interval)?,
        })
    }

    /// Returns the time between two kicks of the bath \[time\].
    pub fn interval(self) -> f64 {
        self.interval
    }

    /// Returns the factor on all velocities in a kick, before [`Self::kicks`] are added: `e^(-gamma
    /// tau)`; `None` without drag.
    pub fn damping(self) -> Option<f64> {
        match self.noise {
            Noise::White { .. } => None,
            Noise::Langevin { drag, .. } => Some((-drag * self.interval).exp()),
        }
    }

    /// Returns the random velocity change \[length/time\] of each particle in the kick of the bath
    /// with the number `number`; the third component is 0 in two dimensions.
    ///
    /// `copies` is the number of gases that stand one after the other: the first gets the
    /// kicks of a single gas. White noise keeps the momentum of each copy by itself. With N
    /// particles in a copy, each component has the variance `2 heating interval/(D m) . N/(N - 1)`,
    /// where the last factor makes up for what the mean takes away, by the share of its mass from
    /// each; a particle alone stays as it is. In a Langevin bath the variance is `(T_b/m)(1 -
    /// e^(-2 gamma tau))`.
    pub fn kicks(
        self,
        dimension: usize,
        particles: usize,
        copies: usize,
        mass: impl Fn(usize) -> f64,
        number: u64,
        streams: &Streams,
    ) -> Vec<Vector3<f64>> {
        let mut kicks = vec![Vector3::zeros(); particles];
        let size = (particles / copies.max(1)).max(1);
        let (energy, keeps_momentum) = match self.noise {
            Noise::White { .. } if size < 2 => return kicks,
            Noise::White { heating } => {
                let energy = heating * self.interval * size as f64 / (size - 1) as f64;
                (2.0 * energy / dimension as f64, true)
            }
            Noise::Langevin { drag, temperature } => {
                (-temperature * (-2.0 * drag * self.interval).exp_m1(), false)
            }
        };
        for (copy, gas) in kicks.chunks_mut(size).enumerate() {
            let (mut momentum, mut total) = (Vector3::zeros(), 0.0);
            for (place, kick) in gas.iter_mut().enumerate() {
                let index = copy * size + place;
                let mass = mass(index);
                let spread = (energy / mass).sqrt();
                let mut stream =
                    streams.stream_at(Purpose::StochasticDrive, [number, index as u64]);
                for axis in 0..dimension {
                    let normal: f64 = StandardNormal.sample(&mut stream);
                    kick[axis] = spread * normal;
                }
                momentum += *kick * mass;
                total += mass;
            }
            if keeps_momentum {
                let mean = momentum / total;
                for kick in gas {
                    *kick -= mean;
                }
            }
        }
        kicks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Masses 1 and 4 in turn.
    fn mass(index: usize) -> f64 {
        [1.0, 4.0][index % 2]
    }

    /// Momentum to rounding: N kicks of size 1 sum to at most N roundings of N. Energy within z =
    /// 4.4 standard errors (false alarm 1e-5) of a chi-squared with 2(N - 1) degrees of freedom for
    /// each kick; the error bar, 0.5 %, is small against the 11 % that the factor N/(N - 1) makes
    /// up for.
    #[test]
    fn white_noise_keeps_momentum_and_heats_as_asked() {
        let (count, kicks) = (10, 5000);
        let bath = Bath::white_noise(3.0, 0.5).expect("positive");
        let streams = Streams::new(4, 1);
        let (mut light, mut heavy) = (0.0, 0.0);
        for number in 0..kicks {
            let all = bath.kicks(2, count, 1, mass, number, &streams);
            let mut momentum = Vector3::zeros();
            for (index, kick) in all.iter().enumerate() {
                momentum += kick * mass(index);
                let energy = 0.5 * mass(index) * kick.norm_squared();
                *[&mut light, &mut heavy][index % 2] += energy;
            }
            assert!(momentum.norm() < 1e-13, "{momentum}");
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

    /// The stationary variance of `v -> v damping + kick` is `T_b/m` whatever the interval, and the
    /// correlation of two successive velocities is the damping. Each of 2000 particles gives an
    /// independent v^2; the chain has forgotten its start, at rest, as e^-60. z = 4.4.
    #[test]
    fn langevin_steps_are_exact_for_any_interval() {
        let streams = Streams::new(5, 2);
        for (dimension, interval) in [(2, 0.1), (3, 1.0), (3, 40.0)] {
            let bath = Bath::langevin(1.5, 2.0, interval).expect("positive");
            let (count, damping) = (2000, bath.damping().expect("drag"));
            let steps = (20.0 / interval).ceil() as u64 + 1;
            let mut velocities = vec![Vector3::zeros(); count];
            let (mut energy, mut memory) = (0.0, 0.0);
            for number in 0..steps {
                let kicks = bath.kicks(dimension, count, 1, mass, number, &streams);
                (energy, memory) = (0.0, 0.0);
                for (index, (velocity, kick)) in velocities.iter_mut().zip(kicks).enumerate() {
                    let before = *velocity;
                    *velocity = before * damping + kick;
                    energy += mass(index) * velocity.norm_squared();
                    memory += mass(index) * velocity.dot(&before);
                }
            }
            let freedoms = (dimension * count) as f64;
            let error = 2.0 * (2.0 / freedoms).sqrt();
            let [energy, memory] = [energy, memory].map(|sum| sum / freedoms);
            assert!((energy - 2.0).abs() < 4.4 * error, "{energy} ± {error}");
            let expected = 2.0 * damping;
            assert!(
                (memory - expected).abs() < 4.4 * error,
                "{memory} ± {error}"
            );
        }
    }

    #[test]
    fn copies_keep_their_momentum_and_the_first_is_the_gas_alone() {
        let streams = Streams::new(9, 0);
        let noise = Bath::white_noise(1.0, 0.1).expect("positive");
        let drag = Bath::langevin(1.0, 1.0, 0.1).expect("positive");
        for bath in [noise, drag] {
            let alone = bath.kicks(2, 20, 1, mass, 7, &streams);
            let both = bath.kicks(2, 40, 2, mass, 7, &streams);
            assert_eq!(alone[..], both[..20]);
            assert_ne!(both[..20], both[20..]);
            assert_ne!(alone, bath.kicks(2, 20, 1, mass, 8, &streams));
        }
        let still = vec![Vector3::zeros()];
        assert_eq!(noise.kicks(2, 1, 1, mass, 0, &streams), still);
        assert_ne!(drag.kicks(2, 1, 1, mass, 0, &streams), still);
    }

    #[test]
    fn invalid_baths_are_refused() {
        for (heating, interval) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (1e200, 1e200)] {
            assert!(Bath::white_noise(heating, interval).is_err());
        }
        let inf = f64::INFINITY;
        for (drag, temperature, interval) in [
            (-1.0, 1.0, 1.0),
            (1.0, 0.0, 1.0),
            (inf, inf, 1.0),
            (1.0, inf, 1.0),
            (1.0, 1.0, 101.0),
            (-1.0, 1.0, -1.0),
        ] {
            assert!(Bath::langevin(drag, temperature, interval).is_err());
        }
    }
}
