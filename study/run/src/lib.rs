//! Runs of cases: from a case file to a results folder, for every kind of gas and engine.
//!
//! * [`plan`] derives all quantities of a case, once.
//! * [`start`] makes the initial state of a replica, [`engines`] the engines that run from it.
//! * [`cost`] estimates memory and time, [`check`] checks a case and summarises it.
//! * [`engine_run`] runs one engine of one replica through its scheduled times.
//! * [`run`] does that for all points, replicas and engines, and writes a results folder, in one
//!   process or in several.
//! * [`frontier`] measures the error and the cost of settings around a case.
//! * [`judge`] compares engines with each other and with theory.
//! * [`measure`] defines measurements; [`measures`] has one file for each, with its observables,
//!   samples, records, tables and verdicts.

pub mod check;
pub mod control;
pub mod cost;
pub mod engine_run;
pub mod engines;
pub mod frontier;
mod journal;
pub mod judge;
pub mod measure;
pub mod measures;
pub mod plan;
pub mod run;
pub mod start;
pub mod theory;

pub use check::{Planned, check_case, format};
pub use measure::{Measure, Probe, ReplicaRecords, SampleContext};
pub use plan::CasePlan;
pub use run::{
    PartSummary, PointSummary, Progress, ProgressEstimate, RunError, RunOptions, RunPart,
    RunSummary, choose_resolutions, merge_parts, read_part, run_case, run_joined, run_part,
};

#[cfg(test)]
mod bath_tests;
#[cfg(test)]
mod combination_tests;
#[cfg(test)]
mod flow_tests;
#[cfg(test)]
mod tests;
