//! Files of a results folder are read and hashed more than once: a pipe would be waited for, and a device read without end.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// Opens a file that is one.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    if fs::metadata(path)?.is_file() {
        File::open(path)
    } else {
        let found = "found a folder, a pipe or a device; expected a file";
        Err(io::Error::new(io::ErrorKind::InvalidInput, found))
    }
}

/// All of such a file.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}
