//! Runs of many settings on all cores: each run on one thread, with its own time, memory and counts of work.
//!
//! Starts of replica r are the same for all settings of a size: what differs between two settings is then less noisy than
//! either. A run takes one thread, so that its CPU time is its cost whatever else the machine does.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Instant;

use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Interrupt, Particle, Particles};

use super::FrontierError;
use super::quantity::observe;
use super::setting::Setting;
use super::together::{Together, Turns};
use crate::measure::Measure;
use crate::plan::Plan;
use crate::unsaved::{Unsaved, resized};

/// Most memory of the starts that are kept for other settings \[bytes\].
const STARTS: usize = 1 << 29;

/// What one run gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sample {
    /// The quantities, in their order.
    pub values: Vec<f64>,
    /// Pair collisions, of simulators where those collide.
    pub collisions: u64,
    /// Steps of a Monte Carlo engine; 0 for exact dynamics.
    pub steps: u64,
    /// Memory of the engine \[bytes\].
    pub bytes: usize,
    /// CPU time of the start, the engine and its measurements \[s\].
    pub core_seconds: f64,
    /// Wall time of both \[s\].
    pub wall_seconds: f64,
}

/// Runs that are wanted of a setting.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// The setting.
    pub setting: Setting,
    /// Which replicas.
    pub replicas: Range<u64>,
}

/// What became of a task: its runs in the order of the replicas, or why it was left out.
pub(crate) type Outcome = Result<Vec<Sample>, String>;

/// Where runs are made, and what they may cost.
pub(crate) struct Workshop<'a> {
    /// The measured case.
    pub plan: &'a Plan,
    /// What is measured.
    pub measures: Vec<&'static dyn Measure>,
    /// Threads.
    pub threads: usize,
    /// CPU time after which no run is begun \[s\].
    pub limit: f64,
    /// CPU time so far \[s\].
    pub spent: Mutex<f64>,
    /// Told now and then which run has ended.
    pub tell: &'a (dyn Fn(&str) + Sync),
    /// Raised to end early.
    pub interrupt: &'a Interrupt,
    /// Who makes the runs.
    pub together: Together<'a>,
    /// Groups of tasks so far.
    pub groups: AtomicU64,
}

impl Workshop<'_> {
    /// CPU time so far \[s\].
    pub(crate) fn spent(&self) -> f64 {
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does all tasks, cheap ones first; outcomes are in the order of the tasks.
    ///
    /// # Errors
    /// [`FrontierError`] if a system size cannot be planned or threads cannot be started. What a run itself cannot do is
    /// in its outcome.
    pub(crate) fn run(&self, tasks: &[Task]) -> Result<Vec<Outcome>, FrontierError> {
        let mut sizes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, task) in tasks.iter().enumerate() {
            sizes.entry(task.setting.disks).or_default().push(index);
        }
        let mut outcomes: Vec<Outcome> = vec![Ok(Vec::new()); tasks.len()];
        for (disks, members) in sizes {
            let whole = disks == self.plan.count();
            let plan = if whole {
                self.plan.clone()
            } else {
                let case = resized(&self.plan.case, disks, self.plan.packing_fraction);
                Plan::new(&case, &self.plan.folder)?
            };
            let group: Vec<&Task> = members.iter().map(|&index| &tasks[index]).collect();
            for (index, outcome) in members.into_iter().zip(self.group(&plan, &group)?) {
                outcomes[index] = outcome;
            }
        }
        Ok(outcomes)
    }

    /// Does one task.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub(crate) fn one(&self, task: Task) -> Result<Outcome, FrontierError> {
        let outcome = self.run(&[task])?.pop();
        Ok(outcome.unwrap_or_else(|| Ok(Vec::new())))
    }

    /// Tasks of one system size.
    fn group(&self, plan: &Plan, tasks: &[&Task]) -> Result<Vec<Outcome>, FrontierError> {
        let first = tasks.iter().map(|task| task.replicas.start).min();
        let end = tasks.iter().map(|task| task.replicas.end).max();
        let (first, end) = (first.unwrap_or(0), end.unwrap_or(0));
        let room = if tasks.len() > 1 {
            STARTS / (size_of::<Particle>() * plan.count().max(1))
        } else {
            0
        };
        let starts: Vec<Shared> = (first..end).take(room).map(|_| OnceLock::new()).collect();
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
        let bench = Bench {
            workshop: self,
            plan,
            tasks,
            starts: &starts,
            first,
            turns: self
                .together
                .turns(self.groups.fetch_add(1, Ordering::Relaxed)),
            done: Mutex::new(vec![None; jobs.len()]),
            jobs: &jobs,
        };
        let done = self.exchange(bench)?;
        let mut outcomes: Vec<Outcome> = vec![Ok(Vec::new()); tasks.len()];
        for ((task, replica), found) in jobs.iter().zip(done) {
            let found = found.unwrap_or_else(|| Err("the budget was spent before its turn".into()));
            match (&mut outcomes[*task], found) {
                (Ok(samples), Ok(sample)) => samples.push(sample),
                (known @ Ok(_), Err(reason)) => {
                    *known = Err(format!("replica {replica}: {reason}"));
                }
                (Err(_), _) => {}
            }
        }
        Ok(outcomes)
    }
}

