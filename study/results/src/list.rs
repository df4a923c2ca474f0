//! List of the files that a run has written, `run.files`; it is also the lock of the results
//! folder.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Component, Path, PathBuf};

use crate::error::ResultsError;

/// Name of the file that lists the files of the runs in a folder, and is locked while a process
/// writes into it.
pub(crate) const LIST_FILE: &str = "run.files";

/// Largest number of attempts to open and lock the list, as another process may remove it between
/// the two.
const MOST_TRIES: usize = 100;

/// List of the files of a results folder, open and locked.
#[derive(Debug)]
pub(crate) struct FileList {
    pub(crate) file: File,
    pub(crate) known: BTreeSet<String>,
    /// Separate list of this process, if other processes work in the folder too, as appending is
    /// not atomic on network file systems.
    own: Option<File>,
}

impl FileList {
    /// Opens and locks the list of files of a results folder, exclusively or `shared`. Returns a
    /// warning if locking is not supported.
    pub(crate) fn lock(
        folder: &Path,
        shared: bool,
    ) -> Result<(Self, Option<String>), ResultsError> {
        for _ in 0..MOST_TRIES {
            let (list, warning) = Self::lock_once(folder, shared)?;
            if list.is_of(folder) {
                return Ok((list, warning));
            }
        }
        Err(ResultsError::Locked {
            path: folder.to_owned(),
        })
    }

    fn lock_once(folder: &Path, shared: bool) -> Result<(Self, Option<String>), ResultsError> {
        let path = folder.join(LIST_FILE);
        let failed = |source| ResultsError::system(folder, "written")(source);
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(&path)
            .map_err(failed)?;
        let locked = if shared {
            file.try_lock_shared()
        } else {
            file.try_lock()
        };
        let warning = match locked {
            Ok(()) => None,
            Err(TryLockError::WouldBlock) => {
                return Err(ResultsError::Locked {
                    path: folder.to_owned(),
                });
            }
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                Some(format!(
                    "{}: this file system knows no locks; let no other process write here",
                    folder.display()
                ))
            }
            Err(TryLockError::Error(error)) => return Err(failed(error)),
        };
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(failed)?;
        let (known, whole) = parse_names(&text);
        if !shared {
            file.set_len(whole as u64).map_err(failed)?;
        }
        let own = None;
        Ok((Self { file, known, own }, warning))
    }

    /// Starts to register names in a separate list of this process.
    pub(crate) fn note_in(&mut self, path: &Path) -> std::io::Result<()> {
        self.own = Some(File::create_new(path)?);
        Ok(())
    }

    /// Reads the file names registered in the lists of other processes.
    ///
    /// # Errors
    /// [`ResultsError::System`] if a list exists and cannot be read.
    pub(crate) fn read_others(&mut self, lists: &[PathBuf]) -> Result<(), ResultsError> {
        for list in lists {
            match fs::read(list) {
                Ok(text) => self.known.extend(parse_names(&text).0),
                Err(error) if is_gone(&error) => {}
                Err(error) => return Err(ResultsError::system(list, "read")(error)),
            }
        }
        Ok(())
    }

    /// Merges the lists of processes into the common list of files, and removes them.
    pub(crate) fn take_over(&mut self, lists: &[PathBuf]) -> std::io::Result<()> {
        let gone_is_fine = |error: std::io::Error| match error {
            error if is_gone(&error) => Ok(()),
            error => Err(error),
        };
        let mut text = BTreeSet::new();
        for list in lists {
            match fs::read(list) {
                Ok(bytes) => text.extend(parse_names(&bytes).0),
                Err(error) => gone_is_fine(error)?,
            }
        }
        self.own = None;
        let lines = text.iter().map(|name| format!("{name}\n"));
        let lines: String = lines.collect();
        self.file.write_all(lines.as_bytes())?;
        self.known.extend(text);
        let mut removed = lists.iter().map(fs::remove_file);
        removed.try_for_each(|one| one.or_else(gone_is_fine))
    }

    /// Returns true if the list of files at this path is still the open one: neither folder nor
    /// list was moved, removed or replaced. An inode is not reused while it is open.
    pub(crate) fn is_of(&self, folder: &Path) -> bool {
        match (self.file.metadata(), fs::metadata(folder.join(LIST_FILE))) {
            (Ok(open), Ok(there)) => is_same_file(&open, &there),
            _ => false,
        }
    }

    pub(crate) fn note_file(&mut self, name: &str) -> std::io::Result<()> {
        if self.known.contains(name) {
            return Ok(());
        }
        let file = self.own.as_mut().unwrap_or(&mut self.file);
        file.write_all(format!("{name}\n").as_bytes())?;
        self.known.insert(name.to_owned());
        Ok(())
    }

    /// Removes the listed files that `which` selects, and the folders that become empty.
    pub(crate) fn remove(
        &self,
        folder: &Path,
        which: impl Fn(&str) -> bool,
    ) -> Result<(), ResultsError> {
        let mut parents = BTreeSet::new();
        for name in self.known.iter().filter(|name| which(name)) {
            let path = folder.join(name);
            remove_file(&path)?;
            parents.extend(Path::new(name).ancestors().skip(1).map(Path::to_owned));
        }
        // A longer path sorts after the one that contains it.
        for parent in parents.iter().rev() {
            let inside = folder.join(parent);
            for entry in fs::read_dir(&inside).into_iter().flatten().flatten() {
                let half = entry.file_name().to_str().and_then(half_written);
                if half.is_some_and(|name| {
                    parent
                        .join(name)
                        .to_str()
                        .is_some_and(|name| self.known.contains(name) && which(name))
                }) {
                    remove_file(&entry.path())?;
                }
            }
            if !parent.as_os_str().is_empty() {
                // A folder with files of the user stays.
                let _ = fs::remove_dir(&inside);
            }
        }
        Ok(())
    }
}

