//! What a case costs: memory of the whole process, and time. Rough guides, for the reader.

use std::thread;

use stosszahl_case::Kind;
use stosszahl_case::format::Selection;

use super::data::{EngineKind, EnginePlan, Plan};

/// Collisions and simulator steps a second that the estimate of the time assumes.
const COLLISIONS_PER_SECOND: f64 = 4e5;
const SIMULATOR_STEPS_PER_SECOND: f64 = 1.5e7;
/// Collisions of simulators with partners across cells, in a second.
const COLLISIONS_ACROSS_PER_SECOND: f64 = 1e6;
/// Memory of the program itself \[bytes\].
const PROGRAM: f64 = 64e6;
/// Bytes of a disk in exact dynamics: the engine, its checkpoint, a copy that is written, and what probes look at.
const BYTES_EXACT: f64 = 220.0 + 2.0 * 48.0 + PARTICLE;
/// Bytes of a simulator in cells, alike.
const BYTES_IN_CELLS: f64 = 100.0 + 2.0 * 48.0 + PARTICLE;
/// Bytes of a particle without positions, alike, and what its displacement adds.
const BYTES_HOMOGENEOUS: f64 = 38.0 + 2.0 * 40.0 + PARTICLE;
/// One particle as measurements see it.
const PARTICLE: f64 = size_of::<stosszahl_model::Particle>() as f64;

/// Cost of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Most memory of the whole process \[bytes\]: all engines and replicas that run at once.
    pub bytes: f64,
    /// Computing time of all replicas on one core \[s\].
    pub core_seconds: f64,
    /// Number of engines of all replicas, which run side by side.
    pub jobs: usize,
}

impl Cost {
    /// Time on so many threads \[s\].
    pub fn seconds(&self, threads: usize) -> f64 {
        self.core_seconds / threads.clamp(1, self.jobs.max(1)) as f64
    }
}

impl Plan {
    /// Cost on so many threads.
    pub fn cost(&self, threads: usize) -> Cost {
        let replicas = self.case.replicas as f64;
        let start = 0.5 * self.count() as f64 * self.equilibration() / COLLISIONS_PER_SECOND;
        let each = self.engines.iter().map(|engine| self.seconds(engine));
        let mut sizes: Vec<f64> = self
            .engines
            .iter()
            .map(|engine| self.bytes(engine))
            .collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        let jobs = self.engines.len() * self.case.replicas as usize;
        // The largest engines of as many replicas as there are threads for.
        let mut left = threads.clamp(1, jobs.max(1)) as f64;
        let mut bytes = PROGRAM + 2.0 * PARTICLE * self.count() as f64;
        for size in sizes {
            let now = left.min(replicas);
            bytes += now * size;
            left -= now;
        }
        Cost {
            bytes,
            core_seconds: replicas * (start + each.sum::<f64>()),
            jobs,
        }
    }

    /// Bytes of one engine of one replica, with its start, its checkpoint and what probes look at.
    pub fn bytes(&self, engine: &EnginePlan) -> f64 {
        let particles = self.count() as f64;
        match &engine.kind {
            EngineKind::EventDriven { .. } => BYTES_EXACT * particles,
            EngineKind::MonteCarlo(_) => {
                (BYTES_IN_CELLS * engine.copies() as f64 + 2.0 * PARTICLE) * particles
            }
            EngineKind::Homogeneous(_) => BYTES_HOMOGENEOUS * particles,
        }
    }

    /// Seconds of one engine of one replica on one core.
    fn seconds(&self, engine: &EnginePlan) -> f64 {
        let particles = self.count() as f64;
        let pairs = 0.5 * particles * self.expected_collisions(self.case.run.until);
        match &engine.kind {
            EngineKind::EventDriven { .. } => pairs / COLLISIONS_PER_SECOND,
            EngineKind::MonteCarlo(parameters) => {
                let copies = engine.copies() as f64;
                let across = if parameters.scheme.is_across() {
                    copies * pairs / COLLISIONS_ACROSS_PER_SECOND
                } else {
                    0.0
                };
                across
                    + self.expected_steps(parameters) * particles * copies
                        / SIMULATOR_STEPS_PER_SECOND
            }
            EngineKind::Homogeneous(selection) => {
                pairs
                    / match selection {
                        Selection::AliasTables => 3e6,
                        Selection::LowRank => 1.5e6,
                        Selection::SingleMajorant => 2e5,
                    }
            }
        }
    }

    /// Time steps of a Monte Carlo engine up to the end of the run, about.
    pub fn expected_steps(&self, parameters: &stosszahl_dsmc::Parameters) -> f64 {
        // The fastest of many simulators has about 4.5 thermal speeds, a mean one 1.25.
        let mut step = self.scheme_path(parameters) / 1.25;
        if !parameters.scheme.is_across() {
            step = step.min(self.cell(parameters)[0] / 4.5);
        }
        let until = self.case.run.until;
        let thermal = match self.kind {
            Kind::Comparison => 1.0,
            _ => (self.temperature
                / self
                    .species
                    .iter()
                    .map(|one| one.mass)
                    .fold(f64::INFINITY, f64::min))
            .sqrt(),
        };
        let time = self.expected_collisions(until) * self.mean_free_time;
        time * thermal * parameters.steps_per_crossing / step
    }
}

/// Memory that is free for programs now \[bytes\], where the system says so.
pub fn available_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// Threads that the system offers.
pub fn available_threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}
