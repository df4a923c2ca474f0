//! What each command does.
//!
//! A case is of one [`Kind`]; what `check` and `run` do with a kind is its `Job`, and this is the only place
//! that chooses among them.

mod flow;
mod homogeneous;
mod job;
pub(crate) mod paired;

use std::io;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use stosszahl_dsmc::homogeneous::GasError;
use stosszahl_model::initial::Arrangement;
use stosszahl_model::snapshot::SnapshotError;

use crate::accuracy::AccuracyError;
use crate::arguments::{
    Arguments, Bench, BenchDsmc, BenchEd, BenchStart, CheckArguments, Command, FrontierArguments,
    RunArguments, Stress, Validate,
};
use crate::bench::{self, BenchError};
use crate::bench_mixture::{self, BenchMixture};
use crate::case::{Case, CaseError, Kind};
use crate::flow::FlowError;
use crate::flow::case::Flow;
use crate::frontier::{self, FrontierError};
use crate::homogeneous::case::Case as HomogeneousCase;
use crate::homogeneous::plan::PlanError;
use crate::report;
use crate::results::ResultsError;
use crate::run::RunError;
use crate::setup::SetupError;
use crate::stress::{self, StressError};
use crate::validate::{self, ValidateError};

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
    /// The case of a flow is valid but cannot be run.
    #[error("{}: {source}", path.display())]
    Flow {
        /// The case file.
        path: PathBuf,
        /// Why.
        source: FlowError,
    },
    /// The case of a gas without positions is valid but cannot be started.
    #[error("{}: {source}", path.display())]
    Plan {
        /// The case file.
        path: PathBuf,
        /// Why.
        source: PlanError,
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
        source: Box<RunError>,
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
        Command::Stress(Stress::Walls(arguments)) => {
            let cases = stress::wall_cases();
            stress::command(&cases, &arguments.cases, None, say).map_err(CommandError::from)
        }
        Command::Validate(arguments) => match arguments.engine {
            Some(Validate::Dsmc(arguments)) => validate::command(&arguments, say),
            None => validate::whole::command(&arguments.all, say),
        }
        .map_err(CommandError::from),
        Command::Frontier(arguments) => measure_frontier(&arguments),
        Command::Schema { kind } => {
            say(&format!("{:#}", kind.schema().json()));
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

fn check(arguments: &CheckArguments) -> Result<(), CommandError> {
    match Kind::of_file(&arguments.case.case)? {
        Kind::Paired => job::check::<Case>(arguments),
        Kind::Flow => job::check::<Flow>(arguments),
        Kind::Homogeneous => job::check::<HomogeneousCase>(arguments),
    }
}

fn run_case(arguments: &RunArguments) -> Result<(), CommandError> {
    match Kind::of_file(&arguments.case.case)? {
        Kind::Paired => job::run::<Case>(arguments),
        Kind::Flow => job::run::<Flow>(arguments),
        Kind::Homogeneous => job::run::<HomogeneousCase>(arguments),
    }
}

fn measure_frontier(arguments: &FrontierArguments) -> Result<(), CommandError> {
    let setups = job::plans::<Case>(&arguments.case)?;
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
