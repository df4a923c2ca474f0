//! Estimated memory and computing time of a case. Times are rough guides. Memory is the measured
//! peak of the process within a factor of 1.3 in the cases of `tests/program/memory.rs`.
//!
//! The memory of an engine peaks when a measurement samples all particles or processes its sample,
//! or when a checkpoint is written. The process then holds the gas, the records of its
//! measurements, and both again as bytes on their way to the file. Records stay until the result
//! tables are made. Large figures can take more memory than this after the run, when the report is
//! made.

use std::thread;

use stosszahl_case::format::SelectionSpec;
use stosszahl_model::SizeDistribution;
pub use stosszahl_model::memory::available as available_memory;

use super::data::{CasePlan, EngineKind, EnginePlan, SizeGroup};

/// Speed of event-driven dynamics that the time estimate assumes \[pair collisions/s\].
const COLLISIONS_PER_SECOND: f64 = 4e5;
/// Speed of Monte Carlo free flight that the time estimate assumes \[simulators moved by one time
/// step/s\].
const SIMULATOR_STEPS_PER_SECOND: f64 = 1.5e7;
/// Speed of cell crossings in event-driven dynamics that the time estimate assumes \[crossings/s\].
const CROSSINGS_PER_SECOND: f64 = 5e6;
/// Cell crossings per collision that `COLLISIONS_PER_SECOND` already includes.
const USUAL_CROSSINGS: f64 = 5.0;
/// Speed of Monte Carlo collisions with partners from other cells that the time estimate assumes
/// \[collisions/s\].
const COLLISIONS_ACROSS_PER_SECOND: f64 = 1e6;
/// Speed of Monte Carlo candidate pairs that the time estimate assumes \[pairs/s\].
const TRIALS_PER_SECOND: f64 = 5e6;
/// Candidate pairs per collision of equal particles: for partners in one cell, and for partners
/// across cells, whose speed bound is wider.
const TRIALS: [f64; 2] = [2.0, 4.0];
/// Memory of the program without any gas \[bytes\].
const PROGRAM: f64 = 16e6;
/// Memory of the tables for tests of the initial state \[bytes\].
const TABLES: f64 = 4e6;
/// Memory of one particle in the list that measurements read \[bytes\].
const PARTICLE: f64 = size_of::<stosszahl_model::Particle>() as f64;
/// Memory per particle without positions while speed bounds are fitted for pair selection
/// \[bytes\].
const FITTING: f64 = 60.0;

/// Memory unit per disk when n strips share an event-driven gas: n + 1 units \[bytes\].
const STRIP: f64 = 64.0;

/// Memory of one Monte Carlo cell \[bytes\].
const CELL: f64 = 8.0;
/// Memory of one Monte Carlo cell with its own collision counter, next to walls or in gravity
/// \[bytes\].
const COUNTED_CELL: f64 = 24.0;
/// Computing time of one Monte Carlo cell in a time step, over that of one simulator.
const CELL_STEPS: f64 = 0.3;

/// Largest number of size classes whose pairs are all summed for the cost estimate; of more
/// classes, a sample is used.
const MOST_KINDS: usize = 200;
/// Default number of particles of each species whose whole trajectories are stored.
const PATHS: i64 = 1000;

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

/// Memory that a measurement stores for one engine \[bytes\]: in the first replica, and in each
/// further one.
pub type MeasureMemory = [f64; 2];

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

