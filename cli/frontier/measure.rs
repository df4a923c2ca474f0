//! Runs of many settings on all cores: each run on one thread, with its own time, memory and counts of work.
//!
//! Starts of replica r are the same for all settings of a size: what differs between two settings is then less noisy than
//! either. A run takes one thread, so that its CPU time is its cost whatever else the machine does.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Instant;

use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};
use stosszahl_model::State;

use super::FrontierError;
use super::quantity::observe;
use super::setting::{Setting, resized};
use crate::dispatch::{Planar, Visit, with_scene};
use crate::run::{RunError, Unsaved};
use crate::setup::Setup;

/// Most memory of the starts that are kept for other settings \[bytes\].
const STARTS: usize = 1 << 29;

/// What one run gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sample {
    /// The quantities, in their order.
    pub(crate) values: Vec<f64>,
    /// Pair collisions, of simulators where those collide.
    pub(crate) collisions: u64,
    /// Steps of a Monte Carlo engine; 0 for exact dynamics.
    pub(crate) steps: u64,
    /// Memory of the engine \[bytes\].
    pub(crate) bytes: usize,
    /// CPU time of the start \[s\].
    pub(crate) start_seconds: f64,
    /// CPU time of the engine and its measurements \[s\].
    pub(crate) engine_seconds: f64,
    /// Wall time of both \[s\].
    pub(crate) wall_seconds: f64,
}

impl Sample {
    /// CPU time of the start and the engine \[s\].
    pub(crate) fn core_seconds(&self) -> f64 {
        self.start_seconds + self.engine_seconds
    }
}

/// Runs that are wanted of a setting.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// The setting.
    pub(crate) setting: Setting,
    /// Which replicas.
    pub(crate) replicas: Range<u64>,
}

/// What became of a task: its runs in the order of the replicas, or why it was left out.
pub(crate) type Outcome = Result<Vec<Sample>, String>;

/// Where runs are made, and what they may cost.
pub(crate) struct Workshop<'a> {
    /// The measured case.
    pub(crate) setup: &'a Setup,
    /// Threads.
    pub(crate) threads: usize,
    /// CPU time after which no run is begun \[s\].
    pub(crate) limit: f64,
    /// CPU time so far \[s\].
    pub(crate) spent: Mutex<f64>,
    /// Told now and then which run has ended.
    pub(crate) tell: &'a (dyn Fn(&str) + Sync),
}

impl Workshop<'_> {
    /// CPU time so far \[s\].
    pub(crate) fn spent(&self) -> f64 {
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does all tasks, cheap ones first; outcomes are in the order of the tasks.
    ///
    /// # Errors
    /// [`FrontierError`] if a system size cannot be set up or threads cannot be started. What a run itself cannot do is
    /// in its outcome.
    pub(crate) fn run(&self, tasks: &[Task]) -> Result<Vec<Outcome>, FrontierError> {
        let mut sizes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, task) in tasks.iter().enumerate() {
            sizes.entry(task.setting.disks).or_default().push(index);
        }
        let mut outcomes: Vec<Outcome> = vec![Ok(Vec::new()); tasks.len()];
        for (disks, members) in sizes {
            let setup = Setup::new(&resized(&self.setup.case, disks))?;
            let group = Group {
                workshop: self,
                setup: &setup,
                tasks: members.iter().map(|&index| &tasks[index]).collect(),
            };
            let done = with_scene(&setup, group)?;
            for (index, outcome) in members.into_iter().zip(done) {
                outcomes[index] = outcome;
            }
        }
        Ok(outcomes)
    }
}

/// Tasks of one system size.
struct Group<'a> {
    workshop: &'a Workshop<'a>,
    setup: &'a Setup,
    tasks: Vec<&'a Task>,
}

/// A start that several settings share, with the CPU and wall time it took.
type Shared<P> = OnceLock<Result<(State<P>, [f64; 2]), String>>;

