//! Tasks of a run: each is one replica of one sweep point, with its start and all engines that run
//! from it.
//!
//! A task needs the plan of its point and a folder for its checkpoints. It yields the records of
//! its engines, as the checkpoint of a finished engine holds them, or the reason of its failure.
//! Both are kept as bytes in a journal ([`record`], [`TaskContext::restore`]), by threads of this
//! process and by other processes alike.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::shard_name;
use stosszahl_model::Interrupt;
use stosszahl_model::Particles;
use stosszahl_results::{CHECKPOINTS, ResultsError, RunPlace, copy_file};

use super::error::RunError;
use super::progress::Progress;
use crate::check::Planned;
use crate::control::{CheckpointFile, CheckpointOrigin, Content, Control, Set, WriteGuard};
use crate::engine_run::{Elsewhere, EngineRun, PartError, Saved, prepare};
use crate::engines::rank_group::RankGroup;
use crate::measure::CompletedRun;
use crate::plan::{CasePlan, EnginePlan};
use crate::start::{Preparation, StartReport, is_prepared};

/// Task of a run: one replica of one sweep point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReplicaTask {
    /// Index of the sweep point, from 0 in the order of the case.
    pub point: usize,
    /// Number of the replica, from 0.
    pub replica: u64,
    /// Number of earlier attempts by processes that were lost. Each attempt has its own checkpoint
    /// names, as a lost process may still write.
    pub attempt: u32,
}

/// Result of a finished replica: the report on its start, and its engines in the order of the plan.
pub(crate) type Replica = (Option<StartReport>, Vec<CompletedRun>);

/// Environment in which the tasks of a sweep point run.
#[derive(Clone, Copy)]
pub(crate) struct TaskContext<'a> {
    /// Resolved plan and measures of the point.
    pub planned: &'a Planned<'a>,
    /// Folder of the sweep point, for checkpoints.
    pub folder: &'a Path,
    /// Callback that returns an error if this process may no longer write checkpoints.
    pub guard: &'a WriteGuard<'a>,
    /// Group of processes over which each gas in cells is decomposed; `None` if this process holds
    /// gases alone.
    pub group: Option<&'a RankGroup>,
    /// Hash of the point's name and of all inputs that determine its numbers.
    pub fingerprint: &'a [u8; 32],
    /// Index of the point in progress reports.
    pub number: usize,
    /// Interrupt that stops the task within a second.
    pub stop: &'a Interrupt,
    /// Receiver of progress reports.
    pub progress: &'a dyn Progress,
}

/// Result of a task in its serialized form.
#[derive(Serialize, Deserialize)]
enum Record {
    Done(Option<StartReport>, Vec<Saved>),
    Failed(String, Elsewhere),
}

/// Returns the path of a checkpoint of one part of a task, inside the folder of the point.
fn checkpoint(task: ReplicaTask, part: &str) -> String {
    let ReplicaTask {
        replica, attempt, ..
    } = task;
    match attempt {
        0 => format!("{CHECKPOINTS}/replica-{replica}-{part}.snapshot"),
        _ => format!("{CHECKPOINTS}/replica-{replica}-{part}.attempt-{attempt}.snapshot"),
    }
}

/// Returns the names of the parts of a replica that have a checkpoint: the start, and the engines.
fn parts(plan: &CasePlan) -> impl Iterator<Item = &str> {
    let start = is_prepared(plan).then_some("start");
    start
        .into_iter()
        .chain(plan.engines.iter().map(|engine| engine.name))
}

/// Registers the files that a task may write in the list of files, and creates their folder. To be
/// called before the task begins. `processes` is the number of processes that write checkpoint
/// shards.
///
/// # Errors
/// [`ResultsError`] if the results folder cannot be written.
pub(crate) fn claim(
    place: RunPlace<'_>,
    plan: &CasePlan,
    task: ReplicaTask,
    processes: usize,
) -> Result<(), ResultsError> {
    parts(plan).try_for_each(|part| place.claim(&checkpoint(task, part)).map(drop))?;
    let is_in_cells = |engine: &&EnginePlan| engine.parameters().is_some();
    for engine in plan.engines.iter().filter(is_in_cells) {
        for stem in Set::ALL.map(|set| set.stem(&checkpoint(task, engine.name))) {
            (0..processes).try_for_each(|rank| place.claim(&shard_name(&stem, rank)).map(drop))?;
        }
    }
    Ok(())
}

