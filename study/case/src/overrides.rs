//! Command-line overrides of case keys: `--set key=value`.

use std::path::Path;

use toml::{Table, Value};

use crate::error::{CaseError, Fault, Refusal};
use crate::origin::{KeyPath, split};

/// Override of one case key by a command-line argument.
#[derive(Debug)]
pub(crate) struct Override {
    /// Path of the key from the root of the case.
    pub(crate) key: KeyPath,
    /// New value of the key.
    pub(crate) value: Value,
    /// Command-line argument as given, for messages.
    pub(crate) argument: String,
}

impl Override {
    /// Parses an override `key=value`. The key is dotted; the value is TOML, or else a bare word
    /// taken as text.
    pub(crate) fn parse_override(path: &Path, argument: &str) -> Result<Self, CaseError> {
        let refuse = |allowed: &str| {
            Err(CaseError::Refused(Box::new(Refusal {
                path: path.to_owned(),
                place: None,
                argument: Some(argument.escape_debug().collect()),
                swept: false,
                key: String::new(),
                fault: Fault::BadArgument {
                    allowed: allowed.to_owned(),
                },
                suggestion: None,
                text: "".into(),
                span: None,
            })))
        };
        let Some((key, value)) = argument.split_once('=') else {
            return refuse("an override is key=value, such as run.until=20");
        };
        let Some(key) = bare_keys(key) else {
            return refuse(
                "the key of an override is dotted, such as engine.ed.contact_time or species.1.number",
            );
        };
        if matches!(key[0].as_str(), "format" | "sweep") {
            return refuse("an override changes any key but format and sweep");
        }
        let value = value.trim();
        if value.is_empty() || value.chars().any(char::is_control) {
            return refuse("the value is a number, a word or other TOML value on one line");
        }
        let value = match toml::from_str::<Table>(&format!("value = {value}")) {
            Ok(mut table) => table.remove("value").unwrap_or(Value::Boolean(false)),
            Err(_) if value.starts_with(['"', '\'', '[', '{']) => {
                return refuse("the value is a number, a word or other TOML value");
            }
            Err(_) => Value::String(value.to_owned()),
        };
        Ok(Self {
            key,
            value,
            argument: argument.to_owned(),
        })
    }

    /// Returns the override with its value taken as text.
    pub(crate) fn into_text(mut self) -> Self {
        if !self.value.is_str() {
            let (_, text) = self.argument.split_once('=').unwrap_or_default();
            self.value = Value::String(text.trim().to_owned());
        }
        self
    }
}

/// Splits a dotted key without quotes into its path; `None` if it is not one.
pub(crate) fn bare_keys(dotted: &str) -> Option<KeyPath> {
    /// Largest number of steps in the path of a case key.
    const DEPTH: usize = 8;
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let keys = split(dotted.trim());
    let fine = |key: &String| !key.is_empty() && key.chars().all(bare);
    (keys.len() <= DEPTH && keys.iter().all(fine)).then_some(keys)
}

/// Sets a key in a table, creating the tables and lists on its path; values in the way are
/// replaced. A number in the path is an index into a list, from 1 to one beyond its end.
///
/// # Errors
/// The length of a list that is too short.
pub(crate) fn set(table: &mut Table, key: &[String], value: Value) -> Result<(), usize> {
    let Some((first, rest)) = key.split_first() else {
        return Ok(());
    };
    let missing = Value::Boolean(false);
    put(table.entry(first.clone()).or_insert(missing), rest, value)
}

fn put(place: &mut Value, key: &[String], value: Value) -> Result<(), usize> {
    let Some((first, rest)) = key.split_first() else {
        *place = value;
        return Ok(());
    };
    let missing = Value::Boolean(false);
    if let Ok(number) = first.parse::<usize>() {
        if !place.is_array() {
            *place = Value::Array(Vec::new());
        }
        let Value::Array(list) = place else {
            return Ok(());
        };
        if number == 0 || number > list.len() + 1 {
            return Err(list.len());
        }
        if number == list.len() + 1 {
            list.push(missing);
        }
        return put(&mut list[number - 1], rest, value);
    }
    if !place.is_table() {
        *place = Value::Table(Table::new());
    }
    let Value::Table(table) = place else {
        return Ok(());
    };
    put(table.entry(first.clone()).or_insert(missing), rest, value)
}

/// Removes times and windows of measurements that lie beyond a new, earlier end of the run.
pub(crate) fn shorten(table: &mut Table, until: f64) {
    let number = |value: &Value| {
        let whole = value.as_integer().map(|whole| whole as f64);
        value.as_float().or(whole)
    };
    let late = |value: &Value| number(value).is_some_and(|time| time > until);
    let measures = table.get_mut("measure").and_then(Value::as_table_mut);
    for (_, measure) in measures.into_iter().flatten() {
        if let Some(Value::Array(times)) = measure.get_mut("times")
            && times.iter().any(late)
        {
            // Times beyond the new end are replaced by the new end.
            times.retain(|time| number(time).is_some_and(|time| time < until));
            times.push(Value::Float(until));
        }
        if let Some(Value::Array(windows)) = measure.get_mut("windows") {
            windows.retain(|window| {
                let start = window.get(0).and_then(number);
                start.is_none_or(|start| start < until)
            });
            for window in windows {
                if let Some(end) = window.get_mut(1)
                    && late(end)
                {
                    *end = Value::Float(until);
                }
            }
        }
    }
}
