//! Serialization of values into messages between processes, in the `postcard` format.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Serializes a value for a message to another process.
pub(crate) fn to_bytes<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("all types here have a length")
}

/// Deserializes a value that another process sent.
///
/// # Panics
/// If the bytes come from another program: an error of the transport between processes.
pub(crate) fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> T {
    postcard::from_bytes(bytes).expect("the bytes of the same program")
}
