//! Compile-time features of the crate.

/// True if the crate supports domain decomposition. Otherwise its code is not compiled for each
/// engine.
pub(crate) const PROCESSES: bool = cfg!(feature = "processes");
