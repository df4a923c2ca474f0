//! Dimension of a gas as a type, two or three: vectors, rotations, cross-sections and volumes.

use std::f64::consts::{PI, TAU};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector3, vector};
use rand::{Rng, RngExt};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::equation_of_state::{self, spheres};

/// Vector arithmetic that engines and measurements need; implemented by `nalgebra`'s static
/// vectors.
pub trait Vector:
    Copy
    + Debug
    + Default
    + PartialEq
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
    + Index<usize, Output = f64>
    + IndexMut<usize>
    + Serialize
    + DeserializeOwned
    + Send
    + Sync
    + 'static
{
    /// Returns the scalar product a . b of two vectors.
    fn inner(&self, other: &Self) -> f64;

    /// Returns the squared length a . a of the vector.
    fn square(&self) -> f64 {
        self.inner(self)
    }

    /// Returns the vector in three dimensions; components beyond the dimension are zero.
    fn spatial(&self) -> Vector3<f64>;
}

impl<const D: usize> Vector for SVector<f64, D>
where
    SVector<f64, D>: Default + Serialize + DeserializeOwned,
{
    #[inline]
    fn inner(&self, other: &Self) -> f64 {
        self.dot(other)
    }

    #[inline]
    fn spatial(&self) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| if axis < D { self[axis] } else { 0.0 })
    }
}

/// Space in which particles move, two- or three-dimensional, with its geometry.
pub trait Space: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// Number of space dimensions, 2 or 3.
    const DIMENSION: usize;
    /// Type of positions and velocities.
    type Vector: Vector;
    /// Type of rotations of vectors and spins.
    type Turn: Copy;
    /// Type of angular velocities: one component in two dimensions, three in three.
    type Spin: Vector;
    /// Number of components of an angular velocity: 1 in two dimensions, 3 in three.
    const ROTATIONS: usize;
    /// Moment of inertia of a solid disk or sphere over m R^2: 1/2 or 2/5.
    const INERTIA: f64;

    /// Returns the velocity w x r at the end of an arm r that rotates with the angular velocity w.
    fn arm_velocity(spin: Self::Spin, arm: Self::Vector) -> Self::Vector;
    /// Returns the moment r x F of a force or impulse F at the end of an arm r.
    fn arm_moment(arm: Self::Vector, force: Self::Vector) -> Self::Spin;

    /// Returns the vector whose component i is `component(i)`. Written out for each dimension, it
    /// stays in registers where a loop over components would go through memory.
    fn from_components(component: impl FnMut(usize) -> f64) -> Self::Vector;
    /// Returns the area or volume of a particle of a radius, pi r^2 or 4 pi r^3/3 \[length^D\].
    fn particle_volume(radius: f64) -> f64;
    /// Returns the cross-section of two particles with a contact distance d: 2 d or pi d^2
    /// \[length^(D-1)\].
    fn cross_section(distance: f64) -> f64;
    /// Draws a random line of centres, a unit vector from the second particle to the first, for an
    /// approach along the unit vector `direction`. Also returns the component of `direction` along
    /// it, never positive. The impact parameter is uniform in the cross-section, as molecular chaos
    /// has it.
    fn line_of_centres(direction: Self::Vector, stream: &mut impl Rng) -> (Self::Vector, f64);
    /// Draws a random unit vector, all directions equally likely.
    fn random_direction(stream: &mut impl Rng) -> Self::Vector;
    /// Solid angle of all directions: 2 pi or 4 pi.
    const SOLID_ANGLE: f64;
    /// Draws a random rotation, all equally likely.
    fn random_turn(stream: &mut impl Rng) -> Self::Turn;
    /// Returns a vector after a rotation.
    fn rotate_vector(turn: Self::Turn, vector: Self::Vector) -> Self::Vector;
    /// Returns an angular velocity after a rotation.
    fn turned_spin(turn: Self::Turn, spin: Self::Spin) -> Self::Spin;
    /// Returns an angular velocity as a vector with three components; that of a disk is along the
    /// third axis.
    fn spin_in_space(spin: Self::Spin) -> Vector3<f64>;
    /// Returns the angular velocity given by a vector with three components; for a disk its third
    /// component.
    fn spin_of(vector: Vector3<f64>) -> Self::Spin;
    /// Returns the pair correlation of equal particles at contact, chi, at a packing fraction.
    fn contact_value(packing_fraction: f64) -> f64;
    /// Returns the structure factor S(0) at long wavelengths of an elastic gas of equal particles,
    /// at a packing fraction.
    fn structure_factor_at_zero(packing_fraction: f64) -> f64;
    /// Packing fraction of equal particles at random close packing.
    const RANDOM_CLOSE_PACKING: f64;
    /// Returns the mean free path of equal particles over their diameter.
    fn mean_free_path(packing_fraction: f64, contact_value: f64) -> f64;
    /// Returns the collisions per particle and time of a Maxwellian gas of equal particles, in
    /// units of sqrt(T/m)/d.
    fn collision_rate(packing_fraction: f64, contact_value: f64) -> f64;
    /// Mean speed of a Maxwellian gas over sqrt(T/m).
    const MEAN_SPEED: f64;
}

