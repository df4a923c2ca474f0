//! The replicas of a point that are finished: one file, to which each is added, so that thousands of short replicas are not thousands
//! of files.
//!
//! Layout, little-endian: 8 bytes magic, fingerprint of the run and point (32 bytes); then for each replica the length of what it left (u64),
//! its number (u64), the seed (u64), the fingerprint again, BLAKE3 hash of all these and of what it left (32 bytes), what it left. A kill may
//! cut the last one short: that replica is done again.

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
/// Before what a replica left.
const FRAME: usize = HASHED + 32;
/// The part of that which the hash covers.
const HASHED: usize = 8 + 8 + 8 + 32;

/// The run that a journal belongs to. Each entry repeats it, so that none is taken from the journal of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct JournalOwner {
    /// Hash of all that decides the numbers, and of the point.
    pub run: Fingerprint,
    /// Seed of the case.
    pub seed: u64,
}

/// Its name in the folder of a point.
pub(crate) fn name() -> String {
    format!("{CHECKPOINTS}/replicas.journal")
}

/// Name of the journal of one of several processes, in the folder of a point.
pub(crate) fn name_of(worker: &str) -> String {
    format!("{CHECKPOINTS}/replicas-{worker}.journal")
}

/// A replica, and what it left.
pub(crate) type Entry = (u64, Vec<u8>);

/// The journal of a point, open to be added to.
pub(crate) struct Journal {
    path: PathBuf,
    owner: JournalOwner,
    file: Mutex<Open>,
    /// Between two moments at which the system must have written it.
    interval: Duration,
}

struct Open {
    file: File,
    /// Where the last entry ends.
    end: u64,
    written: Instant,
}

/// Hash of a replica, and what stands before it.
fn frame(owner: JournalOwner, replica: u64, left: &[u8]) -> [u8; FRAME] {
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

/// The entries of a file, and where the last whole one ends; or what is wrong.
fn entries(bytes: &[u8], owner: JournalOwner) -> Result<(Vec<Entry>, usize), Wrong> {
    // A kill may have cut the header short.
    if bytes.len() < HEADER {
        return Ok((Vec::new(), 0));
    }
    if &bytes[..8] != MAGIC {
        return Err(Wrong::Mark);
    }
    if bytes[8..HEADER] != owner.run {
        return Err(Wrong::Run);
    }
    let (all, end) = frames(&bytes[HEADER..], owner)?;
    Ok((all, HEADER + end))
}

/// The entries that stand one after the other, and where the last whole one ends; or what is wrong.
fn frames(bytes: &[u8], owner: JournalOwner) -> Result<(Vec<Entry>, usize), Wrong> {
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
        if head != frame(found, replica, left) {
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

/// What may be wrong with a journal.
#[derive(Debug, PartialEq)]
enum Wrong {
    Mark,
    Run,
    Hash(usize),
    Entry(usize),
}

impl Wrong {
    /// What is said of a file.
    fn of(self, path: &Path, length: usize) -> SnapshotError {
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
    /// Finds the journals in a folder.
    pub(crate) fn find_all(folder: &Path) -> Vec<PathBuf> {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = files.map(|entry| entry.path()).collect();
        paths.retain(|path| path.extension().is_some_and(|end| end == "journal"));
        paths.sort();
        paths
    }

    /// Reads what was added to a journal since it ended at `offset`, 0 for all of it, and says where it ends now. Another process may be adding
    /// to it, or have removed it.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn read_from(
        path: &Path,
        owner: JournalOwner,
        offset: u64,
    ) -> Result<(Vec<Entry>, u64), SnapshotError> {
        let failed = |source| SnapshotError::of_file(path, source);
        let mut file = match File::open(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok((Vec::new(), offset)),
            other => other.map_err(failed)?,
        };
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(offset)).map_err(failed)?;
        file.read_to_end(&mut bytes).map_err(failed)?;
        let read = if offset == 0 {
            entries(&bytes, owner)
        } else {
            frames(&bytes, owner)
        };
        let (all, end) = read.map_err(|wrong| wrong.of(path, bytes.len()))?;
        Ok((all, offset + end as u64))
    }

    /// Reads all journals in the folder of a point: what each replica left.
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

    /// Opens the journal of a run, and makes it if there is none; with what is in it.
    ///
    /// # Errors
    /// [`SnapshotError`] if the file cannot be read or written, is damaged, or of another run.
    pub(crate) fn open(
        path: &Path,
        owner: JournalOwner,
        interval: f64,
    ) -> Result<(Self, Vec<Entry>), SnapshotError> {
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
        let (all, end) = entries(&bytes, owner).map_err(|wrong| wrong.of(path, bytes.len()))?;
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

    /// Adds a replica.
    ///
    /// # Errors
    /// [`SnapshotError::File`].
    pub(crate) fn add(&self, replica: u64, left: &[u8]) -> Result<(), SnapshotError> {
        let bytes = [&frame(self.owner, replica, left), left].concat();
        let mut open = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // Not behind half of one, which a full disk may have left.
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

    /// What was added comes back, also when the file is cut anywhere: then all that were whole.
    #[test]
    fn a_cut_loses_the_last_replica_only() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.journal");
        let (journal, before) = Journal::open(&path, RUN, 1e9).expect("made");
        assert!(before.is_empty());
        let wanted: Vec<Entry> = vec![(3, vec![1; 5]), (0, Vec::new()), (9, vec![2; 90])];
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
            // And it is whole again.
            for (replica, left) in &wanted[kept..] {
                journal.add(*replica, left).expect("added");
            }
            assert_eq!(fs::read(&path).expect("bytes"), whole, "{cut}");
        }
    }

    /// A changed bit is found, wherever it is, or cuts off what follows; nothing wrong is read.
    #[test]
    fn a_changed_bit_is_never_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.journal");
        let wanted: Vec<Entry> = vec![(3, vec![1; 5]), (4, vec![2; 7])];
        let (journal, _) = Journal::open(&path, RUN, 0.0).expect("made");
        for (replica, left) in &wanted {
            journal.add(*replica, left).expect("added");
        }
        let whole = fs::read(&path).expect("bytes");
        let mut named = 0;
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            match entries(&bytes, RUN) {
                Err(_) => named += 1,
                Ok((found, _)) => assert!(
                    found.len() < wanted.len() && found == wanted[..found.len()],
                    "{bit}"
                ),
            }
        }
        // All but those of the two lengths that lead beyond the end.
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

    /// An entry of the journal of another run or seed is not taken, although it is whole.
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
