//! Kinetic theory of a case for tables and verdicts: homogeneous gases and flows.

pub mod flow;
pub mod homogeneous;
