//! Cooling of gases of rough particles, by coupled equations for the temperatures of translation
//! and rotation.
//!
//! For Maxwellian velocities and spins ([`RoughGas::expand`] goes beyond), with the coefficients of
//! normal restitution e and of tangential restitution beta, q = I/(m R^2) and eta = q (1 + beta)/(2
//! (1 + q)):
//!
//! `dT/dt = -G A T^(3/2) + G B T^(1/2) T_r`, `dT_r/dt = f G (B T^(3/2) - C T^(1/2) T_r)`, with
//!
//! | | spheres | disks |
//! |---|---|---|
//! | A | (1 - e^2)/4 + eta (1 - eta) | (1 - e^2)/4 + eta (1 - eta)/2 |
//! | B | eta^2/q | eta^2/(2 q) |
//! | C | (eta/q)(1 - eta/q) | (eta/(2 q))(1 - eta/q) |
//! | G | (16/3) sqrt(pi) n d^2 chi/sqrt(m) | 4 sqrt(pi) n d chi/sqrt(m) |
//! | f | 1 | 2 |
//!
//! Huthmann & Zippelius, Phys. Rev. E 56, R6275 (1997), doi:10.1103/PhysRevE.56.R6275; Luding,
//! Huthmann, McNamara & Zippelius, Phys. Rev. E 58, 3416 (1998), doi:10.1103/PhysRevE.58.3416.
//! Temperatures are m <v^2>/D and I <w^2> for each rotation.

use stosszahl_model::{InvalidValue, Rough, Space};

use super::error::TheoryError;
use super::integrate::{Integrator, Tolerance};

/// Homogeneous gas of equal rough particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughGas {
    /// Collision prefactor G of the equations in the module page, for mass one \[1/(time
    /// sqrt(energy))\].
    rate: f64,
    /// Coefficient A of the equations in the module page: loss of translational energy.
    loss: f64,
    /// Coefficient B of the equations in the module page: exchange between translation and
    /// rotation.
    exchange: f64,
    /// Coefficient C of the equations in the module page: loss of rotational energy.
    return_loss: f64,
    /// Degrees of freedom of translation over those of rotation.
    degrees: f64,
    collision_rate: f64,
    /// Number of velocity components, for Sonine expansions.
    pub(super) dimension: usize,
    /// Number of spin components, for Sonine expansions.
    pub(super) rotations: usize,
    /// Coefficient of normal restitution, for Sonine expansions.
    pub(super) restitution: f64,
    /// Surface parameters eta and q of the module page, for Sonine expansions.
    pub(super) surface: [f64; 2],
}

/// Temperatures of translation and of rotation of a gas of rough particles \[energy\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temperatures {
    /// Temperature of translation, m <v^2>/D \[energy\].
    pub translation: f64,
    /// Temperature of rotation, I <w^2> over the number of spin components \[energy\].
    pub rotation: f64,
}

impl Temperatures {
    /// Computes the kinetic energy per particle, of translation and rotation, in the space `S`
    /// \[energy\].
    pub fn energy<S: Space>(self) -> f64 {
        0.5 * (S::DIMENSION as f64 * self.translation + S::ROTATIONS as f64 * self.rotation)
    }
}

