//! Native part of the Python package: engines, and access to cases and results.
//!
//! It is thin: Python takes the numbers as bytes for its arrays, without copying them. Everything
//! that has a name and documentation for users is in the Python files of the package
//! (`python/stosszahl`), which call this module.

#![allow(
    clippy::needless_pass_by_value,
    reason = "what Python gives is made for the call"
)]

mod arrays;
mod case;
mod engine;
mod error;
mod gas;
mod wait;

use pyo3::prelude::*;

/// Python module `stosszahl._native`: all functions and classes that the package uses.
#[pymodule(gil_used = true)]
mod _native {
    #[pymodule_export]
    use crate::case::{
        bundled, case_text, check, engines, manifest, print_drawing, print_names, print_widths,
        report, run, schema, sweep, toml_of_json,
    };
    #[pymodule_export]
    use crate::engine::{PyEngine, PyImpactParameters};
    #[pymodule_export]
    use crate::gas::PyGas;
}
