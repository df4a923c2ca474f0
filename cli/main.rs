//! The command line program `stosszahl`.

use std::process::ExitCode;

use clap::Parser;
use stosszahl::model::memory;
use stosszahl::{arguments::Arguments, commands};

fn main() -> ExitCode {
    memory::return_large_blocks();
    commands::outlive_file_limits();
    match Arguments::try_parse() {
        Ok(arguments) => commands::execute(arguments),
        Err(asked) => commands::tell(&asked),
    }
}
