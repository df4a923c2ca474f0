//! Hard cases of all engines, the tests of `stosszahl-trials stress`: collapse, close packing,
//! extreme numbers, restarts.
//!
//! Each trial states what it tries and what must hold, and tests it. Tolerances are stated where
//! they are used. Those that several trials share are constants of the modules `gas` and `schemes`,
//! with their origin. Trials also cut their runs at random times and continue them from serialised
//! checkpoints.
//!
//! ```
//! use stosszahl_trials::{Effort, stress::StressEngine};
//! let rest = StressEngine::Ed.cases().into_iter().find(|trial| trial.name == "rest");
//! let report = rest.expect("a trial of this name").run_trial(&Effort::default());
//! assert!(report.passed(), "{report}");
//! ```

mod boxes;
mod collapse;
mod conserved;
mod contacts;
mod crowds;
mod extremes;
mod flight;
mod gas;
mod homogeneous;
mod long;
mod schemes;
mod steps;
mod still;
mod ties;
mod walls;

use clap::{Args, ValueEnum};

use crate::terminal::say;
use crate::trial::chosen;
use crate::{Done, Effort, TrialError, TrialRow};

/// Engine whose hard cases can be run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StressEngine {
    /// Event-driven hard disks: collapse, close packing, ties, grazing contacts, long runs, extreme
    /// sizes and speeds, kills.
    Ed,
    /// Monte Carlo, every scheme: crowded and empty cells, steps too long, cooling through 24
    /// decades, threads, kills.
    Dsmc,
    /// Gases without positions: extreme sizes and temperatures, rare species, no rebound, cooling
    /// until nothing moves, sticking until one cluster is left.
    Mixture,
    /// Obstacles and openings, exact dynamics and Monte Carlo: a sharp corner, a supersonic stream.
    Walls,
}

/// Options of `stosszahl-trials stress`: the selected hard cases, and the form of their report.
#[derive(Clone, Debug, Args)]
pub struct StressCases {
    /// Engine whose hard cases are run.
    #[arg(value_enum)]
    pub engine: StressEngine,
    /// Hard case to run alone; may be repeated, or name several with commas between them.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub case: Vec<String>,
    /// Print the names of the hard cases with what they try and what must hold, and run none.
    #[arg(long)]
    pub list: bool,
    /// Run hard cases longer if they have a long form; progress goes to standard error.
    #[arg(long)]
    pub long: bool,
    /// Print one JSON array, with one object for each hard case.
    #[arg(long)]
    pub json: bool,
    /// Collisions of the runs of exact disks whose length can be set: crystals, elastic-run,
    /// one-huge [default: 5e3 to 2e6; 1e6 to 1e9 with --long].
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u64).range(100..))]
    pub collisions: Option<u64>,
}

impl StressEngine {
    /// Returns all hard cases of the engine, in the order in which they are run.
    pub fn cases(self) -> Vec<TrialRow> {
        let parts: &[&[TrialRow]] = match self {
            Self::Ed => &[
                collapse::TRIALS,
                ties::TRIALS,
                contacts::TRIALS,
                long::TRIALS,
                still::TRIALS,
                boxes::TRIALS,
                // Last, as one of them may leave a busy thread behind.
                extremes::TRIALS,
            ],
            Self::Dsmc => &[
                crowds::TRIALS,
                steps::TRIALS,
                flight::TRIALS,
                conserved::TRIALS,
            ],
            Self::Mixture => &[homogeneous::TRIALS],
            Self::Walls => &[walls::TRIALS],
        };
        parts.concat()
    }
}

/// Runs the requested hard cases one after the other, and prints their reports.
pub(crate) fn command(asked: &StressCases) -> Done {
    if asked.collisions.is_some() && asked.engine != StressEngine::Ed {
        let text = "--collisions: allowed only for exact disks, stress ed";
        return Err(TrialError::refused(text));
    }
    let chosen = chosen(
        &asked.engine.cases(),
        |trial| trial.name,
        "case",
        &asked.case,
    )?;
    if asked.list {
        for trial in chosen {
            let (name, tried, required) = (trial.name, trial.tried, trial.required);
            say(&format!("{name}\n  tried  {tried}\n  must   {required}"));
        }
        return Ok(());
    }
    let effort = Effort {
        long: asked.long,
        collisions: asked.collisions,
        tell: asked.long || asked.collisions.is_some(),
        ..Effort::default()
    };
    let run = |trial: &TrialRow| {
        let report = trial.run_trial(&effort);
        if !asked.json {
            say(&report.to_string());
        }
        report
    };
    let reports: Vec<_> = chosen.iter().map(run).collect();
    let failed = reports.iter().filter(|report| !report.passed());
    let failed: Vec<_> = failed.map(|report| report.name).collect();
    let (of, bad) = (reports.len(), failed.len());
    if asked.json {
        say(&serde_json::to_string_pretty(&reports).unwrap_or_default());
    } else {
        let seconds: f64 = reports.iter().map(|report| report.seconds).sum();
        say(&format!(
            "{} of {of} hard cases passed in {seconds:.0} s",
            of - bad
        ));
    }
    if failed.is_empty() {
        return Ok(());
    }
    let names = failed.join(", ");
    Err(TrialError::failed(format!(
        "{bad} of {of} hard cases failed: {names}"
    )))
}
