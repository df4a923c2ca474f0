//! Command-line arguments of the program `stosszahl`, as clap parses them.

use std::path::PathBuf;
use std::time::Duration;

use crate::study::RunPart;
use crate::study::frontier::QuantityKind;
use clap::{Args, Parser, Subcommand};

/// Version of the program, with the commit if it is known.
pub const VERSION: &str = if env!("STOSSZAHL_COMMIT").is_empty() {
    env!("CARGO_PKG_VERSION")
} else {
    concat!(
        env!("CARGO_PKG_VERSION"),
        " (",
        env!("STOSSZAHL_COMMIT"),
        ")"
    )
};

/// Event-driven and Monte Carlo granular gases from one initial state: where molecular chaos holds,
/// and where it breaks.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl",
    version = VERSION,
    after_help = "Begin with:\n  stosszahl check cases/quick.toml     what a case means, before it is run\n  \
                  stosszahl run cases/quick.toml       the case and its report\n  \
                  stosszahl schema > case.schema.json  for completion in an editor\n\n\
                  Exit codes: 0 done, 1 the run failed, 2 the input was refused, 75 stopped by --stop-after,\n\
                  130 stopped by a signal (continue both with --resume)."
)]
pub struct Arguments {
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a case: make the start, run its engines, write tables and a report.
    ///
    /// Tables are the same bytes for the same case and seed, whatever the number of threads, and
    /// after any stop and continuation.
    ///
    /// Several processes work on one results folder with --join, also on machines that share it:
    /// each replica is done once, and the last process writes tables and report. Without a shared
    /// folder, --part runs a share of the replicas, and `stosszahl merge` puts the shares together.
    #[command(after_help = "Begin with:\n  stosszahl run quick\n  \
                            stosszahl run quick --join & stosszahl run quick --join & wait\n  \
                            srun --ntasks 8 stosszahl run CASE --join --threads 4\n  \
                            stosszahl run CASE --stop-after 3h50m\n  \
                            stosszahl run quick --part 1/2; stosszahl run quick --part 2/2; stosszahl merge results/quick-part-*")]
    Run {
        /// Case, results folder and options of the run.
        #[command(flatten)]
        run: RunArguments,
        /// Sharing of the run with other processes.
        #[command(flatten)]
        joining: JoinArguments,
        /// Run only part K of N of all replicas, for `stosszahl merge` [default of --out:
        /// results/NAME-OF-THE-CASE-part-K-of-N].
        #[arg(long, value_name = "K/N", conflicts_with = "join")]
        part: Option<RunPart>,
    },
    /// Merge the parts of a run (`run --part K/N`) into one results folder: the bytes of a run that
    /// was not cut.
    Merge(MergeArguments),
    /// Validate a case and print what follows from it: mean free path, unit of time, cells, memory,
    /// time.
    ///
    /// The time is measured: each engine runs for about a second. So is what `[accuracy]` chooses.
    Check {
        /// Case, and settings that replace its keys.
        #[command(flatten)]
        case: CaseArguments,
        /// Run nothing: the time is guessed from the start, and what the guess does not know is
        /// said.
        #[arg(long)]
        no_timing: bool,
    },
    /// List the bundled cases with the question that each answers, or print one of them.
    ///
    /// `stosszahl run NAME` runs one; `stosszahl cases NAME > own.toml` begins a case of your own.
    Cases {
        /// The case to print.
        name: Option<String>,
    },
    /// Write a commented case to begin with, from a few numbers.
    ///
    /// What it writes passes `check`. Every line says what its key means; docs/case-file.md has all
    /// keys.
    #[command(
        after_help = "Begin with:\n  stosszahl init own.toml --restitution 0.9\n  stosszahl check own.toml\n  stosszahl run own.toml"
    )]
    Init(InitArguments),
    /// Rebuild report.html from the tables of a results folder.
    Report {
        /// A results folder.
        folder: PathBuf,
    },
    /// Write figures of a results folder as vector files for a paper, or list them.
    ///
    /// A file has the width of one or of two columns of a journal. Text has 8 points at any width,
    /// and curves are told apart without colour. PDF has its fonts embedded; SVG has text as
    /// outlines. Neither needs a font of the system.
    #[command(after_help = "Begin with:\n  stosszahl figure results/quick\n  \
                            stosszahl figure results/quick energy --columns 1\n  \
                            stosszahl figure results/quick energy --width 120 --out energy.svg\n  \
                            stosszahl figure results/quick --all --columns 2 --out figures")]
    Figure(FigureArguments),
    /// Print the JSON Schema of case files.
    Schema,
    /// Print the completions of a shell.
    Completions {
        /// bash, elvish, fish, powershell or zsh.
        shell: clap_complete::Shell,
    },
    /// Print the page of all keys of cases, or of all columns of the tables of some results
    /// folders.
    Reference {
        /// Results folders.
        folders: Vec<PathBuf>,
    },
    /// Write manual pages into a folder.
    Manual {
        /// Path of the folder.
        folder: PathBuf,
    },
    /// Measure error against cost of the engines around a case, and recommend the cheapest setting
    /// for a target error.
    ///
    /// Writes frontier.csv, orders.csv, recommendation.md and frontier.html. Numbers are the same
    /// for the same case, seed and budget, but for timings and what follows from them. Each run is
    /// kept in the results folder as soon as it is done: the same command goes on after a stop, and
    /// another target or budget begins with what is there.
    #[command(
        after_help = "Begin with:\n  stosszahl frontier cases/quick.toml --budget 2m\n  \
                      stosszahl frontier cases/quick.toml --set gas.number=10000 --until 10 --target-error 1%"
    )]
    Frontier {
        /// Case, results folder and options of the measurement.
        #[command(flatten)]
        frontier: FrontierArguments,
        /// Sharing of the work with other processes.
        #[command(flatten)]
        joining: JoinArguments,
    },
    /// Make the figures of a paper again, with a verdict on each of its claims; or list the papers.
    ///
    /// Runs the cases of the paper, each in a folder of its own, and writes report.html and
    /// claims.csv. Finished runs are kept, and a stopped run is resumed.
    #[command(
        after_help = "Begin with:\n  stosszahl reproduce\n  stosszahl reproduce kawasaki-1985 --quick\n  \
                      stosszahl reproduce luding-1998 --figure 3b"
    )]
    Reproduce(ReproduceArguments),
}

