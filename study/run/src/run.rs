//! All points, replicas and engines of a case, side by side, into a results folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use rayon::prelude::*;
use serde_json::Value;
use stosszahl_case::format::{Placement, TimeUnit};
use stosszahl_case::{CaseError, CaseFile, Kind};
use stosszahl_model::{Interrupt, Particles};
use stosszahl_results::{
    CHECKPOINTS, Derived, EngineWork, Existing, FORMAT, Folder, FramesEntry, Keys, Machine,
    Manifest, Place, Program, ResultsError, RunId, SNAPSHOTS, Start, StartTest, Sweep, SweepPoint,
    Table, Verdict,
};

use crate::accuracy;
use crate::check::{Planned, check, level};
use crate::control::{Control, Progress};
use crate::follow::{Part, PartError, prepare};
use crate::gauge::Gauge;
use crate::judge;
use crate::measure::{Finished, Runs};
use crate::plan::{Plan, available_memory, available_threads};
use crate::start::{Preparation, StartReport, is_prepared};

/// Most threads of a run.
const MOST_THREADS: usize = 1024;
/// Keys of a case that change nothing in the folder, and those that change only how the same numbers are shown.
const KEYS: Keys<'static> = Keys {
    ignored: &["run.checkpoint_seconds"],
    output: &["title", "verdict", "measure.fields.windows"],
};
/// Share of collisions in cells with a limited contact value from which it is named.
const MANY_LIMITED: f64 = 0.1;

/// How a case is run.
pub struct Options<'a> {
    /// Results folder; `results/NAME` of the case file by default.
    pub out: Option<PathBuf>,
    /// What becomes of results that are there.
    pub existing: Existing,
    /// Threads; all cores by default.
    pub threads: Option<usize>,
    /// Runs although the estimated memory is more than there is.
    pub force_memory: bool,
    /// Raised to stop within a second.
    pub stop: &'a Interrupt,
    /// Who sees the progress.
    pub progress: &'a dyn Progress,
    /// The commit that the program was built from, for the manifest; may be empty.
    pub commit: &'a str,
}

/// What a run left.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The results folder.
    pub folder: PathBuf,
    /// Whether it is a sweep.
    pub is_sweep: bool,
    /// The points, in the order of the case.
    pub points: Vec<PointSummary>,
}

/// One point of a run.
#[derive(Clone, Debug)]
pub struct PointSummary {
    /// Name of the point; empty without a sweep.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Whether it was complete before.
    pub was_complete: bool,
    /// Duration \[s\].
    pub seconds: f64,
    /// What follows, the most important first.
    pub verdicts: Vec<Verdict>,
    /// What the program chose, and why.
    pub choices: Vec<String>,
    /// What a reader should know.
    pub warnings: Vec<String>,
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The case cannot be run.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The results folder.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// No such number of threads.
    #[error("{found} threads; allowed: from 1 to {MOST_THREADS}")]
    Threads {
        /// How many were asked for.
        found: usize,
    },
    /// The threads cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// A run of the pilot of `[accuracy]` failed.
    #[error("pilot of accuracy.target: {0}")]
    Pilot(#[source] PartError),
    /// More memory than there is.
    #[error(
        "the run needs about {:.1} GiB and {:.1} GiB are free; fewer particles, simulators or threads need less; \
         --force-memory runs it all the same",
        needed / 1_073_741_824.0, available / 1_073_741_824.0
    )]
    Memory {
        /// Estimate for the whole process \[bytes\].
        needed: f64,
        /// What is free \[bytes\].
        available: f64,
    },
    /// One replica failed, or all of them.
    #[error("replica {replica}, {part}: {source}")]
    Replica {
        /// Which, from 0.
        replica: u64,
        /// `start`, or the engine.
        part: String,
        /// Why.
        source: Box<PartError>,
    },
}

impl RunError {
    /// Whether the run only stopped because it was asked to.
    pub fn is_interruption(&self) -> bool {
        let source = match self {
            Self::Replica { source, .. } => source,
            Self::Pilot(source) => source,
            _ => return false,
        };
        matches!(source, PartError::Interrupted)
    }

    /// Whether the gas itself cannot go on.
    fn is_of_gas(&self) -> bool {
        matches!(self, Self::Replica { source, .. } if source.is_of_gas())
    }
}

/// Runs all points of a case into a results folder.
///
/// # Errors
/// [`RunError`]; checkpoints stay.
pub fn run_case(file: &CaseFile, options: &Options<'_>) -> Result<Summary, RunError> {
    let threads = options.threads.unwrap_or_else(available_threads);
    if !(1..=MOST_THREADS).contains(&threads) {
        return Err(RunError::Threads { found: threads });
    }
    let planned = accuracy::settle(file, check(file)?, options, threads)?;
    run_planned(file, &planned, options, threads)
}

