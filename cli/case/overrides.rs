//! Settings from the command line that replace those in the file: `--set key=value`.

use toml::{Table, Value};

use super::error::CaseError;
use super::locate::KeyPath;

/// A setting that replaces the one in the file.
#[derive(Debug)]
pub(super) struct Override {
    /// The keys from the root.
    pub(super) keys: Vec<String>,
    /// The new value.
    pub(super) value: Value,
    /// What was given, for messages.
    pub(super) argument: String,
}

/// Deeper keys than this mean nothing in a case.
const DEPTH: usize = 8;

impl Override {
    /// Reads `key=value`: the key is dotted, and the value is TOML, or else a bare word taken as text.
    pub(super) fn read(argument: &str) -> Result<Self, CaseError> {
        let refuse = |allowed: &str| {
            Err(CaseError::BadOverride {
                argument: argument.to_owned(),
                allowed: allowed.to_owned(),
            })
        };
        let Some((key, value)) = argument.split_once('=') else {
            return refuse("an override is key=value, such as run.until=20");
        };
        let Some(keys) = split_key(key) else {
            return refuse("the key of an override is dotted, such as engine.ed.contact_time");
        };
        if matches!(keys[0].as_str(), "format" | "kind" | "sweep") {
            return refuse("an override changes any key but format, kind and sweep");
        }
        let value = value.trim();
        if value.is_empty() || value.chars().any(char::is_control) {
            return refuse(
                "the value of an override is a number, a word or other TOML value on one line",
            );
        }
        let value = match toml::from_str::<Table>(&format!("value = {value}")) {
            Ok(mut table) => table.remove("value").unwrap_or(Value::Boolean(false)),
            Err(_) if value.starts_with(['"', '\'', '[', '{']) => {
                return refuse("the value of an override is a number, a word or other TOML value");
            }
            Err(_) => Value::String(value.to_owned()),
        };
        Ok(Self {
            keys,
            value,
            argument: argument.to_owned(),
        })
    }

    /// Where the override applies.
    pub(super) fn path(&self) -> KeyPath {
        KeyPath::from_keys(&self.keys)
    }
}

/// The parts of a dotted key of bare keys, unless it is not one.
pub(super) fn split_key(dotted: &str) -> Option<Vec<String>> {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let keys: Vec<String> = dotted.trim().split('.').map(str::to_owned).collect();
    let fine = keys.len() <= DEPTH
        && keys
            .iter()
            .all(|key| !key.is_empty() && key.chars().all(bare));
    fine.then_some(keys)
}

/// Sets a key, making the tables that lead to it; whatever is in the way is replaced.
pub(super) fn set(table: &mut Table, keys: &[String], value: Value) {
    let Some((first, rest)) = keys.split_first() else {
        return;
    };
    if rest.is_empty() {
        table.insert(first.clone(), value);
        return;
    }
    let inner = table
        .entry(first.clone())
        .or_insert_with(|| Value::Table(Table::new()));
    if !inner.is_table() {
        *inner = Value::Table(Table::new());
    }
    if let Value::Table(inner) = inner {
        set(inner, rest, value);
    }
}

/// The overrides that leave out the times and windows of a case file beyond a new, earlier end, so that a run can
/// be shortened by one argument. A file that cannot be read needs none: reading it reports why.
pub fn shortened(path: &std::path::Path, until: f64) -> Vec<String> {
    let table = std::fs::read_to_string(path)
        .ok()
        .and_then(|text| text.parse::<Table>().ok());
    let measure = table
        .as_ref()
        .and_then(|table| table.get("measure"))
        .and_then(Value::as_table);
    let Some(measure) = measure else {
        return Vec::new();
    };
    let number = |value: &Value| {
        value
            .as_float()
            .or_else(|| value.as_integer().map(|n| n as f64))
    };
    let list = |key: &str| measure.get(key).and_then(Value::as_array);
    let mut overrides = Vec::new();
    for key in ["structure_times", "snapshot_times"] {
        let Some(times) = list(key) else { continue };
        let late = |time: &&Value| number(time).is_some_and(|time| time > until);
        if times.iter().any(|time| late(&time)) {
            let mut kept: Vec<String> = times
                .iter()
                .filter(|time| !late(time))
                .map(ToString::to_string)
                .collect();
            // What was asked for at the end is wanted at the new end.
            kept.push(format!("{until:?}"));
            overrides.push(format!("measure.{key}=[{}]", kept.join(", ")));
        }
    }
    let windows: Option<Vec<[f64; 2]>> = list("impact_windows").and_then(|windows| {
        windows
            .iter()
            .map(|window| {
                let [start, end] = window.as_array()?.as_slice() else {
                    return None;
                };
                Some([number(start)?, number(end)?])
            })
            .collect()
    });
    if let Some(windows) = windows.filter(|windows| windows.iter().any(|window| window[1] > until))
    {
        let kept: Vec<String> = windows
            .iter()
            .filter(|window| window[0] < until)
            .map(|window| format!("[{:?}, {:?}]", window[0], window[1].min(until)))
            .collect();
        overrides.push(format!("measure.impact_windows=[{}]", kept.join(", ")));
    }
    overrides
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(argument: &str) -> Option<Value> {
        Override::read(argument).ok().map(|read| read.value)
    }

    #[test]
    fn values_are_toml_or_words() {
        assert_eq!(value("run.until=20"), Some(Value::Integer(20)));
        assert_eq!(
            value("engine.ed.contact_time = 1e-4"),
            Some(Value::Float(1e-4))
        );
        assert_eq!(
            value("start.file=a.csv"),
            Some(Value::String("a.csv".to_owned()))
        );
        assert_eq!(
            value("title=two words"),
            Some(Value::String("two words".to_owned()))
        );
        assert_eq!(
            value("title=\"a = b\""),
            Some(Value::String("a = b".to_owned()))
        );
        assert!(
            value("gas.restitution={ viscoelastic = 0.2 }").is_some_and(|value| value.is_table())
        );
    }

    #[test]
    fn anything_else_is_refused() {
        for bad in [
            "",
            "until",
            "=3",
            "run..until=3",
            "run.until=",
            "title=\"open",
            "a b=1",
            "format=2",
            "sweep=[]",
            "title=a\nb=2",
            "a.a.a.a.a.a.a.a.a=1",
            "\"run\".until=3",
        ] {
            assert!(value(bad).is_none(), "{bad:?} was taken");
        }
    }
}
