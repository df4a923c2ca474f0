//! Error type of trials that cannot be run, and of commands that fail.

use std::error::Error;
use std::fmt;

use stosszahl_dsmc::homogeneous::HomogeneousError;
use stosszahl_model::{InvalidValue, initial::PlacementError};

/// Error of a trial or a command: another error, or a text.
#[derive(Debug)]
pub struct TrialError {
    source: Box<dyn Error + Send + Sync>,
    refused: bool,
}

impl TrialError {
    /// Creates the error of invalid input. The text states the value found and the values allowed.
    pub fn refused(text: impl Into<String>) -> Self {
        let (source, refused) = (text.into().into(), true);
        Self { source, refused }
    }

    /// Creates the error of a condition that does not hold, or of failed work.
    pub fn failed(text: impl Into<String>) -> Self {
        let (source, refused) = (text.into().into(), false);
        Self { source, refused }
    }

    /// Returns the underlying error if it has the type E.
    pub fn downcast_ref<E: Error + 'static>(&self) -> Option<&E> {
        self.source.downcast_ref()
    }

    /// Returns the exit code of the program: 2 for invalid input, 1 for a failure.
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