impl RoughGas {
    /// Creates a gas of equal rough particles; `contact_value` is the pair correlation at contact.
    ///
    /// # Errors
    /// [`TheoryError::Invalid`] if restitution is not in 0 to 1, or another number is not
    /// above zero and finite.
    pub fn new<S: Space>(
        restitution: f64,
        surface: Rough,
        density: f64,
        diameter: f64,
        mass: f64,
        contact_value: f64,
    ) -> Result<Self, TheoryError> {
        InvalidValue::require(
            (0.0..=1.0).contains(&restitution),
            "restitution",
            restitution,
            "0 to 1",
        )?;
        for (name, value) in [
            ("density", density),
            ("diameter", diameter),
            ("mass", mass),
            ("contact value", contact_value),
        ] {
            InvalidValue::unless_positive(name, value)?;
        }
        let q = surface.inertia();
        let eta = q * (1.0 + surface.tangential_restitution()) / (2.0 * (1.0 + q));
        // Tangential directions among D - 1 = 2 or 1, over 2.
        let share = 0.5 * (S::DIMENSION - 1) as f64;
        let degrees = S::DIMENSION as f64 / S::ROTATIONS as f64;
        // G is 4/D times the collisions of one particle in the time 1/sqrt(T).
        let packing_fraction = density * S::particle_volume(0.5 * diameter);
        let collisions =
            S::collision_rate(packing_fraction, contact_value) / (diameter * mass.sqrt());
        Ok(Self {
            rate: 4.0 / S::DIMENSION as f64 * collisions,
            loss: 0.25 * (1.0 - restitution * restitution) + share * eta * (1.0 - eta),
            exchange: share * eta * eta / q,
            return_loss: share * (eta / q) * (1.0 - eta / q),
            degrees,
            collision_rate: collisions,
            dimension: S::DIMENSION,
            rotations: S::ROTATIONS,
            restitution,
            surface: [eta, q],
        })
    }

    /// Computes the collision rate of a particle at a temperature of translation \[1/time\].
    pub fn collision_rate(&self, translation: f64) -> f64 {
        self.collision_rate * translation.sqrt()
    }

    /// Computes the time derivatives of both temperatures \[energy/time\].
    pub fn slopes(&self, now: Temperatures) -> Temperatures {
        let Temperatures {
            translation,
            rotation,
        } = now;
        let rate = self.rate * translation.max(0.0).sqrt();
        Temperatures {
            translation: rate * (self.exchange * rotation - self.loss * translation),
            rotation: rate
                * self.degrees
                * (self.exchange * translation - self.return_loss * rotation),
        }
    }

    /// Computes both temperatures at given times after the start, in rising order, by integration.
    ///
    /// # Errors
    /// [`TheoryError::Integration`] if the integration fails before the last time.
    pub fn cooling(
        &self,
        start: Temperatures,
        times: &[f64],
    ) -> Result<Vec<Temperatures>, TheoryError> {
        let gas = *self;
        let slope = move |_: f64, y: &[f64], slope: &mut [f64]| {
            let slopes = gas.slopes(Temperatures {
                translation: y[0],
                rotation: y[1],
            });
            (slope[0], slope[1]) = (slopes.translation, slopes.rotation);
        };
        let tolerance = Tolerance {
            relative: 1e-10,
            absolute: 0.0,
        };
        let first = 1e-3 / self.collision_rate(start.translation.max(f64::MIN_POSITIVE));
        let values = vec![start.translation, start.rotation];
        let mut problem = Integrator::new(slope, 0.0, values, first.min(1e300), tolerance);
        let at = |&time: &f64| {
            let y = problem.advance(time)?;
            Ok(Temperatures {
                translation: y[0],
                rotation: y[1],
            })
        };
        times.iter().map(at).collect()
    }

