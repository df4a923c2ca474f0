//! Runs of cases: from a case file to a results folder, for every kind of gas and engine.
//!
//! * [`plan`] derives all quantities of a case, once.
//! * [`start`] makes the initial state of a replica, [`engines`] the engines that run from it.
//! * [`follow`] runs each engine through its scheduled times ([`schedule`]).
//! * [`run`] does that for all points, replicas and engines, and writes a results folder.
//! * [`run_joined`] shares a results folder with other processes.
//! * [`run_part`] does a part of a run, and [`merge_parts`] merges the parts.
//! * [`decomposed`] runs a case with each gas in cells held by several processes.
//! * [`measure`] defines measurements; [`measures`] has one file for each, with its observables,
//!   samples, records, tables and verdicts.

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
mod rank_group;
mod replica_task;
pub mod run;
pub mod schedule;
pub mod start;
pub mod theory;
mod unsaved;

pub use accuracy::choose_resolution;
pub use check::{Planned, check_case, format};
pub use control::Progress;
pub use gauge::ProgressEstimate;
pub use join::run_joined;
pub use measure::{Measure, Probe, ReplicaRecords, SampleContext};
pub use parts::{PartSummary, RunPart, merge_parts, read_part, run_part};
pub use plan::CasePlan;
pub use run::{PointSummary, RunError, RunOptions, RunSummary, run_case};

#[cfg(test)]
mod bath_tests;
#[cfg(test)]
mod combination_tests;
#[cfg(test)]
mod flow_tests;
#[cfg(test)]
mod tests;
