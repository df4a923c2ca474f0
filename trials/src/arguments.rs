//! The command line as typed.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, Parser, Subcommand};

use crate::bench::{BenchDsmc, BenchEd, BenchMixture};
use crate::{TrialRow, calibrate, docs, validate};

fn names(trials: &[TrialRow]) -> PossibleValuesParser {
    let value = |trial: &TrialRow| PossibleValue::new(trial.name).help(trial.tried);
    PossibleValuesParser::new(trials.iter().map(value))
}

/// Hard cases, claims about accuracy, and speed of the engines of stosszahl.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl-trials",
    version,
    after_help = "Exit codes: 0 all is well, 1 something does not hold, 2 the input was refused."
)]
pub struct Arguments {
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure the speed of an engine on a defined piece of work, in some seconds.
    #[command(
        subcommand,
        after_help = "Begin with:\n  stosszahl-trials bench ed          collisions of exact disks\n  \
                      stosszahl-trials bench dsmc        Monte Carlo in cells\n  \
                      stosszahl-trials bench mixture     Monte Carlo without positions"
    )]
    Bench(Bench),
    /// Try an engine on hard cases and say what holds: seconds to a minute each, hours with --long.
    ///
    /// Each case prints what it tried, what must hold and what was found. The exit code is 1 if one
    /// fails.
    #[command(
        subcommand,
        after_help = "Begin with:\n  stosszahl-trials stress ed --list         the cases in words\n  \
                      stosszahl-trials stress ed                the short ones\n  \
                      stosszahl-trials stress walls --case floor  only this one"
    )]
    Stress(Stress),
    /// Ask the judge about replicas of which the truth is known: how often verdicts ring, and how
    /// often they find what is there.
    ///
    /// Some minutes; seconds with --quick. The exit code is 1 if a rate is not as stated.
    Calibrate(Calibrate),
    /// Make the results that stand in README and docs again, or check them.
    ///
    /// Without names it makes the cheap ones, in some ten seconds. --check compares the cheap ones
    /// with new runs, number by number within their errors. Of the costly ones it says whether an
    /// engine behind them has another statistics version by now. Of blocks with a file in docs/data
    /// it says whether the text follows from the file. The exit code is 1 if something does not
    /// hold.
    Docs(Docs),
    /// Measure everything that the program claims about accuracy, and say what holds.
    ///
    /// Each line states a claim, what was expected, what was found with its standard error, the
    /// verdict and the cost; the last line says pass or fail. The exit code is 1 unless all is
    /// well. The whole is meant to end within an hour on two cores, --quick within five minutes.
    #[command(
        args_conflicts_with_subcommands = true,
        after_help = "Begin with:\n  stosszahl-trials validate --quick                    five minutes\n  \
                      stosszahl-trials validate --out validation.md        the page, and data/validation.csv\n  \
                      stosszahl-trials validate --part exact,engines       only these\n  \
                      stosszahl-trials validate dsmc --quick               every Monte Carlo scheme"
    )]
    Validate(ValidateArguments),
}

/// `stosszahl-trials calibrate`.
#[derive(Clone, Debug, Args)]
pub struct Calibrate {
    /// Only this part; may be repeated [default: all].
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = names(calibrate::TRIALS))]
    pub part: Vec<String>,
    /// Fewer replicas, and 20 elastic cases in place of 500.
    #[arg(long)]
    pub quick: bool,
}

/// `stosszahl-trials docs`.
#[derive(Clone, Debug, Args)]
pub struct Docs {
    /// Only this block; may be repeated [default: the cheap ones].
    #[arg(value_name = "NAME", value_parser = docs::names())]
    pub name: Vec<String>,
    /// Change nothing, and say what is wrong.
    #[arg(long)]
    pub check: bool,
    /// All blocks, also those that take hours of a core.
    #[arg(long, conflicts_with_all = ["check", "name"])]
    pub costly: bool,
    /// Numbers that are not of new runs.
    #[command(flatten)]
    pub stored: DocsStored,
}

/// Stored numbers that `stosszahl-trials docs` may take in place of new runs.
#[derive(Clone, Copy, Debug, Args)]
pub struct DocsStored {
    /// Run nothing: write the text of blocks whose table is a file in docs/data again, from that
    /// file.
    #[arg(long, conflicts_with_all = ["check", "name", "costly", "resume"])]
    pub from_files: bool,
    /// Resume runs in results/docs that were stopped, and use those that are complete.
    #[arg(long, conflicts_with = "check")]
    pub resume: bool,
}

/// `stosszahl-trials validate`, of the whole or of one engine.
#[derive(Debug, Args)]
pub struct ValidateArguments {
    /// One engine.
    #[command(subcommand)]
    pub engine: Option<Validate>,
    /// The whole.
    #[command(flatten)]
    pub all: ValidateAll,
}

fn duration(text: &str) -> Result<Duration, String> {
    humantime::parse_duration(text)
        .map_err(|error| format!("{error}; allowed is a time such as 90s, 5m or 1h"))
}

