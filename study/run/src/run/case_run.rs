//! Execution of a case: all points, replicas and engines into a results folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rayon::prelude::*;
use stosszahl_case::CaseFile;
use stosszahl_case::format::AccuracySpec;
use stosszahl_results::{FORMAT, Folder, Keys, ResultsError, RunId, Sweep, SweepPoint};

use super::error::{MOST_THREADS, RunError};
use super::options::RunOptions;
use super::point::Job;
use super::summary::{PointSummary, RunSummary};
use crate::check::{Planned, check_within, level};
use crate::frontier::choose_resolution;
use crate::plan::available_threads;

/// Case keys that do not affect the results folder, and keys that only change how results are
/// shown.
const KEYS: Keys<'static> = Keys {
    ignored: &["run.checkpoint_seconds"],
    output: &["title", "question", "verdict", "measure.fields.windows"],
};

/// Runs all points of a case into a results folder.
///
/// # Errors
/// [`RunError`]; checkpoints are kept.
pub fn run_case(file: &CaseFile, options: &RunOptions<'_>) -> Result<RunSummary, RunError> {
    let (planned, threads) = prepare(file, options)?;
    let side_by_side = side_by_side(&planned, threads);
    require_memory(needed_memory(&planned, threads), options)?;
    let opened = Opened::new(file, &planned, options)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let mut points = Vec::new();
    for chunk in opened.jobs(file, &planned, options).chunks(side_by_side) {
        let done: Result<Vec<PointSummary>, RunError> =
            pool.install(|| chunk.par_iter().map(|job| job.run_point(None)).collect());
        points.extend(done?);
    }
    Ok(opened.summary(points))
}

/// Plans all points of a case, lets the program make its choices, and determines the number of
/// threads.
///
/// # Errors
/// As [`run_case`].
pub(crate) fn prepare<'a>(
    file: &'a CaseFile,
    options: &RunOptions<'_>,
) -> Result<(Vec<Planned<'a>>, usize), RunError> {
    let threads = options.threads.unwrap_or_else(available_threads);
    if !(1..=MOST_THREADS).contains(&threads) {
        return Err(RunError::Threads { found: threads });
    }
    let planned = check_within(file, options.free_memory())?;
    let planned = choose_resolutions(file, planned, options, threads)?;
    Ok((planned, threads))
}

/// Chooses simulators and time step for each point whose case sets `[accuracy] target`, by pilot
/// runs.
///
/// # Errors
/// [`RunError`] if the pilot fails or is stopped.
pub fn choose_resolutions<'a>(
    file: &CaseFile,
    planned: Vec<Planned<'a>>,
    options: &RunOptions<'_>,
    threads: usize,
) -> Result<Vec<Planned<'a>>, RunError> {
    if planned.iter().all(|one| one.plan.case.accuracy.is_none()) {
        return Ok(planned);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let one = |one: Planned<'a>| {
        let target = one.plan.case.accuracy.as_ref();
        let Some(target) = target.and_then(AccuracySpec::parse_share) else {
            return Ok(one);
        };
        options
            .progress
            .show_note("a pilot chooses simulators and time steps for accuracy.target");
        let found = pool.install(|| choose_resolution(&one.plan, target, options.stop));
        let (case, choices) = found.map_err(RunError::Pilot)?;
        let mut settled = Planned::plan_point(file, one.point, &case, options.free_memory())?;
        settled.plan.notes.choices.extend(choices);
        Ok(settled)
    };
    planned.into_iter().map(one).collect()
}

