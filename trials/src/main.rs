//! The `stosszahl-trials` command.

use std::process::ExitCode;

use clap::Parser;
use stosszahl_model::memory;
use stosszahl_trials::{arguments::TrialArguments, commands};

fn main() -> ExitCode {
    memory::return_large_blocks();
    commands::execute(TrialArguments::parse())
}
