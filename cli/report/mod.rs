//! The report: one self-contained HTML page built from a results folder.
//!
//! [`write_report`] reads the tables and the manifest that a run left in its folder and writes `report.html` beside
//! them. It needs nothing but the folder, so a report can be rebuilt at any time, on any machine, and the same folder
//! gives the same bytes. A folder with `sweep.json` is a sweep: every finished point gets its own report, and the page
//! of the sweep overlays them.
//!
//! | module    | owns                                                          |
//! |-----------|---------------------------------------------------------------|
//! | `read`    | files to rows, with the place of every fault                  |
//! | `plot`    | the plotting library `kuva`, which nothing else names         |
//! | `figures` | which curves belong together, and their captions              |
//! | `viewer`  | the disks of the snapshots, packed for the page's own viewer  |
//! | `page`    | the page in `maud`                                            |
//! | `sweep`   | the page of a sweep                                           |
//!
//! A table that is absent leaves a note in its section; a table that is damaged is an error. The page loads nothing
//! from anywhere: style, plots, particles and the script of the viewer are inside, at most [`SIZE_LIMIT`] bytes.
//! Plots are static SVG and not a script library, which would weigh megabytes in every report and print badly.

pub(crate) mod figures;
mod optional;
pub(crate) mod page;
pub(crate) mod plot;
pub(crate) mod read;
mod sweep;
mod viewer;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::case::Kind;
use crate::flow;
use crate::homogeneous::report as homogeneous;
use crate::manifest::{FORMAT, MANIFEST_FILE, Manifest, SWEEP_FILE, Sweep};
use crate::tables::{
    ComparisonRow, DisplacementRow, DissipationRow, EnergyRow, ErrorBudgetRow, ImpactParameterRow,
    ImpactSummaryRow, PairCorrelationRow, PairImpactRow, PartialTemperatureRow, ReplicaRow, Row,
    SteadyRow, StructureFactorRow,
};

/// Name of the page inside the folder.
pub const REPORT_FILE: &str = "report.html";
/// Largest size of the page \[bytes\]; above it fewer snapshots are kept.
pub const SIZE_LIMIT: usize = 12_000_000;

/// Why a report could not be built.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The folder holds neither a run nor a sweep.
    #[error("{}: neither {MANIFEST_FILE} nor {SWEEP_FILE} is in this folder", folder.display())]
    NoResults {
        /// Folder that was asked for.
        folder: PathBuf,
    },
    /// A file could not be read.
    #[error("{}: cannot be read", file.display())]
    Read {
        /// File.
        file: PathBuf,
        /// Reason given by the system.
        source: io::Error,
    },
    /// The page could not be written.
    #[error("{}: cannot be written", file.display())]
    Write {
        /// File.
        file: PathBuf,
        /// Reason given by the system.
        source: io::Error,
    },
    /// The header line of a table is not the expected one.
    #[error("{}: found the columns {found:?}, expected {expected:?}", file.display())]
    Columns {
        /// Table.
        file: PathBuf,
        /// Columns in the file.
        found: Vec<String>,
        /// Columns that the table must have.
        expected: &'static [&'static str],
    },
    /// A row has too few or too many fields.
    #[error("{}, line {line}: found {found} fields, expected {expected}", file.display())]
    Length {
        /// Table.
        file: PathBuf,
        /// Line, from one.
        line: u64,
        /// Fields in the row.
        found: u64,
        /// Fields that a row must have.
        expected: u64,
    },
    /// A line is not UTF-8 text.
    #[error("{}, line {line}: found bytes that are not UTF-8 text", file.display())]
    Encoding {
        /// Table.
        file: PathBuf,
        /// Line, from one.
        line: u64,
    },
    /// A field cannot be understood.
    #[error("{}, line {line}, column {column}: found {found:?}, expected {expected}", file.display())]
    Cell {
        /// Table.
        file: PathBuf,
        /// Line, from one.
        line: u64,
        /// Name of the column.
        column: String,
        /// Text of the field.
        found: String,
        /// What the column holds.
        expected: String,
    },
    /// A JSON file cannot be understood.
    #[error("{}, line {line}, column {column}, key {key}", file.display())]
    Json {
        /// File.
        file: PathBuf,
        /// Path of the key inside the file.
        key: String,
        /// Line, from one.
        line: usize,
        /// Column, from one.
        column: usize,
        /// Reason: what was found and what was expected.
        source: serde_json::Error,
    },
    /// The manifest has another format than this program reads.
    #[error("{}: found format {found}, expected {expected}", file.display())]
    Format {
        /// File.
        file: PathBuf,
        /// Format in the file.
        found: u32,
        /// Format that this program reads.
        expected: u32,
    },
    /// A snapshot cannot be understood.
    #[error("{}, line {line}: found {found:?}, expected {expected}", file.display())]
    Snapshot {
        /// File.
        file: PathBuf,
        /// Line, from one.
        line: u64,
        /// Text of the line, cut to 80 characters.
        found: String,
        /// What the line must hold.
        expected: String,
    },
}

