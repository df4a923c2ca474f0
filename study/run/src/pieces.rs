//! The pieces that the work of a run is cut into, and where what they leave is put: the same for threads of this process and
//! for other processes.
//!
//! A piece is one replica of one point: its start, and all engines that run from it. It needs the plan of the point and a
//! folder for its checkpoints. What it leaves are its records, as a checkpoint of a finished part holds them, or why it failed;
//! both can be sent as bytes ([`record`], [`Desk::restore`]). Whoever holds the results folder puts them together.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::shard_name;
use stosszahl_model::Interrupt;
use stosszahl_model::Particles;
use stosszahl_results::{CHECKPOINTS, Place, ResultsError, copy_file};

use crate::check::Planned;
use crate::control::{
    CheckpointFile, CheckpointOrigin, Content, Control, Progress, Set, WriteGuard,
};
use crate::follow::{Elsewhere, Part, PartError, Saved, prepare};
use crate::holders::Holders;
use crate::measure::Finished;
use crate::plan::{EngineKind, EnginePlan, Plan};
use crate::run::RunError;
use crate::start::{Preparation, StartReport, is_prepared};

/// One replica of one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Piece {
    /// The point, from 0 in the order of the case.
    pub point: usize,
    /// The replica, from 0.
    pub replica: u64,
    /// How often it was begun before by a process that was lost. What that one still writes must not meet what this one writes.
    pub attempt: u32,
}

/// What a finished replica leaves: how it started, and its engines in the order of the plan.
pub(crate) type Replica = (Option<StartReport>, Vec<Finished>);

/// Where the pieces of a point are worked on.
#[derive(Clone, Copy)]
pub(crate) struct Desk<'a> {
    /// The point.
    pub planned: &'a Planned<'a>,
    /// Its folder.
    pub folder: &'a Path,
    /// Says whether checkpoints may still be written; `None` if another process holds the folder.
    pub guard: Option<&'a WriteGuard<'a>>,
    /// Hash of all that decides the numbers, and of the point.
    pub fingerprint: &'a [u8; 32],
    /// Its number, for the progress.
    pub number: usize,
    /// Raised to stop within a second.
    pub stop: &'a Interrupt,
    /// Who sees the progress.
    pub progress: &'a dyn Progress,
}

/// A piece as bytes.
#[derive(Serialize, Deserialize)]
enum Record {
    Done(Option<StartReport>, Vec<Saved>),
    Failed(String, Elsewhere),
}

/// The checkpoint of a part of a piece, within the folder of the point.
fn checkpoint(piece: Piece, part: &str) -> String {
    let Piece {
        replica, attempt, ..
    } = piece;
    match attempt {
        0 => format!("{CHECKPOINTS}/replica-{replica}-{part}.snapshot"),
        _ => format!("{CHECKPOINTS}/replica-{replica}-{part}.attempt-{attempt}.snapshot"),
    }
}

/// The parts of a replica that have a checkpoint.
fn parts(plan: &Plan) -> impl Iterator<Item = &str> {
    let start = is_prepared(plan).then_some("start");
    start
        .into_iter()
        .chain(plan.engines.iter().map(|engine| engine.name))
}

/// Notes the files that a piece may write, and makes their folder. To be called before it is begun, here or elsewhere. So many
/// processes write shards of its gases in cells.
///
/// # Errors
/// [`ResultsError`] if the results folder cannot be written.
pub(crate) fn claim(
    place: Place<'_>,
    plan: &Plan,
    piece: Piece,
    processes: usize,
) -> Result<(), ResultsError> {
    parts(plan).try_for_each(|part| place.claim(&checkpoint(piece, part)).map(drop))?;
    let in_cells = |engine: &&EnginePlan| matches!(engine.kind, EngineKind::MonteCarlo(_));
    for engine in plan.engines.iter().filter(in_cells) {
        for stem in Set::ALL.map(|set| set.stem(&checkpoint(piece, engine.name))) {
            (0..processes).try_for_each(|rank| place.claim(&shard_name(&stem, rank)).map(drop))?;
        }
    }
    Ok(())
}

/// Removes the checkpoints of a piece that is finished. What cannot be removed goes with the run.
pub(crate) fn forget(folder: &Path, plan: &Plan, piece: Piece) {
    for attempt in 0..=piece.attempt {
        for part in parts(plan) {
            let _ = fs::remove_file(folder.join(checkpoint(Piece { attempt, ..piece }, part)));
        }
    }
}

/// Gives the latest checkpoints of pieces that were begun again the names of first attempts. To be called while no other process works in
/// the folder.
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
        // Without it the part goes on from the first attempt.
        let _ = fs::rename(path, checkpoints.join(first));
    }
}

/// The numbers of the parts of a piece in the progress: its start, then its engines.
pub(crate) fn numbers(plan: &Plan, piece: Piece) -> std::ops::Range<usize> {
    let parts = plan.engines.len() + 1;
    let first = piece.replica as usize * parts;
    first..first + parts
}

/// Computing time of a replica, about \[s\].
pub(crate) fn seconds(plan: &Plan) -> f64 {
    plan.engines.iter().map(|engine| plan.seconds(engine)).sum()
}