/// `stosszahl-trials validate` of the whole.
#[derive(Clone, Debug, Args)]
pub struct ValidateAll {
    /// Only this part; may be repeated [default: all].
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = names(validate::TRIALS))]
    pub part: Vec<String>,
    /// The selection of five minutes.
    #[arg(long)]
    pub quick: bool,
    /// Begin no further part after this time: 90s, 5m or 1h [default: none].
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub budget: Option<Duration>,
    /// Markdown page to write, with the table data/validation.csv next to it; both are complete
    /// after each part.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// `stosszahl-trials validate` of one engine.
#[derive(Debug, Subcommand)]
pub enum Validate {
    /// Monte Carlo schemes against kinetic theory and exact dynamics, with error bars over
    /// replicas.
    ///
    /// Each line states a quantity, what was expected, what was found and, where the scheme claims
    /// it, the verdict. The exit code is 1 if a claim of the default scheme does not hold.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials validate dsmc --quick                   small gases, wide errors\n  \
                      stosszahl-trials validate dsmc --part cooling            only this part\n  \
                      stosszahl-trials validate dsmc --scheme enskog --out DIR  tables of one scheme"
    )]
    Dsmc(ValidateDsmc),
}

/// `stosszahl-trials validate dsmc`.
#[derive(Clone, Debug, Args)]
pub struct ValidateDsmc {
    /// Only this part; may be repeated [default: all].
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = names(validate::parts::TRIALS))]
    pub part: Vec<String>,
    /// Only this scheme; may be repeated [default: all].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub scheme: Vec<String>,
    /// Few and small gases: errors are too wide for most verdicts, and unresolved claims do not
    /// fail.
    #[arg(long)]
    pub quick: bool,
    /// Folder for validation.csv and validation.md.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// `stosszahl-trials stress`.
#[derive(Debug, Subcommand)]
pub enum Stress {
    /// Event-driven hard disks: collapse, close packing, ties, grazing contacts, long runs, extreme
    /// sizes and speeds, kills.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials stress ed --list                 the cases in words\n  \
                      stosszahl-trials stress ed                        the short ones, in about a minute\n  \
                      stosszahl-trials stress ed --case kills,grazing   only these\n  \
                      stosszahl-trials stress ed --long                 hours: 1e9 collisions, 1e5 disks around a huge one"
    )]
    Ed(StressEd),
    /// Monte Carlo, every scheme: crowded and empty cells, steps too long, cooling through 24
    /// decades, threads, kills.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials stress dsmc --list                 the cases in words\n  \
                      stosszahl-trials stress dsmc                        all of them, in seconds\n  \
                      stosszahl-trials stress dsmc --case threads,kills   only these\n  \
                      stosszahl-trials stress dsmc --long                 minutes: a hundred times the steps"
    )]
    Dsmc(StressCases),
    /// Gases without positions: extreme sizes and temperatures, rare species, no rebound, cooling
    /// until nothing moves, sticking until one cluster is left.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials stress mixture --list         the cases in words\n  \
                      stosszahl-trials stress mixture                all of them, in seconds\n  \
                      stosszahl-trials stress mixture --long         minutes: 1e7 grains of dust, 1e6 sticky disks"
    )]
    Mixture(StressCases),
    /// Walls, obstacles, gravity and openings, exact dynamics and Monte Carlo: sharp corners,
    /// wedges, rest on a floor, grazing, fast walls, empty channels, supersonic streams.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials stress walls --list               the cases in words\n  \
                      stosszahl-trials stress walls                      all of them, in seconds\n  \
                      stosszahl-trials stress walls --case fast-wall     only this one"
    )]
    Walls(StressCases),
}

/// Selection of hard cases, and the form of their report.
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

/// `stosszahl-trials stress ed`.
#[derive(Clone, Debug, Args)]
pub struct StressEd {
    /// Selection of cases, and the form of their report.
    #[command(flatten)]
    pub cases: StressCases,
    /// Collisions of the runs whose length can be set: crystals, elastic-run, one-huge [default:
    /// 5e3 to 2e6; 1e6 to 1e9 with --long].
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u64).range(100..))]
    pub collisions: Option<u64>,
}

/// `stosszahl-trials bench`.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// Event-driven hard disks on one thread: make the start, equilibrate it elastically, then
    /// time; some seconds.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials bench ed                                    10 000 disks, a million collisions\n  \
                      stosszahl-trials bench ed --disks 100000 --packing-fraction 0.7 --json"
    )]
    Ed(BenchEd),
    /// Monte Carlo: dilute elastic hard disks or spheres in cells of half a mean free path, with a
    /// constant step; some seconds.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials bench dsmc                              a million simulators, 50 steps\n  \
                      stosszahl-trials bench dsmc --dimension 3 --threads 1 --json"
    )]
    Dsmc(BenchDsmc),
    /// Monte Carlo of a gas of spheres of a hundred sizes, cooling, on one thread: make the start,
    /// then time; some seconds.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials bench mixture                           a million monomers to time 100\n  \
                      stosszahl-trials bench mixture --selection single-majorant --collisions 2000000"
    )]
    Mixture(BenchMixture),
}
