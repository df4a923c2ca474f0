//! Direct Simulation Monte Carlo of inelastic hard disks and spheres.
//!
//! Particles are smooth or rough, the gas dilute or dense, the box periodic or bounded by walls.
//!
//! Bird's method (*Molecular Gas Dynamics and the Direct Simulation of Gas Flows*, Oxford 1994):
//! simulators fly freely for a step and are sorted into cells. Pairs within a cell collide with the
//! probability of kinetic theory, whatever their positions. **Molecular chaos is imposed** and the
//! impact parameter is uniform. Differences from event-driven dynamics of the same start are due to
//! correlations, or to errors of this method, which are counted and reported.
//!
//! * **Time**: half a free flight, sort, collide, half a free flight: symmetric, second order in
//!   the step; the two half flights between collisions are merged. The step adapts: the fastest
//!   simulator needs several steps to cross a cell, and a mean free time lasts as many. It is
//!   chosen from the state before the previous collisions, so that a sweep knows how far to fly.
//! * **Number of pairs** (no-time-counter): a cell of volume V with n simulators of weight w tests
//!   n(n-1)/2 . chi w s `g_max` dt/V candidate pairs, s the cross section (2 d for disks, pi d^2
//!   for spheres), rounded at random to an adjacent whole number, and accepts a pair with g/`g_max`
//!   (acceptance-rejection). The majorant is the diagonal of the bounding box of the velocities in
//!   the cell; a pair that exceeds it after collisions within the step is counted. One majorant for
//!   the whole box lost: in a clustered gas nearly all its candidates are rejected.
//! * **Density**: chi of a [`Scheme`]. Partners are displaced by one diameter along the transferred
//!   momentum (Alexander, Garcia & Alder, Phys. Rev. Lett. 74, 5212 (1995),
//!   doi:10.1103/PhysRevLett.74.5212). That gives the collisional pressure of elastic hard disks,
//!   times 2r/(1 + r) where restitution r shortens the momentum that is carried.
//! * **Random numbers** are addressed by (seed, replica, step, cell), and the order of simulators
//!   within a cell is that of their source cells. Results have the same bytes for any number of
//!   threads and, for pairs within cells, for any grouping of cells.
//!
//! With the feature `processes` several processes can hold a gas (domain decomposition,
//! [`simulate_distributed`]); without it the crate compiles faster.
//!
//! # Walls, gravity and flow
//!
//! [`BoundaryConditions`] are data. [`EngineSetup::between`] takes walls (with restitution and
//! slip, diffuse, sliding, vibrating), open faces, inflows, obstacles, and weights by region.
//! Gravity is a type of the physical model.
//!
//! * **Flight** is exact: between two collisions a simulator moves from contact to contact on
//!   straight lines or parabolas, with contact times in closed form. Only tiles within reach of a
//!   boundary and simulators that leave their tile search for contacts; a periodic box pays
//!   nothing.
//! * **Rest**: a particle that falls on an inelastic floor touches it infinitely often in finite
//!   time. After a thousand contacts in one flight it is laid to rest, counted, and carried by the
//!   wall until that accelerates away.
//! * **Free volume**: cells cut by walls, with their clearance, or by obstacles have less volume.
//!   Collision rates and packing fractions use the rest, and density windows end at walls.
//! * **Sub-cells**: where an obstacle hides a part of a cell, pairs are drawn within sub-cells
//!   whose points see each other, and densities are averaged over the cells in sight.
//! * **Inflows** are drawn from the exact flux of a drifting Maxwellian through each cell of the
//!   face, at uniform times of the flight.
//! * **Weights** depend on the cell alone, so no simulator stores one. A simulator that moves from
//!   weight a to b becomes a/b simulators on average.
//! * **Ledgers** record what each wall, obstacle, opening, inflow and change of weight gave
//!   ([`Ledgers`]), so that mass, momentum and energy can be accounted for.
//!
//! # Speed
//!
//! Cells are grouped in tiles of some thousand simulators, which fit the second-level cache. A
//! sweep processes tile after tile, several in parallel: a counting sort by cell of those that
//! stayed and arrived, collisions, flight. Simulators that leave go to the tile's outbox and are
//! received in the next sweep. Each simulator is thus read and written once per step, in order,
//! without a second copy. The alternative of three passes over all simulators (sort, collide, move)
//! lost: it needs two copies, and each pass waits for memory. `docs/development/monte-carlo.md` has
//! the figures.
//!
//! Schemes that need a density window run as two sweeps instead of one. Those with partners in
//! other cells are in `cross_cell`: the line of centres is drawn first, then the partner from the
//! place where it must be.
//!
//! # Known errors
//!
//! In cells of two diameters at packing 0.25, with 1.27 disks each (Luding, Müller & McNamara
//! 1998), a scheme has four errors:
//!
//! - chi of so few disks is noisy and must be limited;
//! - the displacement thins out the pairs within a cell;
//! - repeated collisions of the same pairs correlate them;
//! - momentum is carried over three mean free paths.
//!
//! `docs/development/validation.md` has the measured sizes. More simulators per disk reduce all but
//! the last, and weaken thermal noise. [`Scheme::ContactPoint`] has Enskog's rate and pressure
//! nevertheless, and needs many simulators only for chaos.

mod boundary;
mod checkpoint;
mod cross_cell;
mod decomposition;
mod density;
mod engine;
mod entrants;
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
// Unit tests cover the parts: without all types of gases they compile faster.
mod particle;
mod pause;
#[cfg(not(test))]
mod simulate;
mod start;
mod start_means;
mod start_stream;
mod step;
mod sweep;
mod tally;
#[cfg(test)]
mod tests;
mod threads;
mod tile;

pub use boundary::{BoundaryConditions, Inflow, Ledgers, SimulatorWeights, Transfer};
pub use checkpoint::DsmcCheckpoint;
pub use decomposition::{Ranks, ShardLocation, from_first, gather_from_all, shard_name};
pub use engine::DsmcEngine;
pub use grid::Grid;
pub use parameters::{DsmcError, Parameters, SimulatorStart};
pub use particle::{DisplacementTracking, Simulator, Tracked, Untracked};
pub use scheme::{
    ContactLaw, DensityWindow, Neighbourhood, PartnerDisplacement, PartnerSelection, Scheme,
    SchemeProperties, SchemeSettings, WallClearance,
};
#[cfg(not(test))]
pub use simulate::{
    BALANCE, CellGas, CheckpointSource, DomainStart, ExpectedGas, check_gas, resume,
    resume_distributed, serve_domain, simulate, simulate_distributed, simulate_stream,
};
pub use start::EngineSetup;
pub use start_stream::StartStream;
pub use tally::{CellCount, CollisionCounters};

/// Monte Carlo of gases without positions, from its own crate.
pub use stosszahl_homogeneous as homogeneous;

/// Version of the statistics of the DSMC engine in cells. It increases with each change that moves
/// means beyond their errors (*Results changed* in the changelog), not with changes of rounding.
/// Costly results in the documentation are refused once it has moved.
pub const STATISTICS_VERSION: u32 = 2;

/// Version of the statistics of `contact-point` gases with the density taken halfway to contact:
/// twelve or more simulators per disk in periodic boxes. It changes independently of
/// [`STATISTICS_VERSION`].
pub const HALFWAY_STATISTICS_VERSION: u32 = 1;