/// Case file, and settings that replace its own.
#[derive(Debug, Args)]
pub struct CaseArguments {
    /// The case file (TOML), or the name of a bundled case.
    pub case: PathBuf,
    /// Number of replicas, in place of the case's.
    #[arg(long, value_name = "N", value_parser = whole_number, allow_negative_numbers = true)]
    pub replicas: Option<u64>,
    /// Seed, in place of the case's.
    #[arg(long, value_name = "S", value_parser = whole_number, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// End of the run, in place of the case's and in its unit of time; times and windows beyond it
    /// are left out.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Set any key of the case: --set gas.restitution=0.9 --set species.1.number=4000. May be
    /// repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Parses a whole number, also as `1e5`, as cases take it.
fn whole_number(text: &str) -> Result<u64, String> {
    // Limit beyond which floating point does not distinguish all whole numbers.
    let largest = 2.0_f64.powi(53);
    let rounded = || {
        text.parse::<f64>()
            .ok()
            .filter(|value| value.fract() == 0.0)
    };
    let within = |value: &f64| (0.0..=largest).contains(value);
    let written = text.parse().ok();
    let number = written.or_else(|| rounded().filter(within).map(|value| value as u64));
    number.ok_or_else(|| "expected a whole number, such as 1000 or 1e3".into())
}

/// Parses a number of threads, at least 1.
fn threads(text: &str) -> Result<u16, String> {
    let number = whole_number(text)?;
    let few = u16::try_from(number).ok();
    few.filter(|number| (1..=1024).contains(number))
        .ok_or_else(|| format!("{number} is not in 1..=1024"))
}

impl CaseArguments {
    /// Returns all overrides of case keys as `key=value`, in the order in which they apply.
    pub fn overrides(&self) -> Vec<String> {
        let mut all = self.set.clone();
        all.extend(self.replicas.map(|value| format!("replicas={value}")));
        all.extend(self.seed.map(|value| format!("seed={value}")));
        all.extend(self.until.map(|value| format!("run.until={value:?}")));
        all
    }
}

/// Arguments of `stosszahl init`.
#[derive(Debug, Args)]
pub struct InitArguments {
    /// The file to write; it must not exist.
    pub file: PathBuf,
    /// Subject of the case.
    #[arg(long, value_enum, default_value_t)]
    pub kind: Template,
    /// Number of particles.
    #[arg(long, value_name = "N", default_value_t = 2500, value_parser = whole_number, allow_negative_numbers = true)]
    pub number: u64,
    /// Share of the area or volume that particles fill.
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.25,
        allow_negative_numbers = true
    )]
    pub packing_fraction: f64,
    /// Coefficients of restitution, from 0 to 1: several, with commas between, make a sweep.
    #[arg(long, value_name = "R", value_delimiter = ',', default_values_t = [0.8], allow_negative_numbers = true)]
    pub restitution: Vec<f64>,
    /// End of the run, in the unit of time of the case.
    #[arg(
        long,
        value_name = "T",
        default_value_t = 100.0,
        allow_negative_numbers = true
    )]
    pub until: f64,
    /// Independent runs; `check` says which difference they find.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = whole_number, allow_negative_numbers = true)]
    pub replicas: u64,
    /// Replace a file that exists.
    #[arg(long)]
    pub force: bool,
}

