//! Execution of the runs of a frontier on all cores: each run on one thread, with its own time,
//! memory and counts of work.
//!
//! Starts of replica r are the same for all settings of a size: the difference of two settings is
//! then less noisy than either. A run takes one thread, so that its CPU time is its cost whatever
//! else the machine does.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use stosszahl_model::{Interrupt, Particle, Particles, to_bytes};
use stosszahl_results::FolderWorker;

use super::FrontierError;
use super::kept_runs::{KeptRuns, RunKey, task_of};
use super::quantity::{MEASURES, observe};
use super::run_record::{Found, RunRecord, RunResult};
use super::setting::{RunSetting, engine};
use crate::engine_run::in_memory::{InMemoryRun, measures, resized};
use crate::measure::Measure;
use crate::plan::{CasePlan, EngineKind, PlanError};

/// Shortest and longest time between two checks for an unclaimed run, if several processes share
/// the folder.
const LOOKS: [Duration; 2] = [Duration::from_millis(5), Duration::from_millis(500)];
/// Largest memory of initial states that are kept for other settings \[bytes\].
const STARTS: usize = 1 << 29;

/// Replica number of the first reference run; no setting shares initial states with reference runs.
pub(super) const REFERENCE: u64 = 1 << 32;
/// Replica number of the first test run of a recommendation, on fresh seeds.
pub(super) const FRESH: u64 = 1 << 33;

/// Request to run a setting for several replicas.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// Numerical setting to run.
    pub setting: RunSetting,
    /// Numbers of the replicas to run.
    pub replicas: Range<u64>,
}

/// Outcome of a task: its runs in the order of the replicas, or the reason why the setting was left
/// out.
pub(crate) type TaskOutcome = Result<Vec<RunResult>, String>;

/// Executor of tasks within a budget of CPU time.
pub(crate) struct Workshop<'a> {
    /// Plan of the case whose frontier is measured.
    pub plan: &'a CasePlan,
    /// Runs stored in the results folder.
    pub kept: &'a KeptRuns,
    /// Executor of single runs on threads of this process.
    pub runner: Runner<'a>,
    /// Total CPU time after which no further run begins \[s\].
    pub limit: f64,
    /// CPU time spent on all runs of the frontier \[s\], those of earlier calls included.
    pub spent: Mutex<f64>,
    /// Callback for progress messages, with the run that has ended.
    pub tell: &'a (dyn Fn(&str) + Sync),
    /// Number of groups of tasks executed so far; a group has the tasks of one system size.
    pub groups: AtomicU64,
}

impl Workshop<'_> {
    /// Returns the CPU time spent on all runs of the frontier \[s\], those of earlier calls
    /// included.
    pub(crate) fn spent(&self) -> f64 {
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn spend(&self, seconds: f64) {
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner) += seconds;
    }

    /// Executes tasks, cheap ones first, and returns their outcomes in the order of the tasks.
    ///
    /// # Errors
    /// [`FrontierError`] if a system size cannot be planned or threads cannot be started. Failures
    /// of a run are in its outcome.
    pub(crate) fn run(&self, tasks: &[Task]) -> Result<Vec<TaskOutcome>, FrontierError> {
        let mut sizes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, task) in tasks.iter().enumerate() {
            sizes.entry(task.setting.disks).or_default().push(index);
        }
        let mut outcomes: Vec<TaskOutcome> = vec![Ok(Vec::new()); tasks.len()];
        for (disks, members) in sizes {
            let plan = self.runner.plan_of(disks)?;
            let group: Vec<&Task> = members.iter().map(|&index| &tasks[index]).collect();
            for (index, outcome) in members.into_iter().zip(self.group(&plan, &group)?) {
                outcomes[index] = outcome;
            }
        }
        Ok(outcomes)
    }

    /// Executes one task: the runs of a setting for several replicas.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub(crate) fn one(&self, task: Task) -> Result<TaskOutcome, FrontierError> {
        let outcome = self.run(&[task])?.pop();
        Ok(outcome.unwrap_or_else(|| Ok(Vec::new())))
    }

    /// Executes the tasks of one system size, in parallel over their runs.
    fn group(&self, plan: &CasePlan, tasks: &[&Task]) -> Result<Vec<TaskOutcome>, FrontierError> {
        let first = tasks.iter().map(|task| task.replicas.start).min();
        let end = tasks.iter().map(|task| task.replicas.end).max();
        let (first, end) = (first.unwrap_or(0), end.unwrap_or(0));
        let room = if tasks.len() > 1 {
            STARTS / (size_of::<Particle>() * plan.count().max(1))
        } else {
            0
        };
        let shared = first..end.min(first + room as u64);
        let mut order: Vec<usize> = (0..tasks.len()).collect();
        let cost = |&task: &usize| tasks[task].setting.nominal_seconds(plan);
        order.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let all = |&task: &usize| {
            tasks[task]
                .replicas
                .clone()
                .map(move |replica| (task, replica))
        };
        let jobs: Vec<(usize, u64)> = order.iter().flat_map(all).collect();
        let mut done: Vec<Option<Found>> = Vec::new();
        for &(task, replica) in &jobs {
            let kept = self.kept.find_run(&key(&tasks[task].setting, replica));
            if let Some(record) = &kept {
                self.spend(record.spent);
            }
            done.push(kept.map(|record| record.found));
        }
        let missing = |job: &usize| done[*job].is_none();
        let bench = Bench {
            workshop: self,
            tasks,
            jobs: &jobs,
            shared,
            group: self.groups.fetch_add(1, Ordering::Relaxed),
            state: Mutex::new(State {
                waiting: (0..jobs.len()).filter(missing).collect(),
                held: 0,
                done,
                failure: None,
            }),
        };
        let done = bench.work()?;
        let mut outcomes: Vec<TaskOutcome> = vec![Ok(Vec::new()); tasks.len()];
        for ((task, replica), found) in jobs.iter().zip(done) {
            let found = found.unwrap_or_else(|| Err("the budget was spent before its turn".into()));
            match (&mut outcomes[*task], found) {
                (Ok(samples), Ok(sample)) => samples.push(sample),
                (known @ Ok(_), Err(reason)) => {
                    *known = Err(format!("{}: {reason}", replica_name(*replica)));
                }
                (Err(_), _) => {}
            }
        }
        Ok(outcomes)
    }
}

