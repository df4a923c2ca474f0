//! Location of a claim's number in the results of a run: point, table, column and row keys.

use std::collections::BTreeMap;

use stosszahl_case::paper::Errors;
use toml::Value;

/// Name of the derived quantity "computing time", summed over all engines and replicas of a run
/// \[s\].
pub(crate) const SECONDS: &str = "seconds";
/// Name of the derived quantity "number of collisions", summed over all engines and replicas of a
/// run.
pub(crate) const COLLISIONS: &str = "collisions";

/// Location of one number in the results of a paper's runs.
#[derive(Clone, Debug)]
pub(crate) struct NumberLocation<'a> {
    /// Name of the run whose results hold the number.
    pub run: &'a str,
    /// Name of the sweep point that holds the number; empty for a run without a sweep.
    pub point: String,
    /// Source of the number: a derived quantity, or a column of a table.
    pub source: NumberSource<'a>,
    /// Conditions on key columns that select the table row of the number.
    pub keys: BTreeMap<&'a str, Value>,
    /// Origin of the standard error: few replicas (Student's intervals) or many time blocks (normal
    /// intervals).
    pub errors: Errors,
}

/// Derived quantity or table column that a claim of a paper is compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NumberSource<'a> {
    /// Name of a quantity derived from a case, or of its computing time or collisions.
    Derived(&'a str),
    /// Names of a result table and of its column.
    Column(&'a str, &'a str),
}

/// Returns true if two names of a derived quantity are equal apart from spaces.
pub(crate) fn same_name(a: &str, b: &str) -> bool {
    a.replace('_', " ") == b.replace('_', " ")
}
