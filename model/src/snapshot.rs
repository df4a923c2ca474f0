//! Exact snapshots: everything needed to continue a run to the same bytes.
//!
//! Layout, little-endian: 8 bytes magic, format (u32), payload length (u64), fingerprint of the run
//! (32 bytes), BLAKE3 hash of the payload (32 bytes), payload (postcard: f64 as their 8 bytes). A file
//! appears under its name only when it is complete, so a kill leaves either the old or the new one.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

const MAGIC: &[u8; 8] = b"STOSSZHL";
const FORMAT: u32 = 2;
const HEADER: usize = 8 + 4 + 8 + 32 + 32;

/// Identifies the run that a snapshot belongs to: a hash of the case and whatever else decides its
/// numbers.
pub type Fingerprint = [u8; 32];

/// Why a snapshot could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The file could not be written or read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Not a snapshot, damaged, or of another format.
    #[error("{}: not a usable snapshot: {found}; expected {expected}; without this file its part of the run begins anew", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What was found.
        found: String,
        /// What belongs there.
        expected: &'static str,
    },
    /// A snapshot of another case, seed or version.
    #[error("{}: the snapshot belongs to another run (case, seed or version differ)", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
}

/// Writes `bytes` so that the file appears under its name only when it is complete.
///
/// # Errors
/// [`SnapshotError::File`] if a step of it fails.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), SnapshotError> {
    let failed = |source| SnapshotError::File {
        path: path.to_owned(),
        source,
    };
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    let write = || -> io::Result<()> {
        let mut file = File::create(&partial)?;
        file.write_all(bytes)?;
        file.sync_data()?;
        fs::rename(&partial, path)
    };
    write().map_err(failed)
}

/// Writes a snapshot of `content`.
///
/// # Errors
/// [`SnapshotError::File`] if the file can't be written.
pub fn write<T: Serialize>(
    path: &Path,
    run: &Fingerprint,
    content: &T,
) -> Result<(), SnapshotError> {
    let damaged = |error: postcard::Error| SnapshotError::Damaged {
        path: path.to_owned(),
        found: error.to_string(),
        expected: "serialisable content",
    };
    let payload = postcard::to_stdvec(content).map_err(damaged)?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&FORMAT.to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    bytes.extend_from_slice(run);
    bytes.extend_from_slice(blake3::hash(&payload).as_bytes());
    bytes.extend_from_slice(&payload);
    write_whole(path, &bytes)
}

/// Reads the snapshot of the given run.
///
/// # Errors
/// [`SnapshotError`] if the file is absent, damaged, or belongs to another run.
pub fn read<T: DeserializeOwned>(path: &Path, run: &Fingerprint) -> Result<T, SnapshotError> {
    let bytes = fs::read(path).map_err(|source| SnapshotError::File {
        path: path.to_owned(),
        source,
    })?;
    let damaged = |found: String, expected| SnapshotError::Damaged {
        path: path.to_owned(),
        found,
        expected,
    };
    if bytes.len() < HEADER || &bytes[..8] != MAGIC {
        return Err(damaged(
            format!("{} bytes without its mark", bytes.len()),
            "a stosszahl snapshot",
        ));
    }
    let word = |range: std::ops::Range<usize>| {
        bytes[range]
            .iter()
            .rev()
            .fold(0, |word, &byte| word << 8 | u64::from(byte))
    };
    let format = word(8..12);
    if format != u64::from(FORMAT) {
        return Err(damaged(format!("format {format}"), "format 1"));
    }
    let length = word(12..20);
    let payload = &bytes[HEADER..];
    if payload.len() as u64 != length {
        return Err(damaged(
            format!("{} bytes of {length}", payload.len()),
            "the whole payload",
        ));
    }
    if blake3::hash(payload).as_bytes() != &bytes[52..HEADER] {
        return Err(damaged(
            "a payload with another hash".into(),
            "an unchanged payload",
        ));
    }
    if &bytes[20..52] != run {
        return Err(SnapshotError::Foreign {
            path: path.to_owned(),
        });
    }
    postcard::from_bytes(payload)
        .map_err(|error| damaged(error.to_string(), "content of this version"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapshots_return_the_same_bits_and_refuse_damage() {
        let folder =
            std::env::temp_dir().join(format!("stosszahl-snapshot-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("a.snapshot");
        let content = vec![0.1, -0.0, 5e-324, f64::MAX, std::f64::consts::PI];
        let run = [7; 32];
        write(&path, &run, &content).expect("written");
        let back: Vec<f64> = read(&path, &run).expect("read");
        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&content));
        assert!(matches!(
            read::<Vec<f64>>(&path, &[8; 32]),
            Err(SnapshotError::Foreign { .. })
        ));
        let whole = fs::read(&path).expect("bytes");
        for length in 0..whole.len() {
            fs::write(&path, &whole[..length]).expect("shortened");
            assert!(matches!(
                read::<Vec<f64>>(&path, &run),
                Err(SnapshotError::Damaged { .. })
            ));
        }
        for position in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[position] ^= 16;
            fs::write(&path, &bytes).expect("damaged");
            assert!(read::<Vec<f64>>(&path, &run).is_err(), "byte {position}");
        }
        fs::remove_dir_all(&folder).expect("removed");
    }
}
