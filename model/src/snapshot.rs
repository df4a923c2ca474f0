//! Snapshot files: everything needed to continue a run to the same bytes, with checksum and
//! fingerprint of the run.
//!
//! Layout, little-endian: 8 bytes magic, format (u32), payload length (u64), fingerprint of the run
//! (32 bytes), BLAKE3 hash of the payload (32 bytes), payload (postcard: f64 as their 8 bytes). A
//! file appears under its name only when it is complete, so a kill leaves either the old or the new
//! one.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use atomic_write_file::AtomicWriteFile;
use serde::Serialize;
use serde::de::DeserializeOwned;

const MAGIC: &[u8; 8] = b"STOSSZHL";
const FORMAT: u32 = 3;
const EXPECTED: &str = "format 3";
const HEADER: usize = 8 + 4 + 8 + 32 + 32;
/// Size of the buffer for writing a snapshot file \[bytes\].
const BUFFER: usize = 1 << 16;

/// Fingerprint of a run: a hash of the case and of all other inputs that decide its numbers.
pub type Fingerprint = [u8; 32];

/// BLAKE3 hash of the payload of a snapshot.
pub type Checksum = [u8; 32];

/// Error why a snapshot file could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The snapshot file could not be written or read.
    #[error("{}: {source}", path.display())]
    File {
        /// Path of the snapshot file that could not be written or read.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file is not a snapshot, damaged, or of another format version.
    #[error("{}: not a usable snapshot: {found}; expected {expected}; without this file its part of the run begins anew", path.display())]
    Damaged {
        /// Path of the file that is no valid snapshot.
        path: PathBuf,
        /// Content found in the file.
        found: String,
        /// Content that a snapshot file should have.
        expected: &'static str,
    },
    /// The snapshot belongs to another case, point of a sweep, seed or program version.
    #[error("{}: the snapshot belongs to another run (case, point, seed or version differ)", path.display())]
    Foreign {
        /// Path of the snapshot that belongs to another run.
        path: PathBuf,
    },
    /// The snapshot belongs to this run, but to another replica or engine in it.
    #[error("{}: holds {found}; expected {expected}; without this file its part of the run begins anew", path.display())]
    Misplaced {
        /// Path of the snapshot that belongs to another replica or engine.
        path: PathBuf,
        /// Replica, engine, point and seed that the file was written for.
        found: String,
        /// Replica, engine, point and seed that the file name stands for.
        expected: String,
    },
}

impl SnapshotError {
    /// Creates the error for a failure of the operating system with a file.
    pub fn of_file(path: &Path, source: io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }
}

/// Writes a file with the content `bytes`, which appears under its name only when it is complete.
///
/// # Errors
/// [`SnapshotError::File`] if a step of it fails.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), SnapshotError> {
    when_complete(path, |file| {
        file.write_all(bytes)
            .map_err(|source| SnapshotError::of_file(path, source))
    })
}

/// Writes a file by `write` so that it appears under its name only when it is complete. The folder
/// is opened once, at the beginning, so that the file ends where it was begun, also if the folder
/// is moved meanwhile.
fn when_complete<T>(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<T, SnapshotError>,
) -> Result<T, SnapshotError> {
    let failed = |source| SnapshotError::of_file(path, source);
    let mut file = AtomicWriteFile::open(path).map_err(failed)?;
    let written = write(file.as_file_mut())?;
    file.commit().map_err(failed)?;
    Ok(written)
}

