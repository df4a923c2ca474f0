//! What each command does.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use std::{fs, io, thread};

use stosszahl_dsmc::homogeneous::GasError;
use stosszahl_model::Sizes;
use stosszahl_model::initial::Arrangement;
use stosszahl_model::snapshot::{SnapshotError, write_whole};

use crate::accuracy::{self, AccuracyError};
use crate::arguments::{
    Arguments, Bench, BenchDsmc, BenchEd, BenchStart, CaseArguments, CheckArguments, Command,
    FrontierArguments, RunArguments, Stress, Validate,
};
use crate::bench::{self, BenchError};
use crate::bench_mixture::{self, BenchMixture};
use crate::case::{self, Case, CaseError, CaseFile, Engine, Point, Units};
use crate::export::Tables;
use crate::frontier::{self, FrontierError};
use crate::manifest::{self, Manifest, Sweep, SweepPoint};
use crate::progress::{Progress, duration};
use crate::report;
use crate::results::{self, Existing, ResultsError};
use crate::run::{self, Place, Replica, RunError, SNAPSHOTS};
use crate::setup::{Setup, SetupError, TimeUnit};
use crate::stress::{self, StressError};
use crate::validate::{self, ValidateError};
use crate::verdicts::verdicts;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The case file or an override is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The case is valid but cannot be started.
    #[error("{}: {source}", path.display())]
    Setup {
        /// The case file.
        path: PathBuf,
        /// Why.
        source: SetupError,
    },
    /// The results folder cannot be used.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// `--threads 0`.
    #[error("--threads {found}: allowed are 1 or more")]
    Threads {
        /// What was found.
        found: usize,
    },
    /// A folder or file failed.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// The run failed.
    #[error("{}: {source}", folder.display())]
    Run {
        /// Results folder; checkpoints are kept there.
        folder: PathBuf,
        /// Why.
        source: RunError,
    },
    /// A table or the manifest cannot be written.
    #[error(transparent)]
    Export(#[from] SnapshotError),
    /// A benchmark cannot run.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// A gas without positions cannot be made or cannot go on.
    #[error(transparent)]
    Gas(#[from] GasError),
    /// A hard case failed, or is unknown.
    #[error(transparent)]
    Stress(#[from] StressError),
    /// A claim of the default scheme does not hold, or nothing could be measured.
    #[error(transparent)]
    Validate(#[from] ValidateError),
    /// No resolution can be chosen.
    #[error(transparent)]
    Accuracy(#[from] AccuracyError),
    /// A frontier cannot be measured.
    #[error(transparent)]
    Frontier(#[from] FrontierError),
    /// The report cannot be built.
    #[error(transparent)]
    Report(#[from] report::ReportError),
}

impl CommandError {
    /// 2: the input was refused; 130: stopped; 1: the run failed.
    fn exit_code(&self) -> u8 {
        match self {
            Self::Run { source, .. } if source.is_interruption() => 130,
            Self::Run { source, .. } if source.is_foreign() => 2,
            Self::Results(error) if !error.is_system() => 2,
            Self::Frontier(error) if !error.is_refusal() => 1,
            Self::Report(report::ReportError::Write { .. })
            | Self::Results(_)
            | Self::Folder { .. }
            | Self::Pool(_)
            | Self::Accuracy(AccuracyError::Run(_))
            | Self::Run { .. }
            | Self::Stress(StressError::Failed { .. })
            | Self::Validate(
                ValidateError::Failed { .. }
                | ValidateError::Whole { .. }
                | ValidateError::Trouble(_)
                | ValidateError::Table(_)
                | ValidateError::Folder { .. }
                | ValidateError::Write(_),
            )
            | Self::Export(_) => 1,
            _ => 2,
        }
    }
}

fn say(text: &str) {
    // A closed standard output ends nothing.
    let _ = writeln!(io::stdout(), "{text}");
}

fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Does what the command line asks.
pub fn execute(arguments: Arguments) -> ExitCode {
    let done = match arguments.command {
        Command::Run(arguments) => run_case(&arguments),
        Command::Check(arguments) => check(&arguments),
        Command::Report { folder } => report::write_report(&folder)
            .map_err(CommandError::from)
            .map(|path| say(&path.display().to_string())),
        Command::Bench(Bench::Ed(arguments)) => bench_ed(&arguments),
        Command::Bench(Bench::Dsmc(arguments)) => bench_dsmc(&arguments),
        Command::Bench(Bench::Mixture(arguments)) => bench_mixture(&arguments),
        Command::Stress(Stress::Ed(arguments)) => {
            let cases = stress::cases();
            stress::command(&cases, &arguments.cases, arguments.collisions, say)
                .map_err(CommandError::from)
        }
        Command::Stress(Stress::Dsmc(arguments)) => {
            let cases = stress::dsmc::cases();
            stress::command(&cases, &arguments.cases, None, say).map_err(CommandError::from)
        }
        Command::Stress(Stress::Mixture(arguments)) => {
            let cases = stress::mixture_cases();
            stress::command(&cases, &arguments.cases, None, say).map_err(CommandError::from)
        }
        Command::Validate(arguments) => match arguments.engine {
            Some(Validate::Dsmc(arguments)) => validate::command(&arguments, say),
            None => validate::whole::command(&arguments.all, say),
        }
        .map_err(CommandError::from),
        Command::Frontier(arguments) => measure_frontier(&arguments),
        Command::Schema => {
            say(&format!("{:#}", case::schema()));
            Ok(())
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note(&format!("error: {error}"));
            let mut said = error.to_string();
            let mut cause = std::error::Error::source(&error);
            while let Some(deeper) = cause {
                let text = deeper.to_string();
                // Transparent errors repeat what was said.
                if !said.contains(&text) {
                    note(&format!("  because: {text}"));
                    said.push_str(&text);
                }
                cause = deeper.source();
            }
            if let CommandError::Run { folder, source } = &error
                && source.is_interruption()
            {
                note(&format!("checkpoints are in {}", folder.display()));
            }
            ExitCode::from(error.exit_code())
        }
    }
}

fn read(arguments: &CaseArguments) -> Result<(CaseFile, Vec<Setup>), CommandError> {
    let mut overrides = Vec::new();
    if let Some(until) = arguments.until {
        overrides.extend(case::shortened(&arguments.case, until));
        overrides.push(format!("run.until={until:?}"));
    }
    overrides.extend(
        arguments
            .replicas
            .map(|replicas| format!("replicas={replicas}")),
    );
    overrides.extend(arguments.seed.map(|seed| format!("seed={seed}")));
    overrides.extend(arguments.set.iter().cloned());
    let file = Case::read(&arguments.case, &overrides)?;
    let setups = file
        .points
        .iter()
        .map(|point| Setup::new(&point.case))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|source| CommandError::Setup {
            path: file.path.clone(),
            source,
        })?;
    Ok((file, setups))
}

/// Collisions and simulator steps a second that the estimate of the time assumes; a rough guide.
const COLLISIONS_PER_SECOND: f64 = 4e5;
const SIMULATOR_STEPS_PER_SECOND: f64 = 1.5e7;

/// Collisions of simulators with partners across cells, in a second.
const COLLISIONS_ACROSS_PER_SECOND: f64 = 1e6;

fn check(arguments: &CheckArguments) -> Result<(), CommandError> {
    let (file, setups) = read(&arguments.case)?;
    for (point, setup) in file.points.iter().zip(&setups) {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}: {}", file.path.display(), setup.case.title);
        if !point.name.is_empty() {
            let _ = writeln!(text, "point {}", point.name);
        }
        for (name, value) in setup.derived() {
            let _ = writeln!(text, "  {name:<44} {value:>14.6}");
        }
        let (seconds, bytes) = estimate(setup);
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let parallel = threads.min(setup.case.replicas * setup.case.engines.len()) as f64;
        let _ = writeln!(
            text,
            "  {:<44} {:>14.1}",
            "memory_of_one_engine_in_mebibytes",
            bytes / 1_048_576.0
        );
        let _ = writeln!(
            text,
            "  {} replicas of {} engines on {threads} threads: roughly {}",
            setup.case.replicas,
            setup.case.engines.len(),
            duration(seconds / parallel)
        );
        for warning in setup.warnings() {
            let _ = writeln!(text, "  warning: {warning}");
        }
        say(text.trim_end());
    }
    Ok(())
}

/// Seconds of one core for all replicas, and bytes of the largest engine.
fn estimate(setup: &Setup) -> (f64, f64) {
    let disks = setup.disks as f64;
    let until = setup.case.run.until;
    let start = setup.case.start.collisions_per_particle;
    let exact = 0.5 * disks * (setup.expected_collisions(until) + start);
    let (mut seconds, mut bytes) = (0.5 * disks * start / COLLISIONS_PER_SECOND, 0.0_f64);
    for engine in &setup.case.engines {
        match engine {
            Engine::Ed(_) => {
                seconds += exact / COLLISIONS_PER_SECOND;
                bytes = bytes.max(220.0 * disks);
            }
            Engine::Dsmc(dsmc) => {
                let copies = setup.copies(dsmc);
                let simulators = disks * copies;
                if !dsmc.scheme.within_cells() {
                    seconds += copies * exact / COLLISIONS_ACROSS_PER_SECOND;
                }
                let steps = setup.expected_steps(dsmc);
                seconds += steps * simulators / SIMULATOR_STEPS_PER_SECOND;
                bytes = bytes.max(100.0 * simulators);
            }
        }
    }
    (seconds * setup.case.replicas as f64, bytes)
}

fn measure_frontier(arguments: &FrontierArguments) -> Result<(), CommandError> {
    let (_, setups) = read(&arguments.case)?;
    Ok(frontier::command(arguments, &setups, say, note)?)
}

fn bench_ed(arguments: &BenchEd) -> Result<(), CommandError> {
    let disks = arguments.disks as usize;
    let work = bench::EventDriven {
        disks,
        packing_fraction: arguments.packing_fraction,
        restitution: arguments.restitution,
        arrangement: match arguments.start {
            BenchStart::Disordered => Arrangement::Disordered,
            BenchStart::Hexagonal => Arrangement::Hexagonal,
        },
        equilibrate: arguments.equilibrate,
    };
    let all = if arguments.until.is_some() {
        u64::MAX / 2
    } else {
        (5 * disks as u64).max(1_000_000)
    };
    let collisions = arguments.collisions.unwrap_or(all);
    let speed = work.prepare()?.time(collisions, arguments.until)?;
    if arguments.json {
        say(&serde_json::to_string(&speed).unwrap_or_default());
    } else {
        say(&format!(
            "{} disks at packing {}, restitution {}: {:.4e} collisions/s of wall time, {:.4e} of CPU time \
             ({} in {:.2} s); {:.0} bytes/disk; each collision {:.2} predictions, {:.2} pushes, {:.2} crossings, \
             {:.2} stale, {:.2} broken",
            disks,
            work.packing_fraction,
            work.restitution,
            speed.collisions_per_second,
            speed.collisions_per_cpu_second,
            speed.collisions,
            speed.seconds,
            speed.bytes_per_disk,
            speed.predictions_per_collision,
            speed.pushes_per_collision,
            speed.crossings_per_collision,
            speed.stale_per_collision,
            speed.broken_per_collision
        ));
    }
    Ok(())
}

fn bench_dsmc(arguments: &BenchDsmc) -> Result<(), CommandError> {
    if arguments.threads == Some(0) {
        return Err(CommandError::Threads { found: 0 });
    }
    let work = bench::MonteCarlo {
        dimension: usize::from(arguments.dimension),
        simulators: arguments.simulators as usize,
        per_cell: arguments.per_cell,
        collisions_per_step: arguments.collisions_per_step,
        steps: arguments.steps,
        free_flight: arguments.free_flight,
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads.unwrap_or(0))
        .build()?;
    let speed = pool.install(|| work.time())?;
    if arguments.json {
        say(&serde_json::to_string(&speed).unwrap_or_default());
    } else {
        say(&format!(
            "{} simulators in {} cells, {} dimensions, {} threads: {:.4e} particle-steps/s of wall time, {:.4e} of CPU \
             time ({} steps in {:.2} s); {:.4e} collisions/s, {:.4} a simulator and step, {:.4} of theory's rate, {:.2} \
             trials each; {:.1} bytes/simulator",
            speed.simulators,
            speed.cells,
            work.dimension,
            pool.current_num_threads(),
            speed.particle_steps_per_second,
            speed.particle_steps_per_cpu_second,
            speed.steps,
            speed.seconds,
            speed.collisions_per_second,
            speed.collisions_per_step,
            speed.collision_rate_over_theory,
            speed.trials_per_collision,
            speed.bytes_per_simulator
        ));
    }
    Ok(())
}

fn bench_mixture(arguments: &BenchMixture) -> Result<(), CommandError> {
    let speed = bench_mixture::measure(arguments)?;
    if arguments.json {
        say(&serde_json::to_string(&speed).unwrap_or_default());
    } else {
        say(&bench_mixture::words(&speed));
    }
    Ok(())
}

fn run_case(arguments: &RunArguments) -> Result<(), CommandError> {
    if arguments.threads == Some(0) {
        return Err(CommandError::Threads { found: 0 });
    }
    let (file, setups) = read(&arguments.case)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads.unwrap_or(0))
        .build()?;
    // A pilot gives the same choice when the run is continued.
    let setups = setups
        .into_iter()
        .map(|setup| pool.install(|| accuracy::resolved(setup)))
        .collect::<Result<Vec<_>, _>>()?;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        Path::new("results").join(file.path.file_stem().unwrap_or_else(|| "case".as_ref()))
    });
    let runs: Vec<(String, run::Fingerprint)> = file
        .points
        .iter()
        .zip(&setups)
        .map(|(point, setup)| (point.name.clone(), fingerprint(setup)))
        .collect();
    let existing = match (arguments.resume, arguments.force) {
        (true, _) => Existing::Resume,
        (_, true) => Existing::Replace,
        _ => Existing::Refuse,
    };
    let mut inputs = vec![file.path.as_path()];
    inputs.extend(
        setups
            .iter()
            .filter_map(|setup| match &setup.case.start.bodies {
                case::Bodies::File(start) => Some(start.path.as_path()),
                _ => None,
            }),
    );
    results::open(&folder, existing, &inputs, &runs)?;
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    // Without a handler the run can still be killed and resumed.
    let _ = ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        note("stopping at the next checkpoint; once more to stop at once");
    });
    let sweep = file.points.len() > 1 || !file.points[0].settings.is_empty();
    if sweep {
        write_json(&folder.join(manifest::SWEEP_FILE), &sweep_index(&file))?;
    }
    for (point, setup) in file.points.iter().zip(&setups) {
        let place = if sweep {
            folder.join(&point.name)
        } else {
            folder.clone()
        };
        if arguments.resume && results::is_complete(&place) {
            note(&format!("{} is complete", place.display()));
            results::remove_checkpoints(&place)?;
            continue;
        }
        pool.install(|| run_point(&file, point, setup, &place, &stop))?;
    }
    let path = report::write_report(&folder)?;
    say(&format!("report: {}", path.display()));
    Ok(())
}

