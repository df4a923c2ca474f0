//! Summary of a run: folder, points and verdicts.

use std::path::PathBuf;
use std::sync::Arc;

use stosszahl_results::{Folder, VerdictText};

/// Results of a run.
#[derive(Clone, Debug)]
pub struct RunSummary {
    /// Path of the results folder.
    pub folder: PathBuf,
    /// True if the run is a sweep.
    pub is_sweep: bool,
    /// Points, in the order of the case.
    pub points: Vec<PointSummary>,
    /// Results folder, which no other process writes into until this is dropped; write the report
    /// before.
    pub held: Arc<Folder>,
    /// True if this process, of all that share the folder, must write the report.
    pub is_reporter: bool,
}

/// Results of one point of a run.
#[derive(Clone, Debug)]
pub struct PointSummary {
    /// Name of the point; empty without a sweep.
    pub name: String,
    /// Folder of the point.
    pub folder: PathBuf,
    /// True if the point was complete before.
    pub was_complete: bool,
    /// Wall time of the point in this call \[s\].
    pub seconds: f64,
    /// Verdicts, the most important first.
    pub verdicts: Vec<VerdictText>,
    /// Choices that the program made, with the reasons.
    pub choices: Vec<String>,
    /// Warnings about the point, in words.
    pub warnings: Vec<String>,
}