/// What a piece left, as bytes.
///
/// # Errors
/// If a record cannot be written, which is an error of the program.
pub(crate) fn record(left: &Result<Replica, RunError>) -> Result<Vec<u8>, postcard::Error> {
    let record = match left {
        Ok((report, engines)) => {
            let engines = engines.iter().map(Finished::save);
            Record::Done(report.clone(), engines.collect::<Result<_, _>>()?)
        }
        Err(RunError::Replica { part, source, .. }) => {
            Record::Failed(part.clone(), Elsewhere::of(source))
        }
        Err(other) => Record::Failed("start".to_owned(), Elsewhere::other(other.to_string())),
    };
    postcard::to_stdvec(&record)
}

impl Desk<'_> {
    /// Does a piece: the engines side by side, on the threads of the present pool.
    ///
    /// # Errors
    /// [`RunError::Replica`]; checkpoints stay.
    pub(crate) fn work(&self, piece: Piece) -> Result<Replica, RunError> {
        self.work_among(piece, None)
    }

    /// The same where several processes hold each gas in cells: one engine after the other.
    ///
    /// # Errors
    /// As [`Self::work`].
    pub(crate) fn work_among(
        &self,
        piece: Piece,
        holders: Option<&Holders>,
    ) -> Result<Replica, RunError> {
        let plan = &self.planned.plan;
        let failed = |part: &str, source: PartError| RunError::Replica {
            replica: piece.replica,
            part: part.to_owned(),
            source: Box::new(source),
        };
        let first = numbers(plan, piece).start;
        let (report, start) = if is_prepared(plan) {
            let made = self.start(piece, first);
            let (report, start) = made.map_err(|error| failed("start", error))?;
            (Some(report), Some(start))
        } else {
            (None, None)
        };
        // The longest first.
        let mut order: Vec<usize> = (0..plan.engines.len()).collect();
        order.sort_by(|&a, &b| {
            let seconds = |index: usize| plan.seconds(&plan.engines[index]);
            seconds(b).total_cmp(&seconds(a))
        });
        let one = |index| {
            let engine = &plan.engines[index];
            let run = self.engine(piece, index, first + 1 + index, start.as_ref(), holders);
            Ok((index, run.map_err(|error| failed(engine.name, error))?))
        };
        let mut runs: Vec<(usize, Finished)> = if holders.is_some() {
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

    /// The checkpoint of a part. A piece that is begun again goes on from a copy of what was left.
    fn checkpoint(&self, piece: Piece, part: &str) -> PathBuf {
        let path = self.folder.join(checkpoint(piece, part));
        if !path.exists() {
            let mut before = (0..piece.attempt).rev().map(|attempt| {
                let left = checkpoint(Piece { attempt, ..piece }, part);
                self.folder.join(left)
            });
            if let Some(left) = before.find(|left| left.exists()) {
                // Without it the part begins anew.
                let _ = copy_file(&left, &path);
            }
        }
        path
    }

    fn control<'c, T: Content>(
        &'c self,
        piece: Piece,
        part: &str,
        tell: &'c (dyn Fn(f64, u64) + Sync),
    ) -> Control<'c, T> {
        let case = &self.planned.plan.case;
        let file = CheckpointFile {
            path: self.checkpoint(piece, part),
            run: *self.fingerprint,
            origin: CheckpointOrigin {
                replica: piece.replica,
                part: part.to_owned(),
                seed: case.seed,
            },
            guard: self.guard,
        };
        Control::new(Some(file), case.run.checkpoint_seconds, self.stop, tell)
    }

    /// The start of a replica, equilibrated.
    fn start(&self, piece: Piece, part: usize) -> Result<(StartReport, Particles), PartError> {
        let tell = |share, collisions| self.progress.tell(self.number, part, share, collisions);
        let control: Control<'_, Preparation> = self.control(piece, "start", &tell);
        prepare(&self.planned.plan, piece.replica, &control)
    }

    fn engine(
        &self,
        piece: Piece,
        index: usize,
        number: usize,
        start: Option<&Particles>,
        holders: Option<&Holders>,
    ) -> Result<Finished, PartError> {
        if self.stop.is_raised() {
            return Err(PartError::Interrupted);
        }
        let tell = |share, collisions| self.progress.tell(self.number, number, share, collisions);
        let busy = |activity: &str| self.progress.tell_activity(self.number, number, activity);
        let part = self.part(piece.replica, index, start);
        let control = self.control(piece, part.engine.name, &tell);
        part.run_among(&control.with_activity(&busy), holders)
    }

    fn part<'p>(&'p self, replica: u64, index: usize, start: Option<&'p Particles>) -> Part<'p> {
        let plan = &self.planned.plan;
        Part {
            plan,
            engine: &plan.engines[index],
            measures: &self.planned.measures,
            replica,
            start,
        }
    }

    /// What a piece left, here before or elsewhere, from its bytes.
    ///
    /// # Errors
    /// Why the piece failed, or that its record cannot be read.
    pub(crate) fn restore(&self, piece: Piece, bytes: &[u8]) -> Result<Replica, RunError> {
        let failed = |part: String, source: PartError| RunError::Replica {
            replica: piece.replica,
            part,
            source: Box::new(source),
        };
        let plan = &self.planned.plan;
        match postcard::from_bytes(bytes) {
            Ok(Record::Done(report, engines)) if engines.len() == plan.engines.len() => {
                let engines = engines.into_iter().enumerate().map(|(index, saved)| {
                    let name = plan.engines[index].name;
                    let part = self.part(piece.replica, index, None);
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
