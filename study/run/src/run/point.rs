//! One sweep point of a run: from the results of its replicas to tables, verdicts and the manifest.

use std::collections::BTreeMap;
use std::path::Path;
use std::thread;
use std::time::Instant;

use rayon::prelude::*;
use stosszahl_case::CaseFile;
use stosszahl_case::format::TimeUnit;
use stosszahl_results::{
    Derived, EngineWork, Existing, FORMAT, FramesEntry, Machine, Manifest, Program, RunPlace,
    RunQuestion, SNAPSHOTS, StartRecord, StartTest, Table, VerdictText, engine_title,
    format_percent,
};

use super::error::RunError;
use super::options::RunOptions;
use super::progress::ProgressEstimate;
use super::replica_task::{self, Replica, ReplicaTask, TaskContext};
use super::summary::PointSummary;
use crate::check::Planned;
use crate::check::question;
use crate::control::WriteGuard;
use crate::engine_run::PartError;
use crate::engines::rank_group::RankGroup;
use crate::journal::{self, Journal, JournalOwner};
use crate::judge;
use crate::measure::{CompletedRun, ReplicaRecords};
use crate::plan::CasePlan;
use crate::start::StartReport;

/// Share of collisions in cells whose contact value chi is limited, from which a warning is given.
const MANY_LIMITED: f64 = 0.1;

/// Sweep point of a run with its plan and its place in the results folder.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    /// Case file of the run.
    pub file: &'a CaseFile,
    /// Resolved plan and measures of the point.
    pub planned: &'a Planned<'a>,
    /// Location of the point's results in the results folder.
    pub place: RunPlace<'a>,
    /// Index of the sweep point.
    pub number: usize,
    /// Error probability of each verdict of the point.
    pub level: f64,
    /// Options of the run.
    pub options: &'a RunOptions<'a>,
}

/// Results of finished replicas, by replica number; an error for a replica whose gas failed.
pub(crate) type Left = BTreeMap<u64, Result<Replica, RunError>>;

/// Results of the replicas of a point in which no engine failed.
struct Done {
    /// Finished engine runs, by engine, then by replica.
    finished: Vec<Vec<CompletedRun>>,
    starts: Vec<StartRecord>,
    failed: Vec<RunError>,
}