/// Formats the number of a replica: those of the reference are counted from `REFERENCE`, those on
/// fresh seeds from `FRESH`.
fn replica_name(replica: u64) -> String {
    match replica {
        0..REFERENCE => format!("replica {replica}"),
        REFERENCE..FRESH => {
            format!("replica {} of the reference", replica - REFERENCE)
        }
        _ => format!("replica {} of fresh seeds", replica - FRESH),
    }
}

/// Queue of the runs in one group of tasks, with their results so far. Each job is one replica of
/// one setting.
struct Bench<'a> {
    workshop: &'a Workshop<'a>,
    tasks: &'a [&'a Task],
    jobs: &'a [(usize, u64)],
    /// Range of replicas whose initial states are kept for other settings.
    shared: Range<u64>,
    /// Number of the current group of tasks in this process.
    group: u64,
    state: Mutex<State>,
}

struct State {
    waiting: VecDeque<usize>,
    /// Number of jobs that threads of this process are executing.
    held: usize,
    done: Vec<Option<Found>>,
    failure: Option<FrontierError>,
}

impl Bench<'_> {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Executes the jobs of the queue until none is left or the budget is spent.
    fn work(self) -> Result<Vec<Option<Found>>, FrontierError> {
        let runner = &self.workshop.runner;
        let worker = self.workshop.kept.worker();
        thread::scope(|scope| {
            for _ in 0..runner.threads {
                scope.spawn(|| match worker {
                    Some(worker) => self.work_shared(worker),
                    None => {
                        while let Some(order) = self.next() {
                            self.work_on(&order);
                        }
                    }
                });
            }
        });
        if runner.interrupt.is_raised() {
            return Err(FrontierError::Interrupted);
        }
        let state = self.state.into_inner();
        let State { done, failure, .. } = state.unwrap_or_else(PoisonError::into_inner);
        failure.map_or(Ok(done), Err)
    }

    /// Executes the jobs of the queue that this process can claim, until some process has done
    /// each, or the budget is spent.
    fn work_shared(&self, worker: &FolderWorker) {
        let mut pause = LOOKS[0];
        while !self.is_finished() && !self.is_over() {
            match self.next_shared(worker) {
                Ok(Some(order)) => {
                    self.work_on(&order);
                    pause = LOOKS[0];
                }
                Ok(None) => {
                    thread::sleep(pause);
                    pause = (2 * pause).min(LOOKS[1]);
                }
                Err(error) => {
                    self.state().failure.get_or_insert(error);
                }
            }
        }
    }

    /// Collects the jobs that other processes have done. Then claims a job that is free, or whose
    /// process was lost.
    fn next_shared(&self, worker: &FolderWorker) -> Result<Option<Order>, FrontierError> {
        let kept = self.workshop.kept;
        kept.require_same()?;
        let mut state = self.state();
        let tasks = kept.tasks();
        kept.refresh()?;
        let key_of = |job: usize| {
            let (task, replica) = self.jobs[job];
            key(&self.tasks[task].setting, replica)
        };
        let mut left = VecDeque::new();
        for job in std::mem::take(&mut state.waiting) {
            match kept.find_run(&key_of(job)) {
                Some(record) => {
                    self.workshop.spend(record.spent);
                    state.done[job] = Some(record.found);
                }
                None => left.push_back(job),
            }
        }
        state.waiting = left;
        let waiting: Vec<usize> = state.waiting.iter().copied().collect();
        for claimed in [false, true] {
            for (place, &job) in waiting.iter().enumerate() {
                let task = task_of(&key_of(job));
                if tasks.is_claimed(&task) == claimed && kept.claim(worker, &task)?.is_some() {
                    // Another process may have ended it since the journals were read, and all
                    // claims be gone.
                    kept.refresh()?;
                    if kept.find_run(&key_of(job)).is_some() {
                        return Ok(None);
                    }
                    state.waiting.remove(place);
                    state.held += 1;
                    return Ok(Some(self.order(job)));
                }
            }
        }
        Ok(None)
    }

    /// Returns the request for the run that a job stands for.
    fn order(&self, job: usize) -> Order {
        let (task, replica) = self.jobs[job];
        let setting = &self.tasks[task].setting;
        Order {
            job,
            group: self.group,
            kind: setting.engine.kind.clone(),
            disks: setting.disks,
            replica,
            shares: self.shared.contains(&replica),
        }
    }

    /// Returns true if no further run may begin: the CPU time budget is spent, or the measurement
    /// was interrupted.
    fn is_over(&self) -> bool {
        let workshop = self.workshop;
        workshop.spent() >= workshop.limit || workshop.runner.interrupt.is_raised()
    }

    /// Takes the next job from the queue; `None` if no job is left, or no further run may begin.
    fn next(&self) -> Option<Order> {
        if self.is_over() {
            return None;
        }
        let mut state = self.state();
        if state.failure.is_some() {
            return None;
        }
        let job = state.waiting.pop_front()?;
        state.held += 1;
        Some(self.order(job))
    }

    /// Executes a requested run, and adds its result to the journal.
    fn work_on(&self, order: &Order) {
        let workshop = self.workshop;
        let record = workshop.runner.work(order);
        workshop.spend(record.spent);
        let job = order.job;
        let (task, replica) = self.jobs[job];
        // A run that failed because it was to stop says nothing.
        let is_kept = record.found.is_ok() || !workshop.runner.interrupt.is_raised();
        let key = key(&self.tasks[task].setting, replica);
        let kept = is_kept.then(|| workshop.kept.add(replica, key, record.clone()));
        let mut state = self.state();
        state.held -= 1;
        if let Some(Err(error)) = kept {
            state.failure.get_or_insert(error);
        }
        state.done[job] = Some(record.found);
        drop(state);
        if job.is_multiple_of(16) {
            let label = self.tasks[task].setting.label(workshop.plan);
            let (run, all) = (job + 1, self.jobs.len());
            (workshop.tell)(&format!("run {run} of {all}: {label}"));
        }
    }

    /// Returns true if all jobs of the queue are done, the budget is spent, or the measurement has
    /// failed.
    fn is_finished(&self) -> bool {
        let is_over = self.is_over();
        let state = self.state();
        let is_done = state.held == 0 && (state.waiting.is_empty() || is_over);
        is_done || state.failure.is_some() || self.workshop.runner.interrupt.is_raised()
    }
}

