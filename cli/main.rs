//! The `stosszahl` command.

mod arguments;
mod bundled;
mod commands;
mod init;
mod progress;
mod reference;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    commands::execute(arguments::Arguments::parse())
}
