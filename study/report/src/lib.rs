//! Report of a results folder as one self-contained HTML page with SVG figures.
//!
//! [`write_report`] needs only the folder, so a report can be rebuilt at any time on any machine,
//! and equal folders give equal bytes. No table is known by name: its figures say how it is drawn.
//! The page loads nothing from outside: style, charts, particles, scripts and their library are
//! inside.
//!
//! Figures are static SVG, which is printed and shown without scripts, and also stored as files. A
//! script replaces each by an interactive chart: uPlot (`vendor/uplot`) draws axes and lines and
//! zooms. It was chosen for its size, 53 kB; others of its kind have 300 to 1100.
//!
//! | module   | owns                                                        |
//! |----------|-------------------------------------------------------------|
//! | `scale`  | axes: ranges and ticks                                      |
//! | `chart`  | curves, histograms, and the ranges of their axes            |
//! | `draw`   | charts as SVG                                               |
//! | `sheet`  | a figure as an SVG file of its own                          |
//! | `map`    | quantities over the plane                                   |
//! | `print`  | figures for papers, as SVG and PDF                          |
//! | `figure` | from a table and its figure to charts, colours and legends  |
//! | `viewer` | the particles of the snapshots                              |
//! | `page`   | parts of pages                                              |
//! | `run`    | the page of a run                                           |
//! | `sweep`  | the page of a sweep                                         |
//! | `discoveries` | intervals that are corrected for all points of a sweep  |
//! | `archive`| the folder as a ZIP archive in its page                     |
//! | `summary`| one row for each point of a sweep                           |
//! | `listing`| a page of sentences, figures and lists                      |
//! | `paper`  | the page of a paper                                         |

mod archive;
mod chart;
mod discoveries;
mod draw;
mod figure;
mod listing;
mod map;
mod page;
mod paper;
mod print;
mod run;
mod scale;
mod sheet;
mod summary;
mod sweep;
mod viewer;
mod words;

use std::path::{Path, PathBuf};

use stosszahl_model::initial::FileError;
use stosszahl_results::{
    Figure, Folder, REPORT_FILE, ResultsError, Stored, Sweep, Table, write_file,
};

pub use discoveries::{Corrected, corrected};
pub use listing::{Listed, Listing, listing};
pub use paper::{PaperClaim, PaperFigure, PaperPage, PaperRun, figure_anchor, figure_name, paper};
pub use print::{
    COLUMN_WIDTHS, PRINT_WIDTHS, PrintDrawing, PrintFigure, print_figure, print_figures,
};

/// Error with which a report cannot be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The results folder holds neither a run nor a sweep.
    #[error("{}: neither manifest.json nor sweep.json is in this folder; expected the folder of a finished run", folder.display())]
    NoResults {
        /// Path of the results folder.
        folder: PathBuf,
    },
    /// No table of the results folder has a figure that can be drawn.
    #[error("{}: no table of this folder has a figure that could be drawn", folder.display())]
    NoFigures {
        /// Path of the results folder.
        folder: PathBuf,
    },
    /// The results folder has no figure of the requested name.
    #[error("{}: no figure is called {name}{}; its figures are {}", folder.display(),
        close.as_ref().map_or_else(String::new, |close| format!(" (did you mean {close}?)")), names.join(", "))]
    NoFigure {
        /// Path of the results folder.
        folder: PathBuf,
        /// Name of the figure as given.
        name: String,
        /// Name of the most similar figure; `None` if none is similar.
        close: Option<String>,
        /// Names of all figures of the folder.
        names: Vec<String>,
    },
    /// The requested width of a figure for print is out of range.
    #[error("a width of {found} mm; allowed is {} to {} mm", PRINT_WIDTHS[0], PRINT_WIDTHS[1])]
    PrintWidth {
        /// Requested width \[mm\].
        found: f64,
    },
    /// A file of the results folder is absent or damaged, or the page cannot be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A snapshot file of the results folder is damaged.
    #[error(transparent)]
    Snapshot(#[from] FileError),
}

/// Draws a figure of a table as a standalone SVG file; `None` if there is nothing to draw.
pub fn drawing(table: &Table, figure: &Figure) -> Option<String> {
    Some(sheet::sheet(&figure.title, &figure::draw(table, figure)?))
}

/// Draws figures of several tables as one SVG file with a common legend, each in panels with a
/// heading; `None` if one of them has nothing to draw.
pub fn drawings(title: &str, figures: &[(&str, &Table, &Figure)]) -> Option<String> {
    let drawn = figures.iter().map(|(words, table, figure)| {
        let mut drawn = figure::draw(table, figure)?;
        for panel in &mut drawn.panels {
            let gap = if panel.title.is_empty() { "" } else { " " };
            panel.title.insert_str(0, &format!("{words}{gap}"));
        }
        Some(drawn)
    });
    let all = drawn.collect::<Option<Vec<_>>>()?;
    Some(sheet::sheet(title, &figure::Drawn::join(all)))
}

/// Report page in HTML with the files that belong to it.
struct Report {
    page: String,
    /// Further files of the report, such as drawings: names inside the results folder, and
    /// contents.
    beside: Vec<(String, Vec<u8>)>,
}

impl Report {
    /// Writes all files of the report, the page last; `guard` is called with the path of
    /// each file before it is written.
    fn write(&self, folder: &Path, guard: Guard<'_>) -> Result<PathBuf, ReportError> {
        for (name, bytes) in &self.beside {
            let path = folder.join(name);
            guard(&path)?;
            write_file(&path, bytes)?;
        }
        let path = folder.join(REPORT_FILE);
        guard(&path)?;
        write_file(&path, self.page.as_bytes())?;
        Ok(path)
    }
}

/// Callback before a file is written, with its path; returns an error if files may no longer be
/// written into the results folder.
type Guard<'a> = &'a dyn Fn(&Path) -> Result<(), ResultsError>;

/// Writes the report of a results folder that this process has locked, as [`write_report`], and
/// registers its files with the folder. Nothing is written if the folder was moved or replaced
/// meanwhile.
///
/// # Errors
/// As [`write_report`], and [`ResultsError::Moved`].
pub fn write_held_report(folder: &Folder) -> Result<PathBuf, ReportError> {
    write_guarded(folder.path(), &|path| folder.claim_path(path))
}

/// Rebuilds `report.html` and the drawings of a results folder or of a sweep folder and returns the
/// path of the page. In a sweep folder the report of each finished point is rebuilt too.
///
/// # Errors
/// The folder holds no finished run and no sweep, a table or snapshot is damaged, or a file cannot
/// be written.
pub fn write_report(folder: &Path) -> Result<PathBuf, ReportError> {
    write_guarded(folder, &|_| Ok(()))
}

/// Returns the summary table of a sweep folder, of which the report writes `sweep.csv`; `None` for
/// the folder of a single point.
///
/// # Errors
/// A table of a point is damaged.
pub fn sweep_table(folder: &Path) -> Result<Option<Table>, ReportError> {
    let sweep = Sweep::read(folder)?;
    let table = sweep.map(|sweep| sweep::table(folder, &sweep));
    table.transpose()
}

fn write_guarded(folder: &Path, guard: Guard<'_>) -> Result<PathBuf, ReportError> {
    let report = if let Some(sweep) = Sweep::read(folder)? {
        sweep::build(folder, &sweep, guard)?
    } else if let Some(stored) = Stored::read(folder)? {
        run::build(folder, &stored)?
    } else {
        return Err(ReportError::NoResults {
            folder: folder.to_owned(),
        });
    };
    report.write(folder, guard)
}
