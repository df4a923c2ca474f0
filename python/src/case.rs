//! Python functions for cases (read, check, run) and for results folders.

use std::borrow::Cow;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use include_dir::{Dir, include_dir};
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyUserWarning};
use pyo3::prelude::*;
use serde_json::{Value, json};
use stosszahl_case::{CaseBundle, CaseFile};
use stosszahl_report::{
    COLUMN_WIDTHS, PRINT_WIDTHS, ReportError, print_figure, print_figures, write_held_report,
    write_report,
};
use stosszahl_results::{Existing, Stored, Sweep};
use stosszahl_study::plan::available_threads;
use stosszahl_study::{Progress, ProgressEstimate, RunOptions, format, run_case};

use crate::error::{Raise, raised};
use crate::wait::{Messages, PyInterrupt, wait};

/// Cases and papers that come with the Python package.
static BUNDLE: CaseBundle = CaseBundle({
    static FOLDER: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../cases");
    &FOLDER
});

/// Case passed from Python: path for messages, text unless it is that of the file or bundled case
/// at the path, and overrides `key=value`.
#[derive(FromPyObject)]
pub struct Given {
    path: PathBuf,
    text: Option<String>,
    overrides: Vec<String>,
}

impl Given {
    fn read(&self, py: Python<'_>) -> PyResult<CaseFile> {
        let format = format();
        let read = match &self.text {
            Some(text) => format.from_text(&self.path, text, &self.overrides),
            None => BUNDLE.read_case(&format, &self.path, &self.overrides),
        };
        let file = read.map_err(Raise::into_exception)?;
        for text in &file.notes {
            let text = CString::new(text.as_str())?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 3)?;
        }
        Ok(file)
    }
}

/// Returns the names of the bundled cases, each with its question.
#[pyfunction]
pub fn bundled() -> Vec<(&'static str, String)> {
    let cases = BUNDLE.cases().into_iter();
    cases.map(|one| (one.name, one.question())).collect()
}

/// Returns the text of a case file; if there is no file, of the bundled case of that name.
#[pyfunction]
pub fn case_text(path: PathBuf) -> PyResult<String> {
    BUNDLE.text(&path).map_err(Raise::into_exception)
}

/// Returns the JSON Schema of case files.
#[pyfunction]
pub fn schema() -> String {
    format().json().to_string()
}

/// Converts a JSON object to TOML.
#[pyfunction]
pub fn toml_of_json(text: &str) -> PyResult<String> {
    let bad = |error: String| raised("CaseError", &format!("no case: {error}"));
    let table: toml::Table = serde_json::from_str(text).map_err(|error| bad(error.to_string()))?;
    toml::to_string(&table).map_err(|error| bad(error.to_string()))
}

/// Returns the derived quantities, cost and warnings of each point of a case, as JSON.
#[pyfunction]
pub fn check(py: Python<'_>, case: Given, threads: Option<usize>) -> PyResult<String> {
    let file = case.read(py)?;
    let threads = threads.unwrap_or_else(available_threads);
    let planned = stosszahl_study::check_case(&file).map_err(Raise::into_exception)?;
    let outlines = planned.iter().map(|one| {
        let outline = one.outline(threads);
        let derived = outline
            .derived
            .iter()
            .map(|one| json!({ "name": one.name, "value": one.value, "unit": one.unit }));
        let costs = outline.cost.engines.iter().zip(&outline.cost.pace.engines);
        let engines = costs.map(|(one, seconds)| {
            json!({
                "engine": one.name, "bytes": one.bytes, "collisions": one.collisions,
                "trials_per_collision": one.trials_per_collision, "seconds": seconds[0],
            })
        });
        json!({
            "title": outline.title, "point": outline.point, "derived": derived.collect::<Vec<_>>(),
            "engines": outline.engines, "measures": outline.measures, "replicas": outline.replicas,
            "bytes": outline.cost.bytes, "seconds": outline.cost.seconds(threads),
            "costs": engines.collect::<Vec<_>>(), "warnings": outline.warnings,
        })
    });
    Ok(Value::Array(outlines.collect()).to_string())
}

/// Progress of a run, shared between its threads.
#[derive(Default)]
struct Seen(Mutex<Far>);

/// Progress of a run: work done of each point that has begun, collisions, and notes.
#[derive(Default)]
struct Far {
    points: Vec<Option<ProgressEstimate>>,
    collisions: u64,
    notes: Vec<String>,
}

impl Seen {
    fn lock(&self) -> MutexGuard<'_, Far> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Seen {
    fn begin_point(&self, point: usize, _name: &str, work: ProgressEstimate) {
        let points = &mut self.lock().points;
        if points.len() <= point {
            points.resize_with(point + 1, || None);
        }
        points[point] = Some(work);
    }

    fn tell_share(&self, point: usize, part: usize, share: f64, collisions: u64) {
        let mut far = self.lock();
        far.collisions += collisions;
        if let Some(Some(work)) = far.points.get_mut(point) {
            work.record_share(part, share, Instant::now());
        }
    }