/// Runs points that are planned already.
///
/// # Errors
/// As [`run_case`].
pub fn run_planned(
    file: &CaseFile,
    planned: &[Planned<'_>],
    options: &Options<'_>,
    threads: usize,
) -> Result<Summary, RunError> {
    let parts = |one: &Planned<'_>| one.plan.engines.len() * one.plan.case.replicas as usize;
    let fewest = planned.iter().map(parts).min().unwrap_or(1);
    // Points of few replicas run side by side, as many as have a thread for each part.
    let side_by_side = (threads / fewest.max(1)).max(1);
    let needed = planned.chunks(side_by_side).map(|chunk| {
        let each = threads.div_ceil(chunk.len());
        chunk.iter().map(|one| one.cost(each).bytes).sum::<f64>()
    });
    let needed = needed.fold(0.0, f64::max);
    if let Some(available) =
        available_memory().filter(|&free| needed > free && !options.force_memory)
    {
        return Err(RunError::Memory { needed, available });
    }
    let path = options.out.clone().unwrap_or_else(|| {
        Path::new("results").join(file.path.file_stem().unwrap_or_else(|| "case".as_ref()))
    });
    let starts: Vec<Option<PathBuf>> = planned.iter().map(|one| start_file(&one.plan)).collect();
    let ids = (planned.iter().zip(&starts))
        .map(|(one, start)| {
            let inputs: Vec<&Path> = start.iter().map(PathBuf::as_path).collect();
            RunId::new(&one.point.name, &as_json(&one.plan), KEYS, &inputs)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let inputs: Vec<&Path> = std::iter::once(file.path.as_path())
        .chain(starts.iter().flatten().map(PathBuf::as_path))
        .collect();
    let folder = Folder::open(&path, options.existing, &inputs, ids)?;
    if let Some(warning) = folder.warning() {
        options.progress.note(warning);
    }
    let is_sweep = file.points.len() > 1 || !file.points[0].settings.is_empty();
    if is_sweep {
        folder.write_sweep(&index(file))?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let jobs: Vec<(usize, &Planned<'_>, Place<'_>)> =
        (planned.iter().zip(folder.places()).enumerate())
            .map(|(number, (one, place))| (number, one, place))
            .collect();
    let level = level(planned);
    let mut points = Vec::new();
    for chunk in jobs.chunks(side_by_side) {
        let done: Result<Vec<PointSummary>, RunError> = pool.install(|| {
            let chunk = chunk.par_iter();
            chunk
                .map(|&(number, one, place)| run_point(file, one, place, number, level, options))
                .collect()
        });
        points.extend(done?);
    }
    Ok(Summary {
        folder: path,
        is_sweep,
        points,
    })
}

/// The start file of a case.
fn start_file(plan: &Plan) -> Option<PathBuf> {
    let from_file = plan.case.start.placement == Placement::File;
    let name = plan.case.start.file.as_ref().filter(|_| from_file)?;
    Some(plan.folder.join(name))
}

/// The case as it is run.
fn as_json(plan: &Plan) -> Value {
    serde_json::to_value(&plan.case).unwrap_or_default()
}

fn index(file: &CaseFile) -> Sweep {
    let points = file.points.iter().map(|point| SweepPoint {
        name: point.name.clone(),
        values: (point.settings.iter())
            .map(|one| {
                (
                    one.key.clone(),
                    serde_json::to_value(&one.value).unwrap_or_default(),
                )
            })
            .collect(),
    });
    Sweep {
        format: FORMAT,
        title: file.points[0].case.title.clone(),
        case_text: file.text.clone(),
        kind: kind_name(file.points[0].case.kind()).to_owned(),
        points: points.collect(),
    }
}

fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Comparison => "comparison",
        Kind::Homogeneous => "homogeneous",
        Kind::Flow => "flow",
    }
}

/// Replicas that started out of equilibrium, and which tests failed.
fn unequilibrated(starts: &[Start]) -> Vec<(u64, String)> {
    let bad = starts.iter().filter(|start| !start.equilibrated);
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

fn run_point(
    file: &CaseFile,
    planned: &Planned<'_>,
    place: Place<'_>,
    number: usize,
    level: f64,
    options: &Options<'_>,
) -> Result<PointSummary, RunError> {
    let began = Instant::now();
    let plan = &planned.plan;
    let summary = |was_complete, verdicts, warnings| PointSummary {
        name: place.name().to_owned(),
        folder: place.path(),
        was_complete,
        seconds: began.elapsed().as_secs_f64(),
        verdicts,
        choices: plan.choices.clone(),
        warnings,
    };
    if options.existing == Existing::Resume && place.is_complete()? {
        place.remove_checkpoints()?;
        return Ok(summary(true, Vec::new(), plan.warnings.clone()));
    }
    let name = if place.name().is_empty() {
        &plan.case.title
    } else {
        place.name()
    };
    let gauge = Gauge::of(plan);
    options.progress.begin(number, name, gauge);
    let all = Replicas {
        planned,
        place,
        number,
        options,
    }
    .run()?;
    let mut warnings = plan.warnings.clone();
    warnings.extend(
        all.failed
            .iter()
            .map(|error| format!("{error}; this replica is left out of all tables")),
    );
    let engines = work(plan, &all.finished);
    warnings.extend(limited(&engines));
    let mut tables: Vec<Table> = Vec::new();
    let (mut snapshots, mut frames) = (Vec::new(), Vec::new());
    let mut verdicts: Vec<Verdict> = judge::start(&unequilibrated(&all.starts))
        .into_iter()
        .collect();
    for (measure, known) in planned.measures.iter().enumerate() {
        let runs = Runs {
            measure,
            level,
            finished: &all.finished,
        };
        let own = known.tables(plan, &runs);
        verdicts.extend(known.verdicts(plan, &runs, &own));
        for (snapshot, text) in known.snapshots(plan, &runs) {
            place.write(&snapshot.file, text.as_bytes())?;
            snapshots.push(snapshot);
        }
        for one in known.frames(plan, &runs) {
            let bytes = stosszahl_results::frames::to_bytes(&one.frames)?;
            place.write(&one.file, &bytes)?;
            frames.push(FramesEntry::new(one.engine, one.file, &bytes));
        }
        tables.extend(own);
    }
    let manifest = Manifest {
        format: FORMAT,
        program: Program {
            name: "stosszahl".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            commit: options.commit.to_owned(),
        },
        title: plan.case.title.clone(),
        case_text: file.text.clone(),
        case: as_json(plan),
        kind: kind_name(plan.kind).to_owned(),
        time_unit: time_unit(plan),
        derived: (plan.derived().into_iter())
            .map(|one| Derived {
                name: one.name,
                value: one.value,
                unit: one.unit.to_owned(),
            })
            .collect(),
        machine: machine(),
        seed: plan.case.seed,
        replicas: plan.case.replicas,
        wall_seconds: began.elapsed().as_secs_f64(),
        start: all.starts,
        engines,
        verdicts,
        choices: plan.choices.clone(),
        warnings,
        snapshots,
        frames,
        ..Manifest::default()
    };
    let manifest = place.finish(manifest, &tables)?;
    place.remove_checkpoints()?;
    options.progress.end(number);
    Ok(summary(false, manifest.verdicts, manifest.warnings))
}

/// The unit of time of a case.
fn time_unit(plan: &Plan) -> stosszahl_results::TimeUnit {
    stosszahl_results::TimeUnit {
        name: match plan.time_unit {
            TimeUnit::Case => "unit of time of the case",
            TimeUnit::Haff => "Haff's cooling time of the start",
            TimeUnit::MeanFreeTime => "mean free time of the start",
        }
        .to_owned(),
        size: plan.time_in_case(),
    }
}

/// Work of each engine over all replicas.
fn work(plan: &Plan, finished: &[Vec<Finished>]) -> Vec<EngineWork> {
    let one = |(engine, runs): (&crate::plan::EnginePlan, &Vec<Finished>)| {
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

/// Engines whose collision rates were limited, not those of the density.
fn limited(engines: &[EngineWork]) -> impl Iterator<Item = String> + '_ {
    engines.iter().filter_map(|engine| {
        let share = engine.work.get("share_of_collisions_in_limited_cells").copied()?;
        (share > MANY_LIMITED).then(|| {
            format!(
                "{}: {:.0} % of the collisions were in cells whose contact value was limited by largest_contact_value; the \
                 rate there is the limit's, not the density's",
                engine.engine,
                100.0 * share
            )
        })
    })
}

/// The machine that it runs on.
fn machine() -> Machine {
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

/// All replicas of a point.
struct Replicas<'a> {
    planned: &'a Planned<'a>,
    place: Place<'a>,
    number: usize,
    options: &'a Options<'a>,
}

/// What they left: those of which no engine failed.
struct Done {
    /// By engine, then by replica.
    finished: Vec<Vec<Finished>>,
    starts: Vec<Start>,
    failed: Vec<RunError>,
}

/// One replica: its start, and its engines in the order of the plan.
type Replica = (Option<StartReport>, Vec<Finished>);

impl Replicas<'_> {
    fn run(&self) -> Result<Done, RunError> {
        let plan = &self.planned.plan;
        let replicas: Vec<Result<Replica, RunError>> = (0..plan.case.replicas)
            .into_par_iter()
            .map(|replica| self.replica(replica))
            .collect();
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
                Err(error) if error.is_of_gas() => done.failed.push(error),
                Err(error) => return Err(error),
            }
        }
        let failed = done.failed.len();
        match done.failed.first_mut() {
            // A replica that cannot go on may hide that another engine of it was asked to stop.
            Some(RunError::Replica { source, .. }) if self.options.stop.is_raised() => {
                **source = PartError::Interrupted;
                Err(done.failed.swap_remove(0))
            }
            // Without a single replica there is nothing to tabulate.
            Some(_) if failed as u64 == plan.case.replicas => Err(done.failed.swap_remove(0)),
            _ => Ok(done),
        }
    }

    fn replica(&self, replica: u64) -> Result<Replica, RunError> {
        let plan = &self.planned.plan;
        let failed = |part: &str, source: PartError| RunError::Replica {
            replica,
            part: part.to_owned(),
            source: Box::new(source),
        };
        let first = replica as usize * (plan.engines.len() + 1);
        let (report, start) = if is_prepared(plan) {
            let made = self.start(replica, first);
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
        let mut runs = order
            .into_par_iter()
            .map(|index| {
                let engine = &plan.engines[index];
                let run = self.engine(replica, index, first + 1 + index, start.as_ref());
                Ok((index, run.map_err(|error| failed(engine.name, error))?))
            })
            .collect::<Result<Vec<_>, RunError>>()?;
        runs.sort_by_key(|(index, _)| *index);
        Ok((report, runs.into_iter().map(|(_, run)| run).collect()))
    }

    fn checkpoint(&self, replica: u64, part: &str) -> Result<PathBuf, PartError> {
        Ok(self
            .place
            .claim(&format!("{CHECKPOINTS}/replica-{replica}-{part}.snapshot"))?)
    }

    /// The start of a replica, equilibrated.
    fn start(&self, replica: u64, part: usize) -> Result<(StartReport, Particles), PartError> {
        let plan = &self.planned.plan;
        let tell = |share, collisions| {
            self.options
                .progress
                .tell(self.number, part, share, collisions);
        };
        let (path, seconds) = (
            self.checkpoint(replica, "start")?,
            plan.case.run.checkpoint_seconds,
        );
        let control: Control<'_, Preparation> = Control::new(
            Some(path),
            *self.place.fingerprint(),
            seconds,
            self.options.stop,
            &tell,
        );
        prepare(plan, replica, &control)
    }

    fn engine(
        &self,
        replica: u64,
        index: usize,
        number: usize,
        start: Option<&Particles>,
    ) -> Result<Finished, PartError> {
        let plan = &self.planned.plan;
        let engine = &plan.engines[index];
        if self.options.stop.is_raised() {
            return Err(PartError::Interrupted);
        }
        let tell = |share, collisions| {
            self.options
                .progress
                .tell(self.number, number, share, collisions);
        };
        let (path, seconds) = (
            self.checkpoint(replica, engine.name)?,
            plan.case.run.checkpoint_seconds,
        );
        let control = Control::new(
            Some(path),
            *self.place.fingerprint(),
            seconds,
            self.options.stop,
            &tell,
        );
        let part = Part {
            plan,
            engine,
            measures: &self.planned.measures,
            replica,
            start,
        };
        let done = part.run(&control);
        if let Err(PartError::Stopped { state, .. }) = &done
            && !state.is_empty()
        {
            let name = format!("{SNAPSHOTS}/replica-{replica}-{}.stopped.xyz", engine.name);
            self.place.write(&name, state.as_bytes())?;
            let path = self.place.path().join(&name);
            let text = format!("the gas at that moment is in {}", path.display());
            self.options.progress.note(&text);
        }
        done
    }
}

fn start_of(replica: u64, report: StartReport) -> Start {
    let tests = report.tests.into_iter().map(|test| StartTest {
        name: test.name,
        statistic: test.statistic,
        p_value: test.p_value,
        passed: test.passed,
        detail: test.detail,
    });
    Start {
        replica,
        placement: report.placement,
        collisions_per_particle: report.collisions_per_particle,
        equilibrated: report.equilibrated,
        tests: tests.collect(),
    }
}
