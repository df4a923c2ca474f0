//! Runs whose Monte Carlo gases are held by several processes at once, one gas after the other.
//!
//! The first process does all that a run does ([`run_holding`]). When it begins a gas in cells, it calls the others, which plan the
//! same case and hold their parts of it ([`hold_gases`]). Exact dynamics and gases without positions stay in the first.

use std::sync::Arc;

use stosszahl_case::CaseFile;
use stosszahl_dsmc::{Ranks, from_first, gather_from_all};
use stosszahl_model::random::Streams;

use crate::crew::{Assistant, Board};
use crate::engines::hold;
use crate::follow::Part;
use crate::plan::EnginePlan;
use crate::run::{Opened, Options, RunError, Summary, prepare};

/// The processes that hold the gases of a point.
#[derive(Clone)]
pub struct Holders {
    pub(crate) ranks: Arc<dyn Ranks>,
    pub(crate) point: usize,
}

/// The gas that is begun: point, replica, and the name of the engine; or none any more.
type Call = Option<(usize, u64, String)>;

fn tell(ranks: &dyn Ranks, call: &Call) {
    // Fails only for types without a length.
    from_first(ranks, postcard::to_stdvec(call).unwrap_or_default());
}

impl Holders {
    /// Calls the others to a gas.
    pub(crate) fn call(&self, replica: u64, engine: &EnginePlan) -> &Arc<dyn Ranks> {
        let call = (self.point, replica, engine.name.to_owned());
        tell(&*self.ranks, &Some(call));
        &self.ranks
    }
}

/// Lets the other processes go at the end.
struct Release<'a>(&'a dyn Ranks);

impl Drop for Release<'_> {
    fn drop(&mut self) {
        tell(self.0, &None);
    }
}

/// Whether all processes can go on, or what hinders the first that something hinders.
fn agree<T>(ranks: &dyn Ranks, mine: &Result<T, RunError>) -> Result<(), RunError> {
    let mine = mine.as_ref().err().map(ToString::to_string);
    let all = gather_from_all(ranks, postcard::to_stdvec(&mine).unwrap_or_default());
    for (rank, bytes) in all.iter().enumerate() {
        let why: Option<String> = postcard::from_bytes(bytes)
            .unwrap_or_else(|_| Some("a message of another program".to_owned()));
        if let Some(why) = why {
            return Err(RunError::Crew(format!("rank {rank}: {why}")));
        }
    }
    Ok(())
}

/// Runs all points of a case into a results folder, each gas in cells held by all of these processes. This is the first; the others
/// [`hold_gases`].
///
/// # Errors
/// As [`crate::run_case`]; and if another process cannot hold its part.
pub fn run_holding(
    file: &CaseFile,
    options: &Options<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Summary, RunError> {
    let prepared = prepare(file, options);
    let agreed = agree(&**ranks, &prepared);
    let (planned, threads) = prepared?;
    agreed?;
    let _release = Release(&**ranks);
    let mut here = Assistant::new(&planned, options, threads)?;
    here.hold_with(ranks.clone());
    let opened = Opened::new(file, &planned, options)?;
    let jobs = opened.jobs(file, &planned, options);
    let board = Board::new(&jobs)?.held_by(ranks.size());
    while let Some(order) = board.next_order() {
        here.work_here(&board, &order);
    }
    Ok(opened.summary(board.finished()?))
}

/// Plans the same case in another process, and holds its part of each gas that the first begins. The case, or why it cannot be
/// read here.
///
/// # Errors
/// As [`crate::run_case`]; the first process is told.
pub fn hold_gases(
    file: Result<&CaseFile, String>,
    options: &Options<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<(), RunError> {
    let prepared = file
        .map_err(RunError::Crew)
        .and_then(|file| prepare(file, options));
    let agreed = agree(&**ranks, &prepared);
    let (planned, threads) = prepared?;
    agreed?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    pool.install(|| {
        loop {
            let bytes = from_first(&**ranks, Vec::new());
            let call: Call = postcard::from_bytes(&bytes).unwrap_or(None);
            let Some((point, replica, name)) = call else {
                return Ok(());
            };
            let planned = &planned[point];
            let plan = &planned.plan;
            let Some(engine) = plan.engines.iter().find(|engine| engine.name == name) else {
                return Err(RunError::Crew(format!("no engine is called {name}")));
            };
            let part = Part {
                plan,
                engine,
                measures: &planned.measures,
                replica,
                start: None,
            };
            let streams = Streams::new(plan.case.seed, replica);
            // What hinders this process is said by the first.
            let _ = hold(plan, engine, streams, part.needs(), options.stop, ranks);
        }
    })
}
