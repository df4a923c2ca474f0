//! The commands `run`, alone and shared by several processes (`--join`, `--part`), and `merge`,
//! with what they print.

use std::path::Path;
use std::time::Duration;

use serde_json::json;

use crate::arguments::{JoinArguments, MergeArguments, Printed, RunArguments, TableArguments};
use crate::case::CaseFile;
use crate::error::CommandError;
use crate::model::Interrupt;
use crate::progress::Display;
use crate::report::{corrected, write_held_report};
use crate::results::{Existing, REPORT_FILE, VerdictKind, VerdictText, headlines};
use crate::study::{
    PointSummary, Progress, RunError, RunOptions, RunPart, RunSummary, merge_parts, read_part,
    run_case, run_joined, run_part,
};
use crate::terminal::{TimeLimit, line, listen, note, say};

/// Message printed when a run was stopped.
pub const STOPPED_RUN: &str = "stopped; --resume goes on from the checkpoints";

/// Runs a case in this process: alone, with other processes (`--join`), or a share of its replicas
/// (`--part`).
///
/// # Errors
/// As [`run`].
pub(crate) fn run_on_threads(
    arguments: &RunArguments,
    file: &CaseFile,
    joining: &JoinArguments,
    part: Option<RunPart>,
) -> Result<(), CommandError> {
    if let Some(part) = part {
        return run_share(arguments, file, part);
    }
    if let Some(lost_after) = joining.lost_after() {
        return run_beside(arguments, file, lost_after);
    }
    let (stop, display) = (listen(STOPPED_RUN), display_of(&arguments.printed));
    run(arguments, file, &stop, &display, run_case)
}

/// Returns the progress display on standard error; a silent one with `--quiet`.
fn display_of(printed: &Printed) -> Display {
    if printed.quiet {
        Display::silent()
    } else {
        Display::new()
    }
}

/// Converts command-line arguments to the options of a run.
fn options_of<'a>(
    arguments: &RunArguments,
    stop: &'a Interrupt,
    progress: &'a dyn Progress,
) -> RunOptions<'a> {
    RunOptions {
        out: arguments.out.clone(),
        existing: match (arguments.resume, arguments.force) {
            (true, _) => Existing::Resume,
            (_, true) => Existing::Replace,
            _ => Existing::Refuse,
        },
        threads: arguments.threads.map(usize::from),
        ignore_memory_limit: arguments.ignore_memory_limit,
        stop,
        progress,
        commit: env!("STOSSZAHL_COMMIT"),
    }
}

