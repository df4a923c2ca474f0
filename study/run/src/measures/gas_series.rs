//! Time series of the whole gas, with sums for each species. The measurements of energy and of
//! flows record it.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::{self, Freedom, Sighting};
use stosszahl_model::sum::Totals;
use stosszahl_model::{Grouping, Particle, ParticleReduction};

use crate::measure::SampleContext;
use crate::plan::CasePlan;

/// State of the whole gas at one time, as sums over all particles. All numbers but the time are in
/// engine units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GasSample {
    /// Time at which the gas was sampled, in the case's unit of time.
    pub time: f64,
    /// Number of physical pair collisions since the start: a collision of simulators counts as many
    /// as the particles each represents.
    pub collisions: f64,
    /// Potential energy in gravity: the sum of -m a · r for the acceleration a, along axes that end
    /// at walls or openings.
    pub potential: f64,
    /// Sums over the particles of each species: number, mass, momentum and energies.
    pub species: Vec<SpeciesSums>,
}

/// Number, mass, momentum and energies of all particles of one species, or of the whole gas, in
/// engine units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeciesSums {
    /// Number of particles that the sums include.
    pub number: f64,
    /// Total mass of the particles in the sums.
    pub mass: f64,
    /// Total momentum of the particles, the sum of m v.
    pub momentum: [f64; 3],
    /// Translational kinetic energy, the sum of m v²/2.
    pub translation: f64,
    /// Rotational kinetic energy, the sum of I w²/2 for the moment of inertia I and the spin w.
    pub rotation: f64,
    /// Sum of (m v²)² over the particles, for the fourth cumulant of the velocities.
    pub fourth: f64,
}

impl SpeciesSums {
    /// Returns the granular temperature `m <(v - u)²>/D` in D dimensions, for the mean velocity u;
    /// 0 without particles.
    pub fn temperature(&self, freedom: Freedom) -> f64 {
        if self.number <= 0.0 {
            return 0.0;
        }
        let square: f64 = self.momentum.iter().map(|p| p * p).sum();
        (2.0 * self.translation - square / self.mass) / (freedom.dimension as f64 * self.number)
    }

    /// Returns the rotational temperature, `I <w²>` over the number of spin components. It is 0
    /// without particles and `None` for smooth particles.
    pub fn spin_temperature(&self, freedom: Freedom) -> Option<f64> {
        let each = freedom.rotations as f64 * self.number.max(f64::MIN_POSITIVE);
        (freedom.rotations > 0).then(|| 2.0 * self.rotation / each)
    }
}

impl SpeciesSums {
    /// Returns the fourth cumulant `a2 = D <(m v²)²>/((D + 2) <m v²>²) - 1` of the velocities; 0
    /// for a Maxwellian and at rest.
    pub fn fourth_cumulant(&self, dimension: usize) -> f64 {
        let (d, square) = (dimension as f64, 2.0 * self.translation);
        if square > 0.0 {
            d * self.fourth * self.number / ((d + 2.0) * square * square) - 1.0
        } else {
            0.0
        }
    }

    fn add(&mut self, other: &Self) {
        self.number += other.number;
        self.mass += other.mass;
        for (sum, more) in self.momentum.iter_mut().zip(other.momentum) {
            *sum += more;
        }
        self.translation += other.translation;
        self.rotation += other.rotation;
        self.fourth += other.fourth;
    }
}

impl GasSample {
    /// Sums the state of the whole gas at the current time.
    pub fn sample_gas(sampling: &GasSampling, moment: &SampleContext<'_>) -> Self {
        Self::take_with(sampling, moment, None).0
    }

    /// Sums the state of the whole gas, and in the same pass its fields on a grid if `fields` is
    /// given.
    pub fn take_with(
        sampling: &GasSampling,
        moment: &SampleContext<'_>,
        fields: Option<fields::FieldSample>,
    ) -> (Self, Option<fields::FieldSample>) {
        let gas = &*moment.simulation;
        let mut look = GasReduction {
            sampling: *sampling,
            totals: Totals::new(SUMS * sampling.grouping.groups() + 1),
            fields,
        };
        gas.reduce_particles(&mut look);
        let values = look.totals.values();
        let (species, potential) = values.split_at(values.len() - 1);
        let share = |sums: &[f64]| SpeciesSums {
            number: sums[0],
            mass: sums[1],
            momentum: [sums[2], sums[3], sums[4]],
            translation: sums[5],
            rotation: sums[6],
            fourth: sums[7],
        };
        let sample = Self {
            time: moment.time,
            collisions: gas.work_counters().collisions as f64 * gas.mean_weight(),
            potential: potential[0],
            species: species.chunks(SUMS).map(share).collect(),
        };
        (sample, look.fields)
    }

