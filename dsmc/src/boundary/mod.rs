//! What stands at the faces of the box and inside it, and what comes in through them.
//!
//! A box is periodic by default. [`Boundaries`] is all that can be said of it: walls and open faces, how near a
//! particle comes to them, streams that flow in, regions in which a simulator stands for more or fewer particles, and
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

pub use boundaries::{Boundaries, Clearance};
pub use inflow::Inflow;
pub(crate) use ledgers::ExactLedgers;
pub use ledgers::{Ledgers, Transfer};
pub use weights::Weights;

pub(crate) use cut_cells::CutCell;
pub(crate) use inflow::MOST_SIMULATORS;
pub(crate) use passage::{FlightTiming, Origin, Passage, enter};
pub(crate) use surroundings::Surroundings;
