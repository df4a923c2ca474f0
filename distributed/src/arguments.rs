//! The command line as typed.

use clap::{Parser, Subcommand};
use stosszahl::command_line::RunArguments;

/// stosszahl over MPI: one large Monte Carlo gas on many machines.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl-mpi",
    version,
    after_help = "Begin with:\n  mpirun -n 4 stosszahl-mpi run CASE\n  srun stosszahl-mpi run CASE --threads 8\n\n\
                  All processes need the results folder. Replicas and points of sweeps need no MPI: `stosszahl run CASE --join`, \
                  started any number of times, shares them.\n\n\
                  Exit codes: 0 done, 1 the run failed, 2 the input was refused, 75 stopped by --stop-after,\n\
                  130 stopped by a signal (continue both with --resume)."
)]
pub struct MpiArguments {
    /// Command to run.
    #[command(subcommand)]
    pub command: MpiCommand,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum MpiCommand {
    /// Run a case with each Monte Carlo gas in cells held by all processes together: tables are the
    /// bytes of `stosszahl run`, for any number of processes and threads.
    Run {
        /// As for `stosszahl run`; threads are those of each process.
        #[command(flatten)]
        run: RunArguments,
        /// Seconds of silence after which a process counts as hanging: the job ends.
        #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
        rank_timeout: f64,
    },
}

fn seconds(text: &str) -> Result<f64, String> {
    let allowed = "allowed: seconds from 2 to 1e6";
    let found = text.parse::<f64>().map_err(|_| allowed.to_owned())?;
    if (2.0..=1e6).contains(&found) {
        Ok(found)
    } else {
        Err(allowed.to_owned())
    }
}