/// Writer that counts and hashes the bytes written to a file, so that none need be kept in memory.
struct Hashed<'a> {
    file: &'a mut File,
    hash: blake3::Hasher,
    length: u64,
    /// Error of the operating system in writing, which serialisers do not pass on; `None` if there
    /// was none.
    failure: Option<io::Error>,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.file.write(bytes) {
            Ok(written) => {
                self.hash.update(&bytes[..written]);
                self.length += written as u64;
                Ok(written)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(error),
            Err(error) => {
                let kind = error.kind();
                self.failure = Some(error);
                Err(kind.into())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes a snapshot file with `content`, piece by piece: it needs no memory besides the content.
/// Returns its checksum.
///
/// # Errors
/// [`SnapshotError::File`] if the file can't be written.
pub fn write_snapshot<T: Serialize>(
    path: &Path,
    run: &Fingerprint,
    content: &T,
) -> Result<Checksum, SnapshotError> {
    when_complete(path, |file| write_content(path, file, run, content))
}

/// Writes header and payload of a snapshot into an open file, which will become `path`; returns the
/// checksum of the payload.
fn write_content<T: Serialize>(
    path: &Path,
    file: &mut File,
    run: &Fingerprint,
    content: &T,
) -> Result<Checksum, SnapshotError> {
    let failed = |source| SnapshotError::of_file(path, source);
    // Space for the header, whose content is known at the end.
    file.write_all(&[0; HEADER]).map_err(failed)?;
    let mut payload = BufWriter::with_capacity(
        BUFFER,
        Hashed {
            file,
            hash: blake3::Hasher::new(),
            length: 0,
            failure: None,
        },
    );
    let serialised = postcard::to_io(content, &mut payload).map(drop);
    let (payload, _) = payload.into_parts();
    if let Some(source) = payload.failure {
        return Err(failed(source));
    }
    serialised.map_err(|error| SnapshotError::Damaged {
        path: path.to_owned(),
        found: error.to_string(),
        expected: "serialisable content",
    })?;
    let checksum = *payload.hash.finalize().as_bytes();
    let mut header = Vec::with_capacity(HEADER);
    header.extend_from_slice(MAGIC);
    header.extend_from_slice(&FORMAT.to_le_bytes());
    header.extend_from_slice(&payload.length.to_le_bytes());
    header.extend_from_slice(run);
    header.extend_from_slice(&checksum);
    let file = payload.file;
    file.rewind().map_err(failed)?;
    file.write_all(&header).map_err(failed)?;
    Ok(checksum)
}

/// Reads the content of a snapshot file of the given run.
///
/// # Errors
/// [`SnapshotError`] if the file is absent, damaged, or belongs to another run.
pub fn read_snapshot<T: DeserializeOwned>(
    path: &Path,
    run: &Fingerprint,
) -> Result<T, SnapshotError> {
    Ok(read_checked(path, run)?.0)
}

/// Reads the content of a snapshot file, as [`read_snapshot`] does, and also returns the checksum
/// of its payload.
///
/// # Errors
/// As [`read_snapshot`].
pub fn read_checked<T: DeserializeOwned>(
    path: &Path,
    run: &Fingerprint,
) -> Result<(T, Checksum), SnapshotError> {
    let failed = |source| SnapshotError::of_file(path, source);
    let damaged = |found: String, expected| SnapshotError::Damaged {
        path: path.to_owned(),
        found,
        expected,
    };
    // Regular files only: a pipe would block, and a device may never end.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        let found = "a folder, a pipe or a device".into();
        return Err(damaged(found, "a file"));
    }
    let mut bytes = Vec::new();
    let mut file = File::open(path).map_err(failed)?;
    file.read_to_end(&mut bytes).map_err(failed)?;
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
        return Err(damaged(format!("format {format}"), EXPECTED));
    }
    let length = word(12..20);
    let payload = &bytes[HEADER..];
    if payload.len() as u64 != length {
        return Err(damaged(
            format!("{} bytes of {length}", payload.len()),
            "the whole payload",
        ));
    }
    let checksum = *blake3::hash(payload).as_bytes();
    if checksum != bytes[52..HEADER] {
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
    let content = postcard::from_bytes(payload)
        .map_err(|error| damaged(error.to_string(), "content of this version"))?;
    Ok((content, checksum))
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
        write_snapshot(&path, &run, &content).expect("written");
        let back: Vec<f64> = read_snapshot(&path, &run).expect("read");
        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&content));
        assert!(matches!(
            read_snapshot::<Vec<f64>>(&path, &[8; 32]),
            Err(SnapshotError::Foreign { .. })
        ));
        let whole = fs::read(&path).expect("bytes");
        for length in 0..whole.len() {
            fs::write(&path, &whole[..length]).expect("shortened");
            assert!(matches!(
                read_snapshot::<Vec<f64>>(&path, &run),
                Err(SnapshotError::Damaged { .. })
            ));
        }
        let mut other = whole.clone();
        other[8] ^= 1;
        fs::write(&path, &other).expect("of another format");
        let said = read_snapshot::<Vec<f64>>(&path, &run).map_err(|error| error.to_string());
        let expected = format!("format {}; expected format {FORMAT}", FORMAT ^ 1);
        assert!(
            said.as_ref().is_err_and(|said| said.contains(&expected)),
            "{said:?}"
        );
        for position in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[position] ^= 16;
            fs::write(&path, &bytes).expect("damaged");
            assert!(
                read_snapshot::<Vec<f64>>(&path, &run).is_err(),
                "byte {position}"
            );
        }
        fs::remove_dir_all(&folder).expect("removed");
    }

    /// The layout of the opening lines, made in the obvious way.
    #[test]
    fn a_snapshot_is_its_header_and_its_payload() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.snapshot");
        // Content longer than the write buffer.
        let content: Vec<u64> = (0..3 * BUFFER as u64).collect();
        write_snapshot(&path, &[7; 32], &content).expect("written");
        let payload = postcard::to_stdvec(&content).expect("bytes");
        let mut whole = MAGIC.to_vec();
        whole.extend(FORMAT.to_le_bytes());
        whole.extend((payload.len() as u64).to_le_bytes());
        whole.extend([7; 32]);
        whole.extend(blake3::hash(&payload).as_bytes());
        whole.extend(&payload);
        assert!(fs::read(&path).expect("bytes") == whole);
    }

    /// A full disk is named as such, and the old file stays.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.snapshot");
        write_snapshot(&path, &[7; 32], &1_u64).expect("written");
        let mut full = File::options()
            .write(true)
            .open("/dev/full")
            .expect("a device");
        let long = vec![1_u64; 3 * BUFFER];
        let failed = when_complete(&path, |_| write_content(&path, &mut full, &[7; 32], &long));
        let said = failed.expect_err("a full disk").to_string();
        assert!(said.contains("No space left"), "{said}");
        assert_eq!(read_snapshot::<u64>(&path, &[7; 32]).expect("read"), 1);
    }

    /// Devices and pipes are refused without blocking, `/dev/null` in place of all, because it
    /// ends.
    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.snapshot");
        std::os::unix::fs::symlink("/dev/null", &path).expect("a link");
        let said = read_snapshot::<u64>(&path, &[7; 32]).expect_err("no file");
        assert!(said.to_string().contains("expected a file"), "{said}");
    }

    /// A snapshot that is being written when its folder is moved ends in the moved folder, not in
    /// the one that took its name.
    #[cfg(unix)]
    #[test]
    fn a_snapshot_stays_in_a_folder_that_is_moved() {
        let folder = tempfile::tempdir().expect("a folder");
        let [here, moved] = ["here", "moved"].map(|name| folder.path().join(name));
        fs::create_dir(&here).expect("a folder");
        when_complete(&here.join("a"), |file| {
            fs::rename(&here, &moved).expect("moved");
            fs::create_dir(&here).expect("a folder");
            file.write_all(b"first").expect("written");
            Ok(())
        })
        .expect("written");
        assert_eq!(fs::read(moved.join("a")).expect("bytes"), b"first");
        assert!(!here.join("a").exists());
    }

    /// A link in place of the file is replaced, and its target is unchanged.
    #[cfg(unix)]
    #[test]
    fn a_link_in_the_way_is_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let [path, other] = ["a.snapshot", "other"].map(|name| folder.path().join(name));
        fs::write(&other, "of another program").expect("written");
        std::os::unix::fs::symlink(&other, &path).expect("a link");
        write_snapshot(&path, &[7; 32], &1_u64).expect("written");
        assert_eq!(fs::read(&other).expect("bytes"), b"of another program");
        assert!(!path.is_symlink());
        assert_eq!(read_snapshot::<u64>(&path, &[7; 32]).expect("read"), 1);
    }
}