impl Job<'_> {
    /// Returns the tasks of the point, one for each of its replicas.
    pub(crate) fn tasks(&self) -> impl Iterator<Item = ReplicaTask> + use<> {
        let point = self.number;
        (0..self.planned.plan.case.replicas).map(move |replica| ReplicaTask {
            point,
            replica,
            attempt: 0,
        })
    }

    /// Registers the files that a task may write in the list of files.
    ///
    /// # Errors
    /// [`RunError::Results`] if the folder cannot be written.
    pub(crate) fn claim(&self, task: ReplicaTask, processes: usize) -> Result<(), RunError> {
        Ok(replica_task::claim(
            self.place,
            &self.planned.plan,
            task,
            processes,
        )?)
    }

    /// Returns the environment in which tasks of the point run, with a folder for checkpoints.
    pub(crate) fn context<'d>(
        &'d self,
        folder: &'d Path,
        guard: &'d WriteGuard<'d>,
    ) -> TaskContext<'d> {
        TaskContext {
            planned: self.planned,
            folder,
            guard,
            group: None,
            fingerprint: self.place.fingerprint(),
            number: self.number,
            stop: self.options.stop,
            progress: self.options.progress,
        }
    }

    /// Returns the summary of a point that was complete before the run; `None` if it was not
    /// complete.
    ///
    /// # Errors
    /// [`RunError::Results`] if the folder cannot be read.
    pub(crate) fn complete(&self) -> Result<Option<PointSummary>, RunError> {
        if self.options.existing != Existing::Resume || !self.place.is_complete()? {
            return Ok(None);
        }
        self.place.remove_checkpoints()?;
        let warnings = self.planned.plan.notes.warnings.clone();
        Ok(Some(self.summary(
            true,
            Instant::now(),
            Vec::new(),
            warnings,
        )))
    }

    /// Returns the title of the point: that of the case, with the swept values.
    fn title(&self) -> String {
        let (title, name) = (&self.planned.plan.case.title, self.place.name());
        let alone = name.is_empty() || *title != self.file.title();
        if alone {
            title.clone()
        } else {
            let set = name.replace('=', " = ").replace(',', ", ");
            format!("{title}: {set}")
        }
    }

    /// Reports to the progress receiver that the point begins.
    pub(crate) fn begin(&self) {
        let plan = &self.planned.plan;
        // Title of the case with its overrides.
        let name = if self.place.name().is_empty() {
            &plan.case.title
        } else {
            self.place.name()
        };
        self.options
            .progress
            .begin_point(self.number, name, ProgressEstimate::for_case(plan));
    }

    /// Runs the point on the threads of the current pool. Its gases in cells are decomposed over
    /// the processes of `group`, if given.
    ///
    /// # Errors
    /// [`RunError`]; checkpoints stay.
    pub(crate) fn run_point(&self, group: Option<&RankGroup>) -> Result<PointSummary, RunError> {
        let began = Instant::now();
        if let Some(summary) = self.complete()? {
            return Ok(summary);
        }
        self.begin();
        let folder = self.place.path();
        let guard = || self.place.folder().require_same();
        let context = TaskContext {
            group,
            ..self.context(&folder, &guard)
        };
        let processes = group.map_or(0, RankGroup::size);
        let (journal, mut there) = self.journal()?;
        let all: Vec<(ReplicaTask, Option<Result<Replica, RunError>>)> = self
            .tasks()
            .map(|task| (task, there.remove(&task.replica)))
            .collect();
        let one = |(task, left)| {
            if let Some(left) = left {
                return left;
            }
            self.claim(task, processes)?;
            let left = context.work(task);
            self.keep(&journal, task, &left)?;
            left
        };
        let replicas = if group.is_some() {
            all.into_iter().map(one).collect()
        } else {
            all.into_par_iter().map(one).collect()
        };
        self.finish(replicas, began)
    }

    /// Returns the identity that the journals of the point carry.
    pub(crate) fn journal_owner(&self) -> JournalOwner {
        JournalOwner {
            run: *self.place.fingerprint(),
            seed: self.planned.plan.case.seed,
        }
    }

    /// Opens the journal of finished replicas for a process that works alone. Restores the replicas
    /// in it and in journals of other processes.
    ///
    /// # Errors
    /// [`RunError`] if it cannot be read or written.
    pub(crate) fn journal(&self) -> Result<(Journal, Left), RunError> {
        let path = self.place.claim(&journal::name())?;
        let interval = self.planned.plan.case.run.checkpoint_seconds;
        let (journal, _) = Journal::open(&path, self.journal_owner(), interval)?;
        replica_task::adopt(&self.place.path());
        let mut there = BTreeMap::new();
        for (replica, bytes) in self.entries()? {
            let task = self.task(replica);
            there.insert(replica, self.restore(task, &bytes)?);
            self.tell_done(task);
        }
        Ok((journal, there))
    }

    /// Opens the journal of one of several processes. Other processes may read an entry as soon as
    /// it is added.
    ///
    /// # Errors
    /// [`RunError`] if it cannot be read or written.
    pub(crate) fn journal_of(&self, worker: &str) -> Result<Journal, RunError> {
        let path = self.place.claim(&journal::name_of(worker))?;
        let (journal, _) = Journal::open(&path, self.journal_owner(), 0.0)?;
        Ok(journal)
    }

    /// Reads the records of finished replicas from all journals of the point.
    ///
    /// # Errors
    /// [`RunError`] if a journal cannot be read.
    pub(crate) fn entries(&self) -> Result<BTreeMap<u64, Vec<u8>>, RunError> {
        Ok(Journal::read_all(&self.place.path(), self.journal_owner())?)
    }

    fn task(&self, replica: u64) -> ReplicaTask {
        ReplicaTask {
            point: self.number,
            replica,
            attempt: 0,
        }
    }

    /// Restores the result of a task from its serialized record: the replica, or the failure of its
    /// gas.
    ///
    /// # Errors
    /// [`RunError`] if the bytes cannot be read.
    pub(crate) fn restore(
        &self,
        task: ReplicaTask,
        bytes: &[u8],
    ) -> Result<Result<Replica, RunError>, RunError> {
        let folder = self.place.path();
        let guard = || self.place.folder().require_same();
        match self.context(&folder, &guard).restore(task, bytes) {
            Err(error) if !error.is_of_gas() => Err(error),
            left => Ok(left),
        }
    }

    /// Reports a finished task to the progress receiver.
    pub(crate) fn tell_done(&self, task: ReplicaTask) {
        for part in replica_task::numbers(&self.planned.plan, task) {
            self.options.progress.tell_share(self.number, part, 1.0, 0);
        }
    }

    /// Adds the result of a task to a journal if it is finished or its gas has failed, and then
    /// removes its checkpoints.
    ///
    /// # Errors
    /// [`RunError`] if the journal cannot be written.
    pub(crate) fn keep(
        &self,
        journal: &Journal,
        task: ReplicaTask,
        left: &Result<Replica, RunError>,
    ) -> Result<(), RunError> {
        if left.as_ref().is_err_and(|error| !error.is_of_gas()) {
            return Ok(());
        }
        let bytes = replica_task::record(left)
            .map_err(|error| RunError::Incomplete(format!("the record of a task: {error}")))?;
        self.place.folder().require_same()?;
        journal.add(task.replica, &bytes)?;
        replica_task::forget(&self.place.path(), &self.planned.plan, task);
        Ok(())
    }

    pub(crate) fn summary(
        &self,
        was_complete: bool,
        began: Instant,
        verdicts: Vec<VerdictText>,
        warnings: Vec<String>,
    ) -> PointSummary {
        PointSummary {
            name: self.place.name().to_owned(),
            folder: self.place.path(),
            was_complete,
            seconds: began.elapsed().as_secs_f64(),
            verdicts,
            choices: self.planned.plan.notes.choices.clone(),
            warnings,
        }
    }

    /// Separates the results of the replicas into those of successful ones, in order, and failures.
    fn separate_failures(
        &self,
        replicas: Vec<Result<Replica, RunError>>,
    ) -> Result<Done, RunError> {
        let plan = &self.planned.plan;
        let mut done = Done {
            finished: plan.engines.iter().map(|_| Vec::new()).collect(),
            starts: Vec::new(),
            failed: Vec::new(),
        };
        for (number, replica) in replicas.into_iter().enumerate() {
            match replica {
                Ok((report, engines)) => {
                    done.starts
                        .extend(report.map(|report| start_of(number as u64, report)));
                    for (list, one) in done.finished.iter_mut().zip(engines) {
                        list.push(one);
                    }
                }
                Err(error) if error.is_of_gas() => {
                    self.keep_state(&error)?;
                    done.failed.push(error);
                }
                Err(error) => return Err(error),
            }
        }
        let failed = done.failed.len();
        match done.failed.first_mut() {
            // A replica that cannot continue may hide that another engine of it was interrupted.
            Some(RunError::Replica { source, .. }) if self.options.stop.is_raised() => {
                **source = PartError::Interrupted;
                Err(done.failed.swap_remove(0))
            }
            // Without a single replica there is nothing to tabulate.
            Some(_) if failed as u64 == plan.case.replicas => Err(done.failed.swap_remove(0)),
            _ => Ok(done),
        }
    }

    /// Writes the state of a gas that cannot continue to a file.
    fn keep_state(&self, error: &RunError) -> Result<(), RunError> {
        let RunError::Replica {
            replica,
            part,
            source,
        } = error
        else {
            return Ok(());
        };
        if source.state().is_empty() {
            return Ok(());
        }
        let name = format!("{SNAPSHOTS}/replica-{replica}-{part}.stopped.xyz");
        self.place.write(&name, source.state().as_bytes())?;
        let path = self.place.path().join(&name);
        let text = format!("the gas at that moment is in {}", path.display());
        self.options.progress.show_note(&text);
        Ok(())
    }

    /// Writes tables, verdicts and the manifest from the results of all replicas, in their order.
    ///
    /// # Errors
    /// [`RunError`]: of the first replica that failed for another reason than its gas, of the first
    /// if all failed, or of the folder.
    pub(crate) fn finish(
        &self,
        replicas: Vec<Result<Replica, RunError>>,
        began: Instant,
    ) -> Result<PointSummary, RunError> {
        let Self {
            file,
            planned,
            place,
            number,
            level,
            options,
        } = *self;
        let plan = &planned.plan;
        let all = self.separate_failures(replicas)?;
        let mut warnings = plan.notes.warnings.clone();
        warnings.extend(
            all.failed
                .iter()
                .map(|error| format!("{error}; this replica is left out of all tables")),
        );
        let engines = work(plan, &all.finished);
        warnings.extend(chi_limit_warnings(&engines));
        let mut tables: Vec<Table> = Vec::new();
        let (mut snapshots, mut frames) = (Vec::new(), Vec::new());
        let mut verdicts: Vec<VerdictText> = judge::start(&unequilibrated(&all.starts))
            .into_iter()
            .collect();
        let leading = question::leading(plan, &planned.measures);
        let mut asked = RunQuestion::default();
        let mut later: Vec<VerdictText> = Vec::new();
        for (measure, known) in planned.measures.iter().enumerate() {
            let runs = ReplicaRecords {
                measure,
                level,
                finished: &all.finished,
            };
            let mut own = known.result_tables(plan, &runs);
            let mut said = known.result_verdicts(plan, &runs, &own);
            for table in &mut own {
                label_times(table, plan);
            }
            if measure == leading {
                asked = question::run_question(plan, file.question(), &own);
                question::put_first(plan, &mut said);
                verdicts.extend(said);
            } else {
                later.extend(said);
            }
            for (snapshot, bytes) in known.snapshot_files(plan, &runs) {
                place.write(&snapshot.file, &bytes)?;
                snapshots.push(snapshot);
            }
            for one in known.player_frames(plan, &runs) {
                let bytes = stosszahl_results::frames::to_bytes(&one.frames)?;
                place.write(&one.file, &bytes)?;
                frames.push(FramesEntry::new(one.engine, one.file, &bytes));
            }
            tables.extend(own);
        }
        verdicts.extend(later);
        for column in tables.iter_mut().flat_map(|table| &mut table.columns) {
            column.unit = plan.table_unit(&column.unit);
        }
        let manifest = Manifest {
            format: FORMAT,
            program: Program {
                name: "stosszahl".into(),
                version: env!("CARGO_PKG_VERSION").into(),
                commit: options.commit.to_owned(),
            },
            title: self.title(),
            question: asked,
            case_text: file.text.clone(),
            case: plan.case_json(),
            time_unit: time_unit(plan),
            derived: (plan.derived().into_iter())
                .map(|one| Derived {
                    name: one.name,
                    value: one.value,
                    unit: one.unit.into_owned(),
                })
                .collect(),
            machine: describe_machine(),
            seed: plan.case.seed,
            replicas: plan.case.replicas,
            wall_seconds: began.elapsed().as_secs_f64(),
            start: all.starts,
            engines,
            verdicts,
            choices: plan.notes.choices.clone(),
            warnings,
            snapshots,
            frames,
            ..Manifest::default()
        };
        let manifest = place.finish(manifest, &tables)?;
        place.remove_checkpoints()?;
        options.progress.end_point(number);
        Ok(self.summary(false, began, manifest.verdicts, manifest.warnings))
    }
}

