//! From a checked table to a typed case, and back from a fault in it to its key.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::error::Problem;
use super::locate::{KeyPath, Step};
use super::schema::{self, Schema};

/// Checks a table against its schema and reads it.
pub(crate) fn read<W: DeserializeOwned>(schema: &Schema, table: &Table) -> Result<W, Problem> {
    schema.check(table)?;
    serde_path_to_error::deserialize(Value::Table(table.clone()))
        .map_err(|error| misread(table, &error))
}

/// What the reader of the typed case refuses although the schema does not.
fn misread(table: &Table, error: &serde_path_to_error::Error<toml::de::Error>) -> Problem {
    use serde_path_to_error::Segment;
    let mut key = KeyPath::default();
    for segment in error.path() {
        key = match segment {
            Segment::Seq { index } => key.element(*index),
            Segment::Map { key: name } => key.key(name),
            _ => key,
        };
    }
    let value = value_at(table, &key)
        .map(schema::written)
        .unwrap_or_default();
    Problem::Bad {
        key,
        value,
        allowed: error.inner().message().to_owned(),
        suggestion: None,
    }
}

/// The value of a key.
pub(crate) fn value_at<'a>(table: &'a Table, key: &KeyPath) -> Option<&'a Value> {
    let mut steps = key.steps().iter();
    let Some(Step::Key(first)) = steps.next() else {
        return None;
    };
    steps.try_fold(table.get(first)?, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Element(index) => value.get(index),
    })
}

/// Refuses the value of a key, or its absence.
pub(crate) fn refuse(table: &Table, key: KeyPath, allowed: impl Into<String>) -> Problem {
    match value_at(table, &key) {
        Some(value) => Problem::bad(key, value, allowed),
        None => Problem::Missing {
            key,
            allowed: allowed.into(),
        },
    }
}
