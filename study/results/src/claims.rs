//! Task claims in a results folder shared by several processes.
//!
//! Each process has a file in the folder `claims`, which it rewrites periodically: its heartbeat. A
//! claim of a task is a hard link to that file under the name of the task, so that all claims of a
//! process share its heartbeat. Creating a link is atomic, also on network file systems, and fails
//! if the name is taken. All links are in one folder, as some file systems have none between
//! folders. No claim is removed or replaced while the task is open: the claim of a process that
//! died is superseded by one with the next number.
//!
//! | name | content |
//! |---|---|
//! | `worker-ID` | heartbeat of a process |
//! | `ID.files` | files that this process has written |
//! | `TASK.N` | claim of a task, after N claims of processes that died |
//! | `TASK.done` | end of a task |
//!
//! Times are those of the file system: the age of a claim is the difference between its
//! modification time and that of the process's own file, which has just been written. A dead
//! process of the same machine is detected at once, as the lock on its file is released.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use crate::error::ResultsError;
use crate::list::is_same_file;

/// Name of the folder of claims inside the results folder of a run.
pub const CLAIMS: &str = "claims";
/// Prefix of the heartbeat file of a process.
const WORKER: &str = "worker-";
/// Suffix of the file list of a process.
pub(crate) const LIST_ENDING: &str = ".files";
/// Suffix of the file that marks a finished task.
const DONE: &str = "done";
/// Number of heartbeats in the time after which a silent process counts as lost.
const BEATS: u32 = 8;
/// Longest time between two heartbeats.
const LONGEST_BEAT: Duration = Duration::from_secs(5);
/// Number of characters for the machine's identity in the heartbeat file of a process; the count of
/// heartbeats follows.
const MACHINE_WIDTH: usize = 80;

/// State of the process that holds a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holder {
    /// This process holds the claim.
    Own,
    /// Another process holds the claim, and its heartbeat is recent.
    Alive,
    /// The process that holds the claim has ended, or has had no heartbeat for too long.
    Lost,
}

/// Claim of a task by this process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskClaim {
    folder: PathBuf,
    task: String,
    /// Number of earlier claims of the task, by processes that died.
    pub generation: u32,
}

impl TaskClaim {
    fn path(&self) -> PathBuf {
        claim_path(&self.folder, &self.task, self.generation)
    }
}

/// Registration of this process among all that work in a results folder. Dropping the value
/// deregisters it.
#[derive(Debug)]
pub struct FolderWorker {
    /// Path of the folder with the claims of all processes.
    folder: PathBuf,
    id: String,
    pulse: Arc<Pulse>,
    patience: Duration,
    machine: String,
    /// Channel sender; dropping it ends the heartbeat thread.
    end: Option<Sender<()>>,
    beats: Option<JoinHandle<()>>,
}

/// Heartbeat file of a process, and the time of its last write.
#[derive(Debug)]
struct Pulse {
    file: Mutex<(File, u64)>,
    last: Mutex<Option<Instant>>,
}

impl Pulse {
    /// Writes the heartbeat file, so that the file system's clock sets its modification time.
    fn write_heartbeat(&self) -> io::Result<()> {
        let mut locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, count) = &mut *locked;
        *count += 1;
        file.seek(SeekFrom::Start(MACHINE_WIDTH as u64 + 1))?;
        file.write_all(format!("{count:>20}\n").as_bytes())?;
        file.sync_data()?;
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
        Ok(())
    }

    /// Returns the current time by the clock of the file system, accurate to `within`.
    fn now(&self, within: Duration) -> io::Result<SystemTime> {
        let last = *self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_none_or(|last| last.elapsed() > within) {
            self.write_heartbeat()?;
        }
        self.metadata()?.modified()
    }

    fn metadata(&self) -> io::Result<fs::Metadata> {
        let locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        locked.0.metadata()
    }
}

fn claim_path(folder: &Path, task: &str, generation: u32) -> PathBuf {
    folder.join(format!("{task}.{generation}"))
}

/// Returns the identity of this machine since its boot; `None` if the system does not provide one.
fn machine_id() -> Option<String> {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let boot = boot.trim();
    let known = !boot.is_empty() && boot.len() <= MACHINE_WIDTH;
    (known && boot.is_ascii()).then(|| boot.to_owned())
}

/// Creates a name that no other process has, for its heartbeat file.
pub(crate) fn unique_id() -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut hash = blake3::Hasher::new();
    hash.update(machine_id().unwrap_or_default().as_bytes());
    hash.update(&std::process::id().to_le_bytes());
    hash.update(&COUNT.fetch_add(1, Ordering::Relaxed).to_le_bytes());
    if let Ok(time) = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH) {
        hash.update(&time.as_nanos().to_le_bytes());
    }
    hash.finalize().to_hex()[..16].to_owned()
}

