//! Kinetic theory of a case, for tables and verdicts.

pub mod flow;
pub mod homogeneous;
