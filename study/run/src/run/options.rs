//! Options of a run in addition to its case: results folder, threads, memory limit.

use std::path::PathBuf;

use stosszahl_model::Interrupt;
use stosszahl_results::Existing;

use super::progress::Progress;
use crate::plan::available_memory;

/// Folder, threads and limits with which [`crate::run_case`] runs a case.
pub struct RunOptions<'a> {
    /// Results folder; `results/NAME` of the case file by default.
    pub out: Option<PathBuf>,
    /// Treatment of an existing results folder.
    pub existing: Existing,
    /// Number of threads; all cores by default.
    pub threads: Option<usize>,
    /// True to start even if the run needs more memory than is available.
    pub ignore_memory_limit: bool,
    /// Interrupt that stops the run within a second.
    pub stop: &'a Interrupt,
    /// Receiver of progress reports of the run.
    pub progress: &'a dyn Progress,
    /// Commit from which the program was built, for the manifest; empty if unknown.
    pub commit: &'a str,
}

impl RunOptions<'_> {
    /// Returns the available memory \[bytes\]; `None` if it is unknown or to be ignored.
    pub(crate) fn free_memory(&self) -> Option<f64> {
        available_memory().filter(|_| !self.ignore_memory_limit)
    }
}