/// Subject of a new case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Template {
    /// Exact disks against Monte Carlo, from one initial state.
    #[default]
    Comparison,
    /// Spheres without positions against kinetic theory.
    Homogeneous,
    /// A channel with walls, driven along its axis, exact and by Monte Carlo.
    Channel,
}

/// Arguments of `stosszahl run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Case, and settings that replace its keys.
    #[command(flatten)]
    pub case: CaseArguments,
    /// Results folder [default: results/NAME-OF-THE-CASE].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Continue a stopped run from its checkpoints, to the same bytes.
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Replace an existing results folder.
    #[arg(long)]
    pub force: bool,
    /// Start even if the case needs more memory than is free.
    #[arg(long)]
    pub ignore_memory_limit: bool,
    /// Stop after this time, such as 90s or 3h50m, with exit code 75: what is done is kept, and the
    /// run can be continued. For jobs with a walltime [default: none].
    #[arg(long, value_name = "TIME")]
    pub stop_after: Option<humantime::Duration>,
    /// File formats in which tables are written.
    #[command(flatten)]
    pub tables: TableArguments,
    /// Amount of output at the end.
    #[command(flatten)]
    pub printed: Printed,
}

impl RunArguments {
    /// Returns the time after which the run stops; `None` for no limit.
    pub fn time_limit(&self) -> Option<Duration> {
        self.stop_after.map(Duration::from)
    }
}

/// Sharing of a results folder by several processes.
#[derive(Debug, Args)]
pub struct JoinArguments {
    /// Work on the results folder together with the other processes that are started with the same
    /// command; also goes on after a stop.
    #[arg(long, conflicts_with = "force")]
    pub join: bool,
    /// With --join: seconds of silence after which a process is lost, and its work is done by
    /// others. One that dies on this machine is known at once.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = parse_lost_after, requires = "join")]
    pub lost_after: f64,
}

impl JoinArguments {
    /// Returns the silence after which a process counts as lost; `None` if the folder is not
    /// shared.
    pub fn lost_after(&self) -> Option<Duration> {
        self.join.then(|| Duration::from_secs_f64(self.lost_after))
    }
}

/// Parses the seconds of silence after which a process counts as lost.
fn parse_lost_after(text: &str) -> Result<f64, String> {
    let found = text.parse::<f64>().ok();
    found
        .filter(|found| (1.0..=1e6).contains(found))
        .ok_or_else(|| "allowed: seconds from 1 to 1e6".to_owned())
}

/// Arguments of `stosszahl merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// The results folders of all parts.
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Results folder [default: results/NAME-OF-THE-CASE].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace an existing results folder.
    #[arg(long)]
    pub force: bool,
    /// File formats in which tables are written.
    #[command(flatten)]
    pub tables: TableArguments,
    /// Amount of output at the end.
    #[command(flatten)]
    pub printed: Printed,
}

/// File formats of tables.
#[derive(Debug, Args)]
pub struct TableArguments {
    /// File formats of tables. CSV is always written; Parquet, next to it, needs a program that was
    /// built with the feature `parquet`.
    #[arg(
        long,
        value_name = "FORMAT",
        value_delimiter = ',',
        default_value = "csv"
    )]
    pub tables: Vec<TableFormat>,
}

