//! Law by which particles rebound from walls and obstacles, and ledger of the momentum and energy
//! given to the gas.

use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::invalid::InvalidValue;
use crate::physics::{ParticleModel, SpinOf, VectorOf};
use crate::space::{Space, Vector};
use crate::surface::Surface;

/// Wall law, by which particles rebound from a wall or an obstacle: with restitution and slip, or
/// diffuse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Rebound {
    /// Wall with restitution and slip: the normal velocity is reversed and multiplied by
    /// `restitution`, 0 to 1; the tangential velocity of the contact (of the centre, for smooth
    /// particles) is multiplied by `slip`, -1 to 1. (1, 1) is a specular wall.
    Restitutive {
        /// Coefficient of normal restitution of the wall, 0 to 1.
        restitution: f64,
        /// Tangential velocity of the contact after a rebound from the wall over that before, from
        /// -1 to 1; 1 is no friction.
        slip: f64,
    },
    /// Diffuse wall: the particle forgets how it came and leaves with the flux of a Maxwellian at
    /// rest with the wall. The normal velocity has the density v exp(-m v^2/2T), all others, spins
    /// included, are Gaussian.
    Diffuse {
        /// Temperature of the diffuse wall \[energy\].
        temperature: f64,
    },
}

/// Contact of a particle with a wall or obstacle: normal, wall velocity, and the particle's mass
/// and radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch<V> {
    /// Unit normal vector of the wall, into the gas.
    pub normal: V,
    /// Velocity of the wall at the contact \[length/time\].
    pub wall: V,
    /// Mass of the particle that touches the wall \[mass\].
    pub mass: f64,
    /// Radius of the particle that touches the wall \[length\].
    pub radius: f64,
}

impl Rebound {
    /// Checks that the numbers of the wall law are within their allowed ranges.
    pub(super) fn check_values(&self) -> Result<(), InvalidValue> {
        let within = |name, number: f64, least: f64, allowed| {
            let is_within = (least..=1.0).contains(&number);
            InvalidValue::require(is_within, name, number, allowed).map(|_| ())
        };
        match *self {
            Self::Restitutive { restitution, slip } => {
                within("restitution", restitution, 0.0, "a number from 0 to 1")?;
                within("slip", slip, -1.0, "a number from -1 to 1")
            }
            Self::Diffuse { temperature } => {
                let is_energy = temperature >= 0.0 && temperature.is_finite();
                let allowed = "an energy of at least 0";
                InvalidValue::require(is_energy, "temperature", temperature, allowed).map(|_| ())
            }
        }
    }

    /// Changes the velocity and spin of a particle at a contact with a wall by this law. The random
    /// `stream` is created only for diffuse walls.
    #[inline]
    pub fn apply<P: ParticleModel, R: Rng>(
        &self,
        scene: &P,
        touch: &Touch<VectorOf<P>>,
        velocity: &mut VectorOf<P>,
        spin: &mut SpinOf<P>,
        stream: impl FnOnce() -> R,
    ) {
        let normal = touch.normal;
        match *self {
            Self::Restitutive { restitution, slip } => {
                let mut relative = *velocity - touch.wall;
                // A normal that is rounded must not cost energy.
                let along = relative.inner(&normal) / normal.square();
                if along < 0.0 {
                    relative -= normal * ((1.0 + restitution) * along);
                }
                let radius = touch.radius;
                (scene.surface()).apply_wall_friction(normal, slip, radius, &mut relative, spin);
                *velocity = relative + touch.wall;
            }
            Self::Diffuse { temperature } => {
                let mut stream = stream();
                let spread = (temperature / touch.mass).sqrt();
                let mut fresh = VectorOf::<P>::default();
                for axis in 0..P::Space::DIMENSION {
                    let component: f64 = StandardNormal.sample(&mut stream);
                    fresh[axis] = spread * component;
                }
                // 1 - u lies above zero.
                let outwards = spread * (-2.0 * (1.0 - stream.random::<f64>()).ln()).sqrt();
                fresh += normal * (outwards - fresh.inner(&normal));
                *velocity = fresh + touch.wall;
                let (mass, radius) = (touch.mass, touch.radius);
                *spin = (scene.surface()).thermal_spin(temperature, mass, radius, &mut stream);
            }
        }
    }
}

/// Momentum and energy that a wall, obstacle or opening has given to the gas so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct WallLedger<S: Space> {
    /// Number of contacts with the wall, each times the number of particles that a simulator stands
    /// for.
    pub contacts: f64,
    /// Momentum that the wall has given to the gas \[mass length/time\].
    pub momentum: S::Vector,
    /// Kinetic energy that the wall has given to the gas, rotation included \[energy\].
    pub energy: f64,
}