/// Returns the number of points that run concurrently: points of few replicas, until each thread
/// has an engine.
fn side_by_side(planned: &[Planned<'_>], threads: usize) -> usize {
    let parts = |one: &Planned<'_>| one.plan.engines.len() * one.plan.case.replicas as usize;
    let fewest = planned.iter().map(parts).min().unwrap_or(1);
    (threads / fewest.max(1)).max(1)
}

/// Estimates the memory of a run of these points on `threads` threads \[bytes\].
pub fn needed_memory(planned: &[Planned<'_>], threads: usize) -> f64 {
    let chunks = planned.chunks(side_by_side(planned, threads));
    let needed = chunks.map(|chunk| {
        let each = threads.div_ceil(chunk.len());
        chunk.iter().map(|one| one.cost(each).bytes).sum::<f64>()
    });
    needed.fold(0.0, f64::max)
}

/// Checks that each point fits into the available memory, for points that run one after the other.
///
/// # Errors
/// [`RunError::Memory`].
pub(crate) fn require_memory_of_each(
    planned: &[Planned<'_>],
    threads: usize,
    processes: usize,
    options: &RunOptions<'_>,
) -> Result<(), RunError> {
    let bytes = (planned.iter()).map(|one| one.cost(threads).bytes_each(processes));
    require_memory(bytes.fold(0.0, f64::max), options)
}

/// Checks that a run fits into the available memory, unless the limit is ignored.
///
/// # Errors
/// [`RunError::Memory`].
fn require_memory(needed: f64, options: &RunOptions<'_>) -> Result<(), RunError> {
    match options.free_memory() {
        Some(available) if needed > available => Err(RunError::Memory { needed, available }),
        _ => Ok(()),
    }
}

/// Results folder of a run in progress, and whether the run is a sweep.
pub(crate) struct Opened {
    folder: Arc<Folder>,
    is_sweep: bool,
}

impl Opened {
    /// Creates the results folder of a run, or opens an existing one to resume.
    ///
    /// # Errors
    /// [`RunError::Results`].
    pub(crate) fn new(
        file: &CaseFile,
        planned: &[Planned<'_>],
        options: &RunOptions<'_>,
    ) -> Result<Self, RunError> {
        Self::with(file, planned, options, |path, inputs, ids| {
            Folder::open(path, options.existing, inputs, ids)
        })
    }

    /// Creates the results folder of a run, or joins the processes that work in an existing one.
    ///
    /// # Errors
    /// [`RunError::Results`].
    pub(crate) fn join(
        file: &CaseFile,
        planned: &[Planned<'_>],
        options: &RunOptions<'_>,
        lost_after: Duration,
    ) -> Result<Self, RunError> {
        Self::with(file, planned, options, |path, inputs, ids| {
            Folder::join(path, inputs, ids, lost_after)
        })
    }

    fn with(
        file: &CaseFile,
        planned: &[Planned<'_>],
        options: &RunOptions<'_>,
        open: impl FnOnce(&Path, &[&Path], Vec<RunId>) -> Result<Folder, ResultsError>,
    ) -> Result<Self, RunError> {
        let path = options.out.clone().unwrap_or_else(|| {
            Path::new("results").join(file.path.file_stem().unwrap_or_else(|| "case".as_ref()))
        });
        let starts: Vec<PathBuf> = planned
            .iter()
            .filter_map(|one| one.plan.start_path())
            .collect();
        let inputs = std::iter::once(&file.path).chain(&starts);
        let inputs: Vec<&Path> = inputs.map(PathBuf::as_path).collect();
        let folder = open(&path, &inputs, run_ids(planned)?)?;
        if let Some(warning) = folder.warning() {
            options.progress.show_note(warning);
        }
        let is_sweep = file.points.len() > 1 || !file.points[0].settings.is_empty();
        if is_sweep {
            folder.write_sweep(&index(file))?;
        }
        Ok(Self {
            folder: Arc::new(folder),
            is_sweep,
        })
    }

    /// Returns the results folder.
    pub(crate) fn folder(&self) -> &Folder {
        &self.folder
    }

    /// Returns the sweep points of the run, each with its location in the results folder.
    pub(crate) fn jobs<'a>(
        &'a self,
        file: &'a CaseFile,
        planned: &'a [Planned<'a>],
        options: &'a RunOptions<'a>,
    ) -> Vec<Job<'a>> {
        let both = planned.iter().zip(self.folder.places()).enumerate();
        let job = |(number, (planned, place))| Job {
            file,
            planned,
            place,
            number,
            level: level(planned),
            options,
        };
        both.map(job).collect()
    }

    /// Creates the summary of the run from those of its points.
    pub(crate) fn summary(&self, points: Vec<PointSummary>) -> RunSummary {
        RunSummary {
            folder: self.folder.path().to_owned(),
            is_sweep: self.is_sweep,
            points,
            held: self.folder.clone(),
            is_reporter: true,
        }
    }
}

/// Computes the identities of the runs of all points, from cases and input files.
///
/// # Errors
/// [`RunError::Results`] if a start file cannot be read.
pub(crate) fn run_ids(planned: &[Planned<'_>]) -> Result<Vec<RunId>, RunError> {
    let one = |planned: &Planned<'_>| {
        let start = planned.plan.start_path();
        let inputs: Vec<&Path> = start.iter().map(PathBuf::as_path).collect();
        RunId::new(
            &planned.point.name,
            &planned.plan.case_json(),
            KEYS,
            &inputs,
        )
    };
    Ok(planned.iter().map(one).collect::<Result<_, _>>()?)
}

fn index(file: &CaseFile) -> Sweep {
    let points = file.points.iter().map(|point| SweepPoint {
        name: point.name.clone(),
        values: (point.settings.iter())
            .map(|one| {
                (
                    one.key.clone(),
                    serde_json::to_value(&one.value).expect("a TOML value has keys of text only"),
                )
            })
            .collect(),
    });
    Sweep {
        format: FORMAT,
        title: file.title(),
        case_text: file.text.clone(),
        points: points.collect(),
    }
}
