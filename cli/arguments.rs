//! The command line as typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::bench_mixture::BenchMixture;
use crate::case::Kind;
use crate::validate::Part;

/// Event-driven and Monte Carlo granular gases from one initial state: where molecular chaos holds, and where it
/// breaks.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl",
    version,
    after_help = "Begin with:\n  stosszahl check cases/quick.toml     what a case means, before it is run\n  \
                  stosszahl run cases/quick.toml       the paired case and its report\n  \
                  stosszahl schema > case.schema.json  for completion in an editor\n\n\
                  Exit codes: 0 done, 1 the run failed, 2 the input was refused, 130 stopped (continue with --resume)."
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a case: make the start, run its engines, write tables and a report.
    ///
    /// Tables are the same bytes for the same case and seed, whatever the number of threads, and after any stop and
    /// continuation.
    Run(RunArguments),
    /// Validate a case and print what follows from it: mean free path, t0, cells, memory, time.
    Check(CheckArguments),
    /// Rebuild report.html from the tables of a results folder.
    Report {
        /// A results folder.
        folder: PathBuf,
    },
    /// Print the JSON Schema of case files.
    Schema {
        /// Kind of case.
        #[arg(long, value_enum, default_value_t = Kind::Paired)]
        kind: Kind,
    },
    /// Measure the speed of an engine on a defined piece of work.
    #[command(subcommand)]
    Bench(Bench),
    /// Try an engine on hard cases and say what holds.
    #[command(subcommand)]
    Stress(Stress),
    /// Measure an engine against theory and say what holds.
    #[command(subcommand)]
    Validate(Validate),
}

/// `stosszahl validate`.
#[derive(Debug, Subcommand)]
pub enum Validate {
    /// Monte Carlo schemes against kinetic theory and exact dynamics, with error bars over replicas.
    ///
    /// Each line states a quantity, what was expected, what was found and, where the scheme claims it, the verdict. The exit code is
    /// 1 if a claim of the default scheme does not hold.
    #[command(
        after_help = "Begin with:\n  stosszahl validate dsmc --quick                   small gases, wide errors\n  \
                      stosszahl validate dsmc --part cooling            only this part\n  \
                      stosszahl validate dsmc --scheme enskog --out DIR  tables of one scheme"
    )]
    Dsmc(ValidateDsmc),
}

/// `stosszahl validate dsmc`.
#[derive(Clone, Debug, Args)]
pub struct ValidateDsmc {
    /// Only this part; may be repeated [default: all].
    #[arg(long, value_enum, value_name = "PART", value_delimiter = ',')]
    pub part: Vec<Part>,
    /// Only this scheme; may be repeated [default: all].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub scheme: Vec<String>,
    /// Few and small gases: errors are too wide for most verdicts, and unresolved claims do not fail.
    #[arg(long)]
    pub quick: bool,
    /// Folder for validation.csv and validation.md.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// `stosszahl stress`.
#[derive(Debug, Subcommand)]
pub enum Stress {
    /// Event-driven hard disks: collapse, close packing, ties, grazing contacts, long runs, extreme sizes and speeds, kills.
    ///
    /// Each case prints what it tried, what must hold and what was found. The exit code is 1 if one fails.
    #[command(
        after_help = "Begin with:\n  stosszahl stress ed --list                 the cases in words\n  \
                      stosszahl stress ed                        the short ones, in about a minute\n  \
                      stosszahl stress ed --case kills,grazing   only these\n  \
                      stosszahl stress ed --long                 hours: 1e9 collisions, 1e5 disks around a huge one"
    )]
    Ed(StressEd),
    /// Monte Carlo, every scheme: crowded and empty cells, steps too long, cooling through 24 decades, threads, kills.
    ///
    /// Each case prints what it tried, what must hold and what was found. The exit code is 1 if one fails.
    #[command(
        after_help = "Begin with:\n  stosszahl stress dsmc --list                 the cases in words\n  \
                      stosszahl stress dsmc                        all of them, in seconds\n  \
                      stosszahl stress dsmc --case threads,kills   only these\n  \
                      stosszahl stress dsmc --long                 minutes: a hundred times the steps"
    )]
    Dsmc(StressDsmc),
    /// Gases without positions: extreme sizes and temperatures, rare species, no rebound, cooling until nothing moves,
    /// sticking until one cluster is left.
    ///
    /// Each case prints what it tried, what must hold and what was found. The exit code is 1 if one fails.
    Mixture(StressMixture),
    /// Walls, obstacles, gravity and openings, exact dynamics and Monte Carlo: sharp corners, wedges, rest on a floor,
    /// grazing, fast walls, empty channels, supersonic streams.
    ///
    /// Each case prints what it tried, what must hold and what was found. The exit code is 1 if one fails.
    Walls(StressWalls),
}

/// `stosszahl stress walls`.
#[derive(Clone, Debug, Args)]
pub struct StressWalls {
    /// Which cases, and how.
    #[command(flatten)]
    pub cases: StressCases,
}

