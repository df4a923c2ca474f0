//! Run of a case in all processes: the root manages it, and all hold each of its gases in cells
//! together.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use stosszahl::command_line::{self, Display, RunArguments, STOPPED_RUN, TimeLimit, listen, note};
use stosszahl::dsmc::{Ranks, from_first, gather_from_all};
use stosszahl::model::to_bytes;
use stosszahl::results::Existing;
use stosszahl::study::RunOptions;
use stosszahl::study::run::decomposed::{run_decomposed, serve_subdomains};

use crate::heartbeat::Heartbeat;
use crate::messages::{CaseMessage, read};
use crate::world::{Traffic, World};

/// Runs a case with all processes. If nothing is heard of one for `patience`, the job ends.
pub fn run_on_ranks(arguments: &RunArguments, patience: Duration) -> ExitCode {
    let world = Arc::new(World::new());
    let _heartbeat = Heartbeat::start(&world, patience);
    let ranks: Arc<dyn Ranks> = world.clone();
    let began = Instant::now();
    let code = if world.rank() == 0 {
        lead(arguments, &ranks)
    } else {
        follow(arguments, &ranks);
        ExitCode::SUCCESS
    };
    let seconds = began.elapsed().as_secs_f64();
    let all = gather_from_all(&*ranks, to_bytes(&world.traffic()));
    if world.rank() == 0 && !arguments.printed.quiet {
        for (rank, bytes) in all.iter().enumerate() {
            if let Some(traffic) = read::<Traffic>(bytes) {
                note(&format!(
                    "rank {rank}: {} messages of {:.3e} bytes, and {:.3e} bytes received, in {} rounds, {:.2} s of {seconds:.2} s in them",
                    traffic.messages,
                    traffic.bytes as f64,
                    traffic.received as f64,
                    traffic.rounds,
                    traffic.seconds
                ));
            }
        }
    }
    code
}

fn lead(arguments: &RunArguments, ranks: &Arc<dyn Ranks>) -> ExitCode {
    let stop = listen(STOPPED_RUN);
    let file = command_line::read(&arguments.case);
    let case = file.as_ref().ok();
    let case = case.map(|file| CaseMessage::from_case(file, &arguments.case));
    from_first(&**ranks, to_bytes(&case));
    let done = file.and_then(|file| {
        let display = Display::new();
        command_line::run(arguments, &file, &stop, &display, |file, options| {
            run_decomposed(file, options, ranks)
        })
    });
    command_line::ended(done)
}

/// Follows the first process, which reports the errors of all.
fn follow(arguments: &RunArguments, ranks: &Arc<dyn Ranks>) {
    let stop = listen("");
    let _limit = TimeLimit::start(arguments.time_limit(), &stop, "");
    // No case, if the first process could not read it.
    let file = match read::<Option<CaseMessage>>(&from_first(&**ranks, Vec::new())) {
        Some(Some(case)) => case.read(),
        Some(None) => return,
        None => Err("the first process is of another version of the program".to_owned()),
    };
    let options = RunOptions {
        out: None,
        existing: Existing::Refuse,
        threads: arguments.threads.map(usize::from),
        ignore_memory_limit: arguments.ignore_memory_limit,
        stop: &stop,
        progress: &(),
        commit: "",
    };
    let _ = serve_subdomains(file.as_ref().map_err(Clone::clone), &options, ranks);
}