/// Request for one run, which any thread of the process can execute.
struct Order {
    job: usize,
    group: u64,
    kind: EngineKind,
    disks: usize,
    replica: u64,
    /// True if the initial state is kept for other settings.
    shares: bool,
}

/// Returns the journal key of a run: its setting and replica, which with the case determine its
/// values.
fn key(setting: &RunSetting, replica: u64) -> RunKey {
    to_bytes(&(&setting.engine.kind, setting.disks, replica))
}

/// Initial state that several settings share, with the CPU and wall time spent on it \[s\].
type Shared = OnceLock<Result<(Particles, [f64; 2]), String>>;

/// Executor of single runs, each on a thread pool of its own.
pub(crate) struct Runner<'a> {
    plan: &'a CasePlan,
    measures: Vec<&'static dyn Measure>,
    interrupt: &'a Interrupt,
    threads: usize,
    /// Idle thread pools of one thread each, so that an engine cannot use further threads.
    pools: Mutex<Vec<rayon::ThreadPool>>,
    group: Mutex<Group>,
}

/// Plan and shared initial states of the current group of tasks: those of one system size.
#[derive(Default)]
struct Group {
    number: u64,
    /// Plan of the case with the number of disks of the group.
    plan: Option<Arc<CasePlan>>,
    /// Shared initial states, by the number of the replica.
    starts: BTreeMap<u64, Arc<Shared>>,
}

