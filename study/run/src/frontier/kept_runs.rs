//! Runs of a frontier that are kept in its results folder, each as soon as it is done, so that a frontier that was stopped goes on, and
//! one with another target or budget begins with what is there.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stosszahl_results::{Existing, Folder, Keys, ResultsError, RunId};

use super::measure::RunRecord;
use super::{FrontierError, Options};
use crate::journal::{Journal, JournalOwner};
use crate::plan::Plan;
use crate::point::as_json;
use crate::run::start_file;

/// Name of the journal of runs inside the results folder.
const JOURNAL_FILE: &str = "runs.journal";
/// Time between two moments at which the system must have written the journal \[s\].
const SYNC_SECONDS: f64 = 30.0;
/// Keys of the case that change no run of a setting.
const KEYS: Keys<'static> = Keys {
    ignored: &["run.checkpoint_seconds"],
    output: &["title", "verdict", "replicas"],
};

/// Key of a run: its engine, system size and replica as bytes.
pub(crate) type RunKey = Vec<u8>;

/// Results folder of a frontier, held by this process, with its kept runs.
pub(crate) struct KeptRuns {
    folder: Arc<Folder>,
    journal: Journal,
    known: Mutex<BTreeMap<RunKey, RunRecord>>,
}

impl KeptRuns {
    /// Makes the results folder of a frontier, or finds the one of the same case, and reads the runs that are kept there.
    ///
    /// # Errors
    /// [`FrontierError::Results`] if the folder is of something else or another process writes there; [`FrontierError::Kept`] if its
    /// journal is damaged.
    pub(crate) fn open(plan: &Plan, options: &Options<'_>) -> Result<Self, FrontierError> {
        let path = &options.folder;
        let existing = match (options.force, path.join("run.json").exists()) {
            (true, _) => Existing::Replace,
            (false, true) => Existing::Resume,
            (false, false) => Existing::Refuse,
        };
        let start = start_file(plan);
        let inputs: Vec<&Path> = start.iter().map(PathBuf::as_path).collect();
        let mut case = as_json(plan);
        // A run of the same case is something else.
        case["frontier"] = true.into();
        let run = RunId::new("", &case, KEYS, &inputs)?;
        let folder = Folder::open(path, existing, &inputs, vec![run])?;
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
        let file = folder.claim(JOURNAL_FILE)?;
        let (journal, entries) =
            Journal::open(&file, owner, SYNC_SECONDS).map_err(FrontierError::Kept)?;
        let mut known = BTreeMap::new();
        for (_, bytes) in entries {
            let entry = postcard::from_bytes::<(RunKey, RunRecord)>(&bytes);
            let (key, record) = entry.map_err(|error| FrontierError::Runs {
                what: "kept runs cannot be read",
                reason: format!("{}: {error}", file.display()),
            })?;
            known.insert(key, record);
        }
        Ok(Self {
            folder: Arc::new(folder),
            journal,
            known: Mutex::new(known),
        })
    }

    /// The results folder.
    pub(crate) fn folder(&self) -> &Arc<Folder> {
        &self.folder
    }

    fn known(&self) -> MutexGuard<'_, BTreeMap<RunKey, RunRecord>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a kept run; `None` if it was not made yet.
    pub(crate) fn find(&self, key: &RunKey) -> Option<RunRecord> {
        self.known().get(key).cloned()
    }

    /// Keeps a run.
    ///
    /// # Errors
    /// [`FrontierError::Results`] if the folder was moved; [`FrontierError::Write`] if the journal cannot be written.
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
        self.known().insert(key, record);
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
