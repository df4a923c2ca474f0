//! Pressure tensor of a gas, from the momentum flux of particles and the virial of collisions.
//!
//! ```text
//! V P_ab = < Σ_i m (v_a - u_a)(v_b - u_b) > + (1/t) Σ_collisions r_a Δp_b
//! ```
//!
//! with the mean velocity u, the vector r between the partners and the momentum Δp that the first
//! one gains (J. H. Irving & J. G. Kirkwood, *Journal of Chemical Physics* **18**, 817 (1950),
//! doi:10.1063/1.1747782). The first term is the **kinetic** part, the second the **collisional**
//! one, which point particles do not have. Its trace over D n T is the equation of state.
//!
//! The kinetic sum is measured when the gas is sampled. Between two samples it follows the
//! collisions. Each changes it by `mu (g' g' - g g)` with the relative velocities g before and g'
//! after it, so that its integral over time is exact for smooth particles in free flight, also
//! while the gas cools. Tangential impulses, walls and fields show at the next sample. In a
//! changes `c_x` by `-a c_y` per time, and with it the sum, exactly too.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use stosszahl_model::sum::Totals;
use stosszahl_model::{Collision, DynReduction, Observer, Particle, ParticleReduction};

/// Computes the kinetic part of the pressure tensor times the volume, relative to the mean velocity
/// \[energy\].
///
/// `reduce_particles` adds all particles of a gas, as
/// [`stosszahl_model::Simulation::reduce_particles`] does.
pub fn kinetic_stress(reduce_particles: &mut dyn FnMut(&mut dyn DynReduction)) -> Matrix3<f64> {
    let mut sum = KineticStress::default();
    reduce_particles(&mut sum);
    sum.tensor()
}

/// Reduction over particles that sums mass, momentum and momentum flux.
#[derive(Serialize, Deserialize)]
pub struct KineticStress {
    totals: Totals,
}

impl Default for KineticStress {
    fn default() -> Self {
        Self {
            totals: Totals::new(10),
        }
    }
}

impl KineticStress {
    /// Computes the kinetic stress `Σ w m (v - u)(v - u)` \[energy\]; zero without particles.
    fn tensor(&self) -> Matrix3<f64> {
        let sums = self.totals.values();
        let [mass, x, y, z, xx, yy, zz, xy, xz, yz] = sums[..] else {
            return Matrix3::zeros();
        };
        if mass == 0.0 {
            return Matrix3::zeros();
        }
        let momentum = Vector3::new(x, y, z);
        let flux = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        flux - momentum * momentum.transpose() / mass
    }
}

impl ParticleReduction for KineticStress {
    const NAME: &'static str = "kinetic stress";

    fn add_particle(&mut self, particle: &Particle) {
        let (mass, v) = (particle.weight * particle.mass, particle.velocity);
        let terms = [
            1.0,
            v.x,
            v.y,
            v.z,
            v.x * v.x,
            v.y * v.y,
            v.z * v.z,
            v.x * v.y,
            v.x * v.z,
            v.y * v.z,
        ];
        for (sum, term) in self.totals.open().iter_mut().zip(terms) {
            *sum += mass * term;
        }
    }

    fn close_group(&mut self, _group: u32) {
        self.totals.close();
    }

    fn merge_sum(&mut self, other: Self) {
        self.totals.merge(&other.totals);
    }
}

/// Time integrals of the pressure tensor times the volume over one span of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StressIntegrals {
    /// Time integral of the kinetic part of the pressure tensor times the volume \[energy x time\].
    pub kinetic: Matrix3<f64>,
    /// Time integral of the collisional part of the pressure tensor times the volume: sum over
    /// collisions of `r_a Δp_b`, in row a and column b \[energy x time\].
    pub collisional: Matrix3<f64>,
    /// Kinetic energy dissipated by normal restitution, less what contacts added \[energy\].
    pub energy_lost: f64,
    /// Number of physical collisions in the time span.
    pub collisions: f64,
    /// Length of the time span that the integrals cover \[time\].
    pub duration: f64,
}

impl StressIntegrals {
    /// Computes the time integral of n T V in D dimensions: the mean diagonal element of the
    /// kinetic part \[energy x time\].
    pub fn thermal(&self, dimension: usize) -> f64 {
        self.kinetic.trace() / dimension as f64
    }

    /// Returns the sum of these integrals and those of another time span.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            kinetic: self.kinetic + other.kinetic,
            collisional: self.collisional + other.collisional,
            energy_lost: self.energy_lost + other.energy_lost,
            collisions: self.collisions + other.collisions,
            duration: self.duration + other.duration,
        }
    }
}

/// Observer that integrates the pressure tensor of one run, in blocks of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressRecorder {
    /// Start of the first time block \[time\].
    start: f64,
    /// Duration of each time block \[time\].
    length: f64,
    /// Time integrals of the pressure tensor, one for each time block.
    blocks: Vec<StressIntegrals>,
    /// Current kinetic part of the pressure tensor times the volume \[energy\].
    kinetic: Matrix3<f64>,
    /// Time up to which the kinetic part has been integrated \[time\].
    since: f64,
    /// Shear rate of a uniform shear flow \[1/time\]; 0 without shear flow.
    shear_rate: f64,
    /// Shear rate of the flow difference between partners, contained in their relative velocity
    /// \[1/time\]; 0 if partners collide as points.
    slip_rate: f64,
}

