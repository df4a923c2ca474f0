//! Tests of case files: valid ones and refusals.

mod nature;
mod refusals;
