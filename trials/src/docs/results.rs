//! Runs of bundled cases and of papers for documentation blocks, and the format of their numbers.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use stosszahl_case::PaperFile;
use stosszahl_model::Interrupt;
use stosszahl_reproduce::{ReproduceOptions, Reproduction};
use stosszahl_results::{
    Existing, FinishedPoints, Manifest, RowKey, Stored, SweepPoint, TableEstimate,
};
use stosszahl_study::judge::with_error;
use stosszahl_study::{format, run_case};

use super::ROOT;
use crate::TrialError;
use crate::trial::run_options;

/// Conditions that a key column's cell holds a number (`At`) or a text (`Is`).
pub(super) use stosszahl_results::KeyCondition::{At, Is};

/// Row key that selects exact disks, the event-driven engine.
pub(super) const OF_EXACT: RowKey<'_> = ("engine", Is("ed"));

fn case_path(name: &str) -> std::path::PathBuf {
    Path::new(ROOT).join("cases").join(format!("{name}.toml"))
}

/// Runs a bundled case with settings `key=value` into the folder `out`. An existing run is
/// replaced, or resumed if `resume` is true. Also returns the commit of the results.
///
/// # Errors
/// The case is refused, or its run fails.
pub fn run_bundled(
    case: &str,
    set: &[String],
    out: &Path,
    resume: bool,
    commit: &str,
) -> Result<(FinishedPoints, String), TrialError> {
    let file = format().read(&case_path(case), set)?;
    let existing = match (out.join("run.json").exists(), resume) {
        (true, true) => Existing::Resume,
        (true, false) => Existing::Replace,
        _ => Existing::Refuse,
    };
    let stop = Interrupt::default();
    run_case(&file, &run_options(Some(out), existing, &stop, commit))?;
    let points = FinishedPoints::read_folder(out)?;
    if points.0.len() < file.points.len() || fs::exists(out.join("checkpoints"))? {
        let text = format!("{}: the run is not finished", out.display());
        return Err(TrialError::failed(text));
    }
    let last = points.0.last().map(|(_, stored)| &stored.manifest.program);
    let of = last.map_or(commit, |program| &program.commit).to_owned();
    Ok((points, of))
}

/// Reproduces all papers by quick runs, each in its own folder. Each paper counts as a point with
/// the table of its claims. Also returns the commit of the results.
///
/// # Errors
/// A paper is refused, or a run fails.
pub fn run_papers(
    out: &Path,
    resume: bool,
    commit: &str,
) -> Result<(FinishedPoints, String), TrialError> {
    let mut files = Vec::new();
    for entry in fs::read_dir(Path::new(ROOT).join("cases/papers"))? {
        files.push(entry?.path());
    }
    files.sort();
    let bundled = |name: &str| fs::read_to_string(case_path(name)).ok();
    let stop = Interrupt::default();
    let options = run_options(None, Existing::Refuse, &stop, commit);
    let (mut points, mut of) = (Vec::new(), commit.to_owned());
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let file = PaperFile::read(&path)?;
        let demand = ReproduceOptions {
            figure: None,
            quick: true,
        };
        let paper = Reproduction::new(&file, demand, &bundled)?;
        let own = out.join(&*name);
        paper.run_cases(&own, &options, !resume)?;
        let judged = paper.judge(&own)?;
        // Commit of the stored runs: an earlier one for runs that were complete before.
        for entry in fs::read_dir(&own)? {
            let run = entry?.path();
            if run.is_dir()
                && let Some((_, stored)) = Stored::points(&run)?.last()
            {
                of.clone_from(&stored.manifest.program.commit);
            }
        }
        let point = SweepPoint {
            name: name.into_owned(),
            values: BTreeMap::new(),
        };
        let stored = Stored {
            manifest: Manifest::default(),
            tables: vec![judged.table()],
            changed: Vec::new(),
        };
        points.push((point, stored));
    }
    Ok((FinishedPoints(points), of))
}

/// Formats an estimate with its standard error, rounded to two digits of the error.
pub(super) fn number_text(found: TableEstimate) -> String {
    let [value, error] = value_and_error(found);
    with_error(value, Some(error))
}

/// Returns the value and the standard error of an estimate; NaN for an unknown one.
pub(super) fn value_and_error(found: TableEstimate) -> [f64; 2] {
    [found.value, found.standard_error].map(|part| part.unwrap_or(f64::NAN))
}
