//! Direct Simulation Monte Carlo of inelastic hard disks and spheres, smooth or rough, dilute and dense, in a periodic box
//! or between walls.
//!
//! Bird's method (*Molecular Gas Dynamics and the Direct Simulation of Gas Flows*, Oxford 1994):
//! simulators fly freely for a step, are sorted into cells, and pairs within a cell collide with the
//! probability that kinetic theory gives them, whatever their positions: **molecular chaos is put in
//! by hand**, the impact parameter is uniform, and whatever differs from event-driven dynamics of the
//! same start is due to correlations, or to this method's own errors, which are counted and reported.
//!
//! * **Time**: half a free flight, sort, collide, half a free flight: symmetric, second order in the
//!   step; the half flights between two collisions are one. The step follows the gas: the fastest simulator needs several
//!   steps to cross a cell, and a mean free time lasts as many. What it follows is taken before the collisions of the step
//!   before, so that a sweep knows how far to fly.
//! * **How many pairs**: a cell of volume V with n simulators of weight w (particles each) tries
//!   n(n-1)/2 . chi w s `g_max` dt/V pairs, s the cross section (2 d for disks, pi d^2 for spheres), or one of the two whole
//!   numbers next to it, drawn so that the mean is right, and accepts a pair with g/`g_max`. The majorant is the diagonal of
//!   the box that holds the velocities of the cell: no pair is faster, and only a pair that exceeds it after collisions
//!   within the step is counted. One majorant for the whole box lost: in a clustered gas nearly all its trials are
//!   rejected.
//! * **Density**: chi of a [`Scheme`]. The displacement of Alexander, Garcia & Alder, Phys. Rev. Lett. 74,
//!   5212 (1995), doi:10.1103/PhysRevLett.74.5212, moves the partners by one diameter along the
//!   transferred momentum, which gives the collisional pressure of elastic hard disks, and 2r/(1 + r) of it
//!   where restitution r shortens the momentum that is carried.
//! * **Randomness** is addressed by (seed, replica, step, cell), and the order of simulators within a cell is that of
//!   the cells they came from: results are the same bytes for any number of threads and,
//!   for pairs within cells, however cells are grouped.
//!
//! With the feature `processes` a gas can be held by several processes ([`simulate_among`]); without it the crate compiles faster.
//!
//! # Walls, gravity and flow
//!
//! [`Boundaries`] are data. [`Engine::start_between`] takes walls (restitutive with slip, diffuse, sliding, vibrating), open
//! faces, streams that flow in, obstacles, and weights by region; a field of gravity is a type of the scene.
//!
//! * **Flight** is exact: between two collisions a simulator goes from contact to contact, whose times are closed forms, on
//!   straight lines or parabolas. Only tiles that a boundary can be reached from look for contacts, and simulators that leave
//!   their tile; a periodic box pays nothing.
//! * **Rest**: a grain that falls on a floor which gives back less than it gets touches it infinitely often in a finite
//!   time. After a thousand contacts in one flight it is laid to rest, counted, and borne by the wall until that turns away.
//! * **Room**: cells that walls, with their clearance, or obstacles cut have less volume; collision rates and packing
//!   fractions are those of the rest, and neighbourhoods stop at walls.
//! * **Sub-cells**: where an obstacle hides a part of a cell from another, pairs are drawn within sub-cells whose points see each
//!   other, and densities are taken over what is in sight.
//! * **Streams** are drawn from the exact flux of a drifting Maxwellian through each cell of the face, at uniform times of
//!   the flight.
//! * **Weights** depend on the cell alone, so that no simulator stores one. What goes from a weight a to b becomes a/b
//!   simulators on average.
//! * **Ledgers**: what each wall, obstacle, opening, stream and change of weight gave is kept ([`Ledgers`]), so that mass,
//!   momentum and energy can be accounted for.
//!
//! # Speed
//!
//! Cells are grouped in tiles of some thousand simulators, which fit the second cache. A sweep takes tile after tile, or
//! several at a time: a counting sort by cell of what stayed and what came, collisions, flight; those that leave the tile go
//! to its outbox and are received in the next sweep. So each simulator is read and written once in a step, in
//! order, and no second copy of all exists. Three passes over all simulators, to sort, collide and move, were the alternative:
//! it needs two copies, and each pass waits for the memory anew. `docs/development/monte-carlo.md` has the figures.
//!
//! Schemes that need a neighbourhood of cells run as two sweeps instead of one. Those whose partners are in different
//! cells are in `cross_cell`: the line of centres is drawn first, and the partner from where it then has to be.
//!
//! # Known errors
//!
//! In cells of two diameters at packing 0.25 (1.27 disks each, as in Luding, Müller & McNamara 1998):
//! chi of so few disks is noisy and must be limited; the displacement thins out the pairs within a cell;
//! the same few pairs meet again and again and become correlated; momentum is carried over three mean
//! free paths. `docs/development/validation.md` has the measured sizes. More simulators per disk reduce all but the
//! last, and weaken thermal noise. [`Scheme::ContactPoint`] has the rate and the pressure of Enskog's theory even so, and
//! needs many simulators only for chaos.

mod boundary;
mod checkpoint;
mod cross_cell;
mod decomposition;
mod density;
mod engine;
mod extrema;
mod features;
mod flight;
mod grid;
mod parameters;
mod random_counts;
mod regions;
mod replicate_start;
mod scheme;
mod within_cell;
// Unit tests are of the parts: without all kinds of gases they compile faster.
mod particle;
mod pause;
#[cfg(not(test))]
mod simulate;
mod start;
mod start_means;
mod step;
mod sweep;
mod tally;
#[cfg(test)]
mod tests;
mod threads;
mod tile;

pub use boundary::{Boundaries, Clearance, Inflow, Ledgers, Transfer, Weights};
pub use checkpoint::Checkpoint;
pub use decomposition::{Beside, Ranks, from_first, gather_from_all, shard_name};
pub use engine::Engine;
pub use grid::Grid;
pub use parameters::{Copies, Displacement, EngineError, Parameters};
pub use particle::{Follow, Followed, Simulator, Unfollowed};
pub use scheme::{Neighbourhood, Scheme};
#[cfg(not(test))]
pub use simulate::{
    BALANCE, ExpectedGas, Gas, Left, check, resume, resume_among, serve, simulate, simulate_among,
};
pub use tally::{CellCount, Tally};

/// Gases without positions, in a package of their own.
pub use stosszahl_homogeneous as homogeneous;

/// Version of the statistics of this engine: one more with each change that moves means beyond their errors, under *Results changed* in
/// the changelog. Other digits of the same means do not count. Costly results in the documentation are refused once it has moved.
pub const STATISTICS_VERSION: u32 = 2;

/// The same of `contact-point` gases whose density is taken halfway to the contact, those of twelve or more simulators for each disk in periodic
/// boxes: they alone change with it.
pub const HALFWAY_STATISTICS_VERSION: u32 = 1;
