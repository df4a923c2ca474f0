//! The case as a message from the root to the other processes.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl::case::CaseFile;
use stosszahl::command_line::{CaseArguments, VERSION};
use stosszahl::study;

/// Case as a message: only the root has read its file.
#[derive(Debug, Serialize, Deserialize)]
pub struct CaseMessage {
    /// Version and commit of the program, which must be equal in all processes.
    program: String,
    path: String,
    text: String,
    /// Overrides from the command line.
    overrides: Vec<String>,
}

impl CaseMessage {
    /// Creates the message of a case that the root has read.
    pub fn from_case(file: &CaseFile, arguments: &CaseArguments) -> Self {
        Self {
            program: VERSION.to_owned(),
            path: file.path.to_string_lossy().into_owned(),
            text: file.text.clone(),
            overrides: arguments.overrides(),
        }
    }

    /// Reads the case in this process, or returns the reason why it cannot be read.
    pub fn read(&self) -> Result<CaseFile, String> {
        if self.program != VERSION {
            let found = &self.program;
            return Err(format!(
                "this process runs stosszahl {VERSION}, and rank 0 runs {found}"
            ));
        }
        let read = study::format().from_text(Path::new(&self.path), &self.text, &self.overrides);
        read.map_err(|error| error.to_string())
    }
}

/// Deserialises a message; `None` if it is of another version of the program.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}
