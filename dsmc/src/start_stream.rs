//! Start whose particles are made one after the other, so that no process need hold all of them.

use nalgebra::Vector3;

/// Start of a gas as a sequence of particles. Each visit passes the same numbers, in any process,
/// so that a process makes all particles in turn and keeps some of them.
///
/// Several simulators for each particle take one set of particles each. Indices continue from one
/// set to the next.
pub trait StartStream: Sync {
    /// Dimension: 2 or 3.
    fn dimension(&self) -> usize;

    /// Sides of the box \[length\]; the third is 0 for disks.
    fn lengths(&self) -> [f64; 3];

    /// Number of particles in a set.
    fn particles(&self) -> usize;

    /// Number of sets.
    fn sets(&self) -> usize;

    /// Calls `look` with the index and position \[length\] of every particle, in any order.
    ///
    /// # Errors
    /// The reason if a particle finds no place, or after an interrupt.
    fn visit_positions(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String>;

    /// Calls `look` with the index and velocity \[length/time\] of every particle, in the order of
    /// indices.
    ///
    /// # Errors
    /// The reason after an interrupt.
    fn visit_velocities(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String>;

    /// Calls `look` with the index and angular velocity \[1/time\] of every particle, in the order
    /// of indices. Called for rough particles only.
    ///
    /// # Errors
    /// As [`Self::visit_velocities`].
    fn visit_spins(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String>;
}
