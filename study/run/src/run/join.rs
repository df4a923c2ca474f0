//! Runs shared by several processes through the results folder: each process claims replicas, and
//! the last one of a point writes its tables.
//!
//! A replica is a function of the case, and its records are stored as in a checkpoint, so tables
//! have the bytes of [`crate::run_case`], for any distribution of the work. A process that died
//! leaves its claims, checkpoints and journal. Another one supersedes the claims, resumes from
//! copies of the checkpoints, and reads the journal ([`stosszahl_results::FolderWorker`]).

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use stosszahl_case::CaseFile;
use stosszahl_results::{Folder, FolderWorker, Manifest, ResultsError, TaskClaim, TaskStates};

use super::case_run::{Opened, prepare, require_memory_of_each};
use super::error::RunError;
use super::options::RunOptions;
use super::point::Job;
use super::replica_task::{ReplicaTask, seconds};
use super::summary::{PointSummary, RunSummary};
use crate::check::Planned;
use crate::engine_run::PartError;
use crate::journal::Journal;

/// Name of the task of writing the tables of a sweep point.
const FINISH: &str = "finish";
/// Name of the task of writing the report of a run.
const REPORT: &str = "report";
/// Shortest and longest time between two checks for an unclaimed task.
const LOOKS: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(500)];

/// Runs all points of a case into a results folder, together with other processes that call this
/// function. A process without a heartbeat for `lost_after` counts as lost, and others take over
/// its replicas.
///
/// # Errors
/// As [`crate::run_case`]; other processes continue.
pub fn run_joined(
    file: &CaseFile,
    options: &RunOptions<'_>,
    lost_after: Duration,
) -> Result<RunSummary, RunError> {
    let (planned, threads) = prepare(file, options)?;
    require_memory_of_each(&planned, threads, 1, options)?;
    let opened = Opened::join(file, &planned, options, lost_after)?;
    let jobs = opened.jobs(file, &planned, options);
    let folder = opened.folder();
    let worker = folder.worker();
    let worker = worker.ok_or_else(|| RunError::Processes("the folder is not shared".into()))?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let queue = TaskQueue::new(&jobs, options, folder, worker)?;
    thread::scope(|scope| {
        for _ in 0..concurrent_replicas(&planned, threads) {
            scope.spawn(|| queue.work(&pool));
        }
    });
    let points = queue.finished()?;
    let is_reporter = worker.claim(&folder.claims(), REPORT)?.is_some();
    if is_reporter {
        for job in &jobs {
            job.place.remove_checkpoints()?;
            job.place.remove_claims();
        }
        folder.settle_claims()?;
    }
    Ok(RunSummary {
        is_reporter,
        ..opened.summary(points)
    })
}

/// Returns the number of replicas that run concurrently, so that each thread has an engine.
fn concurrent_replicas(planned: &[Planned<'_>], threads: usize) -> usize {
    let engines = planned.iter().map(|one| one.plan.engines.len()).min();
    (threads / engines.unwrap_or(1).max(1)).max(1)
}

/// Returns the name of the task of running a replica of a sweep point.
fn task_name(job: &Job<'_>, replica: u64) -> String {
    job.place.task(&format!("replica-{replica}"))
}

/// Next step of a thread that executes shared tasks: run, finish, wait, or end.
enum NextStep {
    Replica(ReplicaTask, TaskClaim),
    Finish(usize, TaskClaim),
    /// Wait, because all tasks are claimed by live processes.
    Wait,
    End,
}

/// Queue of the tasks of a run that several processes share.
struct TaskQueue<'a> {
    jobs: &'a [Job<'a>],
    options: &'a RunOptions<'a>,
    folder: &'a Folder,
    worker: &'a FolderWorker,
    /// Indices of the sweep points, the costliest first.
    order: Vec<usize>,
    /// Queue state shared by the threads of this process.
    state: Mutex<QueueState>,
}

struct QueueState {
    points: Vec<PointState>,
    failure: Option<RunError>,
}

/// Progress of a point of a sweep in this process: its start, journal and reported replicas.
#[derive(Default)]
struct PointState {
    began: Option<Instant>,
    /// Journal of the replicas that this process has done.
    journal: Option<Arc<Journal>>,
    /// For each replica of the point: true if it was reported as done.
    told: Vec<bool>,
    summary: Option<PointSummary>,
}

