//! Peak memory of the process in a run.
//!
//! The memory of an engine peaks when a measurement samples all particles or processes its sample,
//! or when a checkpoint is written. The process then holds the gas, the records of its
//! measurements, and both again as bytes on their way to the file. Records stay until the result
//! tables are made. Large figures can take more memory than this after the run, when the report is
//! made.

use stosszahl_model::SizeDistribution;
use stosszahl_results::{Role, TableCell};

use crate::measure::{Measure, empty_tables, share_of_others};
use crate::plan::{CasePlan, EngineKind, EnginePlan};

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
/// Memory of one scheduled event in the run of an engine \[bytes\].
const DUE: f64 = 96.0;
/// Memory of one sample time of a measure while the schedule is built \[bytes\].
const LOOK: f64 = 32.0;
/// Number of sample times below which the tables of a measure are not counted as memory.
const FEW_LOOKS: usize = 1000;
/// Memory of a table row in addition to its cells \[bytes\].
const ROW: f64 = 64.0;
/// Memory of a table with its text and figures during the report, over the memory of its rows;
/// 3.0 to 3.7 were measured.
const REPORTED: f64 = 3.4;
/// Default number of particles of each species whose whole trajectories are stored.
const PATHS: i64 = 1000;

/// Estimate of the peak memory of a run, of each engine and of the process.
pub(super) struct PeakMemory<'a> {
    plan: &'a CasePlan,
    threads: usize,
    /// Memory that measurements store for each engine \[bytes\]: in the first replica, and in each
    /// further one.
    kept: Vec<[f64; 2]>,
    /// True if a measurement needs the list of all particles.
    gathers: bool,
    /// Largest working memory of one measurement, without the particle list \[bytes\].
    working: f64,
    /// Memory per particle that one measurement takes only after all others have sampled \[bytes\].
    last: f64,
    /// Memory of the sample schedule in each engine run \[bytes\].
    schedule: f64,
    /// Memory of all result tables with their figures \[bytes\].
    tables: f64,
    /// Memory of the report's figures \[bytes\].
    figures: f64,
}

