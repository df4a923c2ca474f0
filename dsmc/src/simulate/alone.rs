//! Where a gas is held by one process alone: the feature `processes` is off.

use std::sync::Arc;

use stosszahl_model::sum::Make;
use stosszahl_model::{Interrupt, Particles, Simulation};

use super::{Gas, Left};
use crate::parameters::EngineError;
use crate::share::Ranks;

/// There are none.
pub(super) enum Others {}

impl Others {
    pub(super) fn advance(&self, _: f64, _: u64, _: bool) {
        match *self {}
    }
}

/// [`super::simulate`] of a gas that several processes hold, with the feature `processes`.
///
/// # Errors
/// [`EngineError::OneProcess`].
pub fn simulate_among(
    _: &Gas<'_>,
    _: &[Particles],
    _: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    Err(EngineError::OneProcess)
}

/// [`super::resume`] of a gas that several processes hold, with the feature `processes`.
///
/// # Errors
/// [`EngineError::OneProcess`].
pub fn resume_among(
    _: &Gas<'_>,
    _: Left<'_>,
    _: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    Err(EngineError::OneProcess)
}

/// Holds a part of a gas that another process drives, with the feature `processes`.
///
/// # Errors
/// [`EngineError::OneProcess`].
pub fn serve(
    _: &Gas<'_>,
    _: usize,
    _: [f64; 3],
    _: &Arc<dyn Ranks>,
    _: &Interrupt,
    _: Make,
) -> Result<(), EngineError> {
    Err(EngineError::OneProcess)
}
