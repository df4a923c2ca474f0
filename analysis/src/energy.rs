//! Energy and shape of the velocity distribution.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Observer, Particles, Physics, Sizes, Space, State, Vector};

/// Moments of the velocities at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergySample {
    /// Time \[time\].
    pub time: f64,
    /// Granular temperature T = <m v^2>/D; in proportion to the kinetic energy per particle.
    pub temperature: f64,
    /// a2 = D <m^2 v^4>/((D + 2) <m v^2>^2) - 1; 0 for a Maxwellian and for a gas at rest.
    pub fourth_cumulant: f64,
    /// Collisions per particle so far, two for each pair collision.
    pub collisions_per_particle: f64,
}

impl EnergySample {
    /// Takes the moments of a state after `pair_collisions` pair collisions of its bodies.
    pub fn new<P: Physics>(scene: &P, state: &State<P>, pair_collisions: u64) -> Self {
        let sizes = scene.sizes();
        let bodies = state.bodies.iter().enumerate();
        let squares = bodies.map(|(index, body)| {
            let square = sizes.mass(sizes.tag(index)) * body.velocity.square();
            (1.0, square)
        });
        let simulators = state.bodies.len();
        let collisions = 2.0 * pair_collisions as f64 / simulators.max(1) as f64;
        Self::from_squares(state.time, P::Space::DIMENSION, squares, collisions)
    }

    /// Takes the moments of particles after `pair_collisions` pair collisions of them. Weights count by their ratio to the
    /// first, so that equal ones change no digit.
    pub fn of(particles: &Particles, pair_collisions: u64) -> Self {
        let first = particles.all.first().map_or(1.0, |one| one.weight);
        let squares = particles.all.iter().map(|one| {
            let square = one.mass * one.velocity.norm_squared();
            (one.weight / first, square)
        });
        let collisions = 2.0 * pair_collisions as f64 / particles.all.len().max(1) as f64;
        Self::from_squares(particles.time, particles.dimension, squares, collisions)
    }

    /// From weights and m v^2.
    fn from_squares(
        time: f64,
        dimension: usize,
        squares: impl Iterator<Item = (f64, f64)>,
        collisions_per_particle: f64,
    ) -> Self {
        let dimension = dimension as f64;
        let [mut count, mut second, mut fourth] = [0.0; 3];
        for (weight, square) in squares {
            count += weight;
            second += weight * square;
            fourth += weight * square * square;
        }
        let count = if count > 0.0 { count } else { 1.0 };
        let (second, fourth) = (second / count, fourth / count);
        let fourth_cumulant = if second > 0.0 {
            dimension * fourth / ((dimension + 2.0) * second * second) - 1.0
        } else {
            0.0
        };
        Self {
            time,
            temperature: second / dimension,
            fourth_cumulant,
            collisions_per_particle,
        }
    }
}

/// Observes the momentum transferred in collisions, for the pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Virial {
    sum: f64,
}

impl Virial {
    /// Compressibility factor Z = p/(nT) = 1 + sum(|impulse| d)/(D N T t) of an elastic gas of `count` particles
    /// over the time `duration`.
    pub fn compressibility_factor<P: Physics>(
        &self,
        count: usize,
        temperature: f64,
        duration: f64,
    ) -> f64 {
        1.0 + self.sum / (P::Space::DIMENSION as f64 * count as f64 * temperature * duration)
    }
}

impl Observer for Virial {
    fn collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.sum += collision.virial() * collision.weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use stosszahl_model::{Body, Constant, Domain, Free, Monodisperse, Plane, Scene, Smooth};

    #[test]
    fn moments_of_four_particles() {
        let scene = Scene {
            space: Plane,
            surface: Smooth,
            restitution: Constant::new(1.0).expect("a coefficient"),
            sizes: Monodisperse {
                radius: 0.5,
                mass: 2.0,
            },
            field: Free,
        };
        let speeds = [1.0, -1.0, 3.0, -3.0];
        let bodies = speeds
            .map(|v| Body::new(vector![0.0, 0.0], vector![v, 0.0]))
            .to_vec();
        let domain = Domain::periodic(vector![9.0, 9.0]).expect("a box");
        let sample = EnergySample::new(
            &scene,
            &State {
                time: 1.0,
                domain,
                bodies,
            },
            6,
        );
        // <m v^2> = 2 (1 + 9)/2 = 10, <m^2 v^4> = 4 (1 + 81)/2 = 164.
        assert_eq!(sample.temperature, 5.0);
        assert!((sample.fourth_cumulant - (2.0 * 164.0 / (4.0 * 100.0) - 1.0)).abs() < 1e-15);
        assert_eq!(sample.collisions_per_particle, 3.0);
    }
}
