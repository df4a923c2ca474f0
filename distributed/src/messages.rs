//! What the processes of a run say to each other.

use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl::arguments::{CaseArguments, VERSION};
use stosszahl::case::CaseFile;
use stosszahl::study;

/// The case, which only the root has read.
#[derive(Debug, Serialize, Deserialize)]
pub struct Case {
    /// Version and commit of the program, which must be one.
    program: String,
    path: PathBuf,
    text: String,
    /// What is set from outside.
    overrides: Vec<String>,
}

impl Case {
    /// As the root has read it.
    pub fn of(file: &CaseFile, arguments: &CaseArguments) -> Self {
        Self {
            program: VERSION.to_owned(),
            path: file.path.clone(),
            text: file.text.clone(),
            overrides: arguments.overrides(),
        }
    }

    /// The case in this process, or why it cannot be read here.
    pub fn read(&self) -> Result<CaseFile, String> {
        if self.program != VERSION {
            let found = &self.program;
            return Err(format!(
                "this process runs stosszahl {VERSION}, and rank 0 runs {found}"
            ));
        }
        let read = study::format().from_text(&self.path, &self.text, &self.overrides);
        read.map_err(|error| error.to_string())
    }
}

/// From the root to the others.
#[derive(Debug, Serialize, Deserialize)]
pub enum ToOther {
    /// The case.
    Case(Case),
    /// Something to be done; what it leaves comes back with the same number.
    Order(u64, #[serde(with = "serde_bytes")] Vec<u8>),
    /// The end, and whether MPI is to be closed by all together: not if a process was lost.
    End {
        /// Whether all are there.
        together: bool,
    },
}

/// From the others to the root.
#[derive(Debug, Serialize, Deserialize)]
pub enum ToRoot {
    /// The case is planned; this many orders can be done at once.
    Ready(usize),
    /// The case cannot be run here.
    Failed(String),
    /// What an order left.
    Record(u64, #[serde(with = "serde_bytes")] Vec<u8>),
    /// This process was asked to stop; what it was given and has not sent back is for others.
    Leaves,
    /// Collisions since the last time.
    Progress(u64),
}

/// A message as bytes.
pub fn write<T: Serialize>(message: &T) -> Vec<u8> {
    // Fails only for types without a length, of which there is none here.
    postcard::to_stdvec(message).unwrap_or_default()
}

/// A message from bytes; none if it is of another version of the program.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}
