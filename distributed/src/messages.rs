//! What the processes of a run say to each other.

use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// From the root to the others.
#[derive(Debug, Serialize, Deserialize)]
pub enum ToOther {
    /// The case, which only the root has read.
    Case {
        /// Version and commit of the program, which must be one.
        program: String,
        /// The case file.
        path: PathBuf,
        /// Its text.
        text: String,
        /// What is set from outside.
        overrides: Vec<String>,
    },
    /// Something to be done; what it leaves comes back with the same number.
    Order(u64, Vec<u8>),
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
    Record(u64, Vec<u8>),
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