impl<'a> PeakMemory<'a> {
    /// Sums what the measures of a case store and need, for a run on `threads` threads.
    pub(super) fn new(
        plan: &'a CasePlan,
        measures: &[&'static dyn Measure],
        threads: usize,
    ) -> Self {
        let all = measures.iter();
        let engines = plan.engines.iter();
        Self {
            plan,
            threads,
            kept: engines
                .map(|engine| kept_by_measures(plan, engine, measures))
                .collect(),
            gathers: all.clone().any(|one| one.gathers_particles(plan)),
            working: (all.clone().map(|one| one.working_bytes(plan))).fold(0.0, f64::max),
            last: (all.clone().map(|one| one.kept_last_per_particle(plan))).sum(),
            schedule: schedule_bytes(plan, measures),
            tables: table_bytes(plan, measures),
            figures: all.map(|one| one.figure_bytes(plan)).sum(),
        }
    }

    /// Estimates the peak memory of the process \[bytes\]: the largest engines of as many replicas
    /// as there are threads for, and all records.
    pub(super) fn of_process(&self) -> f64 {
        let replicas = self.plan.case.replicas as usize;
        let mut parts: Vec<(f64, f64)> = Vec::new();
        let mut records = 0.0;
        for (index, kept) in self.kept.iter().enumerate() {
            records += kept[0] + (replicas - 1) as f64 * kept[1];
            for replica in 0..replicas.min(self.threads) {
                let is_first = replica == 0;
                let kept = kept[usize::from(!is_first)];
                parts.push((self.of_engine(index, is_first), kept));
            }
        }
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        parts.truncate(self.threads);
        let parts: f64 = parts
            .iter()
            .map(|part| part.0 - part.1 + self.schedule)
            .sum();
        let running = self.starts() + parts + records;
        // Tables are made while there are the records, and read again for the report.
        PROGRAM
            + running
                .max(records + self.tables)
                .max(self.figures + self.tables)
    }

    /// Estimates the memory of the largest gas of which several processes hold a part each
    /// \[bytes\]; 0 if one process must hold all of it.
    pub(super) fn divisible(&self) -> f64 {
        if self.gathers || self.starts() > 0.0 {
            return 0.0;
        }
        let engines = self.kept.iter().enumerate();
        let alone = engines.map(|(index, kept)| self.of_engine(index, true) - 2.0 * kept[0]);
        alone.fold(0.0, f64::max)
    }

    /// Estimates the memory of initial states that are made whole and shared by engines \[bytes\].
    fn starts(&self) -> f64 {
        let plan = self.plan;
        let is_made_whole = |engine: &EnginePlan| !plan.has_independent_start(engine);
        if !plan.has_box() || !plan.engines.iter().any(is_made_whole) {
            return 0.0;
        }
        PARTICLE * plan.count() as f64 * self.threads.min(plan.case.replicas as usize) as f64
    }

    /// Estimates the peak memory of one engine in one replica \[bytes\]. `is_first` tells the first
    /// replica, which some measurements sample alone.
    pub(super) fn of_engine(&self, index: usize, is_first: bool) -> f64 {
        let (plan, engine) = (self.plan, &self.plan.engines[index]);
        let kept = self.kept[index][usize::from(!is_first)];
        let count = plan.count() as f64 * engine.copies() as f64;
        let vector = 8.0 * plan.gas.dimension as f64;
        let spin = match (plan.gas.particles.rough.is_some(), plan.gas.dimension) {
            (false, _) => 0.0,
            (true, 2) => 8.0,
            (true, _) => 24.0,
        };
        let unequal = !matches!(plan.gas.particles.sizes, SizeDistribution::Equal(_));
        let tag = if unequal { 8.0 } else { 0.0 };
        // Position and velocity.
        let moving = 2.0 * vector + spin;
        let gathered = if self.gathers { PARTICLE } else { 0.0 };
        let (held, saved, look) = match &engine.kind {
            EngineKind::EventDriven { .. } => {
                let engine = 104.0 + moving + 8.0 + tag + 2.0 * spin + self.strips();
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
        let paths = paths(plan, engine);
        let cells = match &engine.kind {
            EngineKind::MonteCarlo(parameters) if !plan.is_uniform() => {
                COUNTED_CELL * plan.cells(parameters)
            }
            EngineKind::MonteCarlo(parameters) => CELL * plan.cells(parameters),
            _ => 0.0,
        };
        let own = held * count + cells + kept + paths;
        let tables = if plan.is_disk_fluid() { TABLES } else { 0.0 };
        // While others look, or the gas is saved, the last of what is kept is still to come.
        let last = self.last * count;
        let saving = saved * count + kept + paths - last;
        own + (look * count).max(saving).max(self.working + tables - last)
    }

    /// Returns the memory per disk for the parallel strips of an event-driven gas \[bytes\]; 0
    /// without strips.
    fn strips(&self) -> f64 {
        let plan = self.plan;
        let parts = plan.engines.len() * plan.case.replicas as usize;
        let strips = stosszahl_ed::strips_for(self.threads / parts.max(1), plan.count());
        if strips > 1 && !plan.is_sheared() {
            STRIP * (strips + 1) as f64
        } else {
            0.0
        }
    }
}

/// Estimates what the measures of a case store for one engine \[bytes\]: in the first replica, and
/// in each further one.
fn kept_by_measures(
    plan: &CasePlan,
    engine: &EnginePlan,
    measures: &[&'static dyn Measure],
) -> [f64; 2] {
    let count = (plan.count() * engine.copies()) as f64;
    [true, false].map(|is_first| {
        let samples = |one: &&&'static dyn Measure| {
            if is_first {
                one.looks_at(plan, 0)
            } else {
                share_of_others(**one, plan) > 0.0
            }
        };
        let kept = measures.iter().filter(samples).map(|one| {
            let looks = one.sample_times(plan).len() as f64;
            count * one.kept_per_particle(plan)
                + one.kept_bytes(plan)
                + looks * one.kept_per_look(plan)
        });
        kept.sum()
    })
}

/// Estimates the memory of stored trajectories and displacements of a gas without positions
/// \[bytes\].
fn paths(plan: &CasePlan, engine: &EnginePlan) -> f64 {
    let EngineKind::Homogeneous(_) = engine.kind else {
        return 0.0;
    };
    let corner = 8.0 + 8.0 * plan.gas.dimension as f64;
    let measures = &plan.case.measure;
    let follows = [
        "displacement",
        "velocity_correlation",
        "time_averaged_displacement",
    ];
    let followed = follows.iter().any(|name| measures.contains_key(*name));
    let places = if followed {
        corner * plan.count() as f64
    } else {
        0.0
    };
    let chosen = measures
        .get("time_averaged_displacement")
        .map_or(0, |options| {
            let particles = options.get("particles").and_then(toml::Value::as_integer);
            particles.unwrap_or(PATHS).max(0)
        });
    let chosen: f64 = (plan.gas.species.iter())
        .map(|one| (one.count as f64).min(chosen as f64))
        .sum();
    let corners = 1.0 + plan.expected_collisions(plan.case.run.until);
    places + chosen * corners * corner
}

/// Estimates the memory of the schedule of one engine run \[bytes\].
fn schedule_bytes(plan: &CasePlan, measures: &[&'static dyn Measure]) -> f64 {
    let looks = measures.iter().map(|one| one.sample_times(plan).len());
    let (most, all) = looks.fold((0, 0), |(most, all), one| (most.max(one), all + one));
    DUE * most as f64 + LOOK * all as f64
}

/// Estimates the memory of all tables with rows for each time, with their text and figures in the
/// report \[bytes\].
fn table_bytes(plan: &CasePlan, measures: &[&'static dyn Measure]) -> f64 {
    let looks = measures.iter().map(|one| one.sample_times(plan).len());
    let most = looks.max().unwrap_or(0);
    if most < FEW_LOOKS {
        return 0.0;
    }
    let mut all = 0.0;
    for (one, table) in empty_tables(plan, measures) {
        let has = |name: &str| {
            let mut columns = table.columns.iter();
            columns.any(|column| column.role == Role::Key && column.name == name)
        };
        if !has("time") {
            continue;
        }
        // Tables made from records of another measure have its times.
        let times = Some(one.sample_times(plan).len()).filter(|times| *times > 0);
        let mut rows = (times.unwrap_or(most) * plan.engines.len()) as f64;
        if has("replica") {
            rows *= plan.case.replicas as f64;
        }
        if has("species") {
            rows *= plan.gas.species.len() as f64;
        }
        all += rows * (ROW + (size_of::<TableCell>() * table.columns.len()) as f64);
    }
    REPORTED * all
}