impl<'a> TaskQueue<'a> {
    fn new(
        jobs: &'a [Job<'a>],
        options: &'a RunOptions<'a>,
        folder: &'a Folder,
        worker: &'a FolderWorker,
    ) -> Result<Self, RunError> {
        let cost = |point: &usize| seconds(&jobs[*point].planned.plan);
        let mut order: Vec<usize> = (0..jobs.len()).collect();
        order.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
        let mut points = Vec::new();
        for job in jobs {
            let mut state = PointState {
                told: vec![false; job.planned.plan.case.replicas as usize],
                ..PointState::default()
            };
            if job.place.has_manifest() {
                state.summary = Some(summary_of_finished(job, true)?);
            } else {
                // Replicas kept by processes that died before they could mark them, or by one that
                // worked alone.
                for replica in job.entries()?.into_keys() {
                    worker.mark_done(&folder.claims(), &task_name(job, replica))?;
                }
            }
            points.push(state);
        }
        Ok(Self {
            jobs,
            options,
            folder,
            worker,
            order,
            state: Mutex::new(QueueState {
                points,
                failure: None,
            }),
        })
    }

    fn state(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Executes tasks of the run until none is left in any process.
    fn work(&self, pool: &rayon::ThreadPool) {
        let mut pause = LOOKS[0];
        loop {
            let step = self.next_step();
            let done = match step {
                Ok(NextStep::End) => return,
                Ok(NextStep::Wait) => {
                    thread::sleep(pause);
                    pause = (2 * pause).min(LOOKS[1]);
                    continue;
                }
                Ok(NextStep::Replica(task, claim)) => self.work_on(pool, task, &claim),
                Ok(NextStep::Finish(point, claim)) => self.finish(point, &claim),
                Err(error) => Err(error),
            };
            pause = LOOKS[0];
            if let Err(error) = done {
                self.state().failure.get_or_insert(error);
            }
        }
    }

    /// Returns the next step of a thread: a task without a claim, or else one whose process was
    /// lost.
    fn next_step(&self) -> Result<NextStep, RunError> {
        let mut state = self.state();
        if state.failure.is_some() {
            return Ok(NextStep::End);
        }
        if self.options.stop.is_raised() {
            return Err(RunError::Replica {
                replica: 0,
                part: String::new(),
                source: Box::new(PartError::Interrupted),
            });
        }
        self.folder.require_same()?;
        let tasks = TaskStates::read_claims(&self.folder.claims());
        for claimed in [false, true] {
            for &point in &self.order {
                let there = &mut state.points[point];
                if there.summary.is_none()
                    && let Some(step) = self.step_of(point, there, &tasks, claimed)?
                {
                    return Ok(step);
                }
            }
        }
        let is_over = state.points.iter().all(|point| point.summary.is_some());
        Ok(if is_over {
            NextStep::End
        } else {
            NextStep::Wait
        })
    }

    /// Finds a task of one sweep point, among claimed ones or among free ones.
    fn step_of(
        &self,
        point: usize,
        state: &mut PointState,
        tasks: &TaskStates,
        claimed: bool,
    ) -> Result<Option<NextStep>, RunError> {
        let job = &self.jobs[point];
        let claims = self.folder.claims();
        if job.place.has_manifest() {
            state.summary = Some(summary_of_finished(job, false)?);
            self.options.progress.end_point(point);
            return Ok(None);
        }
        let mut is_open = false;
        for task in job.tasks() {
            let name = task_name(job, task.replica);
            if tasks.is_done(&name) {
                if !std::mem::replace(&mut state.told[task.replica as usize], true) {
                    job.tell_done(task);
                }
                continue;
            }
            is_open = true;
            if tasks.is_claimed(&name) != claimed {
                continue;
            }
            if let Some(claim) = self.worker.claim(&claims, &name)? {
                // Others may have finished the point, and removed its claims, since they were read.
                if job.place.has_manifest() {
                    job.place.remove_claims();
                    return Ok(None);
                }
                if state.began.is_none() {
                    state.began = Some(Instant::now());
                    job.begin();
                }
                let attempt = claim.generation;
                return Ok(Some(NextStep::Replica(
                    ReplicaTask { attempt, ..task },
                    claim,
                )));
            }
        }
        if is_open {
            return Ok(None);
        }
        let claim = self.worker.claim(&claims, &job.place.task(FINISH))?;
        Ok(claim.map(|claim| NextStep::Finish(point, claim)))
    }

    /// Runs a replica and appends its records to the journal.
    fn work_on(
        &self,
        pool: &rayon::ThreadPool,
        task: ReplicaTask,
        claim: &TaskClaim,
    ) -> Result<(), RunError> {
        let job = &self.jobs[task.point];
        let name = task_name(job, task.replica);
        let claims = self.folder.claims();
        if task.attempt > 0 && job.entries()?.contains_key(&task.replica) {
            return Ok(self.worker.mark_done(&claims, &name)?);
        }
        let guard = || {
            self.folder.require_same()?;
            if self.worker.holds(claim) {
                return Ok(());
            }
            Err(ResultsError::TakenOver {
                path: job.place.path(),
                task: name.clone(),
            })
        };
        job.claim(task, 0)?;
        let folder = job.place.path();
        let left = pool.install(|| job.context(&folder, &guard).work(task));
        match guard() {
            // This process was suspended too long; another one has resumed from its checkpoint.
            Err(error @ ResultsError::TakenOver { .. }) => {
                self.options.progress.show_note(&error.to_string());
                return Ok(());
            }
            other => other?,
        }
        if let Err(error) = &left
            && !error.is_of_gas()
        {
            return left.map(drop);
        }
        let journal = self.journal(task.point)?;
        job.keep(&journal, task, &left)?;
        Ok(self.worker.mark_done(&claims, &name)?)
    }

    /// Returns the journal of this process for a point, created with its first replica.
    fn journal(&self, point: usize) -> Result<Arc<Journal>, RunError> {
        let mut state = self.state();
        let journal = &mut state.points[point].journal;
        if let Some(journal) = journal {
            return Ok(journal.clone());
        }
        let made = Arc::new(self.jobs[point].journal_of(self.worker.id())?);
        *journal = Some(made.clone());
        Ok(made)
    }

    /// Writes the tables of a point after all its replicas are done.
    fn finish(&self, point: usize, claim: &TaskClaim) -> Result<(), RunError> {
        let job = &self.jobs[point];
        if job.place.has_manifest() {
            return Ok(());
        }
        let mut entries = job.entries()?;
        let mut replicas = Vec::new();
        for task in job.tasks() {
            let Some(bytes) = entries.remove(&task.replica) else {
                return Err(RunError::Incomplete(format!(
                    "{}: replica {} is marked as done, and no journal has it; remove {} and join again",
                    job.place.path().display(),
                    task.replica,
                    self.folder.claims().display()
                )));
            };
            replicas.push(job.restore(task, &bytes)?);
        }
        if !self.worker.holds(claim) {
            return Ok(());
        }
        let began = self.state().points[point].began;
        let summary = job.finish(replicas, began.unwrap_or_else(Instant::now))?;
        job.place.remove_claims();
        self.state().points[point].summary = Some(summary);
        Ok(())
    }

    fn finished(self) -> Result<Vec<PointSummary>, RunError> {
        let state = self.state.into_inner();
        let state = state.unwrap_or_else(PoisonError::into_inner);
        match state.failure {
            Some(error) => Err(error),
            None => Ok((state.points.into_iter())
                .filter_map(|point| point.summary)
                .collect()),
        }
    }
}

/// Returns the summary of a finished point, from its manifest.
fn summary_of_finished(job: &Job<'_>, was_complete: bool) -> Result<PointSummary, RunError> {
    let path = job.place.path();
    let manifest = match Manifest::read(&path)? {
        Some(manifest) if job.place.is_complete()? => manifest,
        _ => return Err(ResultsError::Unsound { path }.into()),
    };
    Ok(job.summary(
        was_complete,
        Instant::now(),
        manifest.verdicts,
        manifest.warnings,
    ))
}
