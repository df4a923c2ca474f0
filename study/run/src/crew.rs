//! A run whose pieces are done by several processes.
//!
//! One process holds the results folder: [`run_among`] hands out pieces from a [`Board`] through whatever connects the processes,
//! which is the caller's [`Crew`]. The others, and its own threads, do them as an [`Assistant`]. Every process plans the case
//! for itself, so that orders are short. A piece is a function of the case, and records come back as a checkpoint holds them,
//! so tables are the bytes of [`crate::run_case`], whoever did what.
//!
//! All processes need the results folder: checkpoints are written there by those who do a piece, so that another process can go
//! on with it, in the same run or a later one.

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::{Deserialize, Serialize};
use stosszahl_case::CaseFile;
use stosszahl_dsmc::Ranks;

use crate::check::Planned;
use crate::holders::Holders;
use crate::journal::Journal;
use crate::pieces::{Desk, Piece, Replica, record, seconds};
use crate::point::Job;
use crate::run::{Opened, Options, PointSummary, RunError, Summary, prepare, require_memory};

/// What another process needs to know to do a piece of a case that it has planned.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Order {
    piece: Piece,
    /// The folder of the point.
    folder: PathBuf,
    fingerprint: [u8; 32],
}

/// Work that is done order by order, in any process; orders and what they leave are bytes.
pub trait Work: Sync {
    /// An order that nobody does; none if there is none now.
    fn next(&self) -> Option<Vec<u8>>;

    /// Takes back the order of a process that was lost: somebody else is to do it.
    fn put_back(&self, order: &[u8]);

    /// Takes what an order left in another process.
    fn take(&self, order: &[u8], record: &[u8]);

    /// Ends the work, as another process cannot do its part.
    fn fail(&self, why: String);

    /// Whether all is done, or the work has ended.
    fn is_finished(&self) -> bool;

    /// What it is made of, and how many of these are done, of all.
    fn count(&self) -> (&'static str, [usize; 2]);
}

/// Does orders of the work of another process.
pub trait Hand: Sync {
    /// How many orders are to be done at once.
    fn slots(&self) -> usize;

    /// Does an order, and returns what it left, for [`Work::take`].
    fn work(&self, order: &[u8]) -> Vec<u8>;
}

/// What connects the processes that do some work.
pub trait Crew: Sync {
    /// Has work done until it is finished: by other processes, and by this one, which does so many orders at once by `here`.
    fn work(&self, work: &dyn Work, slots: usize, here: &(dyn Fn(&[u8]) + Sync));
}

/// An order as bytes, and back. They are of the same program, which was asked before.
pub(crate) fn write<T: Serialize>(order: &T) -> Vec<u8> {
    // Fails only for types without a length.
    postcard::to_stdvec(order).unwrap_or_default()
}

/// The pieces of a run that are still to be done, and what came back.
pub struct Board<'a> {
    jobs: &'a [Job<'a>],
    state: Mutex<State>,
    /// How many processes write checkpoints of one gas.
    writers: usize,
}

struct State {
    /// The largest last.
    waiting: Vec<Piece>,
    points: Vec<Point>,
    failure: Option<RunError>,
}

/// A point on its way.
struct Point {
    began: Option<Instant>,
    /// None of a point that was complete before.
    journal: Option<Journal>,
    replicas: Vec<Option<Result<Replica, RunError>>>,
    summary: Option<PointSummary>,
}

impl Point {
    /// What is there of a point from a run before.
    fn new(job: &Job<'_>) -> Result<Self, RunError> {
        if let Some(summary) = job.complete()? {
            return Ok(Self {
                began: None,
                journal: None,
                replicas: Vec::new(),
                summary: Some(summary),
            });
        }
        let (journal, mut there) = job.journal()?;
        let mut point = Self {
            began: None,
            journal: Some(journal),
            replicas: job
                .pieces()
                .map(|piece| there.remove(&piece.replica))
                .collect(),
            summary: None,
        };
        point.finish_if_whole(job)?;
        Ok(point)
    }

