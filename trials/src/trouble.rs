//! Errors of trials that cannot be run, and of commands that fail.

use std::error::Error;
use std::fmt;

use stosszahl_dsmc::homogeneous::HomogeneousError;
use stosszahl_model::{InvalidValue, initial::PlacementError};

/// Reason why a trial could not be run, or a command fails: any error, or a text.
#[derive(Debug)]
pub struct TrialError {
    source: Box<dyn Error + Send + Sync>,
    refused: bool,
}

impl TrialError {
    /// Creates the error of refused input, with the value found and the values allowed.
    pub fn refused(text: impl Into<String>) -> Self {
        let (source, refused) = (text.into().into(), true);
        Self { source, refused }
    }

    /// Creates the error of a condition that does not hold, or of work that could not be done.
    pub fn failed(text: impl Into<String>) -> Self {
        let (source, refused) = (text.into().into(), false);
        Self { source, refused }
    }

    /// Returns the error, if it is of this type.
    pub fn downcast_ref<E: Error + 'static>(&self) -> Option<&E> {
        self.source.downcast_ref()
    }

    /// Exit code of the program: 2 for refused input, 1 for a failure.
    pub(crate) fn exit_code(&self) -> u8 {
        if self.refused { 2 } else { 1 }
    }
}

impl fmt::Display for TrialError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.source.fmt(out)
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for TrialError {
    fn from(error: E) -> Self {
        let source: Box<dyn Error + Send + Sync> = error.into();
        let refused = source.is::<InvalidValue>()
            || source.is::<PlacementError>()
            || source.is::<HomogeneousError>();
        Self { source, refused }
    }
}
