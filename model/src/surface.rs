//! Tangential contact laws of smooth and rough particles, and the spin that a particle stores for
//! them.

use std::fmt::Debug;

use nalgebra::Vector3;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::colliding_pair::{CollidingPair, PostCollision};
use crate::invalid::InvalidValue;
use crate::space::{Space, Vector};

/// Tangential contact law, between two particles and between a particle and a wall.
///
/// The type `Spin` is all that a particle stores for it: a smooth particle carries `()`, which is
/// zero bytes and zero instructions.
pub trait Surface<S: Space>: Copy + Debug + Send + Sync + 'static {
    /// Angular velocity of one particle \[1/time\]; `()` if particles do not spin.
    type Spin: Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned + Send + Sync;

    /// True if particles spin, because their contacts have friction.
    const ROUGH: bool;

    /// Adds the tangential impulse of a contact to the velocities after the normal collision, and
    /// changes the spins.
    fn apply_friction(
        &self,
        pair: &CollidingPair<S::Vector, Self::Spin>,
        after: &mut PostCollision<S::Vector, Self::Spin>,
    );

    /// Applies the tangential impulse of a wall to a particle. `normal` is a unit vector into the
    /// gas, and `velocity` is relative to the wall. `slip`, from -1 to 1, is the tangential
    /// velocity of the contact after it over that before; 1 is no friction.
    fn apply_wall_friction(
        &self,
        normal: S::Vector,
        slip: f64,
        radius: f64,
        velocity: &mut S::Vector,
        spin: &mut Self::Spin,
    );

    /// Draws a random spin from the Maxwellian of a temperature I <w^2>/`ROTATIONS` \[energy\].
    fn thermal_spin(
        &self,
        temperature: f64,
        mass: f64,
        radius: f64,
        stream: &mut impl Rng,
    ) -> Self::Spin;

    /// Returns the kinetic energy of rotation of a particle, I w^2/2 \[energy\].
    fn spin_energy(&self, mass: f64, radius: f64, spin: Self::Spin) -> f64;

    /// Returns a spin multiplied by a factor, to convert units.
    fn scale_spin(spin: Self::Spin, factor: f64) -> Self::Spin;

    /// Returns a spin after a rotation.
    fn rotate_spin(&self, turn: S::Turn, spin: Self::Spin) -> Self::Spin;

    /// Returns a spin as a vector with three components; that of a disk is along the third axis.
    fn spin_in_space(spin: Self::Spin) -> Vector3<f64>;

    /// Returns the spin given by a vector with three components; for a disk its third component.
    fn spin_of(vector: Vector3<f64>) -> Self::Spin;
}

/// Tangential law of smooth particles: no tangential impulse, so that spins never change and none
/// is stored.
///
/// On a wall the tangential velocity of the centre is what slips.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smooth;

impl<S: Space> Surface<S> for Smooth {
    type Spin = ();

    const ROUGH: bool = false;

    #[inline(always)]
    fn apply_friction(
        &self,
        _pair: &CollidingPair<S::Vector>,
        _after: &mut PostCollision<S::Vector>,
    ) {
    }

    #[inline]
    fn apply_wall_friction(
        &self,
        normal: S::Vector,
        slip: f64,
        _radius: f64,
        velocity: &mut S::Vector,
        (): &mut (),
    ) {
        if slip != 1.0 {
            *velocity -= tangential(*velocity, normal) * (1.0 - slip);
        }
    }

    #[inline]
    fn thermal_spin(&self, _: f64, _: f64, _: f64, _stream: &mut impl Rng) {}

    #[inline]
    fn spin_energy(&self, _mass: f64, _radius: f64, (): ()) -> f64 {
        0.0
    }

    #[inline(always)]
    fn scale_spin((): (), _factor: f64) {}

    #[inline]
    fn rotate_spin(&self, _turn: S::Turn, (): ()) {}

    fn spin_in_space((): ()) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn spin_of(_vector: Vector3<f64>) {}
}

