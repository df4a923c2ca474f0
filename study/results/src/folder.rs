//! The results folder: whether it may be written into, what in it belongs to the program, and whether it is finished.
//!
//! | file | what it is |
//! |---|---|
//! | `run.json` | marks the folder: which runs it is for, with their cases and fingerprints |
//! | `run.files` | each file that a run has written, noted before it is written; locked while a run writes |
//! | `manifest.json` | written last: a run is finished if all files that it names are there with their checksums |
//!
//! Only files in `run.files` are ever removed, so what a user puts into the folder stays. The lock is on a file of its own,
//! which is never replaced: a lock on `run.json` would be lost with each atomic write of it. Files appear under their
//! names only when they are complete (the crate `atomic-write-file`).

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use atomic_write_file::AtomicWriteFile;
use serde::Serialize;

use crate::error::ResultsError;
use crate::identity::{Mark, RUN_FILE, RunId, differences};
use crate::list::{LIST_FILE, List, half_written, is_inside};
use crate::manifest::{
    MANIFEST_FILE, Manifest, REPORT_FILE, SWEEP_FILE, SWEEP_TABLE, Sweep, TableEntry, hash_of,
};
use crate::table::Table;

/// Name of the folder of checkpoints inside that of a run.
pub const CHECKPOINTS: &str = "checkpoints";
/// Name of the folder of snapshots inside that of a run.
pub const SNAPSHOTS: &str = "snapshots";

/// What to do with a folder that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Refuse it.
    Refuse,
    /// Continue it.
    Resume,
    /// Replace it.
    Replace,
}

/// A results folder that this process, and no other, writes into.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    runs: Vec<RunId>,
    list: Mutex<List>,
    warning: Option<String>,
}

/// The place of one run: the folder, or the subfolder of a point of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    folder: &'a Folder,
    run: &'a RunId,
}

/// Writes a file, in a folder that is made if need be, so that it appears under its name only when it is complete.
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

fn json(path: &Path, content: &impl Serialize) -> Result<Vec<u8>, ResultsError> {
    let mut bytes = serde_json::to_vec_pretty(content)
        .map_err(|error| ResultsError::system(path, "written")(error.into()))?;
    bytes.push(b'\n');
    Ok(bytes)
}