impl<S: Space> WallLedger<S> {
    /// Adds one contact that stands for `weight` particles, with momentum and energy given to each.
    #[inline]
    pub fn enter(&mut self, weight: f64, momentum: S::Vector, energy: f64) {
        self.contacts += weight;
        self.momentum += momentum * weight;
        self.energy += energy * weight;
    }

    /// Adds the entries of another ledger to this one.
    pub fn add(&mut self, other: &Self) {
        self.contacts += other.contacts;
        self.momentum += other.momentum;
        self.energy += other.energy;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{FallingParticles, grains, no_gravity};
    use crate::{Plane, Rough, Smooth, Volume};
    use nalgebra::{SVector, vector};
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn scene<S: Space, C: Surface<S>>(surface: C) -> FallingParticles<S, C> {
        grains(1.0, 1.0, surface, no_gravity())
    }

    fn no_numbers() -> Xoshiro256PlusPlus {
        unreachable!("nothing is drawn here")
    }

    #[test]
    fn restitution_and_slip_are_relative_to_the_wall() {
        let touch = Touch {
            normal: vector![0.0, 1.0],
            wall: vector![0.25, 0.5],
            mass: 2.0,
            radius: 0.5,
        };
        let law = Rebound::Restitutive {
            restitution: 0.5,
            slip: -0.5,
        };
        let mut velocity = vector![1.25, -1.5];
        law.apply(
            &scene::<Plane, _>(Smooth),
            &touch,
            &mut velocity,
            &mut (),
            no_numbers,
        );
        assert_eq!(velocity, vector![0.25 - 0.5, 0.5 + 1.0]);
    }

    /// Moments of the flux of a Maxwellian: for the normal velocity sqrt(pi T/2m) and, of its
    /// square, 2 T/m; for the others T/m and T/I. 20000 draws; each within z = 4.4 of its exact
    /// standard error.
    #[test]
    fn a_diffuse_wall_sends_out_the_flux_of_a_maxwellian() {
        let surface = Rough::new(0.0, 0.4).expect("a surface");
        let scene = scene::<Volume, _>(surface);
        let touch = Touch {
            normal: vector![0.0, -1.0, 0.0],
            wall: vector![0.0, 0.0, 3.0],
            mass: 2.0,
            radius: 0.5,
        };
        let law = Rebound::Diffuse { temperature: 1.5 };
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
        let draws = 20_000;
        let mut sums = SVector::<f64, 5>::zeros();
        for _ in 0..draws {
            let (mut velocity, mut spin) = (vector![9.0, 9.0, 9.0], vector![9.0, 9.0, 9.0]);
            law.apply(&scene, &touch, &mut velocity, &mut spin, || {
                Xoshiro256PlusPlus::from_rng(&mut stream)
            });
            let out = -velocity[1];
            assert!(out > 0.0);
            let aside = velocity[2] - 3.0;
            sums += vector![
                out,
                out * out,
                velocity[0] * velocity[0],
                aside * aside,
                spin.norm_squared()
            ];
        }
        let over = 1.5 / 2.0;
        let inertia = 0.4 * 2.0 * 0.25;
        let expected = [
            (std::f64::consts::FRAC_PI_2 * over).sqrt(),
            2.0 * over,
            over,
            over,
            3.0 * 1.5 / inertia,
        ];
        // Variances: (2 - pi/2) T/m, 4 (T/m)^2, 2 (T/m)^2 and, of three squares, 6 (T/I)^2.
        let variances = [
            (2.0 - std::f64::consts::FRAC_PI_2) * over,
            4.0 * over * over,
            2.0 * over * over,
            2.0 * over * over,
            6.0 * (1.5 / inertia).powi(2),
        ];
        for index in 0..5 {
            let mean = sums[index] / f64::from(draws);
            let error = (variances[index] / f64::from(draws)).sqrt();
            assert!(
                (mean - expected[index]).abs() < 4.4 * error,
                "{index}: {mean} {}",
                expected[index]
            );
        }
    }

    #[test]
    fn ledgers_add_up() {
        let mut ledger = WallLedger::<Plane>::default();
        ledger.enter(2.0, vector![1.0, 0.0], 3.0);
        let mut sum = ledger;
        sum.add(&ledger);
        assert_eq!(sum.contacts, 4.0);
        assert_eq!(sum.momentum, vector![4.0, 0.0]);
        assert_eq!(sum.energy, 12.0);
    }
}