/// Tangential law of rough particles: a contact multiplies the relative tangential velocity of the
/// two surfaces by minus the coefficient of tangential restitution.
///
/// Let n be the unit vector along the line of centres from the second to the first partner, R the
/// radii, and c = v1 - v2 - (R1 w1 + R2 w2) x n the velocity of the contact. The tangential impulse
/// on the first partner is J = -mu (q/(1 + q)) (1 + beta) (c - (c . n) n), with q = I/(m R^2) and
/// mu the reduced mass. Each spin changes by -n x J/(q m R). Momentum and angular momentum are
/// conserved, energy only for beta = -1 (smooth) and 1.
///
/// Walton, Braun, Mallon & Cervelli (1988); Luding, Huthmann, McNamara & Zippelius, Phys. Rev. E
/// 58, 3416 (1998), doi:10.1103/PhysRevE.58.3416.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    tangential_restitution: f64,
    inertia: f64,
}

impl Rough {
    /// Creates the law of rough particles with the coefficient of tangential restitution beta, from
    /// -1 (perfectly smooth) to 1 (perfectly rough), and the moment of inertia in units of m R^2,
    /// above 0 and at most 1: 1/2 for a disk, 2/5 for a sphere ([`Space::INERTIA`]).
    ///
    /// # Errors
    /// [`InvalidValue`] outside these ranges.
    pub fn new(tangential_restitution: f64, inertia: f64) -> Result<Self, InvalidValue> {
        InvalidValue::require(
            (-1.0..=1.0).contains(&tangential_restitution),
            "coefficient of tangential restitution",
            tangential_restitution,
            "-1 to 1",
        )?;
        InvalidValue::require(
            inertia > 0.0 && inertia <= 1.0,
            "moment of inertia over m R^2",
            inertia,
            "above 0 and at most 1",
        )?;
        Ok(Self {
            tangential_restitution,
            inertia,
        })
    }

    /// Returns the coefficient of tangential restitution beta, from -1 to 1.
    pub fn tangential_restitution(&self) -> f64 {
        self.tangential_restitution
    }

    /// Returns the moment of inertia of a particle over m R^2.
    pub fn inertia(&self) -> f64 {
        self.inertia
    }

    /// Returns the effective mass of a tangential impulse over that of a normal one, q/(1 + q),
    /// with q = I/(m R^2).
    #[inline]
    fn mass_share(&self) -> f64 {
        self.inertia / (1.0 + self.inertia)
    }
}

impl<S: Space> Surface<S> for Rough {
    type Spin = S::Spin;

    const ROUGH: bool = true;

    #[inline]
    fn apply_friction(
        &self,
        pair: &CollidingPair<S::Vector, S::Spin>,
        after: &mut PostCollision<S::Vector, S::Spin>,
    ) {
        let normal = pair.line * (1.0 / pair.line.square().sqrt());
        let turning = pair.spins[0] * pair.radii[0] + pair.spins[1] * pair.radii[1];
        let contact = pair.velocities[0] - pair.velocities[1] - S::arm_velocity(turning, normal);
        let [m, n] = pair.masses;
        let reduced = m * n / (m + n);
        let factor = -reduced * self.mass_share() * (1.0 + self.tangential_restitution);
        let impulse = tangential(contact, normal) * factor;
        after.velocities[0] += impulse * (1.0 / m);
        after.velocities[1] -= impulse * (1.0 / n);
        let torque = S::arm_moment(normal, impulse);
        for who in 0..2 {
            let inertia = self.inertia * pair.masses[who] * pair.radii[who];
            after.spins[who] -= torque * (1.0 / inertia);
        }
    }

    #[inline]
    fn apply_wall_friction(
        &self,
        normal: S::Vector,
        slip: f64,
        radius: f64,
        velocity: &mut S::Vector,
        spin: &mut S::Spin,
    ) {
        if slip != 1.0 {
            let contact = *velocity - S::arm_velocity(*spin * radius, normal);
            let change = tangential(contact, normal) * (-self.mass_share() * (1.0 - slip));
            *velocity += change;
            *spin -= S::arm_moment(normal, change) * (1.0 / (self.inertia * radius));
        }
    }