fn sweep_index(file: &CaseFile) -> Sweep {
    let points = file
        .points
        .iter()
        .map(|point| SweepPoint {
            name: point.name.clone(),
            folder: point.name.clone(),
            values: point
                .settings
                .iter()
                .map(|one| {
                    (
                        one.key.clone(),
                        serde_json::to_value(&one.value).unwrap_or_default(),
                    )
                })
                .collect(),
        })
        .collect();
    Sweep {
        title: file.points[0].case.title.clone(),
        case_text: file.source_text.clone(),
        points,
    }
}

fn write_json(path: &Path, content: &impl serde::Serialize) -> Result<(), CommandError> {
    let mut bytes = serde_json::to_vec_pretty(content).map_err(|error| CommandError::Folder {
        path: path.to_owned(),
        source: error.into(),
    })?;
    bytes.push(b'\n');
    Ok(write_whole(path, &bytes)?)
}

/// What decides the numbers of a run.
pub(crate) fn fingerprint(setup: &Setup) -> run::Fingerprint {
    let mut hash = blake3::Hasher::new();
    hash.update(env!("CARGO_PKG_VERSION").as_bytes());
    // Neither the title nor how often the run is saved.
    let mut case = setup.case.clone();
    case.title.clear();
    case.run.checkpoint_seconds = 0.0;
    hash.update(&serde_json::to_vec(&case).unwrap_or_default());
    if let Some(file) = &setup.file {
        for vector in file
            .positions
            .iter()
            .chain(file.velocities.iter().flatten())
        {
            hash.update(&vector[0].to_le_bytes())
                .update(&vector[1].to_le_bytes());
        }
    }
    if let Some(sizes) = &setup.sizes {
        for index in 0..setup.disks {
            let tag = sizes.tag(index);
            hash.update(&sizes.radius(tag).to_le_bytes())
                .update(&sizes.mass(tag).to_le_bytes());
        }
    }
    hash.finalize().into()
}

