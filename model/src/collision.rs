//! The one collision law, used by every engine.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::colliding_pair::{CollidingPair, PostCollision};
use crate::physics::{Physics, SpinOf, VectorOf};
use crate::space::Vector;
use crate::surface::Surface;

/// What a measurement may know of one collision, in the plane and in space alike: in the plane the third component of
/// vectors is zero. What follows from the fields is computed on demand.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collision {
    /// When it happened \[time\].
    pub time: f64,
    /// Where the first partner was \[length\], perhaps in another image of a periodic box; the origin in gases without
    /// positions.
    pub position: Vector3<f64>,
    /// Relative velocity before, first minus second \[length/time\].
    pub relative: Vector3<f64>,
    /// The line of centres, from the second to the first partner, with the length of their distance
    /// at contact.
    pub line: Vector3<f64>,
    /// Reduced mass m1 m2/(m1 + m2).
    pub reduced_mass: f64,
    /// The coefficient of restitution that acted.
    pub restitution: f64,
    /// Number of physical collisions that this one stands for: 1 in event-driven dynamics, the weight of a
    /// simulator in Monte Carlo.
    pub weight: f64,
    /// Indices of the partners in the state; [`Collision::ANONYMOUS`] where an engine does not distinguish equal particles.
    pub pair: [u32; 2],
    /// Their species; 0 in a gas of one.
    pub species: [u32; 2],
}

impl Collision {
    /// The index of a particle that has none.
    pub const ANONYMOUS: u32 = u32::MAX;

    /// Square of the normal approach speed, (g . k)^2.
    #[inline]
    pub fn normal_square(&self) -> f64 {
        let along = self.relative.dot(&self.line);
        along * along / self.line.square()
    }

    /// Square of the impact parameter over the contact distance, (b/d)^2 = 1 - (g . k)^2/g^2, in
    /// [0, 1].
    ///
    /// Taken from the tangential part of g, which keeps its digits for central collisions.
    #[inline]
    pub fn impact_square(&self) -> f64 {
        let along = self.relative.dot(&self.line) / self.line.square();
        let tangential = self.relative - self.line * along;
        (tangential.square() / self.relative.square()).min(1.0)
    }

    /// Kinetic energy that was lost to the normal part of the contact, (mu/2)(1 - e^2)(g . k)^2.
    #[inline]
    pub fn energy_lost(&self) -> f64 {
        0.5 * self.reduced_mass * (1.0 - self.restitution * self.restitution) * self.normal_square()
    }

    /// Momentum transferred times the distance of the centres, mu (1 + e) |g . k| d: the collision's
    /// share of the virial.
    #[inline]
    pub fn virial(&self) -> f64 {
        -self.reduced_mass * (1.0 + self.restitution) * self.relative.dot(&self.line)
    }
}

/// Velocities and spins after a collision with the given coefficient of normal restitution.
///
/// With g = v1 - v2 and k the unit vector along the line of centres,
/// v1 += -(m2/(m1 + m2))(1 + e)(g . k) k and v2 -= the same with m1: momentum is conserved, the normal
/// part of g is reversed and shortened by e, the tangential part is untouched. The line is divided by
/// its own square, so that a contact distance that is off by rounding costs no energy.
///
/// What is tangential is the [`Surface`]'s.
#[inline]
pub fn collide<P: Physics>(
    scene: &P,
    pair: &CollidingPair<VectorOf<P>, SpinOf<P>>,
    restitution: f64,
) -> PostCollision<VectorOf<P>, SpinOf<P>> {
    let mut after = bounce(pair, restitution);
    scene.surface().rub(pair, &mut after);
    after
}

/// The normal part of [`collide`]: what smooth particles do.
#[inline]
pub fn bounce<V: Vector, W: Copy>(
    pair: &CollidingPair<V, W>,
    restitution: f64,
) -> PostCollision<V, W> {
    let [first, second] = pair.velocities;
    let relative = first - second;
    let kick = pair.line * ((1.0 + restitution) * relative.inner(&pair.line) / pair.line.square());
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
    use crate::{Constant, Free, Monodisperse, Plane, Scene, Smooth, Volume};
    use nalgebra::{Vector2, Vector3, vector};
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn scene<S: crate::Space>(space: S) -> Scene<S, Smooth, Constant, Monodisperse, Free> {
        Scene {
            space,
            surface: Smooth,
            restitution: Constant::new(0.5).expect("a coefficient"),
            sizes: Monodisperse {
                radius: 0.5,
                mass: 1.0,
            },
            field: Free,
        }
    }

    /// Conservation laws for random pairs with random masses, plane and space alike. Bounds: about ten
    /// roundings of numbers of order ten, so 1e-14.
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
            let after = collide(&scene(Volume), &pair, restitution).velocities;
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
            let collision = Collision {
                time: 0.0,
                position: Vector3::zeros(),
                relative: before,
                line: pair.line,
                reduced_mass: pair.masses[0] * pair.masses[1] / (pair.masses[0] + pair.masses[1]),
                restitution,
                weight: 1.0,
                pair: [0, 1],
                species: [0; 2],
            };
            assert!(
                (energy(pair.velocities) - energy(after) - collision.energy_lost()).abs() < 3e-14
            );
        }
    }

    #[test]
    fn impact_parameter_of_central_and_grazing_pairs() {
        let collision = |relative: Vector2<f64>| Collision {
            time: 0.0,
            position: Vector3::zeros(),
            relative: relative.spatial(),
            line: vector![0.0, 1.0, 0.0],
            reduced_mass: 0.5,
            restitution: 1.0,
            weight: 1.0,
            pair: [0, 1],
            species: [0; 2],
        };
        assert_eq!(collision(vector![0.0, -2.0]).impact_square(), 0.0);
        assert_eq!(collision(vector![3.0, 0.0]).impact_square(), 1.0);
        // b/d = 1e-9 survives although 1 - 1e-18 does not exist in double precision.
        let nearly_central = collision(vector![1e-9, -1.0]).impact_square().sqrt();
        assert!((nearly_central - 1e-9).abs() < 1e-24);
        let after = collide(
            &scene(Plane),
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
