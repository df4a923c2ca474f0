//! Serialization of values into messages between processes, in the `postcard` format.

use serde::de::DeserializeOwned;

pub(crate) use stosszahl_model::to_bytes;

/// Deserializes a value that another process sent.
///
/// # Panics
/// If the bytes come from another program: an error of the transport between processes.
pub(crate) fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> T {
    postcard::from_bytes(bytes).expect("the bytes of the same program")
}
