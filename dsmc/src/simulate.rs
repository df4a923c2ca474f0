//! DSMC gases in cells behind the common interface [`stosszahl_model::Simulation`], with engine
//! types chosen at run time.

mod among;
mod begin;
mod cells;
mod field;
mod others;
mod refusals;
mod tiles;

pub use among::{DomainStart, resume_distributed, serve_domain, simulate_distributed};
pub use begin::{CellGas, CheckpointSource, resume, simulate, simulate_stream};
pub use cells::BALANCE;
pub use refusals::{ExpectedGas, check_gas};
