//! Runs with domain decomposition over processes (`stosszahl-mpi`): all processes hold parts of
//! each Monte Carlo gas in cells, one gas after the other.
//!
//! The first process does all that a run does ([`run_decomposed`]). When it begins a gas in cells,
//! it calls the others, which plan the same case and hold their subdomains of the gas
//! ([`serve_subdomains`]). Exact dynamics and gases without positions stay in the first. Tables are
//! the bytes of [`crate::run_case`].

use std::sync::Arc;

use stosszahl_case::CaseFile;
use stosszahl_dsmc::{Ranks, from_first, gather_from_all};
use stosszahl_model::random::Streams;
use stosszahl_model::to_bytes;

use super::case_run::{Opened, prepare, require_memory_of_each};
use super::error::RunError;
use super::options::RunOptions;
use super::summary::RunSummary;
use crate::check::Planned;
use crate::engine_run::EngineRun;
use crate::engines::hold;
use crate::engines::rank_group::{Call, RankGroup, send_call};

/// Guard that, when dropped, tells the other processes that the run has ended.
struct Release<'a>(&'a dyn Ranks);

impl Drop for Release<'_> {
    fn drop(&mut self) {
        send_call(self.0, None);
    }
}

/// Checks that all processes are ready; otherwise returns the error of the lowest rank that is not.
fn require_all_ready<T>(ranks: &dyn Ranks, mine: &Result<T, RunError>) -> Result<(), RunError> {
    let mine = mine.as_ref().err().map(ToString::to_string);
    let all = gather_from_all(ranks, to_bytes(&mine));
    for (rank, bytes) in all.iter().enumerate() {
        let why: Option<String> = postcard::from_bytes(bytes)
            .unwrap_or_else(|_| Some("a message of another program".to_owned()));
        if let Some(why) = why {
            return Err(RunError::Processes(format!("rank {rank}: {why}")));
        }
    }
    Ok(())
}

/// Returns an error if no gas of the case can be decomposed over several processes.
fn require_gas_in_cells(planned: &[Planned<'_>], processes: usize) -> Result<(), RunError> {
    let mut engines = planned.iter().flat_map(|one| &one.plan.engines);
    if processes == 1 || engines.any(|engine| engine.parameters().is_some()) {
        return Ok(());
    }
    Err(RunError::NothingToDecompose)
}

/// Runs all points of a case into a results folder, with each gas in cells decomposed over all
/// processes. The caller is the first process; the other processes call [`serve_subdomains`].
///
/// # Errors
/// As [`crate::run_case`]; [`RunError::Processes`] if another process cannot hold its subdomain,
/// and [`RunError::NothingToDecompose`] for a case without a gas in cells.
pub fn run_decomposed(
    file: &CaseFile,
    options: &RunOptions<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<RunSummary, RunError> {
    let prepared = prepare(file, options).and_then(|(planned, threads)| {
        require_gas_in_cells(&planned, ranks.size())?;
        require_memory_of_each(&planned, threads, ranks.size(), options)?;
        Ok((planned, threads))
    });
    let ready = require_all_ready(&**ranks, &prepared);
    let (planned, threads) = prepared?;
    ready?;
    let _release = Release(&**ranks);
    let opened = Opened::new(file, &planned, options)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let mut points = Vec::new();
    for job in opened.jobs(file, &planned, options) {
        let group = RankGroup::new(ranks.clone(), job.number);
        points.push(pool.install(|| job.run_point(Some(&group)))?);
    }
    Ok(opened.summary(points))
}

/// Plans the case in a process other than the first, and holds its subdomain of each decomposed
/// gas. `file` is the case, or the reason why this process cannot read it.
///
/// # Errors
/// As [`crate::run_case`]; the first process is told.
pub fn serve_subdomains(
    file: Result<&CaseFile, String>,
    options: &RunOptions<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<(), RunError> {
    let prepared = file
        .map_err(RunError::Processes)
        .and_then(|file| prepare(file, options));
    let ready = require_all_ready(&**ranks, &prepared);
    let (planned, threads) = prepared?;
    ready?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    pool.install(|| {
        loop {
            let bytes = from_first(&**ranks, Vec::new());
            let call = postcard::from_bytes::<Option<Call>>(&bytes).map_err(|error| {
                RunError::Processes(format!("a message of another program: {error}"))
            })?;
            let Some(call) = call else {
                return Ok(());
            };
            let planned = &planned[call.point];
            let plan = &planned.plan;
            let Some(engine) = (plan.engines.iter()).find(|engine| engine.name == call.engine)
            else {
                let name = call.engine;
                return Err(RunError::Processes(format!("no engine is called {name}")));
            };
            let part = EngineRun {
                plan,
                engine,
                measures: &planned.measures,
                replica: call.replica,
                start: None,
            };
            let streams = Streams::new(plan.case.seed, call.replica);
            // The first process reports the failures of all.
            let _ = hold(plan, engine, streams, part.needs(), options.stop, ranks);
        }
    })
}
