//! Execution of the commands.

use std::io::{self, Write as _};
use std::process::ExitCode;

use crate::arguments::{Arguments, Bench, Command, Stress, Validate};
use crate::bench::Work;
use crate::terminal::say;
use crate::{Done, calibrate, docs, stress, validate};

fn bench(work: &dyn Work, json: bool) -> Done {
    say(&work.measure()?.text(json));
    Ok(())
}

/// Runs the command line, and returns its exit code.
pub fn execute(arguments: Arguments) -> ExitCode {
    let done = match arguments.command {
        Command::Bench(Bench::Ed(work)) => bench(&work, work.json),
        Command::Bench(Bench::Dsmc(work)) => bench(&work, work.json),
        Command::Bench(Bench::Mixture(work)) => bench(&work, work.json),
        Command::Stress(Stress::Ed(asked)) => {
            stress::command(&stress::event_driven(), &asked.cases, asked.collisions)
        }
        Command::Stress(Stress::Dsmc(asked)) => {
            stress::command(&stress::monte_carlo(), &asked, None)
        }
        Command::Stress(Stress::Mixture(asked)) => {
            stress::command(&stress::mixtures(), &asked, None)
        }
        Command::Stress(Stress::Walls(asked)) => stress::command(&stress::walls(), &asked, None),
        Command::Docs(asked) => docs::command(&asked),
        Command::Calibrate(asked) => calibrate::command(&asked),
        Command::Validate(asked) => match asked.engine {
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