impl StressRecorder {
    /// Creates `count` time blocks of equal duration from `start` to `end` \[time\]. `kinetic` is
    /// the kinetic stress of the gas at time `now`.
    pub fn new([start, end]: [f64; 2], count: usize, now: f64, kinetic: Matrix3<f64>) -> Self {
        Self {
            start,
            length: (end - start) / count.max(1) as f64,
            blocks: vec![StressIntegrals::default(); count.max(1)],
            kinetic,
            since: now,
            shear_rate: 0.0,
            slip_rate: 0.0,
        }
    }

    /// Returns this recorder for a uniform shear flow \[1/time\]; velocities are relative to the
    /// flow. If `apart`, partners are a contact distance apart in the flow, so that their relative
    /// velocity includes its difference; otherwise they are points.
    #[must_use]
    pub fn in_flow(self, shear_rate: f64, apart: bool) -> Self {
        let slip_rate = if apart { shear_rate } else { 0.0 };
        Self {
            shear_rate,
            slip_rate,
            ..self
        }
    }

    /// Advances the kinetic stress by a time of free flight in the shear flow; returns its integral
    /// over that time.
    fn fly_freely(&mut self, time: f64) -> Matrix3<f64> {
        if self.shear_rate == 0.0 {
            return self.kinetic * time;
        }
        let (before, turn) = (self.kinetic, self.shear_rate * time);
        // Rows and columns of the flow get those of its gradient.
        let mut one = Matrix3::zeros();
        for axis in 0..3 {
            one[(0, axis)] += before[(1, axis)];
            one[(axis, 0)] += before[(axis, 1)];
        }
        let mut two = Matrix3::zeros();
        two[(0, 0)] = before[(1, 1)];
        self.kinetic = before - one * turn + two * (turn * turn);
        (before - one * (turn / 2.0) + two * (turn * turn / 3.0)) * time
    }

    /// Returns the integrals of each time block, in order of time.
    pub fn blocks(&self) -> &[StressIntegrals] {
        &self.blocks
    }

    /// Sets the kinetic stress \[energy\] to the value measured at time `now`.
    pub fn set_kinetic(&mut self, now: f64, kinetic: Matrix3<f64>) {
        self.advance(now);
        self.kinetic = kinetic;
    }

    /// Scales the kinetic stress at time `now`, after all velocities were scaled or randomly kicked
    /// without a preferred direction.
    pub fn scale(&mut self, now: f64, factor: f64) {
        self.advance(now);
        self.kinetic *= factor;
    }

    /// Integrates the kinetic stress up to time `now`.
    fn advance(&mut self, now: f64) {
        let mut from = self.since;
        self.since = now;
        if from < self.start {
            let to = now.min(self.start);
            self.fly_freely(to - from);
            from = to;
        }
        while from < now {
            let Some(number) = self.block_of(from) else {
                self.fly_freely(now - from);
                return;
            };
            let end = self.start + self.length * (number + 1) as f64;
            // A block that rounding has left empty ends at once.
            let to = if end > from { now.min(end) } else { now };
            let integral = self.fly_freely(to - from);
            let block = &mut self.blocks[number];
            block.kinetic += integral;
            block.duration += to - from;
            from = to;
        }
    }

    /// Returns the index of the time block that contains a time; `None` outside all blocks.
    fn block_of(&self, time: f64) -> Option<usize> {
        let number = (time - self.start) / self.length;
        let inside = number >= 0.0 && number < self.blocks.len() as f64;
        inside.then_some(number as usize)
    }
}

impl Observer for StressRecorder {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for one in batch {
            self.advance(one.time);
            if let Some(number) = self.block_of(one.time) {
                let block = &mut self.blocks[number];
                block.collisional += one.momentum_transfer * one.weight;
                block.energy_lost += one.energy_lost() * one.weight;
                block.collisions += one.weight;
            }
            let (mut before, distance) = (one.relative_velocity, one.line.norm());
            before.x -= self.slip_rate * one.line.y;
            let gained = (one.approach() + one.separation()) / distance;
            let after = before + one.line * gained;
            let mass = one.weight * one.reduced_mass;
            self.kinetic += mass * (after * after.transpose() - before * before.transpose());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    fn particles() -> Vec<Particle> {
        let velocities = [
            vector![1.0, 2.0, 0.0],
            vector![-1.0, 0.5, 3.0],
            vector![0.0, -1.0, 1.0],
        ];
        let masses = [1.0, 2.0, 0.5];
        let particle = |(velocity, mass)| Particle {
            velocity,
            mass,
            ..Particle::at_rest(0.5, 1.0)
        };
        velocities.into_iter().zip(masses).map(particle).collect()
    }

