//! Running a case: replicas and engines in parallel, checkpoints, and continuation to the same bytes.
//!
//! A run is cut into legs. A leg is a function of the checkpoint before it, and the cuts are where work counts say,
//! never where a clock says, so it does not matter at which of them a run is stopped. Only *whether* a checkpoint is
//! written after a leg depends on the clock.

mod driven;
mod gas;
mod job;
mod prepare;
mod record;

use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use std::{fs, io};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use stosszahl_model::random::Streams;
pub use stosszahl_model::snapshot::Fingerprint;
use stosszahl_model::snapshot::{self, SnapshotError};

pub use driven::{Driven, PARTS};
pub use job::{Finished, Work};
pub use prepare::StartReport;
pub use record::Record;

use crate::dispatch::{Planar, Visit, with_scene};
use crate::progress::{JobProgress, Progress};
use crate::setup::{Setup, SetupError};
use prepare::Preparation;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The start cannot be made.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The placed disks overlap: a fault of the program.
    #[error("disks {} and {} of the start overlap by {depth} diameters", pair[0], pair[1])]
    Overlap {
        /// The pair.
        pair: [usize; 2],
        /// How deep, in diameters.
        depth: f64,
    },
    /// Event-driven dynamics cannot go on.
    #[error("event-driven engine: {0}")]
    EventDriven(#[from] stosszahl_ed::EngineError),
    /// Event-driven dynamics cannot go on from a state that was kept.
    #[error("event-driven engine: {source}; the state at that time is in {}", path.display())]
    Stopped {
        /// Why.
        source: stosszahl_ed::EngineError,
        /// The state, as extended XYZ.
        path: PathBuf,
    },
    /// The Monte Carlo engine cannot start.
    #[error("Monte Carlo engine: {0}")]
    MonteCarlo(#[from] stosszahl_dsmc::EngineError),
    /// A gas without positions cannot start or go on.
    #[error("gas without positions: {0}")]
    Gas(#[from] stosszahl_dsmc::homogeneous::GasError),
    /// A flow cannot start.
    #[error(transparent)]
    Flow(#[from] crate::flow::FlowError),
    /// A measurement cannot be made.
    #[error("measurement: {0}")]
    Measurement(#[from] stosszahl_analysis::Error),
    /// More collisions than `engine.ed.collision_limit` allows.
    #[error("{collisions} collisions have reached engine.ed.collision_limit")]
    CollisionLimit {
        /// How many happened.
        collisions: u64,
    },
    /// A checkpoint or table cannot be written or read.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// A folder cannot be made or removed.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The user asked to stop; checkpoints are written.
    #[error("stopped; continue with --resume")]
    Interrupted,
    /// One replica failed.
    #[error("replica {replica}, {part}: {source}")]
    Replica {
        /// Which, from 0.
        replica: usize,
        /// `start`, or the engine.
        part: String,
        /// Why.
        source: Box<RunError>,
    },
}

impl RunError {
    /// What happened, whichever replica it happened in.
    fn cause(&self) -> &Self {
        match self {
            Self::Replica { source, .. } => source.cause(),
            other => other,
        }
    }

    /// Whether the run only stopped because it was asked to.
    pub fn is_interruption(&self) -> bool {
        matches!(self.cause(), Self::Interrupted)
    }

    /// Whether checkpoints of another run were found.
    pub fn is_foreign(&self) -> bool {
        matches!(self.cause(), Self::Snapshot(SnapshotError::Foreign { .. }))
    }
}

/// One replica, finished.
#[derive(Clone, Debug)]
pub struct Replica {
    /// How its start came about.
    pub start: StartReport,
    /// Its engines, in the order of the case.
    pub engines: Vec<Finished>,
}

/// Collisions in one leg of event-driven dynamics. A new leg costs about as much as a tenth of a collision for each
/// disk.
fn leg_collisions(disks: usize) -> u64 {
    (4 * disks as u64).max(100_000)
}

/// Saves, stops and tells about one part of one replica.
pub(crate) struct Control<'a, T> {
    path: PathBuf,
    fingerprint: &'a Fingerprint,
    interval: Duration,
    last: Mutex<Instant>,
    stop: &'a AtomicBool,
    progress: JobProgress,
    content: PhantomData<fn(T)>,
}

impl<'a, T> Control<'a, T> {
    /// The control of a part of a replica, with `seconds` between two checkpoints.
    pub(crate) fn new(
        place: Place<'a>,
        replica: usize,
        part: &str,
        seconds: f64,
        progress: &JobProgress,
    ) -> Self {
        Self {
            path: place
                .folder
                .join(CHECKPOINTS)
                .join(format!("replica-{replica}-{part}.snapshot")),
            fingerprint: place.fingerprint,
            interval: Duration::from_secs_f64(seconds.min(1e9)),
            last: Mutex::new(Instant::now()),
            stop: place.stop,
            progress: progress.clone(),
            content: PhantomData,
        }
    }
}

impl<T> Control<'_, T> {
    /// The same control over something else.
    fn with<U>(&self) -> Control<'_, U> {
        Control {
            path: self.path.clone(),
            fingerprint: self.fingerprint,
            interval: self.interval,
            last: Mutex::new(Instant::now()),
            stop: self.stop,
            progress: self.progress.clone(),
            content: PhantomData,
        }
    }

    pub(crate) fn tell(&self, share: f64, collisions: u64) {
        self.progress.tell(share, collisions);
    }
}

impl<T: Serialize + DeserializeOwned> Control<'_, T> {
    /// The last checkpoint, if there is one.
    pub(crate) fn load(&self) -> Result<Option<T>, RunError> {
        match snapshot::read(&self.path, self.fingerprint) {
            Ok(content) => Ok(Some(content)),
            Err(SnapshotError::File { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                Ok(None)
            }
            Err(error) => Err(error.into()),
        }
    }

    pub(crate) fn save(&self, content: &T) -> Result<(), RunError> {
        Ok(snapshot::write(&self.path, self.fingerprint, content)?)
    }

    /// After a leg: saves when it is time to, and stops when asked to.
    fn pause(&self, content: &T) -> Result<(), RunError> {
        let stop = self.stop.load(Ordering::Relaxed);
        let due = {
            let mut last = self
                .last
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            let due = last.elapsed() >= self.interval;
            if due {
                *last = Instant::now();
            }
            due
        };
        if stop || due {
            self.save(content)?;
        }
        if stop {
            Err(RunError::Interrupted)
        } else {
            Ok(())
        }
    }

    /// As [`Self::pause`], for content that is costly to gather.
    pub(crate) fn pause_with(&self, gather: impl FnOnce() -> T) -> Result<(), RunError> {
        let due = self
            .last
            .lock()
            .map_or(true, |last| last.elapsed() >= self.interval);
        if due || self.stop.load(Ordering::Relaxed) {
            self.pause(&gather())
        } else {
            Ok(())
        }
    }
}

/// Where and how a case is run.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// Results folder; it exists.
    pub folder: &'a Path,
    /// Identifies the run in its checkpoints.
    pub fingerprint: &'a Fingerprint,
    /// Set to stop at the next leg.
    pub stop: &'a AtomicBool,
    /// Who is told.
    pub progress: &'a Progress,
}

