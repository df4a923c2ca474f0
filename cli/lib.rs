//! Facade and command line of stosszahl.
//!
//! The physics lives in the crates that are re-exported here: [`model`] (what both engines share), [`ed`] (exact
//! event-driven disks), [`dsmc`] (Monte Carlo collisions) and [`analysis`] (measurements and verdicts). This crate
//! turns a case file into a run of them and a run into tables and a report: [`case`] reads, [`setup`] derives,
//! [`dispatch`] chooses the types, [`run`] runs, [`export`] tabulates, [`verdicts`] says it in words, [`report`]
//! draws it.

pub use stosszahl_analysis as analysis;
pub use stosszahl_dsmc as dsmc;
pub use stosszahl_ed as ed;
pub use stosszahl_model as model;

pub mod arguments;
pub mod bench;
pub mod bench_mixture;
pub mod case;
pub mod commands;
pub mod dispatch;
mod displacement;
mod driven;
pub mod export;
pub mod flow;
pub mod homogeneous;
pub mod manifest;
pub mod progress;
pub mod report;
pub mod results;
pub mod run;
pub mod setup;
pub mod stress;
pub mod tables;
pub mod validate;
pub mod verdicts;
