//! The command `stosszahl-mpi`: one large Monte Carlo gas on many machines, over MPI.
//!
//! Rank 0 reads the case and holds the results folder. All ranks hold each gas in cells together, by
//! domain decomposition. Tables are the bytes of `stosszahl run`.
//!
//! | module | owns |
//! |---|---|
//! | `decomposed_run` | the run in all processes |
//! | `world` | exchange of messages between the subdomains |
//! | `messages` | the case as a message |
//! | `heartbeat` | the end of a job of which one process hangs |

mod arguments;
mod decomposed_run;
mod heartbeat;
mod messages;
mod world;

use std::process::ExitCode;
use std::time::Duration;

use clap::Parser as _;
use mpi::Threading;
use mpi::traits::Communicator as _;
use stosszahl::command_line::{self, note};
use stosszahl::model::memory;

use crate::arguments::{MpiArguments, MpiCommand};

/// Rank of the process that holds the results folder.
const ROOT: i32 = 0;

fn main() -> ExitCode {
    memory::return_large_blocks();
    command_line::outlive_file_limits();
    let Some((universe, level)) = mpi::initialize_with_threading(Threading::Serialized) else {
        note("error: MPI is started already");
        return ExitCode::FAILURE;
    };
    if level < Threading::Serialized {
        note("error: this MPI library is built without threads");
        return ExitCode::FAILURE;
    }
    match MpiArguments::try_parse() {
        Ok(MpiArguments {
            command: MpiCommand::Run { run, rank_timeout },
        }) => decomposed_run::run_on_ranks(&run, Duration::from_secs_f64(rank_timeout)),
        // All processes find the same error, and the root prints it.
        Err(error) => {
            if universe.world().rank() == ROOT {
                let _ = error.print();
            }
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
        }
    }
}
