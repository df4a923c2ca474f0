//! Monte Carlo of homogeneous gases: no positions, no cells, sizes as many as one likes.

mod alias;
mod bird;
mod contact;
mod engine;
mod error;
mod gas;
mod kernel;
mod low_rank;
mod memory;
mod motion;
mod places;
mod selection;
mod slots;
mod tree;

pub use bird::Bird;
pub use contact::{Bounce, Contacts, Meeting, Outcome, Tracers, line_of_centres};
pub use engine::{Checkpoint, Engine, Stop, Tally};
pub use error::GasError;
pub use gas::{Gas, Grains, Particle, TagOf};
pub use kernel::{Contact, Kernel};
pub use low_rank::LowRank;
pub use motion::{Displacement, Motion};
pub use selection::{Candidate, Selection, Standing};
pub use slots::Slots;
