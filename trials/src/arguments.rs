//! The command line as typed.

use clap::{Args, Parser, Subcommand};

use crate::bench::{BenchDsmc, BenchEd, BenchMixture};
use crate::calibrate::Calibrate;
use crate::docs::Docs;
use crate::stress::StressCases;
use crate::validate::{ValidateAll, ValidateDsmc};

/// Hard cases, claims about accuracy, and speed of the engines of stosszahl.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl-trials",
    version,
    after_help = "Exit codes: 0 all is well, 1 something does not hold, 2 the input was refused."
)]
pub struct TrialArguments {
    /// Command to run.
    #[command(subcommand)]
    pub command: TrialCommand,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum TrialCommand {
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
    Stress(StressCommand),
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

/// `stosszahl-trials stress`.
#[derive(Debug, Subcommand)]
pub enum StressCommand {
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