impl Visit for Group<'_> {
    type Output = Result<Vec<Outcome>, FrontierError>;

    fn visit<P: Planar>(self, scene: P) -> Self::Output {
        let first = self.tasks.iter().map(|task| task.replicas.start).min();
        let end = self.tasks.iter().map(|task| task.replicas.end).max();
        let (first, end) = (first.unwrap_or(0), end.unwrap_or(0));
        let kept = self.tasks.len() > 1;
        let room = STARTS / (size_of::<stosszahl_model::Body<P>>() * self.setup.disks);
        let starts: Vec<Shared<P>> = (first..end)
            .take(if kept { room } else { 0 })
            .map(|_| OnceLock::new())
            .collect();
        let mut jobs: Vec<(usize, u64)> = Vec::new();
        let mut order: Vec<usize> = (0..self.tasks.len()).collect();
        let cost = |&task: &usize| self.tasks[task].setting.nominal_seconds(self.setup);
        order.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        for &task in &order {
            jobs.extend(
                self.tasks[task]
                    .replicas
                    .clone()
                    .map(|replica| (task, replica)),
            );
        }
        let bench = Bench {
            group: &self,
            scene: &scene,
            starts: &starts,
            first,
            next: AtomicUsize::new(0),
            done: Mutex::new(vec![None; jobs.len()]),
            jobs: &jobs,
        };
        bench.work()?;
        let done = bench
            .done
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        let mut outcomes: Vec<Outcome> = vec![Ok(Vec::new()); self.tasks.len()];
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

/// The queue of jobs of a group and what is done of it.
struct Bench<'a, P: Planar> {
    group: &'a Group<'a>,
    scene: &'a P,
    starts: &'a [Shared<P>],
    first: u64,
    jobs: &'a [(usize, u64)],
    next: AtomicUsize,
    done: Mutex<Vec<Option<Result<Sample, String>>>>,
}

impl<P: Planar> Bench<'_, P> {
    fn work(&self) -> Result<(), FrontierError> {
        let pools = (0..self.group.workshop.threads.max(1))
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
        let workshop = self.group.workshop;
        while workshop.spent() < workshop.limit {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(&(task, replica)) = self.jobs.get(number) else {
                return;
            };
            let found = self.sample(&self.group.tasks[task].setting, replica);
            if number.is_multiple_of(16) {
                let label = self.group.tasks[task].setting.label(workshop.setup.disks);
                (workshop.tell)(&format!(
                    "run {} of {}: {label}",
                    number + 1,
                    self.jobs.len()
                ));
            }
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            done[number] = Some(found);
        }
    }

    fn spend(&self, seconds: f64) {
        let spent = &self.group.workshop.spent;
        *spent.lock().unwrap_or_else(PoisonError::into_inner) += seconds;
    }

    fn start(&self, replica: u64) -> Result<(State<P>, [f64; 2]), String> {
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let run = Unsaved {
            setup: self.group.setup,
            replica,
        };
        let state = run
            .start(self.scene)
            .map_err(|error| format!("start: {error}"))?;
        let seconds = [cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()];
        self.spend(seconds[0]);
        Ok((state, seconds))
    }

    fn sample(&self, setting: &Setting, replica: u64) -> Result<Sample, String> {
        let own;
        let shared = self.starts.get((replica - self.first) as usize);
        let (start, [start_seconds, start_wall]) = if let Some(shared) = shared {
            shared.get_or_init(|| self.start(replica)).as_ref()?
        } else {
            own = self.start(replica)?;
            &own
        };
        let setup = self.group.setup;
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let run = Unsaved { setup, replica };
        let finished = run
            .run(self.scene, &setting.engine, start)
            .map_err(|error: RunError| error.to_string())?;
        let engine_seconds = cpu.elapsed().as_secs_f64();
        self.spend(engine_seconds);
        let whole = setup.disks == self.group.workshop.setup.disks;
        let steps = finished.work.numbers.get("steps").copied().unwrap_or(0.0);
        Ok(Sample {
            values: observe(setup, &setting.engine, &finished, whole),
            collisions: finished.work.collisions,
            steps: steps as u64,
            bytes: finished.work.bytes,
            start_seconds: *start_seconds,
            engine_seconds,
            wall_seconds: start_wall + wall.elapsed().as_secs_f64(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_numbers() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), 2.0);
        assert_eq!(median([4.0, 1.0, 2.0, 3.0].into_iter()), 2.5);
        assert!(median(std::iter::empty()).is_nan());
    }
}