/// File format of tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TableFormat {
    /// Comma-separated values, which the report is made of.
    Csv,
    /// Parquet, with units and meanings of columns as metadata.
    Parquet,
}

/// Arguments of `stosszahl figure`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("which").args(["name", "all"])))]
pub struct FigureArguments {
    /// The folder of a finished run or sweep.
    pub folder: PathBuf,
    /// Name of the figure; without one the figures are listed.
    pub name: Option<String>,
    /// Write all figures, each under its name, into the folder --out.
    #[arg(long, requires = "out")]
    pub all: bool,
    /// Columns of the journal that the figure takes: 86 mm for 1, 178 mm for 2.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2), requires = "which", allow_negative_numbers = true)]
    pub columns: u8,
    /// Width in millimetres, from 60 to 400, in place of that of columns.
    #[arg(
        long,
        value_name = "MM",
        conflicts_with = "columns",
        requires = "which",
        allow_negative_numbers = true
    )]
    pub width: Option<f64>,
    /// Format of the file [default: by the ending of --out, or pdf].
    #[arg(long, value_enum, requires = "which")]
    pub format: Option<FigureFormat>,
    /// File to write, or folder to write into [default: NAME.pdf here]. A file that exists is
    /// replaced.
    #[arg(long, value_name = "FILE", requires = "which")]
    pub out: Option<PathBuf>,
}

/// Format of a figure for print.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum FigureFormat {
    /// Document for LaTeX, with fonts embedded.
    #[default]
    Pdf,
    /// Drawing for word processors and drawing programs, with text as outlines.
    Svg,
}

/// Output of a run at its end; without options, the main conclusions.
#[derive(Debug, Args)]
pub struct Printed {
    /// Print all conclusions, choices and warnings.
    #[arg(long, short, conflicts_with_all = ["quiet", "json"])]
    pub verbose: bool,
    /// Print only where the report is.
    #[arg(long, short, conflicts_with = "json")]
    pub quiet: bool,
    /// Print conclusions, choices and warnings of all points as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `stosszahl reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// The name of a bundled paper, or a paper file (TOML); without one the papers are listed.
    pub paper: Option<PathBuf>,
    /// Only one figure or table of the paper, by its name in the list.
    #[arg(long, value_name = "N", requires = "paper")]
    pub figure: Option<String>,
    /// Smaller runs, which see less.
    #[arg(long)]
    pub quick: bool,
    /// Folder [default: results/NAME-OF-THE-PAPER, with -quick behind it for quick runs].
    #[arg(long, value_name = "DIR", requires = "paper")]
    pub out: Option<PathBuf>,
    /// Threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Replace finished runs.
    #[arg(long, requires = "paper")]
    pub force: bool,
    /// Start even if a case needs more memory than is free.
    #[arg(long)]
    pub ignore_memory_limit: bool,
}

/// Arguments of `stosszahl frontier`.
#[derive(Debug, Args)]
pub struct FrontierArguments {
    /// Case, and settings that replace its keys.
    #[command(flatten)]
    pub case: CaseArguments,
    /// Quantities that must be within the target: energy, collision-rate, cumulant, impact-slope or
    /// structure; may be repeated [default: energy]. All are measured.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub quantity: Vec<QuantityKind>,
    /// Largest error that a recommended setting may have, as a share: 1% or 0.01.
    #[arg(
        long,
        value_name = "E",
        default_value = "1%",
        allow_hyphen_values = true
    )]
    pub target_error: String,
    /// Core time for the whole sweep, planned at nominal speeds: 90s, 10m or 1h. Two cores take
    /// half as long.
    #[arg(
        long,
        value_name = "TIME",
        default_value = "10m",
        allow_hyphen_values = true
    )]
    pub budget: humantime::Duration,
    /// Results folder [default: results/NAME-OF-THE-CASE-frontier].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Folder of kept references [default: the results folder].
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Threads [default: all cores].
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Most times that a recommendation is tested on fresh seeds.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1000), allow_negative_numbers = true)]
    pub tests: u64,
    /// Make all runs anew, in place of those that are kept in the results folder.
    #[arg(long)]
    pub force: bool,
}
