//! The `stosszahl` command.

use std::process::ExitCode;

use clap::Parser;
use stosszahl::{arguments::Arguments, commands};

fn main() -> ExitCode {
    commands::execute(Arguments::parse())
}
