//! The report: one self-contained HTML page from a results folder.
//!
//! [`write_report`] needs nothing but the folder, so a report can be rebuilt at any time, on any machine, and the same
//! folder gives the same bytes. Nothing here knows a table by name: a table says by its figures how it is drawn. The page
//! loads nothing from anywhere: style, charts, particles and the script of the viewer are inside.
//!
//! | module   | owns                                                        |
//! |----------|-------------------------------------------------------------|
//! | `scale`  | axes: ranges and ticks                                      |
//! | `chart`  | curves, error bars, histograms as inline SVG                |
//! | `map`    | quantities over the plane                                   |
//! | `figure` | from a table and its figure to charts, colours and legends  |
//! | `viewer` | the particles of the snapshots                              |
//! | `page`   | parts of pages                                              |
//! | `run`    | the page of a run                                           |
//! | `sweep`  | the page of a sweep                                         |
//! | `listing`| a page of sentences, figures and lists                      |

mod chart;
mod figure;
mod listing;
mod map;
pub mod page;
mod run;
mod scale;
mod sweep;
mod viewer;
pub mod words;

use std::path::{Path, PathBuf};

use stosszahl_model::initial::FileError;
use stosszahl_results::{REPORT_FILE, ResultsError, Stored, Sweep, write_file};

pub use chart::{Chart, ChartAxis, Curve, Marker, Point, Stroke, Word, swatch};
pub use figure::{engine_colour, engine_marker};
pub use listing::{Listing, listing};

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

/// Rebuilds `report.html` of a results folder or of a sweep folder and returns its path. In a sweep folder the report of
/// each finished point is rebuilt too.
///
/// # Errors
/// The folder holds no finished run and no sweep, a table or snapshot is damaged, or the page cannot be written.
pub fn write_report(folder: &Path) -> Result<PathBuf, ReportError> {
    let page = if let Some(sweep) = Sweep::read(folder)? {
        sweep::build(folder, &sweep)?
    } else if let Some(stored) = Stored::read(folder)? {
        run::build(folder, &stored)?
    } else {
        return Err(ReportError::NoResults {
            folder: folder.to_owned(),
        });
    };
    write_page(folder, &page)
}

fn write_page(folder: &Path, page: &str) -> Result<PathBuf, ReportError> {
    let path = folder.join(REPORT_FILE);
    write_file(&path, page.as_bytes())?;
    Ok(path)
}
