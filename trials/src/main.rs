//! The `stosszahl-trials` command.

use std::process::ExitCode;

use clap::Parser;
use stosszahl_trials::{arguments::Arguments, commands};

fn main() -> ExitCode {
    commands::execute(Arguments::parse())
}