fn run_point(
    file: &CaseFile,
    point: &Point,
    setup: &Setup,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<(), CommandError> {
    let began = Instant::now();
    let name = if point.name.is_empty() {
        &setup.case.title
    } else {
        &point.name
    };
    fs::create_dir_all(folder).map_err(|source| CommandError::Folder {
        path: folder.to_owned(),
        source,
    })?;
    let replicas = {
        let progress = Progress::start(name);
        let place = Place {
            folder,
            fingerprint: &fingerprint(setup),
            stop,
            progress: &progress,
        };
        run::run(setup, place).map_err(|source| CommandError::Run {
            folder: folder.to_owned(),
            source,
        })?
    };
    let tables = Tables::new(setup, &replicas);
    tables.write(setup, folder)?;
    let manifest = describe(
        file,
        setup,
        &replicas,
        &tables,
        began.elapsed().as_secs_f64(),
    );
    write_json(&folder.join(manifest::MANIFEST_FILE), &manifest)?;
    report::write_report(folder)?;
    results::remove_checkpoints(folder)?;
    say(&format!("{name} ({})", duration(manifest.wall_seconds)));
    for choice in &manifest.choices {
        say(&format!("  resolution: {choice}"));
    }
    for verdict in &manifest.verdicts {
        say(&format!("  {}: {}", verdict.topic, verdict.sentence));
    }
    Ok(())
}

fn describe(
    file: &CaseFile,
    setup: &Setup,
    replicas: &[Replica],
    tables: &Tables,
    seconds: f64,
) -> Manifest {
    let case = &setup.case;
    let engines = case.engines.iter().enumerate().map(|(index, engine)| {
        let runs: Vec<_> = replicas
            .iter()
            .map(|replica| &replica.engines[index])
            .collect();
        let mut work: BTreeMap<String, f64> = BTreeMap::new();
        for run in &runs {
            for (name, number) in &run.work.numbers {
                *work.entry(name.clone()).or_default() += number / runs.len() as f64;
            }
        }
        manifest::EngineWork {
            engine: engine.name().to_owned(),
            wall_seconds: runs.iter().map(|run| run.seconds).sum(),
            collisions: runs.iter().map(|run| run.work.collisions).sum(),
            work,
        }
    });
    let engines: Vec<manifest::EngineWork> = engines.collect();
    let suspicions = warnings(setup, &engines);
    let snapshots = case.engines.iter().flat_map(|engine| {
        case.measure
            .snapshot_times
            .iter()
            .enumerate()
            .map(move |(index, &time)| manifest::Snapshot {
                engine: engine.name().to_owned(),
                time_over_t0: time,
                file: format!("{SNAPSHOTS}/{}-{index}.xyz", engine.name()),
            })
    });
    let start = replicas
        .iter()
        .enumerate()
        .map(|(replica, known)| manifest::Start {
            replica: replica as u64,
            placement: known.start.placement.clone(),
            collisions_per_particle: known.start.collisions_per_particle,
            equilibrated: known.start.equilibrated,
            tests: known
                .start
                .tests
                .iter()
                .map(|test| manifest::StartTest {
                    name: test.name.clone(),
                    statistic: test.statistic,
                    p_value: test.p_value,
                    passed: test.passed,
                    detail: test.detail.clone(),
                })
                .collect(),
        });
    Manifest {
        format: manifest::FORMAT,
        program: manifest::Program {
            name: "stosszahl".into(),
            version: env!("CARGO_PKG_VERSION").into(),
        },
        title: case.title.clone(),
        case_text: file.source_text.clone(),
        case: serde_json::to_value(case).unwrap_or_default(),
        units: match case.units {
            Units::Reduced => manifest::Units::Reduced,
            Units::Si => manifest::Units::Si,
        },
        t0: manifest::ReferenceTime {
            seconds_or_units: setup.time * setup.scale.time(),
            definition: match setup.time_unit {
                TimeUnit::Haff => manifest::TimeDefinition::Haff,
                TimeUnit::MeanFreeTime => manifest::TimeDefinition::MeanFreeTime,
            },
        },
        derived: setup.derived().into_iter().collect(),
        machine: machine(),
        seed: case.seed,
        replicas: case.replicas as u64,
        wall_seconds: seconds,
        start: start.collect(),
        engines,
        verdicts: verdicts(setup, replicas, tables),
        choices: setup.choices.clone(),
        warnings: suspicions,
        snapshots: snapshots.collect(),
    }
}

/// What deserves a second look, before and after the run.
fn warnings(setup: &Setup, engines: &[manifest::EngineWork]) -> Vec<String> {
    /// Share of collisions in cells with a limited contact value from which it is named.
    const MANY: f64 = 0.1;
    let mut list = setup.warnings();
    for engine in engines {
        let share = engine
            .work
            .get("share_of_collisions_in_limited_cells")
            .copied()
            .unwrap_or(0.0);
        if share > MANY {
            list.push(format!(
                "{}: {:.0} % of the collisions were in cells whose contact value was limited by largest_contact_value; the rate \
                 there is the limit's, not the density's",
                engine.engine,
                100.0 * share
            ));
        }
    }
    list
}

fn machine() -> manifest::Machine {
    let processor = fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        })
        .unwrap_or_else(|| "unknown".into());
    manifest::Machine {
        cores: thread::available_parallelism().map_or(1, |n| n.get() as u64),
        processor,
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
    }
}