    /// Takes what a piece left. Of a piece that was done twice, the first counts; a finished point has let go of all.
    fn take(
        &mut self,
        job: &Job<'_>,
        piece: Piece,
        left: Result<Replica, RunError>,
    ) -> Result<(), RunError> {
        let Some(place @ None) = self.replicas.get_mut(piece.replica as usize) else {
            return Ok(());
        };
        if let Err(error) = &left
            && !error.is_of_gas()
        {
            return left.map(drop);
        }
        if let Some(journal) = &self.journal {
            job.keep(journal, piece, &left)?;
        }
        *place = Some(left);
        self.finish_if_whole(job)
    }

    fn finish_if_whole(&mut self, job: &Job<'_>) -> Result<(), RunError> {
        if self.replicas.iter().all(Option::is_some) {
            let all = self.replicas.drain(..).flatten().collect();
            let began = self.began.unwrap_or_else(Instant::now);
            self.summary = Some(job.finish(all, began)?);
        }
        Ok(())
    }
}

impl<'a> Board<'a> {
    pub(crate) fn new(jobs: &'a [Job<'a>]) -> Result<Self, RunError> {
        let mut waiting = Vec::new();
        let mut points = Vec::new();
        for job in jobs {
            let point = Point::new(job)?;
            let left = job.pieces().zip(&point.replicas);
            waiting.extend(left.filter_map(|(piece, left)| left.is_none().then_some(piece)));
            points.push(point);
        }
        let cost = |piece: &Piece| seconds(&jobs[piece.point].planned.plan);
        waiting.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
        waiting.reverse();
        let state = State {
            waiting,
            points,
            failure: None,
        };
        Ok(Self {
            jobs,
            state: Mutex::new(state),
            writers: 0,
        })
    }

    /// The same where so many processes hold each gas.
    pub(crate) fn held_by(self, writers: usize) -> Self {
        Self { writers, ..self }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The largest piece that nobody does; none if there is none, or the run has failed.
    pub(crate) fn next_order(&self) -> Option<Order> {
        let mut state = self.state();
        if state.failure.is_some() {
            return None;
        }
        let piece = state.waiting.pop()?;
        let job = &self.jobs[piece.point];
        if let Err(error) = job.claim(piece, self.writers) {
            state.failure = Some(error);
            return None;
        }
        let point = &mut state.points[piece.point];
        if point.began.is_none() {
            point.began = Some(Instant::now());
            job.begin();
        }
        Some(Order {
            piece,
            folder: job.place.path(),
            fingerprint: *job.place.fingerprint(),
        })
    }

    /// Takes what a piece left, and finishes its point if it was the last.
    fn put(&self, piece: Piece, left: Result<Replica, RunError>) {
        let mut state = self.state();
        let job = &self.jobs[piece.point];
        if let Err(error) = state.points[piece.point].take(job, piece, left) {
            state.failure.get_or_insert(error);
        }
    }

    pub(crate) fn finished(self) -> Result<Vec<PointSummary>, RunError> {
        let state = self.state.into_inner();
        let state = state.unwrap_or_else(PoisonError::into_inner);
        match state.failure {
            Some(error) => Err(error),
            None => Ok(state
                .points
                .into_iter()
                .filter_map(|point| point.summary)
                .collect()),
        }
    }
}

impl Work for Board<'_> {
    fn next(&self) -> Option<Vec<u8>> {
        Some(write(&self.next_order()?))
    }

    fn put_back(&self, order: &[u8]) {
        let Ok(Order { piece, .. }) = postcard::from_bytes(order) else {
            return;
        };
        let attempt = piece.attempt + 1;
        self.state().waiting.push(Piece { attempt, ..piece });
    }

    fn take(&self, order: &[u8], record: &[u8]) {
        let Ok(Order { piece, folder, .. }) = postcard::from_bytes(order) else {
            return;
        };
        let job = &self.jobs[piece.point];
        let guard = || job.place.folder().require_same();
        let left = job.desk(&folder, &guard).restore(piece, record);
        self.put(piece, left);
    }

    fn fail(&self, why: String) {
        self.state().failure.get_or_insert(RunError::Crew(why));
    }

    fn is_finished(&self) -> bool {
        let state = self.state();
        state.failure.is_some() || state.points.iter().all(|point| point.summary.is_some())
    }

    fn count(&self) -> (&'static str, [usize; 2]) {
        let state = self.state();
        let counts = self.jobs.iter().zip(&state.points).map(|(job, point)| {
            let all = job.pieces().count();
            let there = point.replicas.iter().flatten().count();
            [if point.summary.is_some() { all } else { there }, all]
        });
        let sum = counts.fold([0, 0], |[done, all], more| [done + more[0], all + more[1]]);
        ("replicas", sum)
    }
}