/// Removes the checkpoints of a finished task. Files that cannot be removed are deleted at the end
/// of the run.
pub(crate) fn forget(folder: &Path, plan: &CasePlan, task: ReplicaTask) {
    for attempt in 0..=task.attempt {
        for part in parts(plan) {
            let _ = fs::remove_file(folder.join(checkpoint(ReplicaTask { attempt, ..task }, part)));
        }
    }
}

/// Renames the latest checkpoints of repeated tasks to the names of first attempts. To be called
/// while no other process works in the folder.
pub(crate) fn adopt(folder: &Path) {
    let checkpoints = folder.join(CHECKPOINTS);
    let mut latest: BTreeMap<String, (u32, PathBuf)> = BTreeMap::new();
    for entry in fs::read_dir(&checkpoints).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let attempt = name.to_str().and_then(|name| {
            let (first, attempt) = name.strip_suffix(".snapshot")?.split_once(".attempt-")?;
            Some((format!("{first}.snapshot"), attempt.parse::<u32>().ok()?))
        });
        let Some((first, attempt)) = attempt else {
            continue;
        };
        let known = latest.insert(first.clone(), (attempt, entry.path()));
        if let Some(other) = known {
            let (older, newer) = if other.0 < attempt {
                (other, (attempt, entry.path()))
            } else {
                ((attempt, entry.path()), other)
            };
            latest.insert(first, newer);
            let _ = fs::remove_file(older.1);
        }
    }
    for (first, (_, path)) in latest {
        // If it fails, the part resumes from the first attempt.
        let _ = fs::rename(path, checkpoints.join(first));
    }
}

/// Returns the indices under which progress reports list the parts of a task: its start, then its
/// engines.
pub(crate) fn numbers(plan: &CasePlan, task: ReplicaTask) -> std::ops::Range<usize> {
    let parts = plan.engines.len() + 1;
    let first = task.replica as usize * parts;
    first..first + parts
}

/// Estimates the computing time of a replica \[s\].
pub(crate) fn seconds(plan: &CasePlan) -> f64 {
    plan.engines.iter().map(|engine| plan.seconds(engine)).sum()
}

/// Serializes the result of a task, for a journal.
///
/// # Errors
/// If a record cannot be serialized, which is an error of the program.
pub(crate) fn record(left: &Result<Replica, RunError>) -> Result<Vec<u8>, postcard::Error> {
    let record = match left {
        Ok((report, engines)) => {
            let engines = engines.iter().map(CompletedRun::save);
            Record::Done(report.clone(), engines.collect::<Result<_, _>>()?)
        }
        Err(RunError::Replica { part, source, .. }) => {
            Record::Failed(part.clone(), Elsewhere::from_error(source))
        }
        Err(other) => Record::Failed("start".to_owned(), Elsewhere::other(other.to_string())),
    };
    postcard::to_stdvec(&record)
}

