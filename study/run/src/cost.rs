//! Estimated memory and computing time of a case. Times are rough guides. Memory is the measured
//! peak of the process within a factor of 1.3 in the cases of `tests/program/memory.rs`.

mod memory;
mod time;

use crate::measure::{Measure, work_with_companions};
use crate::plan::{CasePlan, EnginePlan};

/// Estimated memory and computing time of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Peak memory of the process, with all engines and replicas that run at once \[bytes\].
    pub bytes: f64,
    /// Memory of the largest gas of which several processes hold a part each \[bytes\]; 0 if one
    /// process must hold all of it.
    pub divisible: f64,
    /// Computing times of the start and the engines of a replica, estimated by the plan or measured
    /// in a short test.
    pub pace: RuntimeEstimate,
    /// Number of replicas of the case.
    pub replicas: u64,
    /// Estimated cost of each engine, for one replica.
    pub engines: Vec<EngineCost>,
}

/// Estimated memory and number of collisions of one engine in one replica.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineCost {
    /// Name of the engine whose cost is estimated.
    pub name: &'static str,
    /// Memory of one replica of the engine \[bytes\].
    pub bytes: f64,
    /// Number of pair collisions in one replica, counted for simulators in Monte Carlo engines.
    pub collisions: f64,
    /// Candidate pairs per collision; `None` for event-driven dynamics.
    pub trials_per_collision: Option<f64>,
}

/// Computing times of the start and the engines of a replica on one core \[s\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RuntimeEstimate {
    /// Time to prepare the initial state that all engines of a replica share \[s\].
    pub start: f64,
    /// Computing time of each engine \[s\]: in the first replica, which some measurements sample
    /// alone, and in each further one.
    pub engines: Vec<[f64; 2]>,
    /// Time to solve the theory that result tables show, after all replicas \[s\].
    pub ending: f64,
}

impl RuntimeEstimate {
    /// Returns the time of a whole run of `replicas` replicas on `threads` threads \[s\]. It is the
    /// total work over the threads, or the longest single task if that is longer.
    pub fn seconds(&self, replicas: u64, threads: usize) -> f64 {
        let sum = |which: usize| self.engines.iter().map(|one| one[which]).sum::<f64>();
        let longest = self.engines.iter().map(|one| one[0]).fold(0.0, f64::max);
        let others = replicas.saturating_sub(1) as f64;
        let all = replicas as f64 * self.start + sum(0) + others * sum(1);
        (all / threads.max(1) as f64).max(self.start + longest) + self.ending
    }

    /// Multiplies the time of the start and of each engine by the factors of another estimate.
    pub(crate) fn scaled(&self, factors: &Self) -> Self {
        let both = self.engines.iter().zip(&factors.engines);
        Self {
            start: self.start * factors.start,
            engines: both.map(|(a, b)| [a[0] * b[0], a[1] * b[1]]).collect(),
            ending: self.ending.max(factors.ending),
        }
    }

    /// Returns the ratios of all times to those of `other`, as factors; the time of the theory is
    /// kept.
    pub(crate) fn ratio_to(&self, other: &Self) -> Self {
        let ratio = |a: f64, b: f64| if a > 0.0 && b > 0.0 { a / b } else { 1.0 };
        let both = self.engines.iter().zip(&other.engines);
        let both = both.map(|(a, b)| [ratio(a[0], b[0]), ratio(a[1], b[1])]);
        Self {
            start: ratio(self.start, other.start),
            engines: both.collect(),
            // It is measured where it is not guessed.
            ending: self.ending,
        }
    }
}

impl Cost {
    /// Returns the peak memory of each of `processes` processes that hold gases together \[bytes\].
    pub fn bytes_each(&self, processes: usize) -> f64 {
        self.bytes - self.divisible * (1.0 - 1.0 / processes.max(1) as f64)
    }

    /// Returns the estimated time of the whole case on `threads` threads \[s\].
    pub fn seconds(&self, threads: usize) -> f64 {
        self.pace.seconds(self.replicas, threads)
    }
}

/// Estimates memory and computing time of a case with its measures on `threads` threads.
pub(crate) fn estimate_cost(
    plan: &CasePlan,
    measures: &[&'static dyn Measure],
    threads: usize,
) -> Cost {
    let peak = memory::PeakMemory::new(plan, measures, threads);
    let engines = plan.engines.iter().enumerate();
    let engines = engines.map(|(index, engine)| EngineCost {
        name: engine.name,
        bytes: peak.of_engine(index, true),
        collisions: plan.collisions(engine),
        trials_per_collision: plan.trials_per_collision(engine),
    });
    Cost {
        bytes: peak.of_process(),
        divisible: peak.divisible(),
        pace: estimate_runtime(plan, measures),
        replicas: plan.case.replicas,
        engines: engines.collect(),
    }
}

/// Estimates the computing times of one replica at nominal speeds: its start, its engines, and
/// companion gases of measures.
pub(crate) fn estimate_runtime(
    plan: &CasePlan,
    measures: &[&'static dyn Measure],
) -> RuntimeEstimate {
    let engine = |engine: &EnginePlan| {
        let factors = work_with_companions(measures, plan, engine);
        factors.map(|factor| factor * plan.seconds(engine))
    };
    RuntimeEstimate {
        start: plan.start_seconds(),
        engines: plan.engines.iter().map(engine).collect(),
        ending: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace(start: f64, engines: &[[f64; 2]]) -> RuntimeEstimate {
        RuntimeEstimate {
            start,
            engines: engines.to_vec(),
            ending: 0.0,
        }
    }

    #[test]
    fn work_is_shared_among_threads_as_far_as_it_can_be() {
        let pace = pace(1.0, &[[10.0, 8.0], [4.0, 4.0]]);
        // Three replicas: 15 and twice 13.
        assert_eq!(pace.seconds(3, 1), 41.0);
        assert_eq!(pace.seconds(3, 2), 20.5);
        // Nothing is faster than the longest engine after its start.
        assert_eq!(pace.seconds(3, 100), 11.0);
        assert_eq!(pace.seconds(1, 1), 15.0);
        let ended = RuntimeEstimate {
            ending: 2.0,
            ..pace
        };
        assert_eq!(ended.seconds(3, 100), 13.0);
    }

    #[test]
    fn what_is_measured_once_corrects_what_is_guessed_elsewhere() {
        let (guess, found) = (pace(2.0, &[[1.0, 1.0]]), pace(1.0, &[[3.0, 2.0]]));
        let factor = found.ratio_to(&guess);
        assert_eq!(
            pace(4.0, &[[5.0, 5.0]]).scaled(&factor),
            pace(2.0, &[[15.0, 10.0]])
        );
        // What takes no time corrects nothing.
        assert_eq!(found.ratio_to(&pace(0.0, &[[1.0, 1.0]])).start, 1.0);
    }
}