/// Relabels time axes of figures with the unit of time of the case: "t/t0", "lag/t0".
fn label_times(table: &mut Table, plan: &CasePlan) {
    let unit = match plan.clock.time_unit {
        TimeUnit::Case => return,
        TimeUnit::Haff => "t0",
        TimeUnit::MeanFreeTime => "mean free time",
    };
    let times: Vec<_> = (table.columns.iter())
        .filter(|column| column.unit == "time")
        .map(|column| column.name.clone())
        .collect();
    for figure in &mut table.figures {
        for axis in [&mut figure.x, &mut figure.y] {
            if times.contains(&axis.column) {
                let symbol = if axis.label == "time" {
                    "t"
                } else {
                    &axis.label
                };
                axis.label = format!("{symbol}/{unit}").into();
            }
        }
    }
}

/// Returns the unit of time of a case for the manifest.
fn time_unit(plan: &CasePlan) -> stosszahl_results::TimeUnitSize {
    stosszahl_results::TimeUnitSize {
        name: match plan.clock.time_unit {
            TimeUnit::Case => "unit of time of the case",
            TimeUnit::Haff => "Haff's cooling time of the start",
            TimeUnit::MeanFreeTime => "mean free time of the start",
        }
        .to_owned(),
        size: plan.time_in_case(),
    }
}

