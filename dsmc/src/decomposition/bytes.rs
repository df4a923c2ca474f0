//! Values as bytes of messages between processes.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A value as bytes.
pub(crate) fn write<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("all types here have a length")
}

/// A value from the bytes that another process wrote.
///
/// # Panics
/// If they are of another program, which is an error of whoever connects the processes.
pub(crate) fn read<T: DeserializeOwned>(bytes: &[u8]) -> T {
    postcard::from_bytes(bytes).expect("the bytes of the same program")
}
