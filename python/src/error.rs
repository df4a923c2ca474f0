//! Conversion of errors to Python exceptions of `stosszahl/errors.py`, with the messages of the
//! command line.

use std::error::Error;

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use stosszahl_case::CaseError;
use stosszahl_gas::GasError;
use stosszahl_report::ReportError;
use stosszahl_results::ResultsError;
use stosszahl_study::RunError;

/// Error that can be raised as a Python exception.
pub trait Raise {
    /// Converts the error to a Python exception.
    fn into_exception(self) -> PyErr;
}

/// Creates an exception of a class in `stosszahl/errors.py`; the first argument of each class is a
/// message.
fn exception<'py>(py: Python<'py>, class: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let class = py
        .import("stosszahl.errors")
        .and_then(|module| module.getattr(class));
    let made = class.and_then(|class| class.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Creates an exception of a class in `stosszahl/errors.py` with a message.
pub fn raised(class: &str, message: &str) -> PyErr {
    Python::attach(|py| exception(py, class, (message,)))
}

/// Formats an error and its causes, each once, as the command line does.
fn explained(error: &dyn Error) -> String {
    let mut said = error.to_string();
    let mut cause = error.source();
    while let Some(deeper) = cause {
        let text = deeper.to_string();
        if !said.contains(&text) {
            said.push_str("\n  because: ");
            said.push_str(&text);
        }
        cause = deeper.source();
    }
    said
}

impl Raise for GasError {
    fn into_exception(self) -> PyErr {
        let class = match self {
            Self::Memory { .. } => "OutOfMemoryError",
            _ => "GasError",
        };
        raised(class, &explained(&self))
    }
}

impl Raise for ResultsError {
    fn into_exception(self) -> PyErr {
        raised("ResultsError", &explained(&self))
    }
}

impl Raise for ReportError {
    fn into_exception(self) -> PyErr {
        raised("ResultsError", &explained(&self))
    }
}

impl Raise for CaseError {
    fn into_exception(self) -> PyErr {
        let report = self.report(false);
        let message = report.strip_prefix("error: ").unwrap_or(&report);
        let refusal = self.refusal();
        let key = refusal.map(|one| one.key.clone());
        let place = refusal.and_then(|one| one.place);
        Python::attach(|py| exception(py, "CaseError", (message, key, place)))
    }
}

impl Raise for RunError {
    fn into_exception(self) -> PyErr {
        match self {
            Self::Case(error) => error.into_exception(),
            Self::Results(error) => error.into_exception(),
            other => raised("RunError", &explained(&other)),
        }
    }
}
