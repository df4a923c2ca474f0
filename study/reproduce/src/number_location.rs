//! Places of numbers in the results of a run.

use std::collections::BTreeMap;

use stosszahl_case::paper::Errors;
use toml::Value;

/// Name of the quantity of computing time of all engines and replicas \[s\].
pub(crate) const SECONDS: &str = "seconds";
/// Name of the quantity of collisions of all engines and replicas.
pub(crate) const COLLISIONS: &str = "collisions";

/// Place of a number in the results.
#[derive(Clone, Debug)]
pub(crate) struct NumberLocation<'a> {
    /// Name of the run.
    pub run: &'a str,
    /// Name of the point of its sweep; empty without one.
    pub point: String,
    /// Quantity that follows from the case, or a table and its column.
    pub source: NumberSource<'a>,
    /// Key columns and their values.
    pub keys: BTreeMap<&'a str, Value>,
    /// Source of the standard error.
    pub errors: Errors,
}

/// Derived quantity or table column that a claim of a paper is compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NumberSource<'a> {
    /// Quantity that follows from a case.
    Derived(&'a str),
    /// Table and its column.
    Column(&'a str, &'a str),
}

/// Returns true if two names of a quantity are equal, with spaces or without.
pub(crate) fn same_name(a: &str, b: &str) -> bool {
    a.replace('_', " ") == b.replace('_', " ")
}