impl FolderWorker {
    /// Registers this process in a results folder. A process without a heartbeat for `patience`
    /// counts as lost.
    ///
    /// # Errors
    /// [`ResultsError::System`] if the folder cannot be written.
    pub(crate) fn register(results: &Path, patience: Duration) -> Result<Self, ResultsError> {
        let period = (patience / BEATS).min(LONGEST_BEAT);
        Self::register_beating(results, patience, Some(period))
    }

    /// Registers this process with a given period of heartbeats; with `None`, it writes a single
    /// one.
    fn register_beating(
        results: &Path,
        patience: Duration,
        period: Option<Duration>,
    ) -> Result<Self, ResultsError> {
        let folder = results.join(CLAIMS);
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| ResultsError::system(&path, "written")(source)
        };
        fs::create_dir_all(&folder).map_err(failed(&folder))?;
        let id = unique_id();
        let machine = machine_id().unwrap_or_default();
        // Hidden until it is locked, since an unlocked file counts as that of a dead process.
        let (hidden, path) = (
            folder.join(format!(".{id}")),
            folder.join(format!("{WORKER}{id}")),
        );
        let open = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&hidden);
        let mut file = open.map_err(failed(&hidden))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {}
            Err(error) => return Err(failed(&hidden)(error.into())),
        }
        let written = file.write_all(format!("{machine:<MACHINE_WIDTH$}\n").as_bytes());
        written.map_err(failed(&hidden))?;
        let pulse = Arc::new(Pulse {
            file: Mutex::new((file, 0)),
            last: Mutex::new(None),
        });
        pulse.write_heartbeat().map_err(failed(&hidden))?;
        fs::rename(&hidden, &path).map_err(failed(&path))?;
        let (end, ended) = channel::<()>();
        let beats = period.map(|period| {
            let beating = pulse.clone();
            thread::spawn(move || {
                while ended.recv_timeout(period) == Err(RecvTimeoutError::Timeout) {
                    // A full disk or an unavailable server; the next heartbeat may succeed.
                    let _ = beating.write_heartbeat();
                }
            })
        });
        Ok(Self {
            folder,
            id,
            pulse,
            patience,
            machine,
            end: Some(end),
            beats,
        })
    }

    /// Returns the unique name of this process, made of letters and digits.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Returns the path of the list of files that this process has written.
    pub(crate) fn list_path(&self) -> PathBuf {
        self.folder.join(format!("{}{LIST_ENDING}", self.id))
    }

    /// Returns the state of the process that holds a claim; `None` if there is no such claim.
    fn claim_holder(&self, claim: &Path) -> io::Result<Option<Holder>> {
        let open = OpenOptions::new().read(true).write(true).open(claim);
        let mut file = match open {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            other => other?,
        };
        let theirs = file.metadata()?;
        if is_same_file(&theirs, &self.pulse.metadata()?) {
            return Ok(Some(Holder::Own));
        }
        let mut text = Vec::new();
        file.read_to_end(&mut text)?;
        let line = text.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let is_here = !self.machine.is_empty() && line.trim_ascii() == self.machine.as_bytes();
        if is_here && file.try_lock().is_ok() {
            let _ = file.unlock();
            return Ok(Some(Holder::Lost));
        }
        let now = self.pulse.now(self.patience / BEATS)?;
        // A modification time in the future counts as alive.
        let age = now.duration_since(theirs.modified()?).unwrap_or_default();
        Ok(Some(if age > self.patience {
            Holder::Lost
        } else {
            Holder::Alive
        }))
    }

    /// Claims a task for this process if it is free or its holder is lost; `None` if another
    /// process holds it.
    ///
    /// # Errors
    /// [`ResultsError::System`] if the file system cannot make links.
    pub fn claim(&self, folder: &Path, task: &str) -> Result<Option<TaskClaim>, ResultsError> {
        let mut claim = TaskClaim {
            folder: folder.to_owned(),
            task: task.to_owned(),
            generation: 0,
        };
        let failed = |path: &Path, source| ResultsError::system(path, "written")(source);
        loop {
            let path = claim.path();
            let Some(holder) = self
                .claim_holder(&path)
                .map_err(|error| failed(&path, error))?
            else {
                break;
            };
            let next = claim_path(folder, task, claim.generation + 1);
            if holder != Holder::Lost && !next.exists() {
                return Ok(None);
            }
            claim.generation += 1;
        }
        let path = claim.path();
        if cfg!(not(unix)) {
            let source = ErrorKind::Unsupported.into();
            return Err(ResultsError::Links { path, source });
        }
        let own = self.folder.join(format!("{WORKER}{}", self.id));
        match fs::hard_link(&own, &path) {
            Ok(()) => Ok(Some(claim)),
            // The reply of a server may be lost, and the link be created twice.
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                Ok(self.holds(&claim).then_some(claim))
            }
            // The run is finished, and its claims are removed.
            Err(error) if error.kind() == ErrorKind::NotFound && !folder.exists() => Ok(None),
            Err(error) => Err(ResultsError::Links {
                path,
                source: error,
            }),
        }
    }

    /// Returns true if this process still holds the claimed task and no other has taken it over.
    pub fn holds(&self, claim: &TaskClaim) -> bool {
        let next = claim_path(&claim.folder, &claim.task, claim.generation + 1);
        let own = match (fs::metadata(claim.path()), self.pulse.metadata()) {
            (Ok(there), Ok(own)) => is_same_file(&there, &own),
            _ => false,
        };
        own && !next.exists()
    }

    /// Marks a claimed task as finished. Its results must be written before.
    ///
    /// # Errors
    /// [`ResultsError::System`] if the mark cannot be made.
    pub fn mark_done(&self, folder: &Path, task: &str) -> Result<(), ResultsError> {
        let path = folder.join(format!("{task}.{DONE}"));
        match File::create_new(&path) {
            Ok(_) => Ok(()),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
            // The run is finished, and its claims are removed.
            Err(error) if error.kind() == ErrorKind::NotFound && !folder.exists() => Ok(()),
            Err(error) => Err(ResultsError::system(&path, "written")(error)),
        }
    }

    /// Returns true if another process is alive in the results folder.
    ///
    /// # Errors
    /// [`ResultsError::System`] if the folder of claims cannot be read.
    pub(crate) fn find_other(&self) -> Result<bool, ResultsError> {
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let is_worker = |name: &str| name.starts_with(WORKER);
            if !entry.file_name().to_str().is_some_and(is_worker) {
                continue;
            }
            let path = entry.path();
            let holder = self.claim_holder(&path);
            let holder = holder.map_err(ResultsError::system(&path, "read"))?;
            if holder == Some(Holder::Alive) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

impl Drop for FolderWorker {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(beats) = self.beats.take() {
            let _ = beats.join();
        }
        let locked = self
            .pulse
            .file
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        // As for the file list: a child process may have a copy of the open file.
        let _ = locked.0.unlock();
        let _ = fs::remove_file(self.folder.join(format!("{WORKER}{}", self.id)));
        // The last process to leave a finished run removes the folder.
        let _ = fs::remove_dir(&self.folder);
    }
}

