//! Results folder: locking, the list of files that belong to the program, and whether a run is
//! finished.
//!
//! | file | content |
//! |---|---|
//! | `run.json` | marks the folder: which runs it is for, with their cases and fingerprints |
//! | `run.files` | each file that a run has written, noted before it is written; locked while a run writes |
//! | `manifest.json` | written last: a run is finished if all files that it names are there with their checksums |
//!
//! Only files in `run.files` are ever removed, so files of the user stay. The lock is on a separate
//! file that is never replaced: a lock on `run.json` would be lost with each atomic write of it.
//! Before each write the list at the path is compared with the open one. So a run whose folder was
//! moved or removed stops, and does not write into another one. Files appear under their names only
//! when they are complete (the crate `atomic-write-file`).

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use atomic_write_file::AtomicWriteFile;
use serde::Serialize;

use crate::claims::{self, CLAIMS, FolderWorker};
use crate::error::ResultsError;
use crate::identity::{RUN_FILE, RunId, RunMark, differences};
use crate::list::{FileList, LIST_FILE, half_written, is_inside};
use crate::manifest::{
    MANIFEST_FILE, Manifest, REPORT_FILE, SWEEP_FILE, SWEEP_TABLE, Sweep, TableEntry, hash_of,
};
use crate::table::Table;

/// Name of the folder of checkpoints inside the results folder of a run.
pub const CHECKPOINTS: &str = "checkpoints";
/// Name of the folder of snapshots inside the results folder of a run.
pub const SNAPSHOTS: &str = "snapshots";

/// Time without heartbeat after which processes that share a folder count as lost to one that needs
/// it exclusively.
const PATIENCE: Duration = Duration::from_mins(1);

/// Treatment of a results folder that exists when a run starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Refuse to start if the results folder exists.
    Refuse,
    /// Resume the run in the existing results folder.
    Resume,
    /// Replace the run in the existing results folder.
    Replace,
}

/// Results folder that this process has locked for writing.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    runs: Vec<RunId>,
    /// Fingerprint of each run that the folder is for, made from its inputs and its name.
    fingerprints: Vec<[u8; 32]>,
    list: Mutex<FileList>,
    warning: Option<String>,
    /// Registration of this process among all that share the folder; `None` if it works alone.
    worker: Option<FolderWorker>,
}

/// Location of one run: the folder, or the subfolder of a point of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct RunPlace<'a> {
    folder: &'a Folder,
    run: &'a RunId,
    fingerprint: &'a [u8; 32],
}

/// Writes a file atomically: it appears under its name only when it is complete. Creates its folder
/// if needed.
///
/// # Errors
/// [`ResultsError::System`] names the file.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    let write = || -> std::io::Result<()> {
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut file = AtomicWriteFile::open(path)?;
        file.write_all(bytes)?;
        file.commit()
    };
    write().map_err(ResultsError::system(path, "written"))
}

/// Copies a file atomically: the copy appears under its name only when it is complete.
///
/// # Errors
/// [`ResultsError::System`] names the file.
pub fn copy_file(from: &Path, to: &Path) -> Result<(), ResultsError> {
    let mut source = fs::File::open(from).map_err(ResultsError::system(from, "read"))?;
    let mut write = || -> std::io::Result<()> {
        let mut file = AtomicWriteFile::open(to)?;
        std::io::copy(&mut source, &mut file)?;
        file.commit()
    };
    write().map_err(ResultsError::system(to, "written"))
}

fn json(path: &Path, content: &impl Serialize) -> Result<Vec<u8>, ResultsError> {
    let mut bytes = serde_json::to_vec_pretty(content)
        .map_err(|error| ResultsError::system(path, "written")(error.into()))?;
    bytes.push(b'\n');
    Ok(bytes)
}

