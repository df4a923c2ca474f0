//! Features that the crate was compiled with.

/// True if several processes may hold one gas. Without it their code is not compiled for each engine.
pub(crate) const PROCESSES: bool = cfg!(feature = "processes");