/// `stosszahl stress mixture`.
#[derive(Clone, Debug, Args)]
pub struct StressMixture {
    /// Which cases, and how.
    #[command(flatten)]
    pub cases: StressCases,
}

/// Which hard cases are run, and how they are told.
#[derive(Clone, Debug, Args)]
pub struct StressCases {
    /// Only this case; may be repeated, or name several with commas between them.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub case: Vec<String>,
    /// Print the names of the cases with what they try and what must hold, and run none.
    #[arg(long)]
    pub list: bool,
    /// Longer runs of the cases that have them; progress goes to standard error.
    #[arg(long)]
    pub long: bool,
    /// Print one JSON array, one object for each case.
    #[arg(long)]
    pub json: bool,
}

/// `stosszahl stress dsmc`.
#[derive(Clone, Debug, Args)]
pub struct StressDsmc {
    /// Which cases, and how.
    #[command(flatten)]
    pub cases: StressCases,
}

/// `stosszahl stress ed`.
#[derive(Clone, Debug, Args)]
pub struct StressEd {
    /// Which cases, and how.
    #[command(flatten)]
    pub cases: StressCases,
    /// Collisions of the runs whose length can be set: crystals, elastic-run, one-huge [default: 5e3 to 2e6; 1e6 to 1e9
    /// with --long].
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u64).range(100..))]
    pub collisions: Option<u64>,
}

/// `stosszahl bench`.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// Event-driven hard disks on one thread: make the start, equilibrate it elastically, then time.
    Ed(BenchEd),
    /// Monte Carlo: dilute elastic hard disks or spheres in cells of half a mean free path, with a constant step.
    Dsmc(BenchDsmc),
    /// Monte Carlo of a gas of spheres of a hundred sizes, cooling, on one thread: make the start, then time.
    Mixture(BenchMixture),
}

/// `stosszahl bench dsmc`.
#[derive(Clone, Debug, Args)]
pub struct BenchDsmc {
    /// Disks in the plane (2) or spheres in space (3).
    #[arg(long, value_name = "D", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dimension: u8,
    /// Number of simulators, about: cells are filled equally.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(2..))]
    pub simulators: u32,
    /// Simulators for each cell.
    #[arg(long, value_name = "C", default_value_t = 10.0)]
    pub per_cell: f64,
    /// Pair collisions for each simulator and step.
    #[arg(long, value_name = "R", default_value_t = 0.07)]
    pub collisions_per_step: f64,
    /// Steps to time.
    #[arg(long, value_name = "S", default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// Threads [default: all cores].
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
    /// No collisions; all else as with them.
    #[arg(long)]
    pub free_flight: bool,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `stosszahl bench ed`.
#[derive(Clone, Debug, Args)]
pub struct BenchEd {
    /// Number of disks.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(2..))]
    pub disks: u32,
    /// Packing fraction.
    #[arg(long, value_name = "P", default_value_t = 0.25)]
    pub packing_fraction: f64,
    /// Coefficient of restitution while timing.
    #[arg(long, value_name = "R", default_value_t = 1.0)]
    pub restitution: f64,
    /// Arrangement of the start.
    #[arg(long, value_enum, default_value_t = BenchStart::Disordered)]
    pub start: BenchStart,
    /// Elastic collisions per particle before timing.
    #[arg(long, value_name = "C", default_value_t = 10.0)]
    pub equilibrate: f64,
    /// Pair collisions to time [default: 5 for each disk, at least a million].
    #[arg(long, value_name = "M")]
    pub collisions: Option<u64>,
    /// Time only until this time, in units of t0 (Haff's time; mean free times of an elastic gas).
    #[arg(long, value_name = "T")]
    pub until: Option<f64>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// How disks are arranged before they are equilibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchStart {
    /// In no order: random sequential addition, a molten lattice above packing 0.45.
    Disordered,
    /// On a hexagonal lattice.
    Hexagonal,
}

/// What may be set from outside a case file.
#[derive(Debug, Args)]
pub struct CaseArguments {
    /// The case file (TOML).
    pub case: PathBuf,
    /// Number of replicas, in place of the case's.
    #[arg(long, value_name = "N")]
    pub replicas: Option<u64>,
    /// Seed, in place of the case's.
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
    /// End of the run in units of t0, in place of the case's; times and windows beyond it are left out.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Set any key of the case: --set gas.restitution=0.9 --set engine.ed.contact_time=1e-5. May be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// `stosszahl run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// The case and what is set from outside.
    #[command(flatten)]
    pub case: CaseArguments,
    /// Results folder [default: results/NAME-OF-THE-CASE].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads [default: all cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Continue a stopped run from its checkpoints, to the same bytes.
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Replace an existing results folder.
    #[arg(long)]
    pub force: bool,
}

/// `stosszahl check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The case and what is set from outside.
    #[command(flatten)]
    pub case: CaseArguments,
}
