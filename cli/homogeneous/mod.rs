//! Cases of gases without positions: from a case file to tables and a report.
//!
//! What is simulated is `stosszahl_dsmc::homogeneous`, what it is compared with is `stosszahl_analysis::theory`. Here stand
//! the case file ([`case`]), what follows from it ([`plan`]), the run ([`run`]), its tables ([`tables`]), the comparison with
//! theory and the page.

pub mod case;
mod checks;
pub mod export;
mod law;
pub mod manifest;
mod outline;
pub mod plan;
pub mod record;
pub mod report;
pub mod run;
mod steady;
pub mod tables;
mod theory;
mod validate;
mod written;

pub(crate) use checks::verdicts;
pub(crate) use outline::{outline, warnings};
