//! The command line program `stosszahl`.

use std::process::ExitCode;

use clap::Parser;
use stosszahl::command_line::{self, Arguments};
use stosszahl::model::memory;

fn main() -> ExitCode {
    memory::return_large_blocks();
    command_line::outlive_file_limits();
    match Arguments::try_parse() {
        Ok(arguments) => command_line::execute(arguments),
        Err(asked) => command_line::tell(&asked),
    }
}