    fn thermal_spin(
        &self,
        temperature: f64,
        mass: f64,
        radius: f64,
        stream: &mut impl Rng,
    ) -> S::Spin {
        let spread = (temperature / (self.inertia * mass)).sqrt() / radius;
        let mut spin = S::Spin::default();
        for axis in 0..S::ROTATIONS {
            let normal: f64 = StandardNormal.sample(stream);
            spin[axis] = spread * normal;
        }
        spin
    }

    #[inline]
    fn spin_energy(&self, mass: f64, radius: f64, spin: S::Spin) -> f64 {
        0.5 * self.inertia * mass * radius * radius * spin.square()
    }

    #[inline(always)]
    fn scale_spin(spin: S::Spin, factor: f64) -> S::Spin {
        spin * factor
    }

    #[inline]
    fn rotate_spin(&self, turn: S::Turn, spin: S::Spin) -> S::Spin {
        S::turned_spin(turn, spin)
    }

    fn spin_in_space(spin: S::Spin) -> Vector3<f64> {
        S::spin_in_space(spin)
    }

    fn spin_of(vector: Vector3<f64>) -> S::Spin {
        S::spin_of(vector)
    }
}

/// Returns the tangential part of a vector, perpendicular to the unit vector `normal`.
#[inline]
fn tangential<V: Vector>(vector: V, normal: V) -> V {
    vector - normal * vector.inner(&normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{FallingParticles, grains, no_gravity};
    use crate::{Plane, Volume, collide};
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    type Stream = Xoshiro256PlusPlus;

    fn scene<S: Space>(beta: f64) -> FallingParticles<S, Rough> {
        let surface = Rough::new(beta, S::INERTIA).expect("a surface");
        grains(1.0, 1.0, surface, no_gravity())
    }

    fn vector<V: Vector>(components: usize, stream: &mut Stream) -> V {
        let mut vector = V::default();
        for axis in 0..components {
            vector[axis] = stream.random_range(-1.0..1.0);
        }
        vector
    }

    fn pair_of<S: Space>(stream: &mut Stream) -> CollidingPair<S::Vector, S::Spin> {
        let mut positive = || stream.random_range(0.3..2.0);
        let (masses, radii) = ([positive(), positive()], [positive(), positive()]);
        CollidingPair {
            velocities: [vector(S::DIMENSION, stream), vector(S::DIMENSION, stream)],
            spins: [vector(S::ROTATIONS, stream), vector(S::ROTATIONS, stream)],
            masses,
            radii,
            line: S::random_direction(stream) * (radii[0] + radii[1]),
        }
    }

    /// Velocity of the first surface against the second where they touch.
    fn contact_velocity<S: Space>(
        pair: &CollidingPair<S::Vector, S::Spin>,
        velocities: [S::Vector; 2],
        spins: [S::Spin; 2],
    ) -> S::Vector {
        let normal = pair.line * (1.0 / pair.line.square().sqrt());
        let arms = [normal * -pair.radii[0], normal * pair.radii[1]];
        let surface = |who: usize| velocities[who] + S::arm_velocity(spins[who], arms[who]);
        surface(0) - surface(1)
    }

    /// Checks random pairs with random masses and radii: momentum, angular momentum about the first
    /// centre, the velocity of the contact and, for (1, -1) and (1, 1), the energy. Bound: some
    /// hundred roundings of numbers of order ten, 1e-13.
    fn check<S: Space>() {
        let stream = &mut Stream::seed_from_u64(2);
        for round in 0..10_000 {
            let pair = pair_of::<S>(stream);
            let restitution: f64 = stream.random();
            let elastic = round % 2 == 0;
            let beta = match round % 4 {
                0 => -1.0,
                2 => 1.0,
                _ => stream.random_range(-1.0..1.0),
            };
            let restitution = if elastic { 1.0 } else { restitution };
            let scene = scene::<S>(beta);
            let after = collide(&scene, &pair, restitution);

            let momentum = |v: [S::Vector; 2]| v[0] * pair.masses[0] + v[1] * pair.masses[1];
            let change = momentum(after.velocities) - momentum(pair.velocities);
            assert!(change.square().sqrt() < 1e-13);

            let inertia = [0, 1].map(|who| S::INERTIA * pair.masses[who] * pair.radii[who].powi(2));
            let angular = |v: [S::Vector; 2], spins: [S::Spin; 2]| {
                S::arm_moment(-pair.line, v[1] * pair.masses[1])
                    + spins[0] * inertia[0]
                    + spins[1] * inertia[1]
            };
            let change =
                angular(after.velocities, after.spins) - angular(pair.velocities, pair.spins);
            assert!(change.square().sqrt() < 1e-13);

            let normal = pair.line * (1.0 / pair.line.square().sqrt());
            let before = contact_velocity::<S>(&pair, pair.velocities, pair.spins);
            let now = contact_velocity::<S>(&pair, after.velocities, after.spins);
            let expected =
                tangential(before, normal) * -beta - normal * (restitution * before.inner(&normal));
            assert!((now - expected).square().sqrt() < 1e-13);

            let energy = |v: [S::Vector; 2], spins: [S::Spin; 2]| -> f64 {
                (0..2)
                    .map(|who| {
                        let (mass, radius) = (pair.masses[who], pair.radii[who]);
                        let spin =
                            Surface::<S>::spin_energy(&scene.surface, mass, radius, spins[who]);
                        0.5 * mass * v[who].square() + spin
                    })
                    .sum()
            };
            let before = energy(pair.velocities, pair.spins);
            let change = energy(after.velocities, after.spins) - before;
            if elastic {
                assert!(change.abs() < 1e-13 * before, "{beta}: {change}");
            } else {
                assert!(change <= 1e-13 * before);
            }
        }
    }

    #[test]
    fn rough_contacts_conserve_what_they_must() {
        check::<Plane>();
        check::<Volume>();
    }

    /// Compares a wall, a partner of infinite mass, with a partner 1e12 times as heavy, which
    /// differs in the twelfth digit.
    fn walls_are_heavy<S: Space>() {
        let stream = &mut Stream::seed_from_u64(3);
        for _ in 0..1000 {
            let mut pair = pair_of::<S>(stream);
            pair.masses[1] = 1e12;
            pair.velocities[1] = S::Vector::default();
            pair.spins[1] = S::Spin::default();
            let slip = stream.random_range(-1.0..1.0);
            let scene = scene::<S>(-slip);
            let normal = pair.line * (1.0 / pair.line.square().sqrt());
            let after = collide(&scene, &pair, 1.0);
            let (mut velocity, mut spin) = (pair.velocities[0], pair.spins[0]);
            velocity -= normal * (2.0 * velocity.inner(&normal));
            Surface::<S>::apply_wall_friction(
                &scene.surface,
                normal,
                slip,
                pair.radii[0],
                &mut velocity,
                &mut spin,
            );
            assert!((velocity - after.velocities[0]).square().sqrt() < 1e-10);
            assert!((spin - after.spins[0]).square().sqrt() < 1e-10);
        }
    }

    #[test]
    fn a_wall_is_a_heavy_partner() {
        walls_are_heavy::<Plane>();
        walls_are_heavy::<Volume>();
    }

    /// I <w^2> is the temperature for each rotation: 20000 draws, z = 4.4.
    #[test]
    fn spins_have_their_temperature() {
        let stream = &mut Stream::seed_from_u64(4);
        let surface = Rough::new(0.0, 0.4).expect("a surface");
        let draws = 20_000;
        let sum: f64 = (0..draws)
            .map(|_| {
                let spin = Surface::<Volume>::thermal_spin(&surface, 2.0, 3.0, 0.25, stream);
                2.0 * Surface::<Volume>::spin_energy(&surface, 3.0, 0.25, spin) / 3.0
            })
            .sum();
        let error = 2.0 * (2.0 / 3.0 / f64::from(draws)).sqrt();
        assert!((sum / f64::from(draws) - 2.0).abs() < 4.4 * error);
    }

    #[test]
    fn refuses_what_is_no_surface() {
        assert!(Rough::new(-1.1, 0.4).is_err());
        assert!(Rough::new(0.0, 0.0).is_err());
        assert!(Rough::new(f64::NAN, 0.4).is_err());
        assert!(Rough::new(1.0, 1.0).is_ok());
    }
}
