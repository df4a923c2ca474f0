//! Hard cases for the Monte Carlo engine: what `stosszahl stress dsmc` runs.
//!
//! Every case runs all schemes for which it makes sense; the module `gas` lists them, and has the tolerances that several cases share.

mod conserved;
mod cooling;
mod crowds;
mod few;
mod flight;
mod gas;
mod repeated;
mod steps;

use super::{Case, Effort, Findings, Trouble};

/// All cases, in the order in which they are run.
pub fn cases() -> Vec<Case> {
    [
        crowds::CASES,
        few::CASES,
        steps::CASES,
        cooling::CASES,
        flight::CASES,
        repeated::CASES,
        conserved::CASES,
    ]
    .concat()
}

/// The case of a name.
pub fn case(name: &str) -> Option<Case> {
    cases().into_iter().find(|case| case.name == name)
}
