//! The `stosszahl` command.

mod allocator;
mod arguments;
mod bundled;
mod commands;
mod init;
mod progress;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    allocator::return_large_blocks();
    commands::execute(arguments::Arguments::parse())
}