/// What a run of a process left, by the number of the job.
type Found = Vec<(usize, Result<Sample, String>)>;

impl Workshop<'_> {
    /// Does jobs as long as there are some that nobody does, and returns those of all processes.
    fn exchange(
        &self,
        bench: Bench<'_>,
    ) -> Result<Vec<Option<Result<Sample, String>>>, FrontierError> {
        let before = self.spent();
        self.together.each(bench.work())?;
        let mut done = bench.done.into_inner();
        let known = done.as_mut().unwrap_or_else(|error| error.get_mut());
        let found = known.iter_mut().enumerate();
        let found: Found = found
            .filter_map(|(job, found)| Some((job, found.take()?)))
            .collect();
        let said = (self.interrupt.is_raised(), self.spent() - before, found);
        let (mut stops, mut spent) = (false, before);
        for (stop, more, found) in self.together.all(said) {
            stops |= stop;
            spent += more;
            for (job, found) in found {
                known[job] = Some(found);
            }
        }
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner) = spent;
        if stops {
            return Err(FrontierError::Interrupted);
        }
        Ok(std::mem::take(known))
    }
}

/// A start that several settings share, with the CPU and wall time it took.
type Shared = OnceLock<Result<(Particles, [f64; 2]), String>>;

/// The queue of jobs of a group and what is done of it.
struct Bench<'a> {
    workshop: &'a Workshop<'a>,
    plan: &'a Plan,
    tasks: &'a [&'a Task],
    starts: &'a [Shared],
    first: u64,
    jobs: &'a [(usize, u64)],
    /// Who does which.
    turns: Turns<'a>,
    done: Mutex<Vec<Option<Result<Sample, String>>>>,
}

impl Bench<'_> {
    fn work(&self) -> Result<(), FrontierError> {
        let pools = (0..self.workshop.threads.max(1))
            // An engine that would share its work with other threads finds only its own.
            .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
            .collect::<Result<Vec<_>, _>>()?;
        thread::scope(|scope| {
            for pool in &pools {
                scope.spawn(|| pool.install(|| self.serve()));
            }
        });
        Ok(())
    }

    /// Takes jobs until none is left or the budget is spent.
    fn serve(&self) {
        let workshop = self.workshop;
        while workshop.spent() < workshop.limit && !workshop.interrupt.is_raised() {
            let turn = self.turns.draw();
            let Some(&(task, replica)) = self.jobs.get(turn) else {
                return;
            };
            let setting = &self.tasks[task].setting;
            let found = self.sample(setting, replica);
            if turn.is_multiple_of(16) {
                let label = setting.label(workshop.plan);
                let (run, all) = (turn + 1, self.jobs.len());
                (workshop.tell)(&format!("run {run} of {all}: {label}"));
            }
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            done[turn] = Some(found);
        }
    }

    /// Does something, and says what CPU and wall time it took \[s\].
    fn timed<T>(&self, work: impl FnOnce() -> T) -> (T, [f64; 2]) {
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let done = work();
        let seconds = [cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()];
        let spent = &self.workshop.spent;
        *spent.lock().unwrap_or_else(PoisonError::into_inner) += seconds[0];
        (done, seconds)
    }

    fn sample(&self, setting: &Setting, replica: u64) -> Result<Sample, String> {
        let run = Unsaved {
            plan: self.plan,
            measures: &self.workshop.measures,
            replica,
            stop: self.workshop.interrupt,
        };
        let begin = || {
            let (state, seconds) = self.timed(|| run.start());
            let state = state.map_err(|error| format!("start: {error}"))?;
            Ok::<_, String>((state, seconds))
        };
        let own;
        let shared = self.starts.get((replica - self.first) as usize);
        let (start, placed) = if let Some(shared) = shared {
            shared.get_or_init(begin).as_ref().map_err(String::clone)?
        } else {
            own = begin()?;
            &own
        };
        let (finished, seconds) = self.timed(|| run.run(&setting.engine, start));
        let finished = finished.map_err(|error| error.to_string())?;
        let whole = self.plan.count() == self.workshop.plan.count();
        let steps = finished.work.numbers.get("steps").copied().unwrap_or(0.0);
        Ok(Sample {
            values: observe(self.plan, &setting.engine, &finished, whole),
            collisions: finished.work.collisions,
            steps: steps as u64,
            bytes: finished.bytes,
            core_seconds: placed[0] + seconds[0],
            wall_seconds: placed[1] + seconds[1],
        })
    }
}

/// The median of some numbers; not a number if there are none.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[count / 2],
        count => 0.5 * (values[count / 2 - 1] + values[count / 2]),
    }
}