/// Memory that measurements need while they sample a gas.
#[derive(Clone, Copy, Debug, Default)]
pub struct Looks {
    /// True if a measurement needs the list of all particles.
    pub gathers: bool,
    /// Largest working memory of one measurement, without the particle list \[bytes\].
    pub working: f64,
    /// Memory per particle that one measurement takes only after all others have sampled \[bytes\].
    pub last: f64,
    /// Memory of the sample schedule in each engine run \[bytes\].
    pub schedule: f64,
    /// Memory of all result tables with their figures \[bytes\].
    pub tables: f64,
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

impl CasePlan {
    /// Estimates computing time and peak memory of the case on `threads` threads. `kept` is the
    /// memory that measurements store for each engine, `figures` that of the report's figures
    /// \[bytes\].
    pub fn cost(
        &self,
        threads: usize,
        kept: &[MeasureMemory],
        sampling: &Looks,
        figures: f64,
    ) -> Cost {
        let replicas = self.case.replicas as usize;
        let particles = self.count() as f64;
        let engines = self.engines.iter().zip(kept);
        let engines: Vec<EngineCost> = engines
            .map(|(engine, kept)| EngineCost {
                name: engine.name,
                bytes: self.engine_bytes(engine, kept[0], sampling, threads),
                collisions: self.collisions(engine),
                trials_per_collision: self.trials_per_collision(engine),
            })
            .collect();
        // The largest engines of as many replicas as there are threads for; records stay to the end
        // of the run.
        let mut parts: Vec<(f64, f64)> = Vec::new();
        let mut records = 0.0;
        for (engine, kept) in self.engines.iter().zip(kept) {
            records += kept[0] + (replicas - 1) as f64 * kept[1];
            for replica in 0..replicas.min(threads) {
                let kept = kept[replica.min(1)];
                parts.push((self.engine_bytes(engine, kept, sampling, threads), kept));
            }
        }
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        parts.truncate(threads);
        let is_made_whole = |engine: &EnginePlan| !self.has_independent_start(engine);
        let starts = if self.has_box() && self.engines.iter().any(is_made_whole) {
            PARTICLE * particles * threads.min(replicas) as f64
        } else {
            0.0
        };
        let divisible = if sampling.gathers || starts > 0.0 {
            0.0
        } else {
            let engines = self.engines.iter().zip(kept);
            let alone = engines.map(|(engine, kept)| {
                self.engine_bytes(engine, kept[0], sampling, threads) - 2.0 * kept[0]
            });
            alone.fold(0.0, f64::max)
        };
        let parts: f64 = parts
            .iter()
            .map(|part| part.0 - part.1 + sampling.schedule)
            .sum();
        let running = starts + parts + records;
        // Tables are made while there are the records, and read again for the report.
        let bytes = PROGRAM
            + running
                .max(records + sampling.tables)
                .max(figures + sampling.tables);
        Cost {
            bytes,
            divisible,
            pace: self.pace(),
            replicas: self.case.replicas,
            engines,
        }
    }

    /// Estimates the computing times of the start and the engines of a replica from assumed speeds.
    pub fn pace(&self) -> RuntimeEstimate {
        let engines = self.engines.iter().map(|engine| [self.seconds(engine); 2]);
        RuntimeEstimate {
            start: self.start_seconds(),
            engines: engines.collect(),
            ending: 0.0,
        }
    }

    /// Returns the memory per disk for the parallel strips of an event-driven gas \[bytes\]; 0
    /// without strips.
    fn strips(&self, threads: usize) -> f64 {
        let parts = self.engines.len() * self.case.replicas as usize;
        let strips = stosszahl_ed::strips_for(threads / parts.max(1), self.count());
        if strips > 1 && !self.is_sheared() {
            STRIP * (strips + 1) as f64
        } else {
            0.0
        }
    }

    /// Estimates the peak memory of one engine in one replica on `threads` threads \[bytes\].
    /// `kept` is the memory that its measurements store.
    fn engine_bytes(
        &self,
        engine: &EnginePlan,
        kept: f64,
        sampling: &Looks,
        threads: usize,
    ) -> f64 {
        let count = self.count() as f64 * engine.copies() as f64;
        let vector = 8.0 * self.gas.dimension as f64;
        let spin = match (self.gas.particles.rough.is_some(), self.gas.dimension) {
            (false, _) => 0.0,
            (true, 2) => 8.0,
            (true, _) => 24.0,
        };
        let unequal = !matches!(self.gas.particles.sizes, SizeDistribution::Equal(_));
        let tag = if unequal { 8.0 } else { 0.0 };
        // Position and velocity.
        let moving = 2.0 * vector + spin;
        let gathered = if sampling.gathers { PARTICLE } else { 0.0 };
        let (held, saved, look) = match &engine.kind {
            EngineKind::EventDriven { .. } => {
                let engine = 104.0 + moving + 8.0 + tag + 2.0 * spin + self.strips(threads);
                // The beginning of the leg stays next to the engine; measurements see a copy of the
                // gas.
                (engine + moving, moving + 8.0, moving + 8.0 + gathered)
            }
            EngineKind::MonteCarlo(parameters) => {
                // With partners across cells 28 bytes more of a simulator were found in the plane.
                let held = if parameters.scheme.is_cross_cell() {
                    3.0
                } else {
                    2.0
                };
                (held * (moving + tag), moving + tag, gathered)
            }
            EngineKind::Homogeneous(_) => {
                (2.0 * (vector + 13.0), vector + 4.0, gathered.max(FITTING))
            }
        };
        let paths = self.paths(engine);
        let cells = match &engine.kind {
            EngineKind::MonteCarlo(parameters) if !self.is_uniform() => {
                COUNTED_CELL * self.cells(parameters)
            }
            EngineKind::MonteCarlo(parameters) => CELL * self.cells(parameters),
            _ => 0.0,
        };
        let own = held * count + cells + kept + paths;
        let tables = if self.is_disk_fluid() { TABLES } else { 0.0 };
        // While others look, or the gas is saved, the last of what is kept is still to come.
        let last = sampling.last * count;
        let saving = saved * count + kept + paths - last;
        own + (look * count)
            .max(saving)
            .max(sampling.working + tables - last)
    }