impl<'a> Runner<'a> {
    pub(crate) fn new(
        plan: &'a CasePlan,
        threads: usize,
        interrupt: &'a Interrupt,
    ) -> Result<Self, FrontierError> {
        let threads = threads.max(1);
        let pools = (0..threads)
            .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            plan,
            measures: measures(&MEASURES),
            interrupt,
            threads,
            pools: Mutex::new(pools),
            group: Mutex::default(),
        })
    }

    /// Plans the case with another number of disks.
    pub(crate) fn plan_of(&self, disks: usize) -> Result<CasePlan, PlanError> {
        if disks == self.plan.count() {
            return Ok(self.plan.clone());
        }
        let case = resized(&self.plan.case, disks, self.plan.gas.packing_fraction);
        CasePlan::new(&case, &self.plan.folder)
    }

    /// Returns the plan for a requested run, and its shared initial state if other settings use it,
    /// too.
    fn of_group(&self, order: &Order) -> Result<(Arc<CasePlan>, Option<Arc<Shared>>), PlanError> {
        let mut group = self.group.lock().unwrap_or_else(PoisonError::into_inner);
        if group.number != order.group {
            *group = Group {
                number: order.group,
                ..Group::default()
            };
        }
        let plan = match &group.plan {
            Some(plan) => plan.clone(),
            None => Arc::new(self.plan_of(order.disks)?),
        };
        group.plan = Some(plan.clone());
        let start = || group.starts.entry(order.replica).or_default().clone();
        Ok((plan, order.shares.then(start)))
    }

    fn run(&self, order: &Order) -> RunRecord {
        let mut spent = 0.0;
        let found = self.sample(order, &mut spent);
        RunRecord { found, spent }
    }

    fn sample(&self, order: &Order, spent: &mut f64) -> Found {
        let (plan, shared) = self.of_group(order).map_err(|error| error.to_string())?;
        let run = InMemoryRun {
            plan: &plan,
            measures: &self.measures,
            replica: order.replica,
            stop: self.interrupt,
        };
        let mut begin = || {
            let (state, seconds) = run_timed(spent, || run.make_start());
            let state = state.map_err(|error| format!("start: {error}"))?;
            Ok::<_, String>((state, seconds))
        };
        let own;
        let (start, placed) = if let Some(shared) = &shared {
            shared
                .get_or_init(&mut begin)
                .as_ref()
                .map_err(String::clone)?
        } else {
            own = begin()?;
            &own
        };
        let engine = engine(order.kind.clone());
        let (finished, seconds) = run_timed(spent, || run.run_engine(&engine, start));
        let finished = finished.map_err(|error| error.to_string())?;
        let whole = plan.count() == self.plan.count();
        let steps = finished.work.numbers.get("steps").copied().unwrap_or(0.0);
        Ok(RunResult {
            values: observe(&plan, &engine, &finished, whole),
            collisions: finished.work.collisions,
            steps: steps as u64,
            bytes: finished.bytes,
            core_seconds: placed[0] + seconds[0],
            wall_seconds: placed[1] + seconds[1],
        })
    }

    /// Executes a requested run on a pool of one thread.
    fn work(&self, order: &Order) -> RunRecord {
        let pools = || self.pools.lock().unwrap_or_else(PoisonError::into_inner);
        let pool = pools().pop();
        let record = match &pool {
            Some(pool) => pool.install(|| self.run(order)),
            None => self.run(order),
        };
        pools().extend(pool);
        record
    }
}

/// Runs `work`, adds its CPU time to `spent`, and returns its result with its CPU and wall time
/// \[s\].
fn run_timed<T>(spent: &mut f64, work: impl FnOnce() -> T) -> (T, [f64; 2]) {
    let (cpu, wall) = (ThreadTime::now(), Instant::now());
    let done = work();
    let seconds = [cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()];
    *spent += seconds[0];
    (done, seconds)
}

/// Returns the median of some numbers; NaN without numbers.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[count / 2],
        count => 0.5 * (values[count / 2 - 1] + values[count / 2]),
    }
}