/// Snapshot of a folder of claims: which tasks are claimed and which are finished.
#[derive(Clone, Debug, Default)]
pub struct TaskStates {
    names: std::collections::BTreeSet<String>,
}

impl TaskStates {
    /// Reads which tasks are claimed and finished in a folder of claims.
    pub fn read_claims(folder: &Path) -> Self {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        Self {
            names: names.collect(),
        }
    }

    /// Returns true if a task is marked as finished.
    pub fn is_done(&self, task: &str) -> bool {
        self.names.contains(&format!("{task}.{DONE}"))
    }

    /// Returns true if some process has claimed a task.
    pub fn is_claimed(&self, task: &str) -> bool {
        self.names.contains(&format!("{task}.0"))
    }
}

fn is_id(text: &str) -> bool {
    text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// Returns true if the name of a file in a folder of claims is that of a heartbeat file. While it
/// is not locked yet, the file has a hidden name.
fn is_of_worker(name: &str) -> bool {
    name.starts_with(WORKER) || name.strip_prefix('.').is_some_and(is_id)
}

/// Returns true if the name of a file in a folder of claims is a claim, or the mark of a finished
/// task.
fn is_of_task(name: &str) -> bool {
    let Some((task, end)) = name.rsplit_once('.') else {
        return false;
    };
    !task.is_empty() && (end == DONE || end.parse::<u32>().is_ok())
}

/// Removes the claims of finished tasks whose names begin with `prefix`.
pub(crate) fn remove_claims(folder: &Path, prefix: &str) {
    let is_one = |name: &str| name.starts_with(prefix) && is_of_task(name);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(is_one) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

impl FolderWorker {
    /// Removes the heartbeat files of lost processes from the folder of claims.
    pub(crate) fn remove_lost(&self) {
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            if entry.file_name().to_str().is_some_and(is_of_worker)
                && matches!(self.claim_holder(&entry.path()), Ok(Some(Holder::Lost)))
            {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Lists the paths of the file lists of all processes in the folder of claims.
pub(crate) fn lists(results: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(results.join(CLAIMS)).into_iter().flatten();
    let is_list = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.ends_with(LIST_ENDING))
    };
    let paths = entries.flatten().map(|entry| entry.path());
    paths.filter(is_list).collect()
}

/// Removes the heartbeat files of dead processes from a folder of claims. Call it while no other
/// process works in the folder.
pub(crate) fn remove_workers(results: &Path) {
    let folder = results.join(CLAIMS);
    for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_ours = |name: &str| {
            let list = name.strip_suffix(LIST_ENDING);
            is_of_worker(name) || list.is_some_and(is_id) || is_of_task(name)
        };
        if name.to_str().is_some_and(is_ours) {
            let _ = fs::remove_file(entry.path());
        }
    }
    let _ = fs::remove_dir(&folder);
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_hours(1);

    /// Of many processes one holds a task; when it ends, one other takes over, and the first holds
    /// it no more.
    #[test]
    fn one_of_many_has_a_task() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join(CLAIMS);
        let register = || FolderWorker::register(place.path(), LONG).expect("registered");
        let mut workers: Vec<FolderWorker> = (0..6).map(|_| register()).collect();
        for generation in 0..4 {
            let claims: Vec<Option<TaskClaim>> = thread::scope(|scope| {
                let tries: Vec<_> = (workers.iter())
                    .map(|worker| scope.spawn(|| worker.claim(&folder, "replica-3")))
                    .collect();
                let ended = tries.into_iter().map(|one| one.join().expect("an end"));
                ended.map(|claim| claim.expect("links")).collect()
            });
            let holders: Vec<usize> = (0..workers.len())
                .filter(|&one| claims[one].is_some())
                .collect();
            let [holder] = holders[..] else {
                panic!("{holders:?} have it");
            };
            let claim = claims[holder].clone().expect("a claim");
            assert_eq!(claim.generation, generation);
            assert!(workers[holder].holds(&claim));
            // The end of the holder is detected at once, as its lock is released.
            drop(workers.remove(holder));
            if let Some(other) = workers.first() {
                assert!(!other.holds(&claim));
            }
        }
        assert!(!TaskStates::read_claims(&folder).is_done("replica-3"));
        workers[0].mark_done(&folder, "replica-3").expect("marked");
        let states = TaskStates::read_claims(&folder);
        assert!(states.is_done("replica-3") && states.is_claimed("replica-3"));
        assert!(!states.is_claimed("replica-4"));
    }

    /// A suspended process counts as lost when its file is older than the patience by the folder's
    /// clock, and not before; it then no longer holds its claims.
    #[test]
    fn a_process_that_stands_still_is_lost() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join(CLAIMS);
        let [first, second] = [0, 1]
            .map(|_| FolderWorker::register_beating(place.path(), LONG, None).expect("registered"));
        let claim = first.claim(&folder, "a").expect("links").expect("free");
        let set_back = |age: Duration| {
            let now = second.pulse.now(LONG).expect("a time");
            let file = File::options().write(true).open(claim.path());
            let set = file.expect("a claim").set_modified(now - age);
            set.expect("set back");
        };
        set_back(Duration::from_mins(59));
        assert_eq!(second.claim(&folder, "a").expect("links"), None);
        assert!(first.holds(&claim) && second.find_other().expect("read"));
        set_back(LONG + Duration::from_mins(1));
        let taken = second.claim(&folder, "a").expect("links").expect("lost");
        assert_eq!(taken.generation, 1);
        assert!(second.holds(&taken) && !first.holds(&claim));
        assert!(!second.find_other().expect("read"));
        // The next heartbeat of the first process makes it alive again, but does not restore its
        // task.
        first.pulse.write_heartbeat().expect("a heartbeat");
        assert!(second.find_other().expect("read") && !first.holds(&claim));
        assert_eq!(first.claim(&folder, "a").expect("links"), None);
    }

    /// Processes that end normally leave no files, and no files of the user are removed.
    #[test]
    fn claims_are_removed_and_nothing_else() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join(CLAIMS);
        let worker = FolderWorker::register(place.path(), LONG).expect("registered");
        worker.claim(&folder, "a").expect("links").expect("free");
        worker.mark_done(&folder, "a").expect("marked");
        fs::write(folder.join("notes.txt"), "mine").expect("written");
        remove_claims(&folder, "");
        assert!(!folder.join("a.0").exists() && !folder.join("a.done").exists());
        drop(worker);
        assert!(folder.join("notes.txt").exists());
        fs::remove_file(folder.join("notes.txt")).expect("removed");
        drop(FolderWorker::register(place.path(), LONG).expect("registered"));
        assert!(!folder.exists());
    }
}
