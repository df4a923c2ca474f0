//! The list of the files that a run has written, which is also the lock of the folder.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Component, Path};

use crate::error::ResultsError;

/// Lists the files of the runs, and is locked while one writes.
pub(crate) const LIST_FILE: &str = "run.files";

/// The open and locked list of files.
#[derive(Debug)]
pub(crate) struct List {
    pub(crate) file: File,
    pub(crate) known: BTreeSet<String>,
}

impl List {
    /// Opens and locks the list of a folder; the words are a warning.
    pub(crate) fn lock(folder: &Path) -> Result<(Self, Option<String>), ResultsError> {
        let path = folder.join(LIST_FILE);
        let failed = |source| ResultsError::system(folder, "written")(source);
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(&path)
            .map_err(failed)?;
        let warning = match file.try_lock() {
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
        // What follows the last line end was being noted when the process was killed: nothing was written under it.
        let whole = text
            .iter()
            .rposition(|&byte| byte == b'\n')
            .map_or(0, |last| last + 1);
        file.set_len(whole as u64).map_err(failed)?;
        let text = String::from_utf8_lossy(&text[..whole]);
        let known = text
            .lines()
            .filter(|name| is_inside(name))
            .map(str::to_owned)
            .collect();
        Ok((Self { file, known }, warning))
    }

    pub(crate) fn note(&mut self, name: &str) -> std::io::Result<()> {
        if self.known.contains(name) {
            return Ok(());
        }
        self.file.write_all(format!("{name}\n").as_bytes())?;
        self.known.insert(name.to_owned());
        Ok(())
    }

    /// Removes the files of the list that `which` picks, and folders of them that are empty then.
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
        // A longer path sorts after the one that it is in.
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
                // A folder with something of the user's in it stays.
                let _ = fs::remove_dir(&inside);
            }
        }
        Ok(())
    }
}

impl Drop for List {
    /// Lets go of the lock itself: closing the file would leave it to a child process that another thread is starting, which
    /// holds a copy of each open file until it runs its own program.
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}

/// The file that a half-written one was to become, by its name.
pub(crate) fn half_written(name: &str) -> Option<String> {
    let hidden = || {
        let (target, random) = name.strip_prefix('.')?.rsplit_once('.')?;
        (random.len() == 6).then_some(target)
    };
    name.strip_suffix(".partial")
        .or_else(hidden)
        .map(str::to_owned)
}

/// Whether a name stays inside the folder that it is relative to, and fits in a line.
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
        let (list, _) = List::lock(folder.path()).expect("free");
        let copy = list.file.try_clone().expect("a copy");
        assert!(matches!(
            List::lock(folder.path()),
            Err(ResultsError::Locked { .. })
        ));
        drop(list);
        List::lock(folder.path()).expect("free again");
        drop(copy);
    }
}
