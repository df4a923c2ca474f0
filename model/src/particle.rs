//! Particle in the form that engines show to measurements, and that initial states are read in.

use nalgebra::Vector3;

/// Particle of a gas, or simulator of a Monte Carlo gas. In two dimensions the third component of
/// vectors is zero, and the spin is the third component of its own vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Position of the centre \[length\], inside the box; the origin in gases without positions.
    pub position: Vector3<f64>,
    /// Velocity of the particle's centre \[length/time\].
    pub velocity: Vector3<f64>,
    /// Angular velocity of the particle \[1/time\]; zero for smooth particles.
    pub spin: Vector3<f64>,
    /// Radius of the particle \[length\]; of one particle that a simulator stands for.
    pub radius: f64,
    /// Mass of the particle \[mass\]; of one particle that a simulator stands for.
    pub mass: f64,
    /// Kinetic energy of rotation, I w^2/2 \[energy\].
    pub spin_energy: f64,
    /// Number of the particle's species, from 0.
    pub species: u32,
    /// Number of particles that a simulator stands for; 1 in event-driven dynamics.
    pub weight: f64,
}

impl Particle {
    /// Creates a particle of a radius \[length\] and a mass \[mass\] at rest at the origin.
    pub fn at_rest(radius: f64, mass: f64) -> Self {
        Self {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
            radius,
            mass,
            spin_energy: 0.0,
            species: 0,
            weight: 1.0,
        }
    }
}