    /// Returns the memory of stored trajectories and displacements of a gas without positions
    /// \[bytes\].
    fn paths(&self, engine: &EnginePlan) -> f64 {
        let EngineKind::Homogeneous(_) = engine.kind else {
            return 0.0;
        };
        let corner = 8.0 + 8.0 * self.gas.dimension as f64;
        let measures = &self.case.measure;
        let follows = [
            "displacement",
            "velocity_correlation",
            "time_averaged_displacement",
        ];
        let followed = follows.iter().any(|name| measures.contains_key(*name));
        let places = if followed {
            corner * self.count() as f64
        } else {
            0.0
        };
        let chosen = measures
            .get("time_averaged_displacement")
            .map_or(0, |options| {
                let particles = options.get("particles").and_then(toml::Value::as_integer);
                particles.unwrap_or(PATHS).max(0)
            });
        let chosen: f64 = self
            .gas
            .species
            .iter()
            .map(|one| (one.count as f64).min(chosen as f64))
            .sum();
        let corners = 1.0 + self.expected_collisions(self.case.run.until);
        places + chosen * corners * corner
    }

    /// Returns the cell crossings per pair collision of event-driven disks in a uniform gas.
    pub(crate) fn crossings_per_collision(&self) -> f64 {
        let [width, height, _] = self.gas.lengths;
        let diameters = self.gas.species.iter().map(|one| 2.0 * one.radius);
        stosszahl_ed::crossings_per_collision(
            [width, height],
            self.count(),
            diameters.fold(0.0, f64::max),
            self.dilute_mean_free_path(),
            !self.case.obstacle.is_empty(),
        )
    }

    /// Returns the time of event-driven dynamics for `pairs` pair collisions on one core \[s\].
    fn exact_seconds(&self, pairs: f64) -> f64 {
        let crossings = (self.crossings_per_collision() - USUAL_CROSSINGS).max(0.0);
        pairs * (1.0 / COLLISIONS_PER_SECOND + crossings / CROSSINGS_PER_SECOND)
    }

    /// Returns the time to equilibrate the initial state of one replica on one core \[s\].
    fn start_seconds(&self) -> f64 {
        if self.equilibration() == 0.0 {
            return 0.0;
        }
        self.exact_seconds(0.5 * self.count() as f64 * self.equilibration())
    }

    /// Estimates the number of pair collisions of one engine in one replica.
    pub fn collisions(&self, engine: &EnginePlan) -> f64 {
        let copies = engine.copies() as f64;
        0.5 * copies * self.count() as f64 * self.expected_collisions(self.case.run.until)
    }

