//! Runs of cases into results folders.
//!
//! | module | owns |
//! |---|---|
//! | `options`, `error`, `summary` | what a run is given, and what it returns |
//! | `progress` | messages of a run, and the share of its work that is done |
//! | `replica_task` | one replica with all its engines: the unit of work |
//! | `point` | tables, verdicts and manifest of one point |
//! | `case_run` | all points of a case |
//! | `parts` | a part of a run in a folder of its own, and their merge |
//! | `join` | several processes that share the replicas of one folder |
//! | `decomposed` | several processes that hold one gas together |
//! | `measured_time` | computing times, measured in short runs |

mod case_run;
pub mod decomposed;
mod error;
mod join;
pub mod measured_time;
mod options;
mod parts;
mod point;
mod progress;
mod replica_task;
mod summary;

pub use case_run::{choose_resolutions, needed_memory, run_case};
pub use error::RunError;
pub use join::run_joined;
pub use options::RunOptions;
pub use parts::{PartSummary, RunPart, merge_parts, read_part, run_part};
pub use progress::{Progress, ProgressEstimate};
pub use summary::{PointSummary, RunSummary};
