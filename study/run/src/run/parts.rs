//! Runs in parts (`--part K/N`), each in a results folder of its own, and their merge, for machines
//! without a shared folder.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stosszahl_case::CaseFile;
use stosszahl_results::Folder;

use super::case_run::{Opened, prepare, require_memory_of_each, run_ids};
use super::error::RunError;
use super::options::RunOptions;
use super::replica_task::ReplicaTask;
use super::summary::RunSummary;
use crate::check::format;
use crate::journal::{Journal, JournalOwner};

/// Name of the file that describes the part in a results folder.
const PART_FILE: &str = "part.json";
/// Largest number of replicas that an error message lists.
const NAMED: usize = 5;

/// Part of a run: number K of N parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunPart {
    /// Number K of this part of the run, from 1.
    pub number: u32,
    /// Number N of parts into which the run is cut.
    pub of: u32,
}

impl FromStr for RunPart {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected K/N with K from 1 to N, as 2/5".to_owned();
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let number = number.trim().parse().map_err(|_| wrong())?;
        let of = of.trim().parse().map_err(|_| wrong())?;
        if (1..=of).contains(&number) {
            Ok(Self { number, of })
        } else {
            Err(wrong())
        }
    }
}

impl fmt::Display for RunPart {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "part {} of {}", self.number, self.of)
    }
}

/// Summary of a finished part: its folder and replicas.
#[derive(Clone, Debug)]
pub struct PartSummary {
    /// Results folder of the part, without tables.
    pub folder: PathBuf,
    /// Number of replicas that the part has run.
    pub replicas: usize,
    /// Number of replicas of the whole run.
    pub all: usize,
}

/// Case of a part, stored in its folder so that it can be merged without the case file.
#[derive(Debug, Serialize, Deserialize)]
struct PartCase {
    part: RunPart,
    path: PathBuf,
    text: String,
    settings: Vec<String>,
}

/// Runs the replicas of one part of a case into a results folder. `settings` are the overrides that
/// were applied to the case file. Replicas of all points are dealt out in turn.
///
/// # Errors
/// As [`crate::run_case`].
pub fn run_part(
    file: &CaseFile,
    settings: &[String],
    part: RunPart,
    options: &RunOptions<'_>,
) -> Result<PartSummary, RunError> {
    let (planned, threads) = prepare(file, options)?;
    require_memory_of_each(&planned, threads, 1, options)?;
    let opened = Opened::new(file, &planned, options)?;
    let jobs = opened.jobs(file, &planned, options);
    let case = PartCase {
        part,
        path: std::path::absolute(&file.path).unwrap_or_else(|_| file.path.clone()),
        text: file.text.clone(),
        settings: settings.to_vec(),
    };
    let text = serde_json::to_vec_pretty(&case)
        .map_err(|error| RunError::Incomplete(format!("{PART_FILE}: {error}")))?;
    opened.folder().write(PART_FILE, &text)?;
    let mut journals = Vec::new();
    let mut own: Vec<ReplicaTask> = Vec::new();
    let (mut number, mut replicas) = (0, 0);
    for job in &jobs {
        let (journal, there) = job.journal()?;
        for task in job.tasks() {
            let is_own = number % part.of as usize == part.number as usize - 1;
            number += 1;
            replicas += usize::from(is_own);
            if is_own && !there.contains_key(&task.replica) {
                own.push(task);
            }
        }
        journals.push(journal);
        job.begin();
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let done: Result<(), RunError> = pool.install(|| {
        own.into_par_iter().try_for_each(|task| {
            let job = &jobs[task.point];
            job.claim(task, 0)?;
            let folder = job.place.path();
            let guard = || job.place.folder().require_same();
            let left = job.context(&folder, &guard).work(task);
            if let Err(error) = &left
                && !error.is_of_gas()
            {
                return left.map(drop);
            }
            job.keep(&journals[task.point], task, &left)
        })
    });
    done?;
    for job in &jobs {
        options.progress.end_point(job.number);
    }
    Ok(PartSummary {
        folder: opened.folder().path().to_owned(),
        replicas,
        all: number,
    })
}

/// Reads the case that is stored in the folder of a part.
///
/// # Errors
/// [`RunError::Incomplete`] if the folder does not hold a part; [`RunError::Case`] if its case is
/// refused here.
pub fn read_part(folder: &Path) -> Result<CaseFile, RunError> {
    let path = folder.join(PART_FILE);
    let refused = |why: String| {
        let path = path.display();
        RunError::Incomplete(format!(
            "{path}: {why}; expected a folder that `stosszahl run CASE --part K/N` has made"
        ))
    };
    let text = std::fs::read_to_string(&path).map_err(|error| refused(error.to_string()))?;
    let case: PartCase = serde_json::from_str(&text).map_err(|error| refused(error.to_string()))?;
    Ok(format().from_text(&case.path, &case.text, &case.settings)?)
}

/// Merges the parts of a run into one results folder; the tables have the bytes of
/// [`crate::run_case`].
///
/// # Errors
/// As [`crate::run_case`]; and if a part is of another run, or replicas are missing.
pub fn merge_parts(
    file: &CaseFile,
    parts: &[PathBuf],
    options: &RunOptions<'_>,
) -> Result<RunSummary, RunError> {
    let (planned, _) = prepare(file, options)?;
    let ids = run_ids(&planned)?;
    for part in parts {
        Folder::require_runs(part, &ids)?;
    }
    let (mut left, mut missing) = (Vec::new(), Vec::new());
    for (one, id) in planned.iter().zip(&ids) {
        let (name, case) = (&id.name, &one.plan.case);
        let owner = JournalOwner {
            run: id.identity(),
            seed: case.seed,
        };
        let mut entries = BTreeMap::new();
        for part in parts {
            entries.extend(Journal::read_all(&part.join(name), owner)?);
        }
        let point = if name.is_empty() { "" } else { " of point " };
        let absent = (0..case.replicas).filter(|replica| !entries.contains_key(replica));
        missing.extend(absent.map(|replica| format!("{replica}{point}{name}")));
        left.push(entries);
    }
    if !missing.is_empty() {
        let more = missing.len().saturating_sub(NAMED);
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        missing.truncate(NAMED);
        return Err(RunError::Incomplete(format!(
            "no folder has replica {}{more}; run their part, or go on with it by --resume",
            missing.join(", ")
        )));
    }
    let opened = Opened::new(file, &planned, options)?;
    let jobs = opened.jobs(file, &planned, options);
    let mut points = Vec::new();
    for (job, mut entries) in jobs.iter().zip(left) {
        let (began, mut replicas) = (Instant::now(), Vec::new());
        for task in job.tasks() {
            if let Some(bytes) = entries.remove(&task.replica) {
                replicas.push(job.restore(task, &bytes)?);
            }
        }
        points.push(job.finish(replicas, began)?);
    }
    Ok(opened.summary(points))
}