    /// Estimates the candidate pairs per collision; `None` for event-driven dynamics. Candidates
    /// are drawn for the largest diameter and the largest thermal speed, so it is that bound over
    /// the mean of `sigma^(D-1) v`.
    pub fn trials_per_collision(&self, engine: &EnginePlan) -> Option<f64> {
        let trials = match &engine.kind {
            EngineKind::EventDriven { .. } => return None,
            EngineKind::Homogeneous(SelectionSpec::AliasTables | SelectionSpec::LowRank) => {
                return Some(TRIALS[0]);
            }
            EngineKind::Homogeneous(SelectionSpec::SingleMajorant) => TRIALS[1],
            EngineKind::MonteCarlo(parameters) => {
                TRIALS[usize::from(parameters.scheme.is_cross_cell())]
            }
        };
        // Diameter, square of the speed, and share of each class; the largest of all particles may
        // exceed its class.
        let largest = match &self.gas.particles.sizes {
            SizeDistribution::Equal(_) => return Some(trials),
            SizeDistribution::Each(all) => all
                .pairs()
                .iter()
                .map(|one| 2.0 * one.0)
                .fold(0.0, f64::max),
            SizeDistribution::Species(_) => 0.0,
        };
        let kind = |one: &SizeGroup| [one.diameter, one.temperature / one.mass, one.count as f64];
        let most = |index: usize| {
            let all = self.gas.classes.iter().map(|one| kind(one)[index]);
            all.fold(if index == 0 { largest } else { 0.0 }, f64::max)
        };
        let power = self.gas.dimension as i32 - 1;
        let bound = most(0).powi(power) * (2.0 * most(1)).sqrt();
        let kinds: Vec<[f64; 3]> = sampled(&self.gas.classes).map(kind).collect();
        let pairs = kinds.iter().flat_map(|a| kinds.iter().map(move |b| (a, b)));
        let (mut sum, mut weight) = (0.0, 0.0);
        for (a, b) in pairs {
            let share = a[2] * b[2];
            sum += share * (0.5 * (a[0] + b[0])).powi(power) * (a[1] + b[1]).sqrt();
            weight += share;
        }
        Some((trials * bound * weight / sum).max(trials))
    }

    /// Estimates the computing time of one engine in one replica on one core \[s\].
    pub fn seconds(&self, engine: &EnginePlan) -> f64 {
        let particles = self.count() as f64;
        let pairs = 0.5 * particles * self.expected_collisions(self.case.run.until);
        let trials = self.trials_per_collision(engine).unwrap_or(0.0);
        let tried = self.collisions(engine) * trials / TRIALS_PER_SECOND;
        match &engine.kind {
            EngineKind::EventDriven { .. } => self.exact_seconds(pairs),
            EngineKind::MonteCarlo(parameters) => {
                let copies = engine.copies() as f64;
                let across = if parameters.scheme.is_cross_cell() {
                    copies * pairs / COLLISIONS_ACROSS_PER_SECOND
                } else {
                    0.0
                };
                across.max(tried)
                    + self.expected_steps(parameters)
                        * (particles * copies + CELL_STEPS * self.cells(parameters))
                        / SIMULATOR_STEPS_PER_SECOND
            }
            EngineKind::Homogeneous(selection) => {
                let rate = match selection {
                    SelectionSpec::AliasTables => 3e6,
                    SelectionSpec::LowRank => 1.5e6,
                    SelectionSpec::SingleMajorant => 2e5,
                };
                (pairs / rate).max(tried)
            }
        }
    }

    /// Returns the number of cells of a Monte Carlo engine.
    fn cells(&self, parameters: &stosszahl_dsmc::Parameters) -> f64 {
        let cell: f64 = self.cell(parameters)[..self.gas.dimension].iter().product();
        self.box_volume() / cell
    }

    /// Estimates the number of time steps of a Monte Carlo engine until the end of the run.
    pub fn expected_steps(&self, parameters: &stosszahl_dsmc::Parameters) -> f64 {
        // The fastest of many simulators has about 4.5 thermal speeds, a mean one 1.25.
        let mut step = self.scheme_path(parameters) / 1.25;
        if !parameters.scheme.is_cross_cell() {
            step = step.min(self.cell(parameters)[0] / 4.5);
        }
        let until = self.case.run.until;
        let masses = self.gas.species.iter().map(|one| one.mass);
        let lightest = masses.fold(f64::INFINITY, f64::min);
        let thermal = (self.gas.temperature / lightest).sqrt();
        let time = self.expected_collisions(until) * self.clock.mean_free_time;
        time * thermal * parameters.steps_per_cell_crossing / step
    }
}

/// Returns at most 200 evenly spaced elements of a list, for sums over all pairs of size classes.
fn sampled<T>(all: &[T]) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(MOST_KINDS).max(1))
}

/// Returns the number of threads of the current pool for each of `parts` parallel tasks, at least
/// 1.
pub fn threads_each(parts: usize) -> usize {
    (rayon::current_num_threads() / parts.max(1)).max(1)
}

/// Returns the number of threads that the operating system offers.
pub fn available_threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
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
