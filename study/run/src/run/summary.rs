//! Summary of a run for its caller: results folder, points and verdicts.

use std::path::PathBuf;
use std::sync::Arc;

use stosszahl_results::{Folder, VerdictText};

/// Summary of a run: its results folder and its points.
#[derive(Clone, Debug)]
pub struct RunSummary {
    /// Path of the results folder.
    pub folder: PathBuf,
    /// True if the run is a sweep with several points.
    pub is_sweep: bool,
    /// Summaries of the points, in the order of the case.
    pub points: Vec<PointSummary>,
    /// Results folder, locked by this process until the value is dropped. The report must be
    /// written before.
    pub held: Arc<Folder>,
    /// True if this process, of all that share the folder, must write the report.
    pub is_reporter: bool,
}

/// Summary of one sweep point of a run.
#[derive(Clone, Debug)]
pub struct PointSummary {
    /// Name of the sweep point; empty without a sweep.
    pub name: String,
    /// Path of the folder of the point.
    pub folder: PathBuf,
    /// True if the point was complete before this call.
    pub was_complete: bool,
    /// Wall time spent on the point in this call \[s\].
    pub seconds: f64,
    /// Verdicts on the point, the most important first.
    pub verdicts: Vec<VerdictText>,
    /// Choices that the program made, with the reasons.
    pub choices: Vec<String>,
    /// Warnings about the point, in words.
    pub warnings: Vec<String>,
}