/// Lists the replicas whose start was not equilibrated, with the tests that failed.
fn unequilibrated(starts: &[StartRecord]) -> Vec<(u64, String)> {
    let bad = starts
        .iter()
        .filter(|start| start.equilibrated == Some(false));
    bad.map(|start| {
        let failed = start.tests.iter().filter(|test| test.passed == Some(false));
        let names: Vec<&str> = failed.map(|test| test.name.as_str()).collect();
        let why = match &names[..] {
            [] => "too few elastic collisions".to_owned(),
            names => names.join(", "),
        };
        (start.replica, why)
    })
    .collect()
}

/// Sums the work of each engine over replicas.
fn work(plan: &CasePlan, finished: &[Vec<CompletedRun>]) -> Vec<EngineWork> {
    let one = |(engine, runs): (&crate::plan::EnginePlan, &Vec<CompletedRun>)| {
        let mut work: BTreeMap<String, f64> = BTreeMap::new();
        for run in runs {
            for (name, number) in &run.work.numbers {
                *work.entry(name.clone()).or_default() += number / runs.len() as f64;
            }
        }
        EngineWork {
            engine: engine.name.to_owned(),
            seconds: runs.iter().map(|run| run.seconds).sum(),
            collisions: runs.iter().map(|run| run.work.collisions).sum(),
            bytes: runs.iter().map(|run| run.bytes as u64).max().unwrap_or(0),
            work,
        }
    };
    plan.engines.iter().zip(finished).map(one).collect()
}

