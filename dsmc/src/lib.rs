//! DSMC
mod collide;
mod cross;
mod density;
mod engine;
mod fly;
mod grid;
#[cfg(test)]
mod oracle;
mod parameters;
mod simulator;
mod sweep;
mod tally;
mod tile;

pub use density::{Neighbourhood, Scheme};
pub use engine::{Checkpoint, Engine};
pub use grid::Grid;
pub use parameters::{EngineError, Parameters};
pub use simulator::{Follow, Followed, Simulator, Unfollowed};
pub use tally::Tally;

/// Number of components of a position.
const fn dimension<P: stosszahl_model::Physics>() -> usize {
    <P::Space as stosszahl_model::Space>::DIMENSION
}
