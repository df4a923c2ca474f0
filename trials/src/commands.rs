//! Execution of the commands.

use std::io::{self, Write as _};
use std::process::ExitCode;

use crate::arguments::{Bench, StressCommand, TrialArguments, TrialCommand, Validate};
use crate::bench::BenchWork;
use crate::terminal::say;
use crate::{Done, calibrate, docs, stress, validate};

fn bench(work: &dyn BenchWork, json: bool) -> Done {
    say(&work.measure_speed()?.text(json));
    Ok(())
}

/// Runs the command line, and returns its exit code.
pub fn execute(arguments: TrialArguments) -> ExitCode {
    let done = match arguments.command {
        TrialCommand::Bench(Bench::Ed(work)) => bench(&work, work.json),
        TrialCommand::Bench(Bench::Dsmc(work)) => bench(&work, work.json),
        TrialCommand::Bench(Bench::Mixture(work)) => bench(&work, work.json),
        TrialCommand::Stress(StressCommand::Ed(asked)) => {
            stress::command(&stress::event_driven(), &asked.cases, asked.collisions)
        }
        TrialCommand::Stress(StressCommand::Dsmc(asked)) => {
            stress::command(&stress::monte_carlo(), &asked, None)
        }
        TrialCommand::Stress(StressCommand::Mixture(asked)) => {
            stress::command(&stress::mixtures(), &asked, None)
        }
        TrialCommand::Stress(StressCommand::Walls(asked)) => {
            stress::command(&stress::walls(), &asked, None)
        }
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