/// Two-dimensional space, of disks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plane;

/// Three-dimensional space, of spheres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Volume;

impl Space for Plane {
    const DIMENSION: usize = 2;
    type Vector = SVector<f64, 2>;
    /// Rotation in the plane, as sine and cosine of its angle.
    type Turn = (f64, f64);
    type Spin = SVector<f64, 1>;
    const ROTATIONS: usize = 1;
    const INERTIA: f64 = 0.5;

    #[inline(always)]
    fn arm_velocity(spin: Self::Spin, arm: Self::Vector) -> Self::Vector {
        vector![-spin[0] * arm[1], spin[0] * arm[0]]
    }
    #[inline(always)]
    fn arm_moment(arm: Self::Vector, force: Self::Vector) -> Self::Spin {
        vector![arm[0] * force[1] - arm[1] * force[0]]
    }

    #[inline(always)]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self::Vector {
        vector![component(0), component(1)]
    }
    #[inline]
    fn particle_volume(radius: f64) -> f64 {
        PI * radius * radius
    }
    #[inline]
    fn cross_section(distance: f64) -> f64 {
        2.0 * distance
    }
    #[inline]
    fn line_of_centres(direction: Self::Vector, stream: &mut impl Rng) -> (Self::Vector, f64) {
        let impact = 2.0 * stream.random::<f64>() - 1.0;
        let along = -(1.0 - impact * impact).sqrt();
        let aside = vector![-direction[1], direction[0]];
        (direction * along + aside * impact, along)
    }
    #[inline]
    fn random_direction(stream: &mut impl Rng) -> Self::Vector {
        loop {
            let x = 2.0 * stream.random::<f64>() - 1.0;
            let y = 2.0 * stream.random::<f64>() - 1.0;
            let square = x * x + y * y;
            if square < 1.0 && square > 1e-4 {
                return vector![x, y] / square.sqrt();
            }
        }
    }
    const SOLID_ANGLE: f64 = TAU;
    fn random_turn(stream: &mut impl Rng) -> Self::Turn {
        (TAU * stream.random::<f64>()).sin_cos()
    }
    fn rotate_vector((sine, cosine): Self::Turn, v: Self::Vector) -> Self::Vector {
        vector![cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1]]
    }
    fn turned_spin(_turn: Self::Turn, spin: Self::Spin) -> Self::Spin {
        spin
    }
    fn spin_in_space(spin: Self::Spin) -> Vector3<f64> {
        vector![0.0, 0.0, spin[0]]
    }
    fn spin_of(vector: Vector3<f64>) -> Self::Spin {
        vector![vector[2]]
    }
    fn contact_value(packing_fraction: f64) -> f64 {
        equation_of_state::contact_value(packing_fraction)
    }
    fn structure_factor_at_zero(packing_fraction: f64) -> f64 {
        equation_of_state::structure_factor_at_zero(packing_fraction)
    }
    const RANDOM_CLOSE_PACKING: f64 = equation_of_state::RANDOM_CLOSE_PACKING;
    fn mean_free_path(packing_fraction: f64, contact_value: f64) -> f64 {
        equation_of_state::mean_free_path(packing_fraction, contact_value)
    }
    fn collision_rate(packing_fraction: f64, contact_value: f64) -> f64 {
        equation_of_state::collision_rate(packing_fraction, contact_value, 0.0)
    }
    /// Mean speed of a two-dimensional Maxwellian gas over sqrt(T/m): sqrt(pi/2).
    const MEAN_SPEED: f64 = 1.253_314_137_315_500_3;
}

