//! Command line of `stosszahl-trials`: its arguments, and the execution of its commands.

use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::bench::{BenchDsmc, BenchEd, BenchMixture, BenchWork};
use crate::calibrate::Calibrate;
use crate::docs::Docs;
use crate::stress::StressCases;
use crate::terminal::say;
use crate::validate::{ValidateAll, ValidateDsmc};
use crate::{Done, calibrate, docs, stress, validate};

/// Tests and benchmarks of the stosszahl engines: hard cases, claims about accuracy, and speed.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl-trials",
    version,
    after_help = "Exit codes: 0 all is well, 1 something does not hold, 2 the input was refused."
)]
pub struct TrialArguments {
    /// Command of `stosszahl-trials` to run.
    #[command(subcommand)]
    pub command: TrialCommand,
}

/// Commands of `stosszahl-trials`: bench, stress, calibrate, docs and validate.
#[derive(Debug, Subcommand)]
pub enum TrialCommand {
    /// Measure the speed of an engine on a fixed amount of work, in some seconds.
    #[command(
        subcommand,
        after_help = "Begin with:\n  stosszahl-trials bench ed          collisions of exact disks\n  \
                      stosszahl-trials bench dsmc        Monte Carlo in cells\n  \
                      stosszahl-trials bench mixture     Monte Carlo without positions"
    )]
    Bench(Bench),
    /// Test an engine on hard cases and report what holds: seconds to a minute each, hours with
    /// --long.
    ///
    /// Each case prints what it tries, what must hold and what was found. The exit code is 1 if one
    /// fails.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials stress ed --list                 the cases in words\n  \
                      stosszahl-trials stress ed                        the short ones, in about a minute\n  \
                      stosszahl-trials stress dsmc --case threads,kills only these\n  \
                      stosszahl-trials stress ed --long                 hours: 1e9 collisions, 1e5 disks around a huge one\n  \
                      stosszahl-trials stress dsmc --long               minutes: a hundred times the steps\n  \
                      stosszahl-trials stress mixture --long            minutes: 1e7 grains of dust, 1e6 sticky disks"
    )]
    Stress(StressCases),
    /// Check the error rates of verdicts on replicas with a known truth: how often they raise false
    /// alarms, and how often they find a planted effect.
    ///
    /// Takes some minutes; seconds with --quick. The exit code is 1 if a rate is not as stated.
    Calibrate(Calibrate),
    /// Regenerate the results shown in README and docs, or check them.
    ///
    /// Without names the cheap blocks are made, in some ten seconds. --check compares the cheap
    /// blocks with new runs, number by number within their errors. For costly blocks it reports
    /// engines whose statistics version has changed. For blocks with a file in docs/data it checks
    /// that the text follows from the file. The exit code is 1 if a check fails.
    Docs(Docs),
    /// Measure all claims about accuracy of the program, and report which of them hold.
    ///
    /// Each line shows a claim, the expected value, the value found with its standard error, the
    /// verdict and the cost. The last line is pass or fail, and the exit code is 1 unless all
    /// claims hold. The whole takes up to an hour on two cores, --quick five minutes.
    #[command(
        args_conflicts_with_subcommands = true,
        after_help = "Begin with:\n  stosszahl-trials validate --quick                    five minutes\n  \
                      stosszahl-trials validate --out validation.md        the page, and data/validation.csv\n  \
                      stosszahl-trials validate --part exact,engines       only these\n  \
                      stosszahl-trials validate dsmc --quick               every Monte Carlo scheme"
    )]
    Validate(ValidateArguments),
}

/// Arguments of `stosszahl-trials validate`: one engine, or all claims about accuracy.
#[derive(Debug, Args)]
pub struct ValidateArguments {
    /// Engine to validate alone; `None` for all claims.
    #[command(subcommand)]
    pub engine: Option<Validate>,
    /// Options for the validation of all claims.
    #[command(flatten)]
    pub all: ValidateAll,
}

/// Subcommands of `stosszahl-trials validate`, one for each engine.
#[derive(Debug, Subcommand)]
pub enum Validate {
    /// Compare Monte Carlo schemes with kinetic theory and exact dynamics, with error bars over
    /// replicas.
    ///
    /// Each line shows a quantity, the expected value, the value found and, if the scheme claims
    /// it, the verdict. The exit code is 1 if a claim of the default scheme fails.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials validate dsmc --quick                   small gases, wide errors\n  \
                      stosszahl-trials validate dsmc --part cooling            only this part\n  \
                      stosszahl-trials validate dsmc --scheme enskog --out DIR  tables of one scheme"
    )]
    Dsmc(ValidateDsmc),
}

/// Benchmarks of `stosszahl-trials bench`, one for each engine.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// Time event-driven hard disks on one thread, after a start that is equilibrated elastically;
    /// some seconds.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials bench ed                                    10 000 disks, a million collisions\n  \
                      stosszahl-trials bench ed --disks 100000 --packing-fraction 0.7 --json"
    )]
    Ed(BenchEd),
    /// Time Monte Carlo collisions of dilute elastic hard disks or spheres in cells of half a mean
    /// free path, with a constant time step; some seconds.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials bench dsmc                              a million simulators, 50 steps\n  \
                      stosszahl-trials bench dsmc --dimension 3 --threads 1 --json"
    )]
    Dsmc(BenchDsmc),
    /// Time Monte Carlo collisions of a cooling gas of spheres of a hundred sizes without
    /// positions, on one thread; some seconds.
    #[command(
        after_help = "Begin with:\n  stosszahl-trials bench mixture                           a million monomers to time 100\n  \
                      stosszahl-trials bench mixture --selection single-majorant --collisions 2000000"
    )]
    Mixture(BenchMixture),
}

fn bench(work: &dyn BenchWork, json: bool) -> Done {
    say(&work.measure_speed()?.text(json));
    Ok(())
}

/// Runs the command given on the command line, prints its error if it fails, and returns the exit
/// code.
pub fn execute(arguments: TrialArguments) -> ExitCode {
    let done = match arguments.command {
        TrialCommand::Bench(Bench::Ed(work)) => bench(&work, work.json),
        TrialCommand::Bench(Bench::Dsmc(work)) => bench(&work, work.json),
        TrialCommand::Bench(Bench::Mixture(work)) => bench(&work, work.json),
        TrialCommand::Stress(asked) => stress::command(&asked),
        TrialCommand::Docs(asked) => docs::command(&asked),
        TrialCommand::Calibrate(asked) => calibrate::command(&asked),
        TrialCommand::Validate(asked) => match asked.engine {
            Some(Validate::Dsmc(asked)) => validate::schemes_command(&asked),
            None => validate::command(&asked.all),
        },
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
