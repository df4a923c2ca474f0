//! The command line as typed.

use clap::{Args, Parser, Subcommand};
use stosszahl::arguments::{FrontierArguments, RunArguments};

/// stosszahl over MPI: replicas and points of sweeps on many machines.
#[derive(Debug, Parser)]
#[command(
    name = "stosszahl-mpi",
    version,
    after_help = "Begin with:\n  mpirun -n 4 stosszahl-mpi run cases/quick.toml\n  srun stosszahl-mpi run cases/quick.toml --threads 8\n\n\
                  All processes need the results folder. With Open MPI, `mpirun --enable-recovery` lets a run go on without a \
                  process that was killed.\n\n\
                  Exit codes: 0 done, 1 the run failed, 2 the input was refused, 130 stopped (continue with --resume)."
)]
pub struct Arguments {
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a case: tables are the bytes of `stosszahl run`, for any number of processes and
    /// threads.
    Run {
        /// As for `stosszahl run`; threads are those of each process.
        #[command(flatten)]
        run: RunArguments,
        /// Options of all processes.
        #[command(flatten)]
        shared: Together,
    },
    /// Measure speed against error around a case: tables are those of `stosszahl frontier`, but for
    /// times.
    Frontier {
        /// As for `stosszahl frontier`; threads are those of each process.
        #[command(flatten)]
        frontier: FrontierArguments,
        /// Seconds of silence after which a process is lost: others make its runs.
        #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
        lost_after: f64,
    },
}

/// Options of the work of several processes, and the time after which one counts as lost.
#[derive(Debug, Args)]
pub struct Together {
    /// Seconds of silence after which a process is lost: its work is done by others, or, with one
    /// gas, the job ends.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub lost_after: f64,
    /// All processes hold one gas after the other together, in place of one replica each: for a
    /// large gas of Monte Carlo in cells.
    #[arg(long)]
    pub one_gas: bool,
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
