//! Collision law that all engines use, and the record of a collision for measurements.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::colliding_pair::{CollidingPair, PostCollision};
use crate::physics::{ParticleModel, SpinOf, VectorOf};
use crate::restitution::Separation;
use crate::space::Vector;
use crate::surface::Surface;

/// Record of one collision for measurements, in two and three dimensions: in two the third
/// component of vectors is zero. Derived quantities are computed on demand.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collision {
    /// Time of the collision \[time\].
    pub time: f64,
    /// Position of the first particle of the pair \[length\], perhaps in another periodic image;
    /// the origin in gases without positions.
    pub position: Vector3<f64>,
    /// Relative velocity before the collision, first minus second particle \[length/time\].
    pub relative_velocity: Vector3<f64>,
    /// Line of centres at contact, from the second to the first particle; its length is the
    /// distance of the centres \[length\].
    pub line: Vector3<f64>,
    /// Reduced mass of the pair, m1 m2/(m1 + m2) \[mass\].
    pub reduced_mass: f64,
    /// Coefficient of normal restitution of this collision.
    pub restitution: f64,
    /// Speed that the contact added to the normal separation \[length/time\]; 0 except for laws
    /// that heat.
    pub added_speed: f64,
    /// Momentum that the collision carries over a distance \[energy\]: the element (a, b) is the
    /// distance along axis a times the momentum along b that the first partner gains. Divided by
    /// volume and time its sum is the collisional part of the pressure tensor.
    pub momentum_transfer: Matrix3<f64>,
    /// Number of physical collisions that the record represents: 1 in event-driven dynamics, the
    /// weight of a simulator in Monte Carlo.
    pub weight: f64,
    /// Indices of the two particles in the state; [`Collision::ANONYMOUS`] where an engine does not
    /// distinguish equal particles.
    pub pair: [u32; 2],
    /// Species of the two particles, from 0; 0 in a gas of one species.
    pub species: [u32; 2],
}

impl Collision {
    /// Placeholder for the index of a particle that an engine does not distinguish from equal ones.
    pub const ANONYMOUS: u32 = u32::MAX;

    /// Creates the record of a collision of smooth particles at contact, with weight 1, at time 0
    /// and at the origin, to which engines add what they know.
    ///
    /// `relative` is v1 - v2 \[length/time\] of partners that approach, `line` points from the
    /// second to the first partner with the length of their distance, and the momentum is carried
    /// over this distance.
    pub fn at_contact(
        relative: Vector3<f64>,
        line: Vector3<f64>,
        reduced_mass: f64,
        law: impl Into<Separation>,
    ) -> Self {
        let Separation {
            coefficient,
            added_speed,
        } = law.into();
        let mut collision = Self {
            time: 0.0,
            position: Vector3::zeros(),
            relative_velocity: relative,
            line,
            reduced_mass,
            restitution: coefficient,
            added_speed,
            momentum_transfer: Matrix3::zeros(),
            weight: 1.0,
            pair: [0, 1],
            species: [0; 2],
        };
        let distance = line.norm();
        let impulse = reduced_mass * (collision.approach() + collision.separation()) / distance;
        collision.momentum_transfer = line * line.transpose() * impulse;
        collision
    }

    /// Returns the normal approach speed before the collision, |g . k| \[length/time\].
    #[inline]
    pub fn approach(&self) -> f64 {
        self.normal_square().sqrt()
    }

    /// Returns the normal speed of separation after the collision \[length/time\].
    #[inline]
    pub fn separation(&self) -> f64 {
        self.restitution * self.approach() + self.added_speed
    }

    /// Returns the square of the normal approach speed, (g . k)^2 \[length^2/time^2\].
    #[inline]
    pub fn normal_square(&self) -> f64 {
        let along = self.relative_velocity.dot(&self.line);
        along * along / self.line.square()
    }

    /// Returns the square of the impact parameter over the contact distance, (b/d)^2 = 1 - (g .
    /// k)^2/g^2, in \[0, 1\].
    ///
    /// Taken from the tangential part of g, which keeps its digits for central collisions.
    #[inline]
    pub fn impact_square(&self) -> f64 {
        let along = self.relative_velocity.dot(&self.line) / self.line.square();
        let tangential = self.relative_velocity - self.line * along;
        (tangential.square() / self.relative_velocity.square()).min(1.0)
    }