/// Folder of the checkpoints within a results folder.
pub const CHECKPOINTS: &str = "checkpoints";
/// Folder of the snapshots within a results folder.
pub const SNAPSHOTS: &str = "snapshots";

/// Runs all replicas of a case on the current thread pool; continues from checkpoints where there are some.
///
/// # Errors
/// [`RunError`]; checkpoints stay.
pub fn run(setup: &Setup, place: Place<'_>) -> Result<Vec<Replica>, RunError> {
    for name in [CHECKPOINTS, SNAPSHOTS] {
        let path = place.folder.join(name);
        fs::create_dir_all(&path).map_err(|source| RunError::Folder { path, source })?;
    }
    with_scene(setup, AllReplicas { setup, place })
}

struct AllReplicas<'a> {
    setup: &'a Setup,
    place: Place<'a>,
}

impl Visit for AllReplicas<'_> {
    type Output = Result<Vec<Replica>, RunError>;

    fn visit<P: Planar>(self, scene: P) -> Self::Output {
        let setup = self.setup;
        let replicas = setup.case.replicas;
        let parts = 1 + setup.case.engines.len();
        let jobs = self.place.progress.jobs(replicas * parts);
        (0..replicas)
            .into_par_iter()
            .map(|replica| {
                let jobs = &jobs[replica * parts..(replica + 1) * parts];
                self.replica(&scene, replica, jobs)
            })
            .collect()
    }
}

impl AllReplicas<'_> {
    fn control<T>(&self, replica: usize, part: &str, progress: &JobProgress) -> Control<'_, T> {
        let seconds = self.setup.case.run.checkpoint_seconds;
        Control::new(self.place, replica, part, seconds, progress)
    }

    fn replica<P: Planar>(
        &self,
        scene: &P,
        replica: usize,
        jobs: &[JobProgress],
    ) -> Result<Replica, RunError> {
        let streams = Streams::new(self.setup.case.seed, replica as u64);
        let failed = |part: &str| {
            let part = part.to_owned();
            move |source| RunError::Replica {
                replica,
                part,
                source: Box::new(source),
            }
        };
        let control = self.control::<Preparation<P>>(replica, "start", &jobs[0]);
        let start =
            prepare::prepare(self.setup, scene, streams, &control).map_err(failed("start"))?;
        let engines = self
            .setup
            .case
            .engines
            .par_iter()
            .zip(&jobs[1..])
            .map(|(engine, progress)| {
                let control = self.control(replica, engine.name(), progress);
                let snapshots = (replica == 0).then(|| self.place.folder.join(SNAPSHOTS));
                job::run_engine(
                    self.setup,
                    scene,
                    engine,
                    start.state(),
                    streams,
                    &control,
                    snapshots.as_deref(),
                )
                .map_err(failed(engine.name()))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let start = start.report.expect("a prepared start has a report");
        Ok(Replica { start, engines })
    }
}
