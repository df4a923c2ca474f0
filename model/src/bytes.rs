//! Serialization of values into bytes, in the `postcard` format.

use serde::Serialize;

/// Serializes a value of numbers, texts and lists, such as a message to another process.
///
/// # Panics
/// If the type has a list whose length is unknown before it is serialized: an error of the program.
pub fn to_bytes<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("a type whose lists have a length")
}
