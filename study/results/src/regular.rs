//! Reading of regular files only. Results are read and hashed several times; a pipe would block,
//! and a device might never end.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// Opens a file for reading; an error unless it is a regular file.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    if fs::metadata(path)?.is_file() {
        File::open(path)
    } else {
        let found = "found a folder, a pipe or a device; expected a file";
        Err(io::Error::new(io::ErrorKind::InvalidInput, found))
    }
}

/// Reads all bytes of a regular file.
pub(crate) fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}
