//! Journal of the runs of a frontier in its results folder, from which a stopped frontier resumes,
//! or one with another target or budget begins.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stosszahl_results::{
    Existing, Folder, FolderWorker, Keys, ResultsError, RunId, TaskClaim, TaskStates,
};

use super::run_record::RunRecord;
use super::{FrontierError, FrontierOptions};
use crate::journal::{Journal, JournalOwner};
use crate::plan::CasePlan;

/// Name of the journal of runs inside the results folder, for a process that works alone.
const JOURNAL_FILE: &str = "runs.journal";
/// Name of the task, among processes that share the folder, of writing the tables and the page.
const REPORT: &str = "report";
/// Longest time between two syncs of the journal to disk \[s\].
const SYNC_SECONDS: f64 = 30.0;
/// Case keys that do not change the runs of a frontier, such as titles and verdict rules.
const KEYS: Keys<'static> = Keys {
    ignored: &["run.checkpoint_seconds"],
    output: &["title", "verdict", "replicas"],
};

/// Key of a run in the journal: its setting and replica, serialized.
pub(crate) type RunKey = Vec<u8>;

/// Returns the name of the task of making a run, from its key.
pub(crate) fn task_of(key: &RunKey) -> String {
    format!("run-{}", &blake3::hash(key).to_hex()[..24])
}

/// Results folder of a frontier, locked by this process, with the runs stored in its journals.
pub(crate) struct KeptRuns {
    folder: Arc<Folder>,
    journal: Journal,
    owner: JournalOwner,
    known: Mutex<KnownRuns>,
}

/// Runs that were read from the journals, and the length of each journal at that time.
#[derive(Default)]
struct KnownRuns {
    runs: BTreeMap<RunKey, RunRecord>,
    ends: BTreeMap<PathBuf, u64>,
}

impl KeptRuns {
    /// Creates the results folder of a frontier, or opens that of the same case, and reads the runs
    /// stored in it.
    ///
    /// # Errors
    /// [`FrontierError::Results`] if the folder is of something else or another process writes
    /// there; [`FrontierError::Kept`] if its journal is damaged.
    pub(crate) fn open(
        plan: &CasePlan,
        options: &FrontierOptions<'_>,
    ) -> Result<Self, FrontierError> {
        let path = &options.folder;
        let existing = match (options.force, path.join("run.json").exists()) {
            (true, _) => Existing::Replace,
            (false, true) => Existing::Resume,
            (false, false) => Existing::Refuse,
        };
        let start = plan.start_path();
        let inputs: Vec<&Path> = start.iter().map(PathBuf::as_path).collect();
        let mut case = plan.case_json();
        // The added key tells a frontier's folder from that of a plain run of the case.
        case["frontier"] = true.into();
        let run = RunId::new("", &case, KEYS, &inputs)?;
        let folder = match options.join {
            Some(lost_after) => Folder::join(path, &inputs, vec![run], lost_after)?,
            None => Folder::open(path, existing, &inputs, vec![run])?,
        };
        if let Some(warning) = folder.warning() {
            (options.tell)(warning);
        }
        let mut places = folder.places();
        let run = places.next().map_or([0; 32], |place| *place.fingerprint());
        drop(places);
        let owner = JournalOwner {
            run,
            seed: plan.case.seed,
        };
        // Others read an entry as soon as its run is marked as done.
        let (name, sync) = match folder.worker() {
            Some(worker) => (format!("runs-{}.journal", worker.id()), 0.0),
            None => (JOURNAL_FILE.to_owned(), SYNC_SECONDS),
        };
        let file = folder.claim(&name)?;
        let (journal, _) = Journal::open(&file, owner, sync).map_err(FrontierError::Kept)?;
        let kept = Self {
            folder: Arc::new(folder),
            journal,
            owner,
            known: Mutex::default(),
        };
        kept.refresh()?;
        Ok(kept)
    }

    /// Reads the runs that were added to the journals since the last call.
    ///
    /// # Errors
    /// [`FrontierError::Kept`] if a journal is damaged.
    pub(crate) fn refresh(&self) -> Result<(), FrontierError> {
        let mut known = self.known();
        for path in Journal::find_all(self.folder.path()) {
            let end = known.ends.get(&path).copied().unwrap_or(0);
            let read = Journal::read_from(&path, self.owner, end);
            let (entries, end) = read.map_err(FrontierError::Kept)?;
            for (_, bytes) in entries {
                let entry = postcard::from_bytes::<(RunKey, RunRecord)>(&bytes);
                let (key, record) = entry.map_err(|error| FrontierError::Runs {
                    what: "kept runs cannot be read",
                    reason: format!("{}: {error}", path.display()),
                })?;
                known.runs.entry(key).or_insert(record);
            }
            known.ends.insert(path, end);
        }
        Ok(())
    }

    /// Returns the registration of this process in a shared folder; `None` if it works alone.
    pub(crate) fn worker(&self) -> Option<&FolderWorker> {
        self.folder.worker()
    }

    /// Reads the states of the tasks in the shared results folder: free, claimed, or finished.
    pub(crate) fn tasks(&self) -> TaskStates {
        TaskStates::read_claims(&self.folder.claims())
    }

    /// Claims a run for this process in the shared folder; `None` if another process has claimed
    /// it.
    ///
    /// # Errors
    /// [`FrontierError::Results`] if the file system cannot make links.
    pub(crate) fn claim(
        &self,
        worker: &FolderWorker,
        task: &str,
    ) -> Result<Option<TaskClaim>, FrontierError> {
        Ok(worker.claim(&self.folder.claims(), task)?)
    }

    /// Returns true if this process has to write the tables and the page.
    ///
    /// # Errors
    /// As [`Self::claim`].
    pub(crate) fn is_reporter(&self) -> Result<bool, FrontierError> {
        match self.worker() {
            Some(worker) => Ok(self.claim(worker, REPORT)?.is_some()),
            None => Ok(true),
        }
    }

    /// Returns the results folder of the frontier.
    pub(crate) fn folder(&self) -> &Arc<Folder> {
        &self.folder
    }

    fn known(&self) -> MutexGuard<'_, KnownRuns> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a run from the journals; `None` if it was not made yet.
    pub(crate) fn find_run(&self, key: &RunKey) -> Option<RunRecord> {
        self.known().runs.get(key).cloned()
    }

    /// Appends a run to the journal of this process.
    ///
    /// # Errors
    /// [`FrontierError::Results`] if the folder was moved; [`FrontierError::Write`] if the journal
    /// cannot be written.
    pub(crate) fn add(
        &self,
        replica: u64,
        key: RunKey,
        record: RunRecord,
    ) -> Result<(), FrontierError> {
        self.folder.require_same()?;
        let bytes = postcard::to_stdvec(&(&key, &record)).map_err(|error| FrontierError::Runs {
            what: "a run cannot be kept",
            reason: error.to_string(),
        })?;
        self.journal.add(replica, &bytes)?;
        if let Some(worker) = self.worker() {
            worker.mark_done(&self.folder.claims(), &task_of(&key))?;
        }
        self.known().runs.insert(key, record);
        Ok(())
    }

    /// Checks that the results folder is still at its path.
    ///
    /// # Errors
    /// [`ResultsError::Moved`].
    pub(crate) fn require_same(&self) -> Result<(), ResultsError> {
        self.folder.require_same()
    }
}