    /// Returns the kinetic energy that the normal part of the collision dissipated, `(mu/2)(g_n^2 -
    /// s^2)` with the normal speeds `g_n` before and `s` after it \[energy\]; negative where a
    /// contact heats.
    #[inline]
    pub fn energy_lost(&self) -> f64 {
        let square = self.normal_square();
        let kept = (1.0 - self.restitution * self.restitution) * square;
        let added = if self.added_speed == 0.0 {
            0.0
        } else {
            self.added_speed * (2.0 * self.restitution * square.sqrt() + self.added_speed)
        };
        0.5 * self.reduced_mass * (kept - added)
    }

    /// Returns the virial of the collision \[energy\]: the normal momentum transferred times the
    /// distance of the centres, `mu (g_n + s) d` with the normal speeds before and after.
    #[inline]
    pub fn virial(&self) -> f64 {
        let added = if self.added_speed == 0.0 {
            0.0
        } else {
            self.added_speed * self.line.square().sqrt()
        };
        self.reduced_mass
            * (added - (1.0 + self.restitution) * self.relative_velocity.dot(&self.line))
    }
}

/// Returns the velocities and spins of a pair after a collision, with the normal restitution given
/// by `law`.
///
/// With g = v1 - v2 and k the unit vector along the line of centres, v1 += -(m2/(m1 + m2))(1 + e)(g
/// . k) k and v2 -= the same with m1: momentum is conserved, the normal part of g is reversed and
/// shortened by e, the tangential part is untouched. The line is divided by its own square, so that
/// a contact distance that is off by rounding costs no energy. A law that adds the speed a pushes
/// both partners apart by it, in proportion to the mass of the other.
///
/// What is tangential is the [`Surface`]'s.
#[inline]
pub fn collide<P: ParticleModel>(
    scene: &P,
    pair: &CollidingPair<VectorOf<P>, SpinOf<P>>,
    law: impl Into<Separation>,
) -> PostCollision<VectorOf<P>, SpinOf<P>> {
    let mut after = bounce(pair, law);
    scene.surface().apply_friction(pair, &mut after);
    after
}