impl Folder {
    /// Creates the results folder of some runs, or opens an existing one to resume, and locks it
    /// until the value is dropped. `inputs` are files that must not be replaced.
    ///
    /// # Errors
    /// [`ResultsError`]; the folder is then unchanged, unless the system fails half-way.
    pub fn open(
        path: &Path,
        existing: Existing,
        inputs: &[&Path],
        runs: Vec<RunId>,
    ) -> Result<Self, ResultsError> {
        require_names(&runs)?;
        check_admission(path, existing, inputs, &runs)?;
        fs::create_dir_all(path).map_err(ResultsError::system(path, "made"))?;
        let (mut list, warning) = FileList::lock(path, false)?;
        // Another process may have changed it in between.
        let known = check_admission(path, existing, inputs, &runs)?;
        if path.join(CLAIMS).exists() {
            require_unshared(path)?;
            list.take_over(&claims::lists(path))
                .map_err(ResultsError::system(path, "written"))?;
            claims::remove_workers(path);
        }
        if known && existing == Existing::Replace {
            list.remove(path, |_| true)?;
            list.file
                .set_len(0)
                .map_err(ResultsError::system(path, "written"))?;
            list.known.clear();
        }
        let file = path.join(RUN_FILE);
        write_file(&file, &json(&file, &RunMark::new(&runs))?)?;
        Ok(Self::of(path, runs, list, warning, None))
    }

    /// Creates the results folder of some runs, or joins the processes that work in an existing
    /// one, until the value is dropped. A process without a heartbeat for `patience` counts as
    /// lost.
    ///
    /// # Errors
    /// [`ResultsError`], also if a process works there without sharing the folder.
    pub fn join(
        path: &Path,
        inputs: &[&Path],
        runs: Vec<RunId>,
        patience: Duration,
    ) -> Result<Self, ResultsError> {
        require_names(&runs)?;
        let is_marked = || Ok::<bool, ResultsError>(RunMark::read_mark(path)?.is_some());
        if !is_marked()? {
            check_admission(path, Existing::Refuse, inputs, &runs)?;
            fs::create_dir_all(path).map_err(ResultsError::system(path, "made"))?;
        }
        let (mut list, warning) = FileList::lock(path, true)?;
        let file = path.join(RUN_FILE);
        if !is_marked()? {
            // The first process creates the mark; all others find and compare it.
            write_new(&file, &json(&file, &RunMark::new(&runs))?)?;
        }
        check_admission(path, Existing::Resume, inputs, &runs)?;
        let worker = FolderWorker::register(path, patience)?;
        list.note_in(&worker.list_path())
            .map_err(ResultsError::system(path, "written"))?;
        Ok(Self::of(path, runs, list, warning, Some(worker)))
    }

    fn of(
        path: &Path,
        runs: Vec<RunId>,
        list: FileList,
        warning: Option<String>,
        worker: Option<FolderWorker>,
    ) -> Self {
        Self {
            path: path.to_owned(),
            fingerprints: runs.iter().map(RunId::identity).collect(),
            runs,
            list: Mutex::new(list),
            warning,
            worker,
        }
    }

    /// Checks that an existing results folder belongs to the given runs.
    ///
    /// # Errors
    /// [`ResultsError::Foreign`] names the differences; [`ResultsError::NothingToResume`] if there
    /// are no results of this program.
    pub fn require_runs(path: &Path, runs: &[RunId]) -> Result<(), ResultsError> {
        let path = path.to_owned();
        let Some(known) = RunMark::read_mark(&path)? else {
            return Err(ResultsError::NothingToResume { path });
        };
        match known.differences(runs) {
            Some(differences) => Err(ResultsError::Foreign { path, differences }),
            None => Ok(()),
        }
    }

    /// Returns the registration of this process among all that share the folder; `None` if it works
    /// alone.
    pub fn worker(&self) -> Option<&FolderWorker> {
        self.worker.as_ref()
    }

    /// Returns the path of the folder with the claims of tasks.
    pub fn claims(&self) -> PathBuf {
        self.path.join(CLAIMS)
    }

