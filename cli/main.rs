//! The `stosszahl` command.

mod allocator;

use std::process::ExitCode;

use clap::Parser;
use stosszahl::{arguments::Arguments, commands};

fn main() -> ExitCode {
    allocator::return_large_blocks();
    commands::execute(Arguments::parse())
}