/// Creates warnings about engines whose contact value chi was limited in many collisions.
fn chi_limit_warnings(engines: &[EngineWork]) -> impl Iterator<Item = String> + '_ {
    engines.iter().filter_map(|engine| {
        let share = engine.work.get("share_of_collisions_in_limited_cells").copied()?;
        (share > MANY_LIMITED).then(|| {
            format!(
                "{}: {} of the collisions were in cells whose contact value was limited by max_contact_value; the \
                 rate there is the limit's, not the density's",
                engine_title(&engine.engine),
                format_percent(share)
            )
        })
    })
}

/// Returns a description of the machine for the manifest.
fn describe_machine() -> Machine {
    let processor = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
    Machine {
        cores: thread::available_parallelism().map_or(1, |n| n.get() as u64),
        processor: processor.unwrap_or_else(|| "unknown".into()),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
    }
}

fn start_of(replica: u64, report: StartReport) -> StartRecord {
    let tests = report.tests.into_iter().map(|test| StartTest {
        name: test.name,
        statistic: test.statistic,
        p_value: test.p_value,
        passed: test.passed,
        detail: test.detail,
    });
    StartRecord {
        replica,
        placement: report.placement,
        collisions_per_particle: report.collisions_per_particle,
        equilibrated: report.equilibrated,
        tests: tests.collect(),
    }
}
