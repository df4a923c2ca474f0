//! Mean flow of each species of a gas, and thermal energy relative to it, by reductions over its
//! particles.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::sum::Totals;
use stosszahl_model::{DynReduction, Grouping, Particle, ParticleReduction};

/// Callback that adds all particles of a gas to a reduction, as
/// [`stosszahl_model::Simulation::reduce_particles`] does.
pub type AddUp<'a> = dyn FnMut(&mut dyn DynReduction) + 'a;

/// Mean flow of one species: its number of particles, mass and mean velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeciesFlow {
    /// Number of particles of the species: sum of the weights.
    pub number: f64,
    /// Sum of the squared weights of the simulators of the species.
    pub squares: f64,
    /// Total mass of the particles of the species \[mass\].
    pub mass: f64,
    /// Mass-weighted mean velocity of the species \[length/time\]; zero without particles.
    pub velocity: Vector3<f64>,
}

impl SpeciesFlow {
    /// Flow with zero velocity and infinite mass, relative to which particles keep their own
    /// velocities.
    pub const NONE: Self = Self {
        number: 0.0,
        squares: 0.0,
        mass: f64::INFINITY,
        velocity: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Computes the mean flow of each species by a reduction over all particles.
pub fn flows(grouping: Grouping, reduce_particles: &mut AddUp<'_>) -> Vec<SpeciesFlow> {
    let mut sums = SpeciesFlows {
        grouping,
        totals: Totals::new(6 * grouping.groups()),
    };
    reduce_particles(&mut sums);
    let values = sums.totals.values();
    let flow = |sums: &[f64]| SpeciesFlow {
        number: sums[0],
        squares: sums[1],
        mass: sums[2],
        velocity: Vector3::from_column_slice(&sums[3..]) / sums[2].max(f64::MIN_POSITIVE),
    };
    values.chunks(6).map(flow).collect()
}

/// Reduction that sums weights, squared weights, mass and momentum by species.
#[derive(Serialize, Deserialize)]
pub struct SpeciesFlows {
    grouping: Grouping,
    totals: Totals,
}

impl ParticleReduction for SpeciesFlows {
    const NAME: &'static str = "flows";

    fn add_particle(&mut self, particle: &Particle) {
        let place = 6 * self.grouping.group(particle.species);
        let sums = &mut self.totals.open()[place..place + 6];
        let mass = particle.weight * particle.mass;
        sums[0] += particle.weight;
        sums[1] += particle.weight * particle.weight;
        sums[2] += mass;
        for (sum, component) in sums[3..].iter_mut().zip(particle.velocity.iter()) {
            *sum += mass * component;
        }
    }

    fn close_group(&mut self, _group: u32) {
        self.totals.close();
    }

    fn merge_sum(&mut self, other: Self) {
        self.totals.merge(&other.totals);
    }
}

/// Sums over the thermal motion of one species, relative to its flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Number of particles of the species.
    pub number: f64,
    /// Sum of `m (v - u)²` over the particles: twice the thermal energy \[energy\].
    pub twice_energy: f64,
    /// Sums of `w f^p`, p = 1 to 3, with `f = 1 - w m/M`, the weight w and the mass M of the
    /// species.
    pub free: [f64; 3],
}

/// Computes the thermal motion of each species relative to the given flows, by a reduction over all
/// particles.
pub fn thermal(
    grouping: Grouping,
    flows: &[SpeciesFlow],
    reduce_particles: &mut AddUp<'_>,
) -> Vec<Thermal> {
    let mut sums = Warmth {
        grouping,
        flows: flows.to_vec(),
        totals: Totals::new(5 * grouping.groups()),
    };
    reduce_particles(&mut sums);
    let values = sums.totals.values();
    let thermal = |sums: &[f64]| Thermal {
        number: sums[0],
        twice_energy: sums[1],
        free: [sums[2], sums[3], sums[4]],
    };
    values.chunks(5).map(thermal).collect()
}

/// Reduction that sums the thermal motion of each species.
#[derive(Serialize, Deserialize)]
pub struct Warmth {
    grouping: Grouping,
    flows: Vec<SpeciesFlow>,
    totals: Totals,
}

impl ParticleReduction for Warmth {
    const NAME: &'static str = "warmth";

    fn add_particle(&mut self, particle: &Particle) {
        let species = self.grouping.group(particle.species);
        let flow = &self.flows[species];
        let sums = &mut self.totals.open()[5 * species..][..5];
        let Particle { weight, mass, .. } = *particle;
        sums[0] += weight;
        sums[1] += weight * mass * (particle.velocity - flow.velocity).norm_squared();
        let free = 1.0 - weight * mass / flow.mass;
        sums[2] += weight * free;
        sums[3] += weight * free.powi(2);
        sums[4] += weight * free.powi(3);
    }

    fn close_group(&mut self, _group: u32) {
        self.totals.close();
    }

    fn merge_sum(&mut self, other: Self) {
        self.totals.merge(&other.totals);
    }
}
