//! Quantities of particles that snapshot files can contain, with their names and units.

use serde::Deserialize;
use stosszahl_model::{Particle, Particles};

use crate::plan::UnitScale;

/// Quantity of each particle in a snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ParticleQuantity {
    /// Velocity of the particle \[length/time\].
    Velocity,
    /// Radius of the particle \[length\].
    Radius,
    /// Mass of the particle \[mass\].
    Mass,
    /// Angular velocity of the particle \[1/time\].
    AngularVelocity,
    /// Number of the particle's species, from 0.
    Species,
    /// Weight: number of particles that a simulator stands for.
    Weight,
}

/// Numbers of a quantity of one particle: a scalar, or the components of a vector.
pub(super) enum Numbers {
    One([f64; 1]),
    Vector([f64; 3]),
}

impl Numbers {
    pub(super) fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(one) => one,
            Self::Vector(vector) => vector,
        }
    }
}

impl ParticleQuantity {
    const ALL: [Self; 6] = [
        Self::Velocity,
        Self::Radius,
        Self::Mass,
        Self::AngularVelocity,
        Self::Species,
        Self::Weight,
    ];

    /// Returns the name of the quantity in CSV files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Radius => "radius",
            Self::Mass => "mass",
            Self::AngularVelocity => "angular_velocity",
            Self::Species => "species",
            Self::Weight => "weight",
        }
    }

    /// Returns true if the quantity is a vector.
    pub(super) fn is_vector(self) -> bool {
        matches!(self, Self::Velocity | Self::AngularVelocity)
    }

    /// Returns true if the quantity is written by default: velocity, radius and mass always, others
    /// if particles have or differ in them.
    fn is_written_by_default(self, particles: &Particles) -> bool {
        let mut all = particles.all.iter();
        match self {
            Self::Velocity | Self::Radius | Self::Mass => true,
            Self::AngularVelocity => all.any(|one| one.spin.norm_squared() > 0.0),
            Self::Species => all.any(|one| one.species > 0),
            Self::Weight => all.any(|one| one.weight != particles.all[0].weight),
        }
    }

    /// Returns the quantity of a particle in other units; one engine unit is `scale` of them.
    pub(super) fn numbers(self, one: &Particle, scale: UnitScale) -> Numbers {
        let number = match self {
            Self::Velocity => return Numbers::Vector((one.velocity * scale.speed()).into()),
            Self::AngularVelocity => return Numbers::Vector((one.spin / scale.time()).into()),
            Self::Radius => one.radius * scale.length,
            Self::Mass => one.mass * scale.mass,
            Self::Species => f64::from(one.species),
            Self::Weight => one.weight,
        };
        Numbers::One([number])
    }
}

/// Returns the quantities to write: the requested ones, or by default those in which particles
/// differ.
pub(super) fn written(
    asked: Option<&[ParticleQuantity]>,
    particles: &Particles,
) -> Vec<ParticleQuantity> {
    let all = ParticleQuantity::ALL.into_iter();
    match asked {
        Some(asked) => all.filter(|one| asked.contains(one)).collect(),
        None => all
            .filter(|one| one.is_written_by_default(particles))
            .collect(),
    }
}
