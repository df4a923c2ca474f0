//! Boundaries of a DSMC box: walls, open faces, inflows, obstacles, cut cells and simulator
//! weights.
//!
//! A box is periodic by default. [`BoundaryConditions`] describes walls and open faces, the
//! distance at which they stop particles, inflows, regions of other simulator weight, and
//! obstacles.

mod boundaries;
mod convex;
mod cut_cells;
mod inflow;
mod ledgers;
mod obstacles;
mod passage;
mod sight;
mod surroundings;
mod travel;
mod weights;

pub use boundaries::BoundaryConditions;
pub use inflow::Inflow;
pub(crate) use ledgers::ExactLedgers;
pub use ledgers::{Ledgers, Transfer};
pub use weights::SimulatorWeights;

pub(crate) use cut_cells::CutCell;
pub(crate) use inflow::MOST_SIMULATORS;
pub(crate) use passage::{FlightTiming, Origin, Passage, enter};
pub(crate) use surroundings::GridBoundaries;
