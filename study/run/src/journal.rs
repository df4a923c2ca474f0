//! Journal of the finished replicas of a sweep point: one file to which each record is appended, so
//! that thousands of short replicas do not make thousands of files.
//!
//! Layout, little-endian: 8 bytes magic, fingerprint of run and point (32 bytes). Then for each
//! replica: length of its record (u64), its number (u64), the seed (u64), the fingerprint, the
//! BLAKE3 hash of all these and the record (32 bytes), the record. A kill may truncate the last
//! entry; that replica is done again.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use stosszahl_model::snapshot::{Fingerprint, SnapshotError};
use stosszahl_results::CHECKPOINTS;

const MAGIC: &[u8; 8] = b"STOSSZJ2";
const HEADER: usize = 8 + 32;
/// Length of the header before a record \[bytes\].
const FRAME: usize = HASHED + 32;
/// Length of the part of the header that the hash covers \[bytes\].
const HASHED: usize = 8 + 8 + 8 + 32;

/// Identity of the run that a journal belongs to. Each entry repeats it, so that entries of other
/// journals are detected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct JournalOwner {
    /// Fingerprint of the run and its sweep point.
    pub run: Fingerprint,
    /// Seed of the case.
    pub seed: u64,
}

/// Returns the file name of the journal in the folder of a point.
pub(crate) fn name() -> String {
    format!("{CHECKPOINTS}/replicas.journal")
}

/// Returns the file name of the journal of one of several processes, in the folder of a point.
pub(crate) fn name_of(worker: &str) -> String {
    format!("{CHECKPOINTS}/replicas-{worker}.journal")
}

/// Entry of a journal: replica number and the bytes of its record.
pub(crate) type JournalEntry = (u64, Vec<u8>);

/// Journal of the finished replicas of a sweep point, open for appending.
pub(crate) struct Journal {
    path: PathBuf,
    owner: JournalOwner,
    file: Mutex<Open>,
    /// Longest time between two syncs of the journal to disk.
    interval: Duration,
}

struct Open {
    file: File,
    /// Length of the journal up to the end of its last entry \[bytes\].
    end: u64,
    written: Instant,
}

/// Builds the header of a record: length, replica number, seed, fingerprint and hash.
fn record_header(owner: JournalOwner, replica: u64, left: &[u8]) -> [u8; FRAME] {
    let mut frame = [0; FRAME];
    for (place, word) in [left.len() as u64, replica, owner.seed].iter().enumerate() {
        frame[8 * place..8 * place + 8].copy_from_slice(&word.to_le_bytes());
    }
    frame[24..HASHED].copy_from_slice(&owner.run);
    let mut hash = blake3::Hasher::new();
    hash.update(&frame[..HASHED]).update(left);
    frame[HASHED..].copy_from_slice(hash.finalize().as_bytes());
    frame
}

/// Parses the bytes of a journal. Returns its entries and the end of the last whole one, or an
/// error.
fn parse_entries(bytes: &[u8], owner: JournalOwner) -> Result<(Vec<JournalEntry>, usize), Wrong> {
    // A kill may have truncated the header.
    if bytes.len() < HEADER {
        return Ok((Vec::new(), 0));
    }
    if &bytes[..8] != MAGIC {
        return Err(Wrong::Mark);
    }
    if bytes[8..HEADER] != owner.run {
        return Err(Wrong::Run);
    }
    let (all, end) = parse_frames(&bytes[HEADER..], owner)?;
    Ok((all, HEADER + end))
}

/// Parses consecutive journal entries. Returns them and the end of the last whole one, or an error.
fn parse_frames(bytes: &[u8], owner: JournalOwner) -> Result<(Vec<JournalEntry>, usize), Wrong> {
    let (mut all, mut end) = (Vec::new(), 0);
    while let Some((head, rest)) = bytes[end..].split_at_checked(FRAME) {
        let word = |at: usize| u64::from_le_bytes(std::array::from_fn(|byte| head[at + byte]));
        let length = usize::try_from(word(0)).unwrap_or(usize::MAX);
        let Some(left) = rest.get(..length) else {
            break;
        };
        let replica = word(8);
        let found = JournalOwner {
            seed: word(16),
            run: std::array::from_fn(|byte| head[24 + byte]),
        };
        if head != record_header(found, replica, left) {
            return Err(Wrong::Hash(all.len()));
        }
        if found != owner {
            return Err(Wrong::Entry(all.len()));
        }
        all.push((replica, left.to_vec()));
        end += FRAME + length;
    }
    Ok((all, end))
}

