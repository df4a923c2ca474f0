//! From a case of any kind to its results folder: what is the same for all kinds.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use std::{fs, thread};

use rayon::prelude::*;
use stosszahl_model::snapshot::{Fingerprint, write_whole};

use super::{CommandError, note, say};
use crate::arguments::{CaseArguments, CheckArguments, RunArguments};
use crate::case::{CaseFile, Form, Point};
use crate::manifest::{self, Machine, Program, Sweep, SweepPoint, Verdict};
use crate::progress::{Progress, duration};
use crate::report;
use crate::results::{self, Existing};
use crate::run::Place;

/// A kind of case that can be checked and run.
pub(super) trait Job: Form + Sync {
    /// What follows from a case: all that a run needs.
    type Plan: Send + Sync;

    /// Files that are in the folder of every finished run.
    const FILES: &'static [&'static str];

    /// What the case shows, in one line.
    fn title(&self) -> &str;

    /// Derives the plan; `file` is the case file, for messages.
    fn plan(&self, file: &Path) -> Result<Self::Plan, CommandError>;

    /// Settles what the case leaves to the program, by a pilot; a run that is continued settles the same.
    fn settle(plan: Self::Plan) -> Result<Self::Plan, CommandError> {
        Ok(plan)
    }

    /// What the program has chosen by itself, in sentences.
    fn choices(_plan: &Self::Plan) -> Vec<String> {
        Vec::new()
    }

    /// What a plan means, in lines.
    fn outline(plan: &Self::Plan) -> String;

    /// How many threads one point can keep busy.
    fn jobs(plan: &Self::Plan) -> usize;

    /// What decides the numbers of a run.
    fn fingerprint(plan: &Self::Plan) -> Fingerprint;

    /// Files beside the case that the run reads.
    fn inputs(_plan: &Self::Plan) -> Vec<&Path> {
        Vec::new()
    }

    /// Runs one point of a case and writes its tables and its manifest.
    fn run(run: &PointRun<'_, Self>, place: Place<'_>) -> Result<Vec<Verdict>, CommandError>;
}

/// One point of a case that is to be run.
pub(super) struct PointRun<'a, C: Job> {
    /// The case file.
    pub file: &'a CaseFile<C>,
    /// What follows from the case at this point.
    pub plan: &'a C::Plan,
    /// When it began.
    pub began: Instant,
}

/// A case file, and the plan of each of its points.
struct Planned<C: Job> {
    file: CaseFile<C>,
    plans: Vec<C::Plan>,
}

impl<C: Job> Planned<C> {
    fn read(arguments: &CaseArguments) -> Result<Self, CommandError> {
        let mut overrides = Vec::new();
        if let Some(until) = arguments.until {
            overrides.extend(C::shortened(&arguments.case, until));
            overrides.push(format!("run.until={until:?}"));
        }
        overrides.extend(
            arguments
                .replicas
                .map(|replicas| format!("replicas={replicas}")),
        );
        overrides.extend(arguments.seed.map(|seed| format!("seed={seed}")));
        overrides.extend(arguments.set.iter().cloned());
        let file = CaseFile::<C>::read(&arguments.case, &overrides)?;
        let plans = file
            .points
            .iter()
            .map(|point| point.case.plan(&file.path))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self { file, plans })
    }

    fn points(&self) -> impl Iterator<Item = (&Point<C>, &C::Plan)> {
        self.file.points.iter().zip(&self.plans)
    }
}

/// The plans of all points of a case.
pub(super) fn plans<C: Job>(arguments: &CaseArguments) -> Result<Vec<C::Plan>, CommandError> {
    Ok(Planned::<C>::read(arguments)?.plans)
}

/// Validates a case and says what follows from it.
pub(super) fn check<C: Job>(arguments: &CheckArguments) -> Result<(), CommandError> {
    let planned = Planned::<C>::read(&arguments.case)?;
    for (point, plan) in planned.points() {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{}: {}",
            planned.file.path.display(),
            point.case.title()
        );
        if !point.name.is_empty() {
            let _ = writeln!(text, "point {}", point.name);
        }
        text.push_str(&C::outline(plan));
        say(text.trim_end());
    }
    Ok(())
}