    /// Computes the ratio of rotational to translational temperature at late times: the positive
    /// root x of f (B/x - C) = B x - A. `None` for perfectly smooth particles, which keep their
    /// spins.
    pub fn late_ratio(&self) -> Option<f64> {
        let (a, b, c) = (self.loss, self.exchange, self.degrees * self.return_loss);
        if b == 0.0 {
            return None;
        }
        // B x^2 - (A - C f) x - f B = 0, in the form that loses no digits.
        let half = 0.5 * (a - c);
        let root = (half * half + self.degrees * b * b).sqrt();
        Some(if half >= 0.0 {
            (half + root) / b
        } else {
            self.degrees * b / (root - half)
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use stosszahl_model::{Plane, Volume};

    pub(crate) fn gas<S: Space>(restitution: f64, beta: f64) -> RoughGas {
        let surface = Rough::new(beta, S::INERTIA).expect("a surface");
        RoughGas::new::<S>(restitution, surface, 0.1, 1.0, 1.0, 1.0).expect("a gas")
    }

    /// The formula sheet's numbers, which were checked by a Monte Carlo of the collision operator
    /// there: half of their last digit.
    #[test]
    fn temperatures_are_those_of_the_formula_sheet() {
        let start = Temperatures {
            translation: 1.0,
            rotation: 1.0,
        };
        for (restitution, beta, expected) in [
            (0.6, 0.0, [[0.588, 0.656], [0.327, 0.401], [0.164, 0.219]]),
            (0.6, 1.0, [[0.731, 0.936], [0.556, 0.788], [0.405, 0.591]]),
            (1.0, 0.0, [[0.822, 0.647], [0.613, 0.382], [0.395, 0.201]]),
            (0.6, -1.0, [[0.679, 1.0], [0.425, 1.0], [0.234, 1.0]]),
            (1.0, 1.0, [[1.0; 2]; 3]),
            (1.0, -1.0, [[1.0; 2]; 3]),
        ] {
            let gas = gas::<Volume>(restitution, beta);
            let mean_free_time = 1.0 / gas.collision_rate(1.0);
            let times = [2.0, 5.0, 10.0].map(|time| time * mean_free_time);
            let found = gas.cooling(start, &times).expect("smooth");
            for (found, expected) in found.iter().zip(expected) {
                let off = [
                    found.translation - expected[0],
                    found.rotation - expected[1],
                ];
                assert!(
                    off.iter().all(|off| off.abs() <= 5.1e-4),
                    "{restitution} {beta}: {found:?} {expected:?}"
                );
            }
        }
    }

    /// The closed form against the formula sheet, half of the last digit, and against the cooling
    /// that leads to it.
    #[test]
    fn the_late_ratio_is_where_cooling_leads() {
        let spheres = [
            (-0.9, 53.2),
            (-0.5, 0.343),
            (0.0, 0.574),
            (0.5, 0.867),
            (0.9, 1.076),
        ];
        for (beta, expected) in spheres {
            let ratio = gas::<Volume>(0.9, beta).late_ratio().expect("rough");
            assert!((ratio / expected - 1.0).abs() < 2e-3, "{beta}: {ratio}");
        }
        let disks = [
            (-0.9, 84.5),
            (-0.5, 0.253),
            (0.0, 0.470),
            (0.5, 0.790),
            (0.9, 1.083),
        ];
        for (beta, expected) in disks {
            let gas = gas::<Plane>(0.9, beta);
            let ratio = gas.late_ratio().expect("rough");
            assert!((ratio / expected - 1.0).abs() < 2e-3, "{beta}: {ratio}");
            let start = Temperatures {
                translation: 1.0,
                rotation: ratio,
            };
            let late = gas.cooling(start, &[100.0]).expect("smooth")[0];
            assert!(late.translation < 0.9);
            // The tolerance of the integration, over its steps.
            assert!((late.rotation / late.translation / ratio - 1.0).abs() < 1e-7);
        }
        assert_eq!(gas::<Plane>(0.9, -1.0).late_ratio(), None);
    }

    #[test]
    fn elastic_grains_share_their_energy_alike() {
        let ratio = gas::<Volume>(1.0, 1.0).late_ratio().expect("rough");
        assert!((ratio - 1.0).abs() < 1e-12);
        let ratio = gas::<Plane>(1.0, 1.0).late_ratio().expect("rough");
        assert!((ratio - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bad_numbers_are_named() {
        let surface = Rough::new(0.0, 0.4).expect("a surface");
        let refused = RoughGas::new::<Volume>(1.5, surface, 0.1, 1.0, 1.0, 1.0);
        let said = refused.expect_err("too much").to_string();
        assert!(said.contains("restitution is 1.5"), "{said}");
        assert!(RoughGas::new::<Volume>(1.0, surface, 0.0, 1.0, 1.0, 1.0).is_err());
    }
}