/// Error in the content of a journal.
#[derive(Debug, PartialEq)]
enum Wrong {
    Mark,
    Run,
    Hash(usize),
    Entry(usize),
}

impl Wrong {
    /// Converts the error to that of a file with a path.
    fn file_error(self, path: &Path, length: usize) -> SnapshotError {
        let path = path.to_owned();
        let (found, expected) = match self {
            Self::Run => return SnapshotError::Foreign { path },
            Self::Mark => (
                format!("{length} bytes without its mark"),
                "finished replicas",
            ),
            Self::Hash(number) => (
                format!("another hash of entry {number}, from 0"),
                "unchanged entries",
            ),
            Self::Entry(number) => (
                format!("entry {number}, from 0, of another run, point or seed"),
                "entries of one run",
            ),
        };
        SnapshotError::Damaged {
            path,
            found,
            expected,
        }
    }
}

impl Journal {
    /// Finds the journals of all processes in the folder of a point.
    pub(crate) fn find_all(folder: &Path) -> Vec<PathBuf> {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = files.map(|entry| entry.path()).collect();
        paths.retain(|path| path.extension().is_some_and(|end| end == "journal"));
        paths.sort();
        paths
    }

    /// Reads the entries added to a journal since `offset` (0 for all), and returns its current
    /// length. Another process may be appending to it, or may have removed it.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn read_from(
        path: &Path,
        owner: JournalOwner,
        offset: u64,
    ) -> Result<(Vec<JournalEntry>, u64), SnapshotError> {
        let failed = |source| SnapshotError::of_file(path, source);
        let mut file = match File::open(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok((Vec::new(), offset)),
            other => other.map_err(failed)?,
        };
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(offset)).map_err(failed)?;
        file.read_to_end(&mut bytes).map_err(failed)?;
        let read = if offset == 0 {
            parse_entries(&bytes, owner)
        } else {
            parse_frames(&bytes, owner)
        };
        let (all, end) = read.map_err(|wrong| wrong.file_error(path, bytes.len()))?;
        Ok((all, offset + end as u64))
    }

    /// Reads all journals in the folder of a point, and returns the record of each replica.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn read_all(
        point: &Path,
        owner: JournalOwner,
    ) -> Result<BTreeMap<u64, Vec<u8>>, SnapshotError> {
        let mut all = BTreeMap::new();
        for path in Self::find_all(&point.join(CHECKPOINTS)) {
            all.extend(Self::read_from(&path, owner, 0)?.0);
        }
        Ok(all)
    }

    /// Opens the journal of a run and reads its entries, or creates it.
    ///
    /// # Errors
    /// [`SnapshotError`] if the file cannot be read or written, is damaged, or of another run.
    pub(crate) fn open(
        path: &Path,
        owner: JournalOwner,
        interval: f64,
    ) -> Result<(Self, Vec<JournalEntry>), SnapshotError> {
        let failed = |source| SnapshotError::of_file(path, source);
        let open = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path);
        let mut file = open.map_err(failed)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let (all, end) =
            parse_entries(&bytes, owner).map_err(|wrong| wrong.file_error(path, bytes.len()))?;
        file.set_len(end as u64).map_err(failed)?;
        if end == 0 {
            file.rewind().map_err(failed)?;
            let header = [MAGIC, &owner.run[..]].concat();
            file.write_all(&header).map_err(failed)?;
        }
        let journal = Self {
            path: path.to_owned(),
            owner,
            file: Mutex::new(Open {
                file,
                end: end.max(HEADER) as u64,
                written: Instant::now(),
            }),
            interval: Duration::from_secs_f64(interval.clamp(0.0, 1e9)),
        };
        Ok((journal, all))
    }

    /// Appends the record of a replica to the journal.
    ///
    /// # Errors
    /// [`SnapshotError::File`].
    pub(crate) fn add(&self, replica: u64, left: &[u8]) -> Result<(), SnapshotError> {
        let bytes = [&record_header(self.owner, replica, left), left].concat();
        let mut open = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // Overwrites a truncated entry, which a full disk may have left.
        let place = SeekFrom::Start(open.end);
        let written = (open.file.seek(place)).and_then(|_| open.file.write_all(&bytes));
        let written = written.and_then(|()| {
            open.end += bytes.len() as u64;
            if open.written.elapsed() < self.interval {
                return Ok(());
            }
            open.written = Instant::now();
            open.file.sync_data()
        });
        written.map_err(|source| SnapshotError::of_file(&self.path, source))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const RUN: JournalOwner = JournalOwner {
        run: [7; 32],
        seed: 5,
    };

    /// A file cut at any point returns all entries that are whole.
    #[test]
    fn a_cut_loses_the_last_replica_only() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.journal");
        let (journal, before) = Journal::open(&path, RUN, 1e9).expect("made");
        assert!(before.is_empty());
        let wanted: Vec<JournalEntry> = vec![(3, vec![1; 5]), (0, Vec::new()), (9, vec![2; 90])];
        let mut ends = vec![HEADER];
        for (replica, left) in &wanted {
            journal.add(*replica, left).expect("added");
            ends.push(fs::read(&path).expect("bytes").len());
        }
        drop(journal);
        let whole = fs::read(&path).expect("bytes");
        for cut in 0..=whole.len() {
            fs::write(&path, &whole[..cut]).expect("written");
            let (journal, found) = Journal::open(&path, RUN, 1e9).expect("opened");
            let kept = ends[1..].iter().filter(|&&end| end <= cut).count();
            assert_eq!(found, wanted[..kept], "{cut}");
            // Appending makes it whole again.
            for (replica, left) in &wanted[kept..] {
                journal.add(*replica, left).expect("added");
            }
            assert_eq!(fs::read(&path).expect("bytes"), whole, "{cut}");
        }
    }

    /// A changed bit is detected anywhere, or cuts off the rest; no wrong entry is read.
    #[test]
    fn a_changed_bit_is_never_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.journal");
        let wanted: Vec<JournalEntry> = vec![(3, vec![1; 5]), (4, vec![2; 7])];
        let (journal, _) = Journal::open(&path, RUN, 0.0).expect("made");
        for (replica, left) in &wanted {
            journal.add(*replica, left).expect("added");
        }
        let whole = fs::read(&path).expect("bytes");
        let mut named = 0;
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            match parse_entries(&bytes, RUN) {
                Err(_) => named += 1,
                Ok((found, _)) => assert!(
                    found.len() < wanted.len() && found == wanted[..found.len()],
                    "{bit}"
                ),
            }
        }
        // All but those of the two lengths that point beyond the end.
        assert!(named > 8 * (whole.len() - 16), "{named}");
        let foreign = JournalOwner {
            run: [8; 32],
            ..RUN
        };
        let other = Journal::open(&path, foreign, 0.0).err();
        assert!(
            matches!(other, Some(SnapshotError::Foreign { .. })),
            "{other:?}"
        );
    }

    /// An entry of another run or seed is refused although it is whole.
    #[test]
    fn an_entry_of_another_run_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let [here, there] = ["a", "b"].map(|name| folder.path().join(name));
        let (journal, _) = Journal::open(&here, RUN, 1e9).expect("made");
        journal.add(0, b"own").expect("added");
        let own = fs::read(&here).expect("bytes");
        for other in [
            JournalOwner { seed: 6, ..RUN },
            JournalOwner {
                run: [8; 32],
                ..RUN
            },
        ] {
            let _ = fs::remove_file(&there);
            let (journal, _) = Journal::open(&there, other, 1e9).expect("made");
            journal.add(1, b"foreign").expect("added");
            let foreign = fs::read(&there).expect("bytes");
            fs::write(&here, [&own[..], &foreign[HEADER..]].concat()).expect("written");
            let said = Journal::open(&here, RUN, 1e9).err().map(|e| e.to_string());
            let said = said.expect("refused");
            assert!(said.contains("entry 1, from 0, of another run"), "{said}");
        }
    }
}
