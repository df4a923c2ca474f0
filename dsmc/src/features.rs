//! Compile-time features of the DSMC crate as constants.

/// True if the crate is compiled with domain decomposition among processes; otherwise that code is
/// left out of every engine.
pub(crate) const PROCESSES: bool = cfg!(feature = "processes");