    /// Merges the file lists of all processes into the common one, and removes all claims, when all
    /// points are finished.
    ///
    /// # Errors
    /// [`ResultsError::System`] if the lists cannot be read or written.
    pub fn settle_claims(&self) -> Result<(), ResultsError> {
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        self.require_list(&list)?;
        list.take_over(&claims::lists(&self.path))
            .map_err(ResultsError::system(&self.path, "written"))?;
        if let Some(worker) = &self.worker {
            worker.remove_lost();
        }
        claims::remove_claims(&self.claims(), "");
        Ok(())
    }

    /// Returns the path of the results folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the warning about the folder for the user, such as missing locks; `None` without
    /// one.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Returns the locations of the runs in the folder, in the order in which the runs were given.
    pub fn places(&self) -> impl Iterator<Item = RunPlace<'_>> {
        let both = self.runs.iter().zip(&self.fingerprints);
        both.map(|(run, fingerprint)| RunPlace {
            folder: self,
            run,
            fingerprint,
        })
    }

    /// Checks that the path of the folder still leads to the locked folder. Call it before anything
    /// is written or removed by its path.
    ///
    /// # Errors
    /// [`ResultsError::Moved`] if the folder or its file list was moved, removed or replaced.
    pub fn require_same(&self) -> Result<(), ResultsError> {
        let list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        self.require_list(&list)
    }

    fn require_list(&self, list: &FileList) -> Result<(), ResultsError> {
        list.is_of(&self.path)
            .then_some(())
            .ok_or_else(|| ResultsError::Moved {
                path: self.path.clone(),
            })
    }

    /// Registers a file of the run in the list of files and writes it atomically.
    ///
    /// # Errors
    /// As [`RunPlace::claim`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        write_file(&self.claim(name)?, bytes)
    }

    /// Writes the index `sweep.json` of a sweep.
    ///
    /// # Errors
    /// [`ResultsError::System`] names the file.
    pub fn write_sweep(&self, sweep: &Sweep) -> Result<(), ResultsError> {
        self.claim(REPORT_FILE)?;
        self.claim(SWEEP_TABLE)?;
        let path = self.claim(SWEEP_FILE)?;
        write_file(&path, &json(&path, sweep)?)
    }

    /// Registers the file at a path inside the results folder, as [`Self::claim`].
    ///
    /// # Errors
    /// As [`RunPlace::claim`].
    pub fn claim_path(&self, path: &Path) -> Result<(), ResultsError> {
        let inside = path.strip_prefix(&self.path).unwrap_or(path);
        let parts = inside.iter().map(|part| part.to_string_lossy());
        self.claim(&parts.collect::<Vec<_>>().join("/")).map(drop)
    }

    /// Registers a file in the list of files, so that `--force` removes it, creates its folder, and
    /// returns its path.
    ///
    /// # Errors
    /// As [`RunPlace::claim`].
    pub fn claim(&self, name: &str) -> Result<PathBuf, ResultsError> {
        if !is_inside(name) {
            return Err(ResultsError::Name {
                name: name.to_owned(),
            });
        }
        let path = self.path.join(name);
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        self.require_list(&list)?;
        list.note_file(name)
            .map_err(ResultsError::system(&self.path, "written"))?;
        let parent = path.parent().unwrap_or(&self.path);
        fs::create_dir_all(parent).map_err(ResultsError::system(parent, "written"))?;
        Ok(path)
    }
}

/// Checks that the names of all points stay inside the results folder.
fn require_names(runs: &[RunId]) -> Result<(), ResultsError> {
    let bad = |run: &&RunId| !run.name.is_empty() && !is_inside(&run.name);
    match runs.iter().find(bad) {
        Some(run) => Err(ResultsError::Name {
            name: run.name.clone(),
        }),
        None => Ok(()),
    }
}

/// Checks by heartbeats that no other process is working in the results folder.
///
/// # Errors
/// [`ResultsError::Locked`] if there is one; others if the file system fails.
fn require_unshared(path: &Path) -> Result<(), ResultsError> {
    let visitor = FolderWorker::register(path, PATIENCE)?;
    if visitor.find_other()? {
        return Err(ResultsError::Locked {
            path: path.to_owned(),
        });
    }
    Ok(())
}