impl Space for Volume {
    const DIMENSION: usize = 3;
    type Vector = SVector<f64, 3>;
    type Turn = UnitQuaternion<f64>;
    type Spin = SVector<f64, 3>;
    const ROTATIONS: usize = 3;
    const INERTIA: f64 = 0.4;

    #[inline(always)]
    fn arm_velocity(spin: Self::Spin, arm: Self::Vector) -> Self::Vector {
        spin.cross(&arm)
    }
    #[inline(always)]
    fn arm_moment(arm: Self::Vector, force: Self::Vector) -> Self::Spin {
        arm.cross(&force)
    }

    #[inline(always)]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self::Vector {
        vector![component(0), component(1), component(2)]
    }
    #[inline]
    fn particle_volume(radius: f64) -> f64 {
        4.0 / 3.0 * PI * radius.powi(3)
    }
    #[inline]
    fn cross_section(distance: f64) -> f64 {
        PI * distance * distance
    }
    #[inline]
    fn line_of_centres(direction: Self::Vector, stream: &mut impl Rng) -> (Self::Vector, f64) {
        // A point in the unit disk: no sine, no cosine.
        let (x, y, square) = loop {
            let x = 2.0 * stream.random::<f64>() - 1.0;
            let y = 2.0 * stream.random::<f64>() - 1.0;
            let square = x * x + y * y;
            if square < 1.0 {
                break (x, y, square);
            }
        };
        // Two vectors across the direction: Duff et al., J. Comput. Graph. Tech. 6, 1 (2017).
        let sign = 1.0_f64.copysign(direction[2]);
        let a = -1.0 / (sign + direction[2]);
        let b = direction[0] * direction[1] * a;
        let first = vector![
            1.0 + sign * direction[0] * direction[0] * a,
            sign * b,
            -sign * direction[0]
        ];
        let second = vector![b, sign + direction[1] * direction[1] * a, -direction[1]];
        let along = -(1.0 - square).sqrt();
        (direction * along + first * x + second * y, along)
    }
    #[inline]
    fn random_direction(stream: &mut impl Rng) -> Self::Vector {
        // Marsaglia, Ann. Math. Statist. 43, 645 (1972).
        loop {
            let x = 2.0 * stream.random::<f64>() - 1.0;
            let y = 2.0 * stream.random::<f64>() - 1.0;
            let square = x * x + y * y;
            if square < 1.0 {
                let root = 2.0 * (1.0 - square).sqrt();
                return vector![x * root, y * root, 1.0 - 2.0 * square];
            }
        }
    }
    const SOLID_ANGLE: f64 = 2.0 * TAU;
    fn random_turn(stream: &mut impl Rng) -> Self::Turn {
        // Shoemake, Graphics Gems III, 124 (1992).
        let split: f64 = stream.random();
        let [first, second] = [(); 2].map(|()| (TAU * stream.random::<f64>()).sin_cos());
        let (low, high) = ((1.0 - split).sqrt(), split.sqrt());
        UnitQuaternion::new_normalize(Quaternion::new(
            high * second.1,
            low * first.0,
            low * first.1,
            high * second.0,
        ))
    }
    fn rotate_vector(turn: Self::Turn, vector: Self::Vector) -> Self::Vector {
        turn * vector
    }
    fn turned_spin(turn: Self::Turn, spin: Self::Spin) -> Self::Spin {
        turn * spin
    }
    fn spin_in_space(spin: Self::Spin) -> Vector3<f64> {
        spin
    }
    fn spin_of(vector: Vector3<f64>) -> Self::Spin {
        vector
    }
    fn contact_value(packing_fraction: f64) -> f64 {
        spheres::contact_value(packing_fraction)
    }
    fn structure_factor_at_zero(packing_fraction: f64) -> f64 {
        spheres::structure_factor_at_zero(packing_fraction)
    }
    const RANDOM_CLOSE_PACKING: f64 = spheres::RANDOM_CLOSE_PACKING;
    fn mean_free_path(packing_fraction: f64, contact_value: f64) -> f64 {
        spheres::mean_free_path(packing_fraction, contact_value)
    }
    fn collision_rate(packing_fraction: f64, contact_value: f64) -> f64 {
        spheres::collision_rate(packing_fraction, contact_value)
    }
    /// Mean speed of a three-dimensional Maxwellian gas over sqrt(T/m): sqrt(8/pi).
    const MEAN_SPEED: f64 = 1.595_769_121_605_730_7;
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Checks that vectors have unit length, that the square of the impact parameter has the mean
    /// 1/3 on a line and 1/2 in a disk, and that the mean lateral component vanishes: z = 4.4
    /// standard errors (false alarm 1e-5 each).
    fn check<S: Space>(directions: &[S::Vector], mean_square: f64, variance: f64) {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
        let count = 100_000;
        let (mut square, mut aside) = (0.0, S::Vector::default());
        for index in 0..count {
            let direction = directions[index % directions.len()];
            let (normal, along) = S::line_of_centres(direction, &mut stream);
            assert!((normal.square() - 1.0).abs() < 1e-14);
            assert!((normal.inner(&direction) - along).abs() < 1e-14 && along <= 0.0);
            square += 1.0 - along * along;
            aside += normal - direction * along;
        }
        let n = count as f64;
        assert!((square / n - mean_square).abs() < 4.4 * (variance / n).sqrt());
        for axis in 0..S::DIMENSION {
            assert!(aside[axis].abs() / n < 4.4 * (mean_square / n).sqrt());
        }
    }

    #[test]
    fn impact_parameters_are_uniform_in_the_cross_section() {
        check::<Plane>(&[vector![0.6, -0.8]], 1.0 / 3.0, 4.0 / 45.0);
        let poles = [
            vector![0.0, 0.0, -1.0],
            vector![0.0, 0.0, 1.0],
            vector![0.6, 0.0, -0.8],
            vector![1.0, 0.0, 0.0],
        ];
        check::<Volume>(&poles, 0.5, 1.0 / 12.0);
    }

    #[test]
    fn turns_keep_lengths_and_go_everywhere() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(6);
        let mut sum = SVector::<f64, 3>::zeros();
        for _ in 0..20_000 {
            let turn = Volume::random_turn(&mut stream);
            let v = Volume::rotate_vector(turn, vector![0.0, 0.0, 2.0]);
            assert!((v.norm() - 2.0).abs() < 1e-14);
            // A rotation turns w x r as it turns w and r.
            let (spin, arm) = (vector![0.3, -1.0, 0.5], vector![0.0, 0.0, 2.0]);
            let whole = Volume::rotate_vector(turn, Volume::arm_velocity(spin, arm));
            let parts = Volume::arm_velocity(Volume::turned_spin(turn, spin), v);
            assert!((whole - parts).norm() < 1e-14);
            sum += v;
        }
        // Each component has the variance 4/3.
        assert!(sum.amax() < 4.4 * (4.0 / 3.0 * 20_000.0_f64).sqrt());
    }

    #[test]
    fn rates_are_mean_speed_over_mean_free_path() {
        fn check<S: Space>() {
            let (phi, chi) = (0.1, S::contact_value(0.1));
            let rate = S::MEAN_SPEED / S::mean_free_path(phi, chi);
            assert!((rate / S::collision_rate(phi, chi) - 1.0).abs() < 1e-14);
        }
        check::<Plane>();
        check::<Volume>();
    }
}