impl Folder {
    /// Makes the results folder of some runs, or finds the one to continue, and locks it until the value is dropped.
    /// `inputs` are files that must survive.
    ///
    /// # Errors
    /// [`ResultsError`]; nothing is changed then, unless the system fails half-way.
    pub fn open(
        path: &Path,
        existing: Existing,
        inputs: &[&Path],
        runs: Vec<RunId>,
    ) -> Result<Self, ResultsError> {
        if let Some(run) = runs
            .iter()
            .find(|run| !run.name.is_empty() && !is_inside(&run.name))
        {
            return Err(ResultsError::Name {
                name: run.name.clone(),
            });
        }
        admit(path, existing, inputs, &runs)?;
        fs::create_dir_all(path).map_err(ResultsError::system(path, "written"))?;
        let (mut list, warning) = List::lock(path)?;
        // Another process may have come between.
        let known = admit(path, existing, inputs, &runs)?;
        if known && existing == Existing::Replace {
            list.remove(path, |_| true)?;
            list.file
                .set_len(0)
                .map_err(ResultsError::system(path, "written"))?;
            list.known.clear();
        }
        let file = path.join(RUN_FILE);
        write_file(&file, &json(&file, &Mark::new(&runs))?)?;
        Ok(Self {
            path: path.to_owned(),
            runs,
            list: Mutex::new(list),
            warning,
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What a user should know about the folder.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// The places of the runs, in the order in which they were named.
    pub fn places(&self) -> impl Iterator<Item = Place<'_>> {
        self.runs.iter().map(|run| Place { folder: self, run })
    }

    /// Writes the index of a sweep.
    ///
    /// # Errors
    /// [`ResultsError::System`] names the file.
    pub fn write_sweep(&self, sweep: &Sweep) -> Result<(), ResultsError> {
        self.claim(REPORT_FILE)?;
        self.claim(SWEEP_TABLE)?;
        let path = self.claim(SWEEP_FILE)?;
        write_file(&path, &json(&path, sweep)?)
    }

    /// Notes that a file belongs to the run, and makes its folder.
    fn claim(&self, name: &str) -> Result<PathBuf, ResultsError> {
        if !is_inside(name) {
            return Err(ResultsError::Name {
                name: name.to_owned(),
            });
        }
        let path = self.path.join(name);
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        list.note(name)
            .map_err(ResultsError::system(&self.path, "written"))?;
        let parent = path.parent().unwrap_or(&self.path);
        fs::create_dir_all(parent).map_err(ResultsError::system(parent, "written"))?;
        Ok(path)
    }
}

/// Whether a folder may be used; `true` if it has results of this program.
fn admit(
    path: &Path,
    existing: Existing,
    inputs: &[&Path],
    runs: &[RunId],
) -> Result<bool, ResultsError> {
    let owned = || path.to_owned();
    let Some(known) = Mark::read(path)? else {
        if existing == Existing::Resume {
            return Err(ResultsError::NothingToResume { path: owned() });
        }
        let ours =
            |name: &str| name == LIST_FILE || half_written(name).as_deref() == Some(RUN_FILE);
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
                let finished = Manifest::read(&path.join(&run.name)).ok().flatten();
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

impl Place<'_> {
    /// Where it is.
    pub fn path(&self) -> PathBuf {
        if self.run.name.is_empty() {
            return self.folder.path.clone();
        }
        self.folder.path.join(&self.run.name)
    }

    /// Name of the point of a sweep; empty without a sweep.
    pub fn name(&self) -> &str {
        &self.run.name
    }

    /// Hash of all that decides the numbers, for checkpoints.
    pub fn fingerprint(&self) -> &[u8; 32] {
        &self.run.numbers
    }

    fn inside(&self, name: &str) -> String {
        if self.run.name.is_empty() {
            return name.to_owned();
        }
        format!("{}/{name}", self.run.name)
    }

    /// Notes that a file belongs to the run, so that `--force` removes it, makes its folder, and returns its path. Names
    /// are relative, with `/` between folders. To be called before the file is written.
    ///
    /// # Errors
    /// The name leads out of the folder, or the folder cannot be written.
    pub fn claim(&self, name: &str) -> Result<PathBuf, ResultsError> {
        self.folder.claim(&self.inside(name))
    }

    /// Claims a file and writes it, as a whole.
    ///
    /// # Errors
    /// As [`Self::claim`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        write_file(&self.claim(name)?, bytes)
    }

    /// Whether the run is finished but for its report: its manifest is of this run, and each file that it names is there
    /// with its checksum.
    ///
    /// # Errors
    /// A file that is there cannot be read.
    pub fn is_complete(&self) -> Result<bool, ResultsError> {
        let path = self.path();
        let Some(manifest) = Manifest::read(&path).ok().flatten() else {
            return Ok(false);
        };
        let (absent, changed) = manifest.damage(&path)?;
        let ours = manifest.fingerprint == self.run.fingerprint();
        Ok(ours && absent.is_empty() && changed.is_empty())
    }

    /// Those of some files that are not there: a checkpoint that is later than a snapshot that was lost must not be used.
    pub fn missing<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> Vec<String> {
        let path = self.path();
        let absent = names.into_iter().filter(|name| !path.join(name).exists());
        absent.map(str::to_owned).collect()
    }

    /// Writes the tables, and then the manifest, of which it fills in what belongs to the folder: format, fingerprint,
    /// tables and checksums. The run is finished then. The page and the drawings of a report are claimed, not written.
    ///
    /// # Errors
    /// A snapshot is missing, a table is not rectangular, or a file cannot be written.
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
            snapshot.blake3 = hash_of(&path.join(&snapshot.file))?.unwrap_or_default();
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
    /// [`ResultsError::System`] names what could not be removed.
    pub fn remove_checkpoints(&self) -> Result<(), ResultsError> {
        let list = &self.folder.list;
        let list = list.lock().unwrap_or_else(PoisonError::into_inner);
        let within = self.inside(CHECKPOINTS);
        let of_run = |name: &str| {
            let rest = name.strip_prefix(&within);
            rest.is_some_and(|rest| rest.starts_with('/'))
        };
        list.remove(&self.folder.path, of_run)
    }
}