    fn end_point(&self, point: usize) {
        if let Some(Some(work)) = self.lock().points.get_mut(point) {
            work.end();
        }
    }

    fn show_note(&self, text: &str) {
        self.lock().notes.push(text.to_owned());
    }
}

/// Runs a case and writes its report. Progress is called with the share that is done, from 0 to 1,
/// the collisions so far, and new notes. Returns the folder, whether it is a sweep, and notes.
#[pyfunction]
#[pyo3(signature = (case, *, out, existing, threads, ignore_memory_limit, progress))]
pub fn run(
    py: Python<'_>,
    case: Given,
    out: Option<PathBuf>,
    existing: &str,
    threads: Option<usize>,
    ignore_memory_limit: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(PathBuf, bool)> {
    let file = case.read(py)?;
    let (stop, seen) = (PyInterrupt::default(), Seen::default());
    let existing = match existing {
        "resume" => Existing::Resume,
        "force" => Existing::Replace,
        _ => Existing::Refuse,
    };
    let number = file.points.len();
    let tell = |py: Python<'_>| {
        let Some(progress) = &progress else {
            return Ok(());
        };
        let mut far = seen.lock();
        let done = far
            .points
            .iter_mut()
            .flatten()
            .map(ProgressEstimate::done_share);
        let share = done.sum::<f64>() / number as f64;
        let (collisions, notes) = (far.collisions, std::mem::take(&mut far.notes));
        drop(far);
        progress.call1(py, (share, collisions, notes)).map(drop)
    };
    let work = |_: Messages<()>| {
        let options = RunOptions {
            out,
            existing,
            threads,
            ignore_memory_limit,
            stop: &stop.soon,
            progress: &seen,
            commit: env!("STOSSZAHL_COMMIT"),
        };
        run_case(&file, &options)
    };
    let summary = wait(py, &stop, work, |_, ()| Ok(()), tell)?;
    let summary = summary.map_err(|error| {
        if error.is_interruption() {
            PyKeyboardInterrupt::new_err("stopped")
        } else {
            error.into_exception()
        }
    })?;
    tell(py)?;
    write_held_report(&summary.held).map_err(Raise::into_exception)?;
    Ok((summary.folder, summary.is_sweep))
}

/// Rebuilds the report of a results folder, and returns the path of the page.
#[pyfunction]
pub fn report(folder: PathBuf) -> PyResult<PathBuf> {
    write_report(&folder).map_err(Raise::into_exception)
}

/// Returns names and titles of the figures of a results folder that can be drawn for a paper.
#[pyfunction]
pub fn print_names(folder: PathBuf) -> PyResult<Vec<(String, String)>> {
    let figures = print_figures(&folder).map_err(Raise::into_exception)?;
    let named = figures.iter();
    let named = named.map(|one| (one.name().to_owned(), one.title().to_owned()));
    Ok(named.collect())
}

/// Returns the widths of one and two columns of a journal, and the smallest and largest width of a
/// figure for a paper \[mm\].
#[pyfunction]
pub fn print_widths() -> ([f64; 2], [f64; 2]) {
    (COLUMN_WIDTHS, PRINT_WIDTHS)
}

/// Figure for print: title, width and height \[mm\], SVG, PDF, and letters that the fonts lack.
type Drawing = (String, [f64; 2], String, Cow<'static, [u8]>, String);

/// Draws a figure of a results folder for a paper, with a width \[mm\].
#[pyfunction]
pub fn print_drawing(folder: PathBuf, name: &str, width: f64) -> PyResult<Drawing> {
    let figure = print_figure(&folder, name).map_err(Raise::into_exception)?;
    let drawing = figure.draw(width).map_err(Raise::into_exception)?;
    Ok((
        figure.title().to_owned(),
        drawing.size(),
        drawing.to_svg(),
        Cow::Owned(drawing.to_pdf()),
        drawing.missing_letters(),
    ))
}

/// Creates the exception for a value that is no JSON, which is an error of the package.
fn no_json(error: serde_json::Error) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

/// Returns the manifest of a finished run as JSON, and the files that were changed since.
#[pyfunction]
pub fn manifest(folder: PathBuf) -> PyResult<(String, Vec<String>)> {
    let read = Stored::read(&folder).map_err(Raise::into_exception)?;
    let Stored {
        manifest, changed, ..
    } = read.ok_or_else(|| ReportError::NoResults { folder }.into_exception())?;
    let text = serde_json::to_string(&manifest).map_err(no_json)?;
    Ok((text, changed))
}

/// Returns the names of the engines with their titles, in the order of tables and legends.
#[pyfunction]
pub fn engines() -> Vec<(&'static str, &'static str)> {
    stosszahl_results::ENGINES.to_vec()
}

/// Returns the index of a sweep as JSON; `None` if the folder is not that of a sweep.
#[pyfunction]
pub fn sweep(folder: PathBuf) -> PyResult<Option<String>> {
    let read = Sweep::read(&folder).map_err(Raise::into_exception)?;
    let text = read.map(|index| serde_json::to_string(&index));
    text.transpose().map_err(no_json)
}