    /// Returns the sums over the particles of all species.
    pub fn total(&self) -> SpeciesSums {
        self.total_of(|_| true)
    }

    /// Returns the sums over those species, numbered from 0, for which `counts` returns true.
    pub fn total_of(&self, counts: impl Fn(usize) -> bool) -> SpeciesSums {
        let mut all = SpeciesSums::default();
        let kept = self.species.iter().enumerate();
        for (_, share) in kept.filter(|(species, _)| counts(*species)) {
            all.add(share);
        }
        all
    }

    /// Returns the total energy: translational, rotational and potential energy in gravity.
    pub fn energy(&self) -> f64 {
        let all = self.total();
        all.translation + all.rotation + self.potential
    }
}

/// Parameters of a sample of the whole gas: the grouping of particles into species, and gravity.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct GasSampling {
    grouping: Grouping,
    /// Acceleration of gravity along the axes that end at walls or openings, in engine units.
    gravity: Vector3<f64>,
}

impl GasSampling {
    /// Creates the sampling parameters of the whole gas from the plan of a case.
    pub fn from_plan(plan: &CasePlan) -> Self {
        Self {
            grouping: plan.grouping(),
            gravity: plan.gravity(),
        }
    }
}

/// Number of scalar sums in a `SpeciesSums`.
const SUMS: usize = 8;

/// Parallel reduction over all particles that computes a `GasSample`.
#[derive(Serialize, Deserialize)]
pub struct GasReduction {
    sampling: GasSampling,
    /// Running sums of all species, followed by the sum of the potential energy in gravity.
    totals: Totals,
    fields: Option<fields::FieldSample>,
}

impl ParticleReduction for GasReduction {
    const NAME: &'static str = "series";

    fn add_particle(&mut self, particle: &Particle) {
        let species = self.sampling.grouping.group(particle.species);
        let all = self.totals.open();
        let Particle { weight, mass, .. } = *particle;
        let height = self.sampling.gravity.dot(&particle.position);
        let last = all.len() - 1;
        all[last] += weight * (-mass * height);
        let sums = &mut all[SUMS * species..][..SUMS];
        sums[0] += weight;
        sums[1] += weight * mass;
        let mut square = 0.0;
        for (sum, &component) in sums[2..5].iter_mut().zip(particle.velocity.iter()) {
            *sum += weight * mass * component;
            square += component * component;
        }
        sums[5] += 0.5 * weight * mass * square;
        sums[6] += 0.5 * weight * (2.0 * particle.spin_energy);
        sums[7] += weight * (mass * square) * (mass * square);
        if let Some(fields) = &mut self.fields {
            let sighting = Sighting {
                position: [particle.position.x, particle.position.y],
                velocity: particle.velocity.into(),
                mass,
                twice_spin_energy: 2.0 * particle.spin_energy,
                weight,
            };
            fields.add(species, &sighting);
        }
    }

    fn close_group(&mut self, group: u32) {
        self.totals.close();
        if let Some(fields) = &mut self.fields {
            fields.close(group);
        }
    }

    fn merge_sum(&mut self, other: Self) {
        self.totals.merge(&other.totals);
        if let (Some(fields), Some(more)) = (&mut self.fields, other.fields) {
            fields.merge(more);
        }
    }
}

/// Returns the number of velocity components and of spin components of particles in a case.
pub fn freedom(plan: &CasePlan) -> Freedom {
    let rotations = match (plan.gas.particles.rough, plan.gas.dimension) {
        (None, _) => 0,
        (Some(_), 2) => 1,
        (Some(_), _) => 3,
    };
    Freedom {
        dimension: plan.gas.dimension,
        rotations,
    }
}

/// Samples of the whole gas in one replica, from the start of the run on.
pub type GasSeries = Vec<GasSample>;

/// Returns the smallest number of samples in any replica; 0 without replicas.
pub fn shortest(all_series: &[&GasSeries]) -> usize {
    all_series
        .iter()
        .map(|series| series.len())
        .min()
        .unwrap_or(0)
}
