//! The command `stosszahl-mpi`: a case on many machines, over MPI.
//!
//! Rank 0 reads the case, holds the results folder and hands out replicas and points of sweeps, or
//! runs of a frontier (`root`); all ranks do them (`other`). Tables are the bytes of
//! `stosszahl run`.
//!
//! | module | owns |
//! |---|---|
//! | `link` | messages, and the heartbeat that reveals lost processes |
//! | `messages` | content of the messages |
//! | `root` | orders go out, records come in |
//! | `other` | orders are done |
//! | `together`, `world` | one gas in all processes (`--one-gas`) |
//! | `pulse` | the end of a job of which one process hangs |

mod arguments;
mod link;
mod messages;
mod other;
mod pulse;
mod root;
mod together;
mod world;

use std::process::{self, ExitCode};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use clap::Parser as _;
use mpi::Threading;
use mpi::traits::Communicator as _;
use stosszahl::arguments::CaseArguments;
use stosszahl::commands::{self, STOPPED_RUN, listen, note};
use stosszahl::model::memory;
use stosszahl::study::crew::run_among;

use crate::arguments::{Arguments, Command};
use crate::link::{Link, ROOT};
use crate::messages::{Case, ToOther};

/// Time that the other processes wait for the end of the root, if MPI is not closed by all
/// together.
const AFTER_ROOT: Duration = Duration::from_secs(1);

/// End of a process.
struct End {
    code: ExitCode,
    /// True if all processes are there to close MPI.
    together: bool,
}

fn main() -> ExitCode {
    memory::return_large_blocks();
    commands::outlive_file_limits();
    let Some((universe, level)) = mpi::initialize_with_threading(Threading::Serialized) else {
        note("error: MPI is started already");
        return ExitCode::FAILURE;
    };
    let world = universe.world();
    if level < Threading::Serialized {
        note("error: this MPI library is built without threads");
        return ExitCode::FAILURE;
    }
    let me = world.rank();
    let command = match Arguments::try_parse() {
        Ok(arguments) => arguments.command,
        // All find the same, and one says it.
        Err(error) => {
            if me == ROOT {
                let _ = error.print();
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let patience = match &command {
        Command::Run { run, shared } if shared.one_gas => {
            return together::run(run, Duration::from_secs_f64(shared.lost_after));
        }
        Command::Run { shared, .. } => shared.lost_after,
        Command::Frontier { lost_after, .. } => *lost_after,
    };
    let patience = Duration::from_secs_f64(patience);
    let (link, ends) = link::link();
    let finished = AtomicBool::new(false);
    let size = world.size();
    let end = thread::scope(|scope| {
        let work = scope.spawn(|| {
            let _guard = Raise(&finished);
            if me == ROOT {
                hold(link, size, &command)
            } else {
                let stop = listen("");
                End {
                    together: other::serve(&link, &command, &stop),
                    code: ExitCode::SUCCESS,
                }
            }
        });
        let lost_one = link::pump(&world, &ends, patience, &finished);
        work.join().map(|end| End {
            together: end.together && !lost_one,
            ..end
        })
    });
    let end = end.unwrap_or(End {
        code: ExitCode::FAILURE,
        together: false,
    });
    if !end.together {
        // Closing MPI would wait for those that are lost. The root goes first: to `mpirun` it is
        // the one that counts.
        if me != ROOT {
            thread::sleep(AFTER_ROOT);
        }
        let failed = end.code != ExitCode::SUCCESS;
        process::exit(i32::from(failed));
    }
    end.code
}

/// Guard that raises a flag when it is dropped, also in a panic.
struct Raise<'a>(&'a AtomicBool);

impl Drop for Raise<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

/// Runs the command with the help of the other processes, and tells them the end.
fn hold(link: Link, size: i32, command: &Command) -> End {
    let link = Mutex::new(link);
    let others = root::Others::new(&link, size);
    let read = |case: &CaseArguments| {
        let file = commands::read(case)?;
        others.tell(&ToOther::Case(Case::of(&file, case)));
        Ok(file)
    };
    let done = match command {
        Command::Run { run, .. } => {
            let stop = listen(STOPPED_RUN);
            read(&run.case).and_then(|file| {
                commands::run(run, &file, &stop, &others, |file, options| {
                    run_among(file, options, &others)
                })
            })
        }
        Command::Frontier { frontier, .. } => read(&frontier.case)
            .and_then(|file| commands::measure_frontier(frontier, &file, Some(&others), None)),
    };
    let code = commands::ended(done);
    others.hear_who_is_gone();
    let together = others.are_all_there();
    others.tell(&ToOther::End { together });
    End { code, together }
}