impl TaskContext<'_> {
    /// Runs a replica: its engines concurrently on the threads of the current pool, or one after
    /// the other if gases in cells are decomposed over processes.
    ///
    /// # Errors
    /// [`RunError::Replica`]; checkpoints stay.
    pub(crate) fn work(&self, task: ReplicaTask) -> Result<Replica, RunError> {
        let plan = &self.planned.plan;
        let failed = |part: &str, source: PartError| RunError::Replica {
            replica: task.replica,
            part: part.to_owned(),
            source: Box::new(source),
        };
        let first = numbers(plan, task).start;
        let (report, start) = if is_prepared(plan) {
            let made = self.start(task, first);
            let (report, start) = made.map_err(|error| failed("start", error))?;
            (Some(report), Some(start))
        } else {
            (None, None)
        };
        // The longest engines start first.
        let mut order: Vec<usize> = (0..plan.engines.len()).collect();
        order.sort_by(|&a, &b| {
            let seconds = |index: usize| plan.seconds(&plan.engines[index]);
            seconds(b).total_cmp(&seconds(a))
        });
        let one = |index| {
            let engine = &plan.engines[index];
            let run = self.engine(task, index, first + 1 + index, start.as_ref());
            Ok((index, run.map_err(|error| failed(engine.name, error))?))
        };
        let mut runs: Vec<(usize, CompletedRun)> = if self.group.is_some() {
            order
                .into_iter()
                .map(one)
                .collect::<Result<_, RunError>>()?
        } else {
            (order.into_par_iter().map(one)).collect::<Result<_, RunError>>()?
        };
        runs.sort_by_key(|(index, _)| *index);
        Ok((report, runs.into_iter().map(|(_, run)| run).collect()))
    }

    /// Returns the path of the checkpoint of one part of a task. A repeated task resumes from a
    /// copy of the latest attempt.
    fn checkpoint(&self, task: ReplicaTask, part: &str) -> PathBuf {
        let path = self.folder.join(checkpoint(task, part));
        if !path.exists() {
            let mut before = (0..task.attempt).rev().map(|attempt| {
                let left = checkpoint(ReplicaTask { attempt, ..task }, part);
                self.folder.join(left)
            });
            if let Some(left) = before.find(|left| left.exists()) {
                // After a failed copy the part begins anew.
                let _ = copy_file(&left, &path);
            }
        }
        path
    }

    fn control<'c, T: Content>(
        &'c self,
        task: ReplicaTask,
        part: &str,
        tell: &'c (dyn Fn(f64, u64) + Sync),
    ) -> Control<'c, T> {
        let case = &self.planned.plan.case;
        let file = CheckpointFile {
            path: self.checkpoint(task, part),
            run: *self.fingerprint,
            origin: CheckpointOrigin {
                replica: task.replica,
                part: part.to_owned(),
                seed: case.seed,
            },
            guard: Some(self.guard),
        };
        Control::new(Some(file), case.run.checkpoint_seconds, self.stop, tell)
    }

    /// Creates the equilibrated start of a replica, or reads it from its checkpoint.
    fn start(&self, task: ReplicaTask, part: usize) -> Result<(StartReport, Particles), PartError> {
        let tell = |share, collisions| {
            self.progress
                .tell_share(self.number, part, share, collisions);
        };
        let control: Control<'_, Preparation> = self.control(task, "start", &tell);
        prepare(&self.planned.plan, task.replica, &control)
    }

    fn engine(
        &self,
        task: ReplicaTask,
        index: usize,
        number: usize,
        start: Option<&Particles>,
    ) -> Result<CompletedRun, PartError> {
        if self.stop.is_raised() {
            return Err(PartError::Interrupted);
        }
        let tell = |share, collisions| {
            self.progress
                .tell_share(self.number, number, share, collisions);
        };
        let busy = |activity: &str| self.progress.tell_activity(self.number, number, activity);
        let part = self.part(task.replica, index, start);
        let control = self.control(task, part.engine.name, &tell);
        part.run_in(&control.with_activity(&busy), self.group)
    }

    fn part<'p>(
        &'p self,
        replica: u64,
        index: usize,
        start: Option<&'p Particles>,
    ) -> EngineRun<'p> {
        let plan = &self.planned.plan;
        EngineRun {
            plan,
            engine: &plan.engines[index],
            measures: &self.planned.measures,
            replica,
            start,
        }
    }

    /// Restores the result of a task from its serialized record.
    ///
    /// # Errors
    /// The error of the task, if it failed; otherwise that its record cannot be read.
    pub(crate) fn restore(&self, task: ReplicaTask, bytes: &[u8]) -> Result<Replica, RunError> {
        let failed = |part: String, source: PartError| RunError::Replica {
            replica: task.replica,
            part,
            source: Box::new(source),
        };
        let plan = &self.planned.plan;
        match postcard::from_bytes(bytes) {
            Ok(Record::Done(report, engines)) if engines.len() == plan.engines.len() => {
                let engines = engines.into_iter().enumerate().map(|(index, saved)| {
                    let name = plan.engines[index].name;
                    let part = self.part(task.replica, index, None);
                    part.restore(saved)
                        .map_err(|error| failed(name.to_owned(), error))
                });
                Ok((report, engines.collect::<Result<_, _>>()?))
            }
            Ok(Record::Done(..)) => Err(failed(
                String::new(),
                postcard::Error::DeserializeBadEncoding.into(),
            )),
            Ok(Record::Failed(part, why)) => Err(failed(part, PartError::Elsewhere(why))),
            Err(error) => Err(failed(String::new(), error.into())),
        }
    }
}
