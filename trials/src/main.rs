//! Entry point of the `stosszahl-trials` command.

use std::process::ExitCode;

use clap::Parser;
use stosszahl_model::memory;
use stosszahl_trials::arguments::{TrialArguments, execute};

fn main() -> ExitCode {
    memory::return_large_blocks();
    execute(TrialArguments::parse())
}