impl Drop for FileList {
    /// Releases the lock of the list explicitly. Closing the file would leave it to a child process
    /// in the making, which holds copies of all open files until it runs its program.
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}

/// Returns true for the error of a list that is gone, because it was merged into the common list;
/// a network file system may know its handle still.
fn is_gone(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::NotFound | ErrorKind::StaleNetworkFileHandle
    )
}

/// Parses the text of a list of files: its names, and its length up to the last line end. A
/// truncated name follows only if the process was killed before it wrote that file.
fn parse_names(text: &[u8]) -> (BTreeSet<String>, usize) {
    let last = text.iter().rposition(|&byte| byte == b'\n');
    let whole = last.map_or(0, |last| last + 1);
    let lines = String::from_utf8_lossy(&text[..whole]);
    let known = lines.lines().filter(|name| is_inside(name));
    (known.map(str::to_owned).collect(), whole)
}

#[cfg(unix)]
pub(crate) fn is_same_file(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Returns true on systems other than Unix, which prevent an open file from being moved or removed.
#[cfg(not(unix))]
pub(crate) fn is_same_file(_: &fs::Metadata, _: &fs::Metadata) -> bool {
    true
}

/// Returns the final name of a half-written file from its temporary name; `None` for other files.
pub fn half_written(name: &str) -> Option<String> {
    let (target, random) = name.strip_prefix('.')?.rsplit_once('.')?;
    (random.len() == 6).then(|| target.to_owned())
}

/// Returns true if a file name stays inside its folder and contains no control characters.
pub(crate) fn is_inside(name: &str) -> bool {
    let normal = |part: Component<'_>| matches!(part, Component::Normal(_));
    !name.is_empty() && !name.contains(char::is_control) && Path::new(name).components().all(normal)
}

fn remove_file(path: &Path) -> Result<(), ResultsError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => {
            Err(ResultsError::system(path, "removed")(source))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A copy of the open file, such as a child process has for a moment, does not keep the lock.
    #[test]
    fn a_copy_of_the_open_list_keeps_no_lock() {
        let folder = tempfile::tempdir().expect("a folder");
        let (list, _) = FileList::lock(folder.path(), false).expect("free");
        let copy = list.file.try_clone().expect("a copy");
        assert!(matches!(
            FileList::lock(folder.path(), true),
            Err(ResultsError::Locked { .. })
        ));
        drop(list);
        FileList::lock(folder.path(), false).expect("free again");
        drop(copy);
    }
}
