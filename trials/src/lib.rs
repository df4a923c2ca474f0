//! Tests of the engines: hard cases ([`stress`]), claims about accuracy ([`validate`]) and speed
//! (`bench`). Also the test of the false-alarm rate of verdicts ([`calibrate`]), and the command
//! that generates results in the documentation ([`docs`]).
//!
//! Trials use the public interface of the engines, as any other program would, and are no part of a
//! user's program. A [`TrialRow`] is a row in a table of trials: its name, what is tried, what must
//! hold, and a function that tests it. All trials run in one loop, [`TrialRow::run_trial`]. Their
//! results are text, faults and [rows](table::TrialTableRow) of claims. Gases are created in the
//! module [`gas`].

#[macro_use]
mod trial;
pub mod arguments;
mod bench;
pub mod calibrate;
pub mod docs;
mod findings;
pub mod gas;
pub mod stress;
pub mod table;
mod terminal;
mod trouble;
pub mod validate;

pub use findings::TrialLog;
pub use trial::{Effort, TrialReport, TrialRow};
pub use trouble::TrialError;

/// Result of a trial or a command; an error if it could not be run or failed.
pub type Done = Result<(), TrialError>;