/// Runs a case by the given function `runs`, writes its report, and prints the results.
///
/// # Errors
/// [`CommandError`] of the run or of its report.
pub fn run(
    arguments: &RunArguments,
    file: &CaseFile,
    stop: &Interrupt,
    progress: &dyn Progress,
    runs: impl FnOnce(&CaseFile, &RunOptions<'_>) -> Result<RunSummary, RunError>,
) -> Result<(), CommandError> {
    arguments.tables.check()?;
    let limit = TimeLimit::start(arguments.time_limit(), stop, STOPPED_RUN);
    let summary = runs(file, &options_of(arguments, stop, progress));
    let summary = summary.map_err(|error| ended_early(error, &limit, STOPPED_RUN))?;
    finish(&summary, &arguments.tables, &arguments.printed)
}

/// Converts the error of a run. If the run was only interrupted or reached its time limit, prints
/// the message `stopped`.
fn ended_early(error: RunError, limit: &TimeLimit, stopped: &str) -> CommandError {
    if !error.is_interruption() {
        return error.into();
    }
    note(stopped);
    if limit.is_reached() {
        CommandError::OutOfTime
    } else {
        error.into()
    }
}

/// Writes Parquet tables if requested and the report of a run, and prints its results.
fn finish(
    summary: &RunSummary,
    tables: &TableArguments,
    printed: &Printed,
) -> Result<(), CommandError> {
    let page = if summary.is_reporter {
        tables.write(summary)?;
        write_held_report(&summary.held)?
    } else {
        summary.folder.join(REPORT_FILE)
    };
    let page = page.display().to_string();
    if printed.json {
        return Ok(say(&as_json(&summary.points, &page))?);
    }
    let (verbose, is_brief) = (printed.verbose, summary.points.len() > 1);
    for point in summary.points.iter().filter(|_| !printed.quiet) {
        if !point.name.is_empty() {
            let blank = if verbose { "\n" } else { "" };
            say(&format!("{blank}{}", point.name))?;
        }
        if point.was_complete {
            say("complete already")?;
        }
        for line in lines(point, verbose, is_brief) {
            say(&line)?;
        }
    }
    if is_brief && !printed.quiet {
        say(&sweep_summary(&summary.points))?;
    }
    Ok(say(&page)?)
}

/// Summarises the verdicts of all points of a sweep in one sentence: the number of each kind, with
/// intervals corrected for all points.
fn sweep_summary(points: &[PointSummary]) -> String {
    let first = |point: &PointSummary| headlines(&point.verdicts).first().copied().cloned();
    let heads: Vec<Option<VerdictText>> = points.iter().map(first).collect();
    let void = |one: &VerdictText| one.kind == VerdictKind::Void;
    let sound = |one: &Option<VerdictText>| {
        let one = one.as_ref().filter(|one| !void(one))?;
        one.number.clone()
    };
    let found = corrected(&heads.iter().map(sound).collect::<Vec<_>>());
    let count = |kind| {
        let all = found.iter().flatten();
        all.filter(|one| one.kind == kind).count()
    };
    let kinds = [
        VerdictKind::Agree,
        VerdictKind::Differ,
        VerdictKind::Undecided,
    ];
    let mut parts: Vec<String> = (kinds.iter())
        .map(|&kind| format!("{} {}", count(kind), kind.name()))
        .collect();
    let voids = heads.iter().flatten().filter(|one| void(one)).count();
    if voids > 0 {
        parts.push(format!("{voids} void"));
    }
    format!(
        "{} points, corrected for all of them (Benjamini and Hochberg): {}",
        points.len(),
        parts.join(", ")
    )
}

/// Formats the lines printed for one point: all verdicts if `verbose`; otherwise leading
/// conclusions, warnings and the number of further lines. If `is_brief`, only the first conclusion
/// and warnings.
fn lines(point: &PointSummary, verbose: bool, is_brief: bool) -> Vec<String> {
    let first = headlines(&point.verdicts);
    let told = |one: &VerdictText| line(one.kind.name(), &one.sentence);
    let others = point.choices.iter().chain(&point.warnings);
    if verbose {
        let verdicts = point.verdicts.iter().map(told);
        return verdicts
            .chain(others.map(|text| line("note", text)))
            .collect();
    }
    let warnings = |one: &&VerdictText| one.kind == VerdictKind::Warning;
    let urgent = point.verdicts.iter().filter(warnings).map(told);
    let most = if is_brief { 1 } else { first.len() };
    let first = first.iter().take(most).map(|one| told(one));
    let mut lines: Vec<String> = first.chain(urgent).collect();
    if is_brief {
        return lines;
    }
    let more = point.verdicts.len() + others.count() - lines.len();
    if more > 0 {
        let what = match more {
            1 => "1 more line".to_owned(),
            more => format!("{more} more lines"),
        };
        lines.push(line(
            "",
            &format!("{what} with --verbose, and in the report"),
        ));
    }
    lines
}

/// Formats conclusions, choices and warnings of all points as JSON.
fn as_json(points: &[PointSummary], report: &str) -> String {
    let points = points.iter().map(|point| {
        json!({
            "name": point.name,
            // Lossy, because a path may not be text.
            "folder": point.folder.display().to_string(),
            "complete_already": point.was_complete,
            "seconds": point.seconds,
            "verdicts": point.verdicts,
            "choices": point.choices,
            "warnings": point.warnings,
        })
    });
    let points: Vec<_> = points.collect();
    format!("{:#}", json!({ "report": report, "points": points }))
}

/// Message printed when a run with `--join` was stopped.
const STOPPED_JOINED: &str = "stopped; the same command goes on from the checkpoints";

/// Runs a case together with other processes that share its results folder (`--join`).
fn run_beside(
    arguments: &RunArguments,
    file: &CaseFile,
    lost_after: Duration,
) -> Result<(), CommandError> {
    arguments.tables.check()?;
    let (stop, display) = (listen(STOPPED_JOINED), display_of(&arguments.printed));
    let limit = TimeLimit::start(arguments.time_limit(), &stop, STOPPED_JOINED);
    let options = options_of(arguments, &stop, &display);
    let summary = run_joined(file, &options, lost_after);
    let summary = summary.map_err(|error| ended_early(error, &limit, STOPPED_JOINED))?;
    finish(&summary, &arguments.tables, &arguments.printed)
}

/// Runs one part of the replicas of a case (`--part`).
fn run_share(arguments: &RunArguments, file: &CaseFile, part: RunPart) -> Result<(), CommandError> {
    arguments.tables.check()?;
    let (stop, display) = (listen(STOPPED_RUN), display_of(&arguments.printed));
    let limit = TimeLimit::start(arguments.time_limit(), &stop, STOPPED_RUN);
    let mut options = options_of(arguments, &stop, &display);
    options.out.get_or_insert_with(|| {
        let name = file.path.file_stem().unwrap_or_else(|| "case".as_ref());
        let mut name = name.to_owned();
        name.push(format!("-part-{}-of-{}", part.number, part.of));
        Path::new("results").join(name)
    });
    let done = run_part(file, &arguments.case.overrides(), part, &options);
    let done = done.map_err(|error| ended_early(error, &limit, STOPPED_RUN))?;
    let folder = done.folder.display();
    if !arguments.printed.quiet {
        say(&format!(
            "{part} is done: {} of {} replicas; `stosszahl merge{}` makes tables of all parts",
            done.replicas,
            done.all,
            arguments.tables.option()
        ))?;
    }
    Ok(say(&folder.to_string())?)
}

/// Merges the results folders of all parts of a run (`merge`).
pub(crate) fn merge(arguments: &MergeArguments) -> Result<(), CommandError> {
    let Some(first) = arguments.folders.first() else {
        return Ok(());
    };
    arguments.tables.check()?;
    let file = read_part(first)?;
    let (stop, display) = (listen("stopped"), display_of(&arguments.printed));
    let options = RunOptions {
        out: arguments.out.clone(),
        existing: if arguments.force {
            Existing::Replace
        } else {
            Existing::Refuse
        },
        threads: None,
        ignore_memory_limit: false,
        stop: &stop,
        progress: &display,
        commit: env!("STOSSZAHL_COMMIT"),
    };
    let summary = merge_parts(&file, &arguments.folders, &options);
    let summary = summary.inspect_err(|error| {
        if error.is_interruption() {
            note("stopped");
        }
    })?;
    finish(&summary, &arguments.tables, &arguments.printed)
}