    /// The tensor of three particles, added in one group or in three, against the definition.
    /// Bound: some ten roundings of numbers of order ten.
    #[test]
    fn kinetic_part_is_about_the_mean_velocity() {
        let all = particles();
        let mass: f64 = all.iter().map(|one| one.mass).sum();
        let mean = all
            .iter()
            .map(|one| one.velocity * one.mass)
            .sum::<Vector3<f64>>()
            / mass;
        let expected: Matrix3<f64> = all
            .iter()
            .map(|one| {
                let own = one.velocity - mean;
                own * own.transpose() * one.mass
            })
            .sum();
        for groups in [1, 3] {
            let found = kinetic_stress(&mut |sum| {
                for (index, one) in all.iter().enumerate() {
                    sum.add_particle(one);
                    if groups == 3 || index == 2 {
                        sum.close_group(index as u32);
                    }
                }
            });
            assert!((found - expected).norm() < 1e-14, "{groups} groups");
        }
    }

    /// Flight and a collision in a shear flow, against the particles themselves. The integral of a
    /// square in time is that of Simpson's rule. Bound: some ten roundings of numbers of order ten.
    #[test]
    fn kinetic_part_follows_a_shear_flow() {
        let rate = 0.75;
        let mut all = [
            (1.0, vector![1.0, 2.0, 0.5]),
            (2.0, vector![-0.5, -1.0, 1.0]),
        ];
        let tensor = |all: &[(f64, Vector3<f64>); 2]| -> Matrix3<f64> {
            all.iter().map(|(mass, c)| c * c.transpose() * *mass).sum()
        };
        let flown = |all: &[(f64, Vector3<f64>); 2], time: f64| {
            all.map(|(mass, c)| (mass, c - Vector3::x() * (rate * time * c.y)))
        };
        let integral = |all: &[(f64, Vector3<f64>); 2], time: f64| {
            let [first, middle, last] =
                [0.0, 0.5, 1.0].map(|part| tensor(&flown(all, part * time)));
            (first + middle * 4.0 + last) * (time / 6.0)
        };
        let mut recorder =
            StressRecorder::new([0.5, 2.5], 1, 0.0, tensor(&all)).in_flow(rate, true);
        all = flown(&all, 0.5);
        let mut expected = integral(&all, 1.0);
        all = flown(&all, 1.0);
        let line = vector![0.6, -0.8, 0.0];
        let flow = Vector3::x() * (rate * line.y);
        let relative = all[0].1 - all[1].1 + flow;
        let law = stosszahl_model::Separation {
            coefficient: 0.5,
            added_speed: 0.0,
        };
        let mut collision = Collision::at_contact(relative, line, 2.0 / 3.0, law);
        collision.time = 1.5;
        let kick = line * (1.5 * relative.dot(&line));
        all[0].1 -= kick * (2.0 / 3.0);
        all[1].1 += kick * (1.0 / 3.0);
        recorder.on_collisions(&[collision]);
        expected += integral(&all, 1.0);
        recorder.set_kinetic(3.0, Matrix3::zeros());
        let found = recorder.blocks()[0].kinetic;
        assert!((found - expected).norm() < 1e-13, "{found} {expected}");
    }

    /// Two blocks around a collision by hand: the kinetic sum changes at the collision, its
    /// integral is exact, and the transfer is in the block of the collision. Bound: some ten
    /// roundings.
    #[test]
    fn integrals_of_one_collision_by_hand() {
        let mut recorder = StressRecorder::new([1.0, 3.0], 2, 0.0, Matrix3::identity());
        let relative = vector![-2.0, 1.0, 0.0];
        let law = stosszahl_model::Separation {
            coefficient: 0.5,
            added_speed: 0.25,
        };
        let collision = Collision {
            time: 1.5,
            weight: 2.0,
            ..Collision::at_contact(relative, Vector3::x(), 0.5, law)
        };
        recorder.on_collisions(&[collision]);
        recorder.set_kinetic(3.5, Matrix3::zeros());
        let after = vector![1.25, 1.0, 0.0];
        let change: Matrix3<f64> = after * after.transpose() - relative * relative.transpose();
        let later = Matrix3::identity() + change;
        let [first, second] = recorder.blocks() else {
            panic!("two blocks");
        };
        let close = |a: Matrix3<f64>, b: Matrix3<f64>| (a - b).norm() < 1e-14;
        assert!(close(first.kinetic, 0.5 * (Matrix3::identity() + later)));
        assert!(close(second.kinetic, later));
        assert_eq!((first.duration, second.duration), (1.0, 1.0));
        // mu (g + s) d = 0.5 (2 + 1.25), twice for the weight.
        assert!((first.collisional[(0, 0)] - 3.25).abs() < 1e-14);
        assert_eq!(second.collisional, Matrix3::zeros());
        assert!((first.energy_lost - 0.5 * (4.0 - 1.25 * 1.25)).abs() < 1e-14);
        assert_eq!(first.collisions, 2.0);
    }
}