/// Runs all points of a case into a results folder.
pub(super) fn run<C: Job>(arguments: &RunArguments) -> Result<(), CommandError> {
    if arguments.threads == Some(0) {
        return Err(CommandError::Threads { found: 0 });
    }
    let mut planned = Planned::<C>::read(&arguments.case)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads.unwrap_or(0))
        .build()?;
    planned.plans = (planned.plans.into_iter())
        .map(|plan| pool.install(|| C::settle(plan)))
        .collect::<Result<Vec<_>, _>>()?;
    let file = &planned.file;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        Path::new("results").join(file.path.file_stem().unwrap_or_else(|| "case".as_ref()))
    });
    let runs: Vec<(String, Fingerprint)> = planned
        .points()
        .map(|(point, plan)| (point.name.clone(), C::fingerprint(plan)))
        .collect();
    let existing = match (arguments.resume, arguments.force) {
        (true, _) => Existing::Resume,
        (_, true) => Existing::Replace,
        _ => Existing::Refuse,
    };
    let mut inputs = vec![file.path.as_path()];
    inputs.extend(planned.plans.iter().flat_map(C::inputs));
    results::open(&folder, existing, &inputs, &runs)?;
    let stop = stopped_by_signals();
    let sweep = file.points.len() > 1 || !file.points[0].settings.is_empty();
    if sweep {
        write_json(&folder.join(manifest::SWEEP_FILE), &sweep_index(file))?;
    }
    let jobs = planned.plans.iter().map(C::jobs).min().unwrap_or(1);
    // Points of few replicas run side by side, as many as have a thread for each replica.
    let side_by_side = (pool.current_num_threads() / jobs.max(1)).max(1);
    let points: Vec<_> = planned.points().zip(&runs).collect();
    for points in points.chunks(side_by_side) {
        pool.install(|| {
            points
                .par_iter()
                .try_for_each(|&((point, plan), (_, fingerprint))| {
                    let place = if sweep {
                        folder.join(&point.name)
                    } else {
                        folder.clone()
                    };
                    if arguments.resume && results::is_complete(&place, C::FILES) {
                        note(&format!("{} is complete", place.display()));
                        return Ok(results::remove_checkpoints(&place)?);
                    }
                    run_point(file, (point, plan), fingerprint, &place, &stop)
                })
        })?;
    }
    let path = report::write_report(&folder)?;
    say(&format!("report: {}", path.display()));
    Ok(())
}

/// Set when the user asks to stop; asked twice, the program ends at once.
fn stopped_by_signals() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    // Without a handler the run can still be killed and resumed.
    let _ = ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        note("stopping at the next checkpoint; once more to stop at once");
    });
    stop
}

fn run_point<C: Job>(
    file: &CaseFile<C>,
    (point, plan): (&Point<C>, &C::Plan),
    fingerprint: &Fingerprint,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<(), CommandError> {
    let began = Instant::now();
    let name = if point.name.is_empty() {
        point.case.title()
    } else {
        &point.name
    };
    fs::create_dir_all(folder).map_err(|source| CommandError::Folder {
        path: folder.to_owned(),
        source,
    })?;
    let verdicts = {
        let progress = Progress::start(name);
        let place = Place {
            folder,
            fingerprint,
            stop,
            progress: &progress,
        };
        C::run(&PointRun { file, plan, began }, place)?
    };
    report::write_report(folder)?;
    results::remove_checkpoints(folder)?;
    say(&format!(
        "{name} ({})",
        duration(began.elapsed().as_secs_f64())
    ));
    for choice in C::choices(plan) {
        say(&format!("  resolution: {choice}"));
    }
    for verdict in &verdicts {
        say(&format!("  {}: {}", verdict.topic, verdict.sentence));
    }
    Ok(())
}

fn sweep_index<C: Job>(file: &CaseFile<C>) -> Sweep {
    let points = file
        .points
        .iter()
        .map(|point| SweepPoint {
            name: point.name.clone(),
            folder: point.name.clone(),
            values: point
                .settings
                .iter()
                .map(|one| {
                    (
                        one.key.clone(),
                        serde_json::to_value(&one.value).unwrap_or_default(),
                    )
                })
                .collect(),
        })
        .collect();
    Sweep {
        title: file.points[0].case.title().to_owned(),
        case_text: file.source_text.clone(),
        kind: C::KIND,
        points,
    }
}

/// Writes JSON so that the file appears only when it is complete.
pub(super) fn write_json(path: &Path, content: &impl serde::Serialize) -> Result<(), CommandError> {
    let mut bytes = serde_json::to_vec_pretty(content).map_err(|error| CommandError::Folder {
        path: path.to_owned(),
        source: error.into(),
    })?;
    bytes.push(b'\n');
    Ok(write_whole(path, &bytes)?)
}

/// Name and version of this program.
pub(super) fn program() -> Program {
    Program {
        name: "stosszahl".into(),
        version: env!("CARGO_PKG_VERSION").into(),
    }
}

/// The machine that it runs on.
pub(super) fn machine() -> Machine {
    let processor = fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        })
        .unwrap_or_else(|| "unknown".into());
    Machine {
        cores: thread::available_parallelism().map_or(1, |n| n.get() as u64),
        processor,
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
    }
}
