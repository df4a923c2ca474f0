//! Results of runs: tables with described columns, verdicts, the manifest, and the results folder.
//!
//! A [`Table`] is described once, where it is measured: each column has a name, a unit and a
//! meaning, each estimate its standard error and its theory, each figure its axes. CSV files,
//! manifest, report and the documentation of columns are derived from that description.
//!
//! A run opens its [`Folder`], which locks it, claims each file before it is written, and ends with
//! [`RunPlace::finish`]. Readers start from [`Stored::read`].

mod claims;
mod csv_file;
mod engines;
mod error;
mod find;
mod folder;
pub mod frames;
mod identity;
mod list;
mod manifest;
mod number_format;
#[cfg(feature = "parquet")]
mod parquet_file;
mod regular;
mod table;
mod verdict;

pub use claims::{CLAIMS, FolderWorker, TaskClaim, TaskStates};
pub use engines::{ENGINES, engine_rank, engine_title, quantity_title};
pub use error::ResultsError;
pub use find::{FinishedPoints, KeyCondition, NumberNotFound, RowKey, TableRow};
pub use folder::{CHECKPOINTS, Existing, Folder, RunPlace, SNAPSHOTS, copy_file, write_file};
pub use identity::{Keys, RunId};
pub use list::half_written;
pub use manifest::{
    Derived, EngineWork, FORMAT, FramesEntry, MANIFEST_FILE, Machine, Manifest, Program,
    REPORT_FILE, RunFingerprints, RunQuestion, SWEEP_FILE, SWEEP_TABLE, Snapshot, StartRecord,
    StartTest, Stored, Sweep, SweepPoint, TableEntry, TimeUnitSize, changed_files,
};
pub use number_format::{
    format_duration, format_number, format_percent, format_rough, format_significant,
    format_with_error, unsigned_zero, with_decimals,
};
pub use table::{
    AxisScale, CellValues, Figure, FigureAxis, PointMark, ReferenceLine, Role, Table, TableCell,
    TableColumn, TableEstimate,
};
pub use verdict::{ComparedNumber, VerdictKind, VerdictText, headlines};
