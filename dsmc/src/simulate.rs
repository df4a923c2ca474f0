//! The engine behind the common interface: chosen at run time, for any grains of the model.

mod among;
mod begin;
mod cells;
mod field;
mod others;
mod refusals;
mod tiles;

pub use among::{resume_among, serve, simulate_among};
pub use begin::{Gas, Left, resume, simulate};
pub use cells::BALANCE;
pub use refusals::{ExpectedGas, check};
