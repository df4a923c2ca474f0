//! From a case to its results, for every kind of case alike.
//!
//! [`plan`] works out what follows from a case, once. [`start`] makes the initial state of a replica, [`engines`] the engines
//! that run from it, [`follow`] takes each through the moments at which something is due ([`schedule`]). [`run`] does that for
//! all points, replicas and engines, and writes a results folder; [`run_joined`] does it together with other processes that share the
//! folder, and [`run_part`] does a part of it, which [`merge_parts`] puts together; [`decomposed`] does
//! it with each gas in cells held by several processes. What is measured are [`measure`] and its implementors in
//! [`measures`]: each one file that says what it observes, samples, saves and which tables and verdicts it yields.

mod accuracy;
pub mod check;
mod collision_rate;
pub mod control;
pub mod decomposed;
pub mod engines;
pub mod follow;
pub mod frontier;
mod gauge;
mod join;
mod journal;
pub mod judge;
mod kicks;
pub mod measure;
pub mod measures;
pub mod pace;
mod parts;
mod places;
pub mod plan;
mod point;
pub mod power;
mod question;
mod replica_task;
pub mod run;
pub mod schedule;
pub mod start;
pub mod theory;
mod unsaved;
mod words;

pub use accuracy::settle;
pub use check::{Planned, check, format};
pub use control::Progress;
pub use gauge::Gauge;
pub use join::run_joined;
pub use measure::{Measure, Moment, Probe, Runs};
pub use parts::{PartSummary, RunPart, merge_parts, read_part, run_part};
pub use plan::Plan;
pub use run::{Options, PointSummary, RunError, Summary, run_case};

#[cfg(test)]
mod flow_tests;
#[cfg(test)]
mod tests;