/// Does pieces of a run on the threads of this process.
pub struct Assistant<'a> {
    planned: &'a [Planned<'a>],
    options: &'a Options<'a>,
    pool: rayon::ThreadPool,
    slots: usize,
    /// Processes that hold each gas in cells together.
    holders: Option<Arc<dyn Ranks>>,
}

impl<'a> Assistant<'a> {
    pub(crate) fn new(
        planned: &'a [Planned<'a>],
        options: &'a Options<'a>,
        threads: usize,
    ) -> Result<Self, RunError> {
        let bytes = planned.iter().map(|one| one.cost(threads).bytes);
        require_memory(bytes.fold(0.0, f64::max), options)?;
        let engines = planned.iter().map(|one| one.plan.engines.len()).min();
        Ok(Self {
            planned,
            options,
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?,
            slots: (threads / engines.unwrap_or(1).max(1)).max(1),
            holders: None,
        })
    }

    /// Each gas in cells is held by these processes from now on, of which this is the first.
    pub(crate) fn hold_with(&mut self, ranks: Arc<dyn Ranks>) {
        self.holders = Some(ranks);
    }

    fn desk<'d>(&'d self, order: &'d Order) -> Desk<'d> {
        Desk {
            planned: &self.planned[order.piece.point],
            folder: &order.folder,
            guard: None,
            fingerprint: &order.fingerprint,
            number: order.piece.point,
            stop: self.options.stop,
            progress: self.options.progress,
        }
    }

    /// Does a piece of this process's own board.
    pub(crate) fn work_here(&self, board: &Board<'_>, order: &Order) {
        let desk = self.desk(order);
        let holders = self.holders.clone().map(|ranks| Holders {
            ranks,
            point: order.piece.point,
        });
        let left = (self.pool).install(|| desk.work_among(order.piece, holders.as_ref()));
        board.put(order.piece, left);
    }
}

impl Hand for Assistant<'_> {
    /// So many that each thread has an engine.
    fn slots(&self) -> usize {
        self.slots
    }

    fn work(&self, order: &[u8]) -> Vec<u8> {
        let Ok(order) = postcard::from_bytes::<Order>(order) else {
            return Vec::new();
        };
        let desk = self.desk(&order);
        let left = match fs::read_dir(&order.folder) {
            Ok(_) => self.pool.install(|| desk.work(order.piece)),
            Err(error) => Err(RunError::Crew(format!(
                "{}: {error}; all processes of a run need its results folder",
                order.folder.display()
            ))),
        };
        let bytes = record(&left).or_else(|error| {
            let left = Err(RunError::Crew(format!("the record of a piece: {error}")));
            record(&left)
        });
        bytes.unwrap_or_default()
    }
}

/// Runs all points of a case into a results folder with the help of other processes.
///
/// # Errors
/// As [`crate::run_case`]; and [`RunError::Crew`].
pub fn run_among(
    file: &CaseFile,
    options: &Options<'_>,
    crew: &dyn Crew,
) -> Result<Summary, RunError> {
    let (planned, threads) = prepare(file, options)?;
    let here = Assistant::new(&planned, options, threads)?;
    let opened = Opened::new(file, &planned, options)?;
    let jobs = opened.jobs(file, &planned, options);
    let board = Board::new(&jobs)?;
    crew.work(&board, here.slots, &|order| {
        if let Ok(order) = postcard::from_bytes(order) {
            here.work_here(&board, &order);
        }
    });
    Ok(opened.summary(board.finished()?))
}

/// Plans the same case in another process, which then does pieces of it.
///
/// # Errors
/// As [`crate::run_case`].
pub fn assist<T>(
    file: &CaseFile,
    options: &Options<'_>,
    work: impl FnOnce(&dyn Hand) -> T,
) -> Result<T, RunError> {
    let (planned, threads) = prepare(file, options)?;
    Ok(work(&Assistant::new(&planned, options, threads)?))
}
