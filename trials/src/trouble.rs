//! What keeps a trial from being tried, and a command from succeeding.

use std::error::Error;
use std::fmt;

use stosszahl_dsmc::homogeneous::GasError;
use stosszahl_model::{Invalid, initial::PlacementError};

/// Why something could not be tried, or a command does not succeed: any error, or a text.
#[derive(Debug)]
pub struct Trouble {
    source: Box<dyn Error + Send + Sync>,
    refused: bool,
}

impl Trouble {
    /// The input was refused: what was found, and what is allowed.
    pub fn refused(text: impl Into<String>) -> Self {
        let (source, refused) = (text.into().into(), true);
        Self { source, refused }
    }

    /// Something does not hold, or could not be done.
    pub fn failed(text: impl Into<String>) -> Self {
        let (source, refused) = (text.into().into(), false);
        Self { source, refused }
    }

    /// The error, if it is of this type.
    pub fn downcast_ref<E: Error + 'static>(&self) -> Option<&E> {
        self.source.downcast_ref()
    }

    /// 2: the input was refused; 1: something failed.
    pub(crate) fn exit_code(&self) -> u8 {
        if self.refused { 2 } else { 1 }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.source.fmt(out)
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for Trouble {
    fn from(error: E) -> Self {
        let source: Box<dyn Error + Send + Sync> = error.into();
        let refused =
            source.is::<Invalid>() || source.is::<PlacementError>() || source.is::<GasError>();
        Self { source, refused }
    }
}