/// Everything that a results folder holds, except the particles of its snapshots.
#[derive(Debug)]
pub(crate) struct Results {
    /// Manifest.
    pub manifest: Manifest,
    /// Energy against time.
    pub energy: Option<Vec<EnergyRow>>,
    /// Comparison of the engines.
    pub comparison: Option<Vec<ComparisonRow>>,
    /// Distribution of the impact parameter.
    pub impact: Option<Vec<ImpactParameterRow>>,
    /// Its summary.
    pub summary: Option<Vec<ImpactSummaryRow>>,
    /// Structure factor.
    pub structure: Option<Vec<StructureFactorRow>>,
    /// Pair correlation function.
    pub pair: Option<Vec<PairCorrelationRow>>,
    /// Dissipation identity.
    pub dissipation: Option<Vec<DissipationRow>>,
    /// Quarters of a driven run; none in a gas that cools freely.
    pub steady: Option<Vec<SteadyRow>>,
    /// Mean squared displacement; none unless it was measured.
    pub displacements: Option<Vec<DisplacementRow>>,
    /// Sources of error; none in folders of earlier versions.
    pub budget: Option<Vec<ErrorBudgetRow>>,
    /// Temperatures of the species; none in a gas of one.
    pub partial: Option<Vec<PartialTemperatureRow>>,
    /// Impact parameters by kind of pair; none in a gas of one species.
    pub pair_impact: Option<Vec<PairImpactRow>>,
    /// Raw samples of the replicas.
    pub replicas: Option<Vec<ReplicaRow>>,
}

/// The fields that manifests of every format have.
#[derive(serde::Deserialize)]
struct Stamp {
    /// Version of the format.
    format: u32,
    /// Kind of the case.
    #[serde(default)]
    kind: Kind,
}

impl Stamp {
    /// Reads the stamp of the manifest in a folder.
    fn read(folder: &Path) -> Result<Self, ReportError> {
        let file = folder.join(MANIFEST_FILE);
        if !file.exists() {
            return Err(ReportError::NoResults {
                folder: folder.to_owned(),
            });
        }
        // A manifest of another format may lack the fields of this one, so its format is read first.
        let stamp: Self = read::json(&file)?;
        if stamp.format != FORMAT {
            return Err(ReportError::Format {
                file,
                found: stamp.format,
                expected: FORMAT,
            });
        }
        Ok(stamp)
    }
}

impl Results {
    /// Reads a results folder.
    fn read(folder: &Path) -> Result<Self, ReportError> {
        Stamp::read(folder)?;
        let manifest = read::json(&folder.join(MANIFEST_FILE))?;
        Ok(Self {
            manifest,
            energy: read::table(folder)?,
            comparison: read::table(folder)?,
            impact: read::table(folder)?,
            summary: read::table(folder)?,
            structure: read::table(folder)?,
            pair: read::table(folder)?,
            dissipation: read::table(folder)?,
            steady: read::table(folder)?,
            displacements: read::table(folder)?,
            budget: read::table(folder)?,
            partial: read::table(folder)?,
            pair_impact: read::table(folder)?,
            replicas: read::table(folder)?,
        })
    }
}

/// Rebuilds `report.html` of a results folder or of a sweep folder and returns its path.
///
/// The page is written to a temporary file first and then renamed, so a reader never meets half a page. In a sweep
/// folder, the report of every finished point is rebuilt too.
///
/// # Errors
/// The folder holds no manifest and no sweep index, a table or snapshot is damaged, or the page cannot be written.
pub fn write_report(folder: &Path) -> Result<PathBuf, ReportError> {
    let sweep = folder.join(SWEEP_FILE);
    let page = if sweep.exists() {
        let sweep: Sweep = read::json(&sweep)?;
        match sweep.kind {
            Kind::Paired => sweep::build(folder)?,
            Kind::Flow => flow::report::build_sweep(folder)?,
            Kind::Homogeneous => homogeneous::build_sweep(folder)?,
        }
    } else {
        match Stamp::read(folder)?.kind {
            Kind::Paired => page::build(folder, &Results::read(folder)?)?,
            Kind::Flow => flow::report::build(folder)?,
            Kind::Homogeneous => homogeneous::build(folder)?,
        }
    };
    write_whole(&folder.join(REPORT_FILE), &page)
}

/// Writes `text` to a temporary file beside `file` and renames it.
pub(crate) fn write_whole(file: &Path, text: &str) -> Result<PathBuf, ReportError> {
    let fault = |source| ReportError::Write {
        file: file.to_owned(),
        source,
    };
    let temporary = file.with_extension(format!("html.{}.part", std::process::id()));
    fs::write(&temporary, text)
        .and_then(|()| fs::rename(&temporary, file))
        .map_err(|source| {
            let _ = fs::remove_file(&temporary);
            fault(source)
        })?;
    Ok(file.to_owned())
}

/// What would make a missing table, in words.
fn origin<R: Row>() -> &'static str {
    match R::FILE {
        "comparison.csv" => "a run of two or more engines",
        "impact_parameter.csv" | "impact_parameter_summary.csv" => {
            "a run that measures the impact parameter in at least one time window"
        }
        "structure_factor.csv" => "a run that measures the structure factor",
        "pair_correlation.csv" => "a run that measures the pair correlation function",
        "dissipation.csv" => {
            "a run that measures the dissipation identity in at least one time window"
        }
        _ => "any finished run",
    }
}