/// Writes a file atomically unless it exists.
fn write_new(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    // Other processes recognise the name as that of a half-written file.
    let name = format!(".{RUN_FILE}.{}", &claims::unique_id()[..6]);
    let hidden = path.with_file_name(name);
    let write = || -> std::io::Result<()> {
        let mut file = fs::File::create_new(&hidden)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(ResultsError::system(path, "written"))?;
    let linked = fs::hard_link(&hidden, path);
    fs::remove_file(&hidden).map_err(ResultsError::system(path, "written"))?;
    match linked {
        Err(source) if source.kind() != ErrorKind::AlreadyExists => Err(ResultsError::Links {
            path: path.to_owned(),
            source,
        }),
        _ => Ok(()),
    }
}

/// Checks whether a folder may become or stay the results folder of some runs; `true` if it has
/// results of this program.
fn check_admission(
    path: &Path,
    existing: Existing,
    inputs: &[&Path],
    runs: &[RunId],
) -> Result<bool, ResultsError> {
    let owned = || path.to_owned();
    let Some(known) = RunMark::read_mark(path)? else {
        if existing == Existing::Resume {
            return Err(ResultsError::NothingToResume { path: owned() });
        }
        let ours = |name: &str| {
            name == LIST_FILE || name == CLAIMS || half_written(name).as_deref() == Some(RUN_FILE)
        };
        let mut entries = fs::read_dir(path).into_iter().flatten().flatten();
        if entries.any(|entry| !entry.file_name().to_str().is_some_and(ours)) {
            return Err(ResultsError::NotResults { path: owned() });
        }
        return Ok(false);
    };
    let inside = |input: &&&Path| match (input.canonicalize(), path.canonicalize()) {
        (Ok(input), Ok(path)) => input.starts_with(path),
        _ => false,
    };
    match existing {
        Existing::Refuse => Err(ResultsError::Exists { path: owned() }),
        Existing::Replace => match inputs.iter().find(inside) {
            Some(input) => Err(ResultsError::InputInside {
                path: owned(),
                input: input.to_path_buf(),
            }),
            None => Ok(true),
        },
        Existing::Resume => {
            if let Some(differences) = known.differences(runs) {
                return Err(ResultsError::Foreign {
                    path: owned(),
                    differences,
                });
            }
            for run in runs {
                let (there, here) = (&known.runs[&run.name], run.fingerprint());
                let finished = Manifest::read_finished(&path.join(&run.name))?;
                if finished.is_some_and(|old| {
                    old.fingerprint.numbers == here.numbers && old.fingerprint.output != here.output
                }) {
                    return Err(ResultsError::Changed {
                        path: path.join(&run.name),
                        differences: differences(&there.case, &run.case),
                    });
                }
            }
            Ok(true)
        }
    }
}

impl<'a> RunPlace<'a> {
    /// Returns the results folder that the run is in.
    pub fn folder(&self) -> &'a Folder {
        self.folder
    }

    /// Returns the path of the folder of this run.
    pub fn path(&self) -> PathBuf {
        if self.run.name.is_empty() {
            return self.folder.path.clone();
        }
        self.folder.path.join(&self.run.name)
    }

    /// Returns the name of the sweep point that this run is; empty without a sweep.
    pub fn name(&self) -> &str {
        &self.run.name
    }

    /// Returns the fingerprint of the run, which includes the name of the point, for checkpoints.
    pub fn fingerprint(&self) -> &'a [u8; 32] {
        self.fingerprint
    }

    /// Returns the full name of a task of this run, unique among the tasks of all points.
    pub fn task(&self, name: &str) -> String {
        format!("{}-{name}", self.task_prefix())
    }

    fn task_prefix(&self) -> String {
        blake3::Hash::from_bytes(*self.fingerprint).to_hex()[..12].to_owned()
    }

    /// Removes the claims of the run's tasks. Call it when the run is finished.
    pub fn remove_claims(&self) {
        claims::remove_claims(&self.folder.claims(), &self.task_prefix());
    }

    /// Returns true if the run has a manifest and thus was finished.
    pub fn has_manifest(&self) -> bool {
        self.path().join(MANIFEST_FILE).exists()
    }

    fn inside(&self, name: &str) -> String {
        if self.run.name.is_empty() {
            return name.to_owned();
        }
        format!("{}/{name}", self.run.name)
    }

    /// Registers a file of the run in the list of files, so that `--force` removes it, creates its
    /// folder, and returns its path. Names are relative, with `/` between folders. Call it before
    /// the file is written.
    ///
    /// # Errors
    /// [`ResultsError`] if the name points outside the folder, or the folder cannot be written.
    pub fn claim(&self, name: &str) -> Result<PathBuf, ResultsError> {
        self.folder.claim(&self.inside(name))
    }

    /// Registers a file of the run in the list of files and writes it atomically.
    ///
    /// # Errors
    /// As [`Self::claim`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        self.folder.write(&self.inside(name), bytes)
    }

    /// Returns true if the run is finished except for its report: its manifest is of this run, and
    /// each file in it exists with its checksum.
    ///
    /// # Errors
    /// [`ResultsError`] if an existing file cannot be read.
    pub fn is_complete(&self) -> Result<bool, ResultsError> {
        let path = self.path();
        let Some(manifest) = Manifest::read_finished(&path)? else {
            return Ok(false);
        };
        let (absent, changed) = manifest.damage(&path)?;
        let ours = manifest.fingerprint == self.run.fingerprint();
        Ok(ours && absent.is_empty() && changed.is_empty())
    }

    /// Returns the names of files that do not exist in the folder of the run. A checkpoint later
    /// than a lost snapshot must not be used.
    pub fn missing<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> Vec<String> {
        let path = self.path();
        let absent = names.into_iter().filter(|name| !path.join(name).exists());
        absent.map(str::to_owned).collect()
    }

    /// Writes the tables, and then the manifest, with its format, fingerprint, tables and checksums
    /// filled in. The run is finished then. Page and drawings of a report are registered, not
    /// written.
    ///
    /// # Errors
    /// [`ResultsError`] if a snapshot is missing, a table is not rectangular, or a file cannot be
    /// written.
    pub fn finish(
        &self,
        mut manifest: Manifest,
        tables: &[Table],
    ) -> Result<Manifest, ResultsError> {
        let path = self.path();
        let lost = self.missing(manifest.snapshots.iter().map(|one| one.file.as_str()));
        if !lost.is_empty() {
            return Err(ResultsError::Lost { path, files: lost });
        }
        for snapshot in &mut manifest.snapshots {
            let hash = hash_of(&path.join(&snapshot.file))?;
            snapshot.blake3 = hash.ok_or_else(|| ResultsError::Lost {
                path: path.clone(),
                files: vec![snapshot.file.clone()],
            })?;
        }
        manifest.format = crate::manifest::FORMAT;
        manifest.fingerprint = self.run.fingerprint();
        manifest.tables.clear();
        for table in tables {
            let bytes = table.to_csv()?;
            self.write(&table.file(), &bytes)?;
            manifest.tables.push(TableEntry::new(table, &bytes));
            for drawing in table.drawings() {
                self.claim(&drawing)?;
            }
        }
        self.claim(REPORT_FILE)?;
        let file = self.claim(MANIFEST_FILE)?;
        write_file(&file, &json(&file, &manifest)?)?;
        Ok(manifest)
    }

    /// Removes the checkpoints of a finished run.
    ///
    /// # Errors
    /// [`ResultsError::System`] names the file that could not be removed.
    pub fn remove_checkpoints(&self) -> Result<(), ResultsError> {
        let list = &self.folder.list;
        let mut list = list.lock().unwrap_or_else(PoisonError::into_inner);
        self.folder.require_list(&list)?;
        if self.folder.worker.is_some() {
            list.read_others(&claims::lists(&self.folder.path))?;
        }
        let within = self.inside(CHECKPOINTS);
        let of_run = |name: &str| {
            let rest = name.strip_prefix(&within);
            rest.is_some_and(|rest| rest.starts_with('/'))
        };
        list.remove(&self.folder.path, of_run)
    }
}
