//! Granular temperature and fourth cumulant of velocities at one time, and the virial of collisions
//! for the pressure.

use serde::{Deserialize, Serialize};
use stosszahl_model::{
    Collision, Observer, ParticleModel, Particles, Simulation, Space, State, VelocityMoments,
};

/// Granular temperature and fourth cumulant of the velocities of a gas at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergySample {
    /// Time of the sample \[time\].
    pub time: f64,
    /// Granular temperature T = <m v^2>/D \[energy\]; proportional to the kinetic energy per
    /// particle.
    pub temperature: f64,
    /// Fourth cumulant a2 = D <m^2 v^4>/((D + 2) <m v^2>^2) - 1; 0 for a Maxwellian and for a gas
    /// at rest.
    pub fourth_cumulant: f64,
    /// Collisions per particle so far, two for each pair collision.
    pub collisions_per_particle: f64,
}

impl EnergySample {
    /// Computes temperature and fourth cumulant of a state after `pair_collisions` pair collisions.
    pub fn new<P: ParticleModel>(scene: &P, state: &State<P>, pair_collisions: u64) -> Self {
        let moments = VelocityMoments::of_state(scene, state);
        let simulators = state.bodies.len();
        let collisions = 2.0 * pair_collisions as f64 / simulators.max(1) as f64;
        Self::from_moments(state.time, P::Space::DIMENSION, &moments, collisions)
    }

    /// Computes temperature and fourth cumulant of particles after `pair_collisions` pair
    /// collisions.
    pub fn of_particles(particles: &Particles, pair_collisions: u64) -> Self {
        let collisions = 2.0 * pair_collisions as f64 / particles.all.len().max(1) as f64;
        let moments = particles.moments();
        Self::from_moments(particles.time, particles.dimension, &moments, collisions)
    }

    /// Computes temperature and fourth cumulant of a gas from its velocity moments,
    /// [`Simulation::velocity_moments`], without a loop over particles.
    pub fn of_gas(gas: &dyn Simulation, moments: &VelocityMoments) -> Self {
        let collisions =
            2.0 * gas.work_counters().collisions as f64 / gas.particle_count().max(1) as f64;
        Self::from_moments(gas.time(), gas.dimension(), moments, collisions)
    }

    fn from_moments(
        time: f64,
        dimension: usize,
        moments: &VelocityMoments,
        collisions_per_particle: f64,
    ) -> Self {
        let dimension = dimension as f64;
        let [second, fourth] = moments.means();
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

/// Observer that sums the momentum transferred in collisions, for the pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Virial {
    sum: f64,
}

impl Virial {
    /// Computes the compressibility factor Z = p/(nT) = 1 + sum(|impulse| d)/(D N T t) of an
    /// elastic gas of `count` particles over the time `duration`.
    pub fn compressibility_factor<P: ParticleModel>(
        &self,
        count: usize,
        temperature: f64,
        duration: f64,
    ) -> f64 {
        1.0 + self.sum / (P::Space::DIMENSION as f64 * count as f64 * temperature * duration)
    }
}

impl Observer for Virial {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.sum += collision.virial() * collision.weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use stosszahl_model::{Domain, samples};

    #[test]
    fn moments_of_four_particles() {
        let scene = samples::mixture(1.0, [(0.5, 2.0); 4]);
        let bodies = [1.0, -1.0, 3.0, -3.0].map(|v| (vector![0.0, 0.0], vector![v, 0.0]));
        let domain = Domain::periodic(vector![9.0, 9.0]).expect("a box");
        let sample = EnergySample::new(&scene, &samples::state(domain, bodies), 6);
        // <m v^2> = 2 (1 + 9)/2 = 10, <m^2 v^4> = 4 (1 + 81)/2 = 164.
        assert_eq!(sample.temperature, 5.0);
        assert!((sample.fourth_cumulant - (2.0 * 164.0 / (4.0 * 100.0) - 1.0)).abs() < 1e-15);
        assert_eq!(sample.collisions_per_particle, 3.0);
    }
}
