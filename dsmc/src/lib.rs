//! Direct Simulation Monte Carlo of inelastic hard disks, dilute and dense, in a periodic box.
//!
//! Bird's method (*Molecular Gas Dynamics and the Direct Simulation of Gas Flows*, Oxford 1994):
//! simulators fly freely for a step, are sorted into cells, and pairs within a cell collide with the
//! probability that kinetic theory gives them, whatever their positions: **molecular chaos is put in
//! by hand**, the impact parameter is uniform, and whatever differs from event-driven dynamics of the
//! same start is due to correlations, or to this method's own errors, which are counted and reported.
//!
//! * **Time**: half a free flight, sort, collide, half a free flight: symmetric, second order in the
//!   step. The step follows the gas: the fastest simulator needs several steps to cross a cell, and a
//!   mean free time lasts as many.
//! * **How many pairs**: a cell of area V with n simulators of weight w (disks each) tries
//!   n(n-1)/2 . chi w 2 d `g_max` dt/V pairs, a real number whose remainder is carried to the next step,
//!   and accepts a pair with g/`g_max`. The majorant is the sum of the two largest speeds relative to the
//!   cell's mean velocity, so it fits each cell; a pair that exceeds it after collisions within the step
//!   is counted. One majorant for the whole box lost: in a clustered gas nearly all its trials are
//!   rejected.
//! * **Density**: chi of a [`Scheme`]. The displacement of Alexander, Garcia & Alder, Phys. Rev. Lett. 74,
//!   5212 (1995), doi:10.1103/PhysRevLett.74.5212, moves the partners by one diameter along the
//!   transferred momentum, which gives the collisional pressure of elastic hard disks, and 2r/(1 + r) of it
//!   where restitution r shortens the momentum that is carried.
//! * **Randomness** is addressed by (seed, replica, step, cell): results do not depend on the order in
//!   which cells are treated.
//!
//! # Known errors
//!
//! In cells of two diameters at packing 0.25 (1.27 disks each, as in Luding, Müller & McNamara 1998):
//! chi of so few disks is noisy and must be limited; the displacement thins out the pairs within a cell;
//! the same few pairs meet again and again and become correlated; momentum is carried over three mean
//! free paths. `docs/validation.md` has the measured sizes. More simulators per disk reduce all but the
//! last, and weaken thermal noise.

mod density;
mod engine;
pub mod homogeneous;

pub use density::{Neighbourhood, Scheme};
pub use engine::{Checkpoint, Engine, EngineError, Parameters, Tally};
