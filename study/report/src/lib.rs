//! The report: one self-contained HTML page from a results folder.
//!
//! [`write_report`] needs nothing but the folder, so a report can be rebuilt at any time, on any machine, and the same
//! folder gives the same bytes. Nothing here knows a table by name: a table says by its figures how it is drawn. The page
//! loads nothing from anywhere: style, charts, particles, scripts and their library are inside. Figures are drawn as static SVG,
//! which is what is printed and what is seen without script; the same drawings are files beside the page. A script puts
//! an interactive chart in the place of each: uPlot (`vendor/uplot`) draws axes and lines and does the zooming. It was
//! chosen by weight, 53 kB where others of its kind have 300 to 1100.
//!
//! | module   | owns                                                        |
//! |----------|-------------------------------------------------------------|
//! | `scale`  | axes: ranges and ticks                                      |
//! | `chart`  | curves, histograms, and the ranges of their axes            |
//! | `draw`   | charts as SVG                                               |
//! | `sheet`  | a figure as an SVG file of its own                          |
//! | `map`    | quantities over the plane                                   |
//! | `figure` | from a table and its figure to charts, colours and legends  |
//! | `viewer` | the particles of the snapshots                              |
//! | `page`   | parts of pages                                              |
//! | `run`    | the page of a run                                           |
//! | `sweep`  | the page of a sweep                                         |
//! | `discoveries` | intervals that are corrected for all points of a sweep  |
//! | `summary`| one row for each point of a sweep                           |
//! | `listing`| a page of sentences, figures and lists                      |
//! | `paper`  | the page of a paper                                         |

mod chart;
mod discoveries;
mod draw;
mod figure;
mod listing;
mod map;
mod page;
mod paper;
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

/// Why a report could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The folder holds neither a run nor a sweep.
    #[error("{}: neither manifest.json nor sweep.json is in this folder; expected the folder of a finished run", folder.display())]
    NoResults {
        /// The folder.
        folder: PathBuf,
    },
    /// A file of the folder is absent or damaged, or the page cannot be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A snapshot is damaged.
    #[error(transparent)]
    Snapshot(#[from] FileError),
}

/// A figure of a table as one SVG file that stands alone; `None` if there is nothing to draw.
pub fn drawing(table: &Table, figure: &Figure) -> Option<String> {
    Some(sheet::sheet(&figure.title, &figure::draw(table, figure)?))
}

/// Figures of several tables as one SVG file below a common legend, each in panels with words above them; `None` if there is nothing to
/// draw in one of them.
pub fn drawings(title: &str, figures: &[(&str, &Table, &Figure)]) -> Option<String> {
    let drawn = figures.iter().map(|(words, table, figure)| {
        let mut drawn = figure::draw(table, figure)?;
        for (title, _) in &mut drawn.panels {
            let gap = if title.is_empty() { "" } else { " " };
            title.insert_str(0, &format!("{words}{gap}"));
        }
        Some(drawn)
    });
    let all = drawn.collect::<Option<Vec<_>>>()?;
    Some(sheet::sheet(title, &figure::Drawn::join(all)))
}

/// A page and the drawings and tables beside it.
struct Report {
    page: String,
    /// Names of files inside the folder, and what they hold.
    beside: Vec<(String, Vec<u8>)>,
}

impl Report {
    /// Writes all of it, the page last; `guard` is asked before each file.
    fn write(&self, folder: &Path, guard: Guard<'_>) -> Result<PathBuf, ReportError> {
        for (name, bytes) in &self.beside {
            guard()?;
            write_file(&folder.join(name), bytes)?;
        }
        guard()?;
        let path = folder.join(REPORT_FILE);
        write_file(&path, self.page.as_bytes())?;
        Ok(path)
    }
}

/// Says whether files may still be written into the folder.
type Guard<'a> = &'a dyn Fn() -> Result<(), ResultsError>;

/// Writes the report of a results folder that this process holds, as [`write_report`] does; nothing is written if the folder was moved
/// or replaced meanwhile.
///
/// # Errors
/// As [`write_report`], and [`ResultsError::Moved`].
pub fn write_held_report(folder: &Folder) -> Result<PathBuf, ReportError> {
    write_guarded(folder.path(), &|| folder.require_same())
}

/// Rebuilds `report.html` and the drawings of a results folder or of a sweep folder and returns the path of the page. In a
/// sweep folder the report of each finished point is rebuilt too.
///
/// # Errors
/// The folder holds no finished run and no sweep, a table or snapshot is damaged, or a file cannot be written.
pub fn write_report(folder: &Path) -> Result<PathBuf, ReportError> {
    write_guarded(folder, &|| Ok(()))
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