/// Applies the normal part of the collision law [`collide`] to a pair, which is all of it for
/// smooth particles.
#[inline]
pub fn bounce<V: Vector, W: Copy>(
    pair: &CollidingPair<V, W>,
    law: impl Into<Separation>,
) -> PostCollision<V, W> {
    let Separation {
        coefficient,
        added_speed,
    } = law.into();
    let [first, second] = pair.velocities;
    let relative = first - second;
    let square = pair.line.square();
    let mut kick = pair.line * ((1.0 + coefficient) * relative.inner(&pair.line) / square);
    if added_speed != 0.0 {
        kick -= pair.line * (added_speed / square.sqrt());
    }
    let total = pair.masses[0] + pair.masses[1];
    PostCollision {
        velocities: [
            first - kick * (pair.masses[1] / total),
            second + kick * (pair.masses[0] / total),
        ],
        spins: pair.spins,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Volume;
    use crate::samples::{disks, equal};
    use nalgebra::{Vector2, Vector3, vector};
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Conservation laws for random pairs with random masses, plane and space alike. Bounds: about
    /// ten roundings of numbers of order ten, so 1e-14.
    #[test]
    fn collisions_conserve_momentum_and_shorten_the_normal_part() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut number = || stream.random_range(-1.0..1.0);
        for _ in 0..10_000 {
            let pair = CollidingPair {
                velocities: [
                    vector![number(), number(), number()],
                    vector![number(), number(), number()],
                ],
                spins: [(); 2],
                masses: [1.5 + number(), 1.5 + number()],
                radii: [0.5; 2],
                line: vector![number(), number(), number()],
            };
            let restitution = number().abs();
            let after = collide(&equal::<Volume>(0.5), &pair, restitution).velocities;
            let momentum = |v: [Vector3<f64>; 2]| v[0] * pair.masses[0] + v[1] * pair.masses[1];
            assert!((momentum(after) - momentum(pair.velocities)).norm() < 1e-14);
            let normal = pair.line.normalize();
            let before = pair.velocities[0] - pair.velocities[1];
            let relative = after[0] - after[1];
            assert!((relative.dot(&normal) + restitution * before.dot(&normal)).abs() < 1e-14);
            let tangential = |g: Vector3<f64>| g - normal * g.dot(&normal);
            assert!((tangential(relative) - tangential(before)).norm() < 1e-14);
            let energy = |v: [Vector3<f64>; 2]| {
                0.5 * (v[0].norm_squared() * pair.masses[0] + v[1].norm_squared() * pair.masses[1])
            };
            let reduced_mass = pair.masses[0] * pair.masses[1] / (pair.masses[0] + pair.masses[1]);
            let collision = Collision::at_contact(before, pair.line, reduced_mass, restitution);
            if before.dot(&pair.line) < 0.0 {
                let gained = (after[0] - pair.velocities[0]) * pair.masses[0];
                let transfer = pair.line * gained.transpose();
                assert!((collision.momentum_transfer - transfer).norm() < 3e-14);
                assert!((collision.virial() - transfer.trace()).abs() < 3e-14);
            }
            assert!(
                (energy(pair.velocities) - energy(after) - collision.energy_lost()).abs() < 3e-14
            );
        }
    }

    /// A contact that adds speed, for random pairs: the separation speed is `r g + a`, momentum is
    /// conserved and the energy is accounted for, also at g = 0. Bounds: some ten roundings of
    /// numbers of order ten, so 3e-14.
    #[test]
    fn contacts_that_heat_separate_at_the_stated_speed() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(2);
        let law = Separation {
            coefficient: 0.8,
            added_speed: 0.3,
        };
        for number in 0..10_000 {
            let mut draw = || stream.random_range(-1.0..1.0);
            let line: Vector3<f64> = vector![draw(), draw(), draw()];
            let mut relative = vector![draw(), draw(), draw()];
            if number == 0 {
                relative = Vector3::zeros();
            }
            if relative.dot(&line) > 0.0 {
                relative = -relative;
            }
            let (masses, mean) = (
                [1.5 + draw(), 1.5 + draw()],
                vector![draw(), draw(), draw()],
            );
            let velocities = [mean + relative, mean];
            let pair = CollidingPair {
                velocities,
                spins: [(); 2],
                masses,
                radii: [0.5; 2],
                line,
            };
            let after = bounce(&pair, law).velocities;
            let normal = line.normalize();
            let approach = -relative.dot(&normal);
            let speed = (after[0] - after[1]).dot(&normal);
            assert!((speed - law.speed(approach)).abs() < 3e-14);
            let momentum = |v: [Vector3<f64>; 2]| v[0] * masses[0] + v[1] * masses[1];
            assert!((momentum(after) - momentum(velocities)).norm() < 3e-14);
            let energy = |v: [Vector3<f64>; 2]| {
                0.5 * (v[0].norm_squared() * masses[0] + v[1].norm_squared() * masses[1])
            };
            let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
            let collision = Collision::at_contact(relative, line, reduced, law);
            let lost = energy(velocities) - energy(after);
            assert!((collision.energy_lost() - lost).abs() < 3e-14);
            let gained = (after[0] - velocities[0]) * masses[0];
            assert!((collision.virial() - line.dot(&gained)).abs() < 3e-14);
        }
    }

    #[test]
    fn impact_parameter_of_central_and_grazing_pairs() {
        let collision = |relative: Vector2<f64>| {
            Collision::at_contact(relative.spatial(), vector![0.0, 1.0, 0.0], 0.5, 1.0)
        };
        assert_eq!(collision(vector![0.0, -2.0]).impact_square(), 0.0);
        assert_eq!(collision(vector![3.0, 0.0]).impact_square(), 1.0);
        // b/d = 1e-9 survives although 1 - 1e-18 does not exist in double precision.
        let nearly_central = collision(vector![1e-9, -1.0]).impact_square().sqrt();
        assert!((nearly_central - 1e-9).abs() < 1e-24);
        let after = collide(
            &disks(0.5),
            &CollidingPair {
                velocities: [vector![0.0, -1.0], vector![0.0, 1.0]],
                spins: [(); 2],
                masses: [1.0, 1.0],
                radii: [0.5; 2],
                line: vector![0.0, 0.3],
            },
            0.5,
        );
        assert_eq!(after.velocities, [vector![0.0, 0.5], vector![0.0, -0.5]]);
    }
}
