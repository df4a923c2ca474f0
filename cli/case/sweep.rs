//! Parameter sweeps: from `[[sweep]]` blocks to the settings of each point.

use std::collections::BTreeSet;

use toml::{Table, Value};

use super::error::Problem;
use super::locate::KeyPath;
use super::overrides::{Override, split_key};
use super::schema::{self, Schema};

/// Most points of one case.
const MOST_POINTS: usize = 10_000;

/// One value that a sweep gives to one key.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// The dotted key.
    pub(super) key: String,
    /// Its parts.
    pub(super) keys: Vec<String>,
    /// The value.
    pub(super) value: Value,
    /// Where in the sweep it was written.
    pub(super) source: KeyPath,
}

/// Expands the sweep blocks into the settings of each point; without a sweep there is one point without
/// settings.
///
/// Each block is the product of its lists, the last key (in alphabetical order) running fastest. A key that an
/// override fixes is not swept.
pub(super) fn expand(
    schema: &Schema,
    table: &mut Table,
    overrides: &[Override],
) -> Result<Vec<Vec<Chosen>>, Problem> {
    let Some(sweep) = table.remove("sweep") else {
        return Ok(vec![Vec::new()]);
    };
    schema.check_part("sweep", &sweep)?;
    let blocks = sweep.as_array().map(Vec::as_slice).unwrap_or_default();
    if blocks.is_empty() {
        return Ok(vec![Vec::new()]);
    }
    let mut points = Vec::new();
    for (i, block) in blocks.iter().enumerate() {
        let path = KeyPath::of("sweep").element(i);
        let block = block.as_table().cloned().unwrap_or_default();
        if block.is_empty() {
            let empty = Value::Table(Table::new());
            return Err(Problem::bad(path, &empty, schema.sentence("sweep")));
        }
        let mut product = vec![Vec::new()];
        for axis in axes(schema, &block, &path)? {
            let target = KeyPath::from_keys(&axis[0].keys);
            let fixed =
                |set: &Override| target.starts_with(&set.path()) || set.path().starts_with(&target);
            if overrides.iter().any(fixed) {
                continue;
            }
            let count = product.len() * axis.len() + points.len();
            if count > MOST_POINTS {
                let allowed = format!("all sweeps together make at most {MOST_POINTS} points");
                return Err(Problem::bad(
                    path.key(&axis[0].key),
                    &block[&axis[0].key],
                    allowed,
                ));
            }
            product = product
                .iter()
                .flat_map(|point: &Vec<Chosen>| {
                    axis.iter()
                        .map(move |value| [point.as_slice(), std::slice::from_ref(value)].concat())
                })
                .collect();
        }
        points.append(&mut product);
    }
    Ok(points)
}

/// The values of each key of a block.
fn axes(schema: &Schema, block: &Table, path: &KeyPath) -> Result<Vec<Vec<Chosen>>, Problem> {
    let mut axes: Vec<Vec<Chosen>> = Vec::new();
    for (key, list) in block {
        let path = path.key(key);
        let Some(keys) = split_key(key) else {
            return Err(Problem::bad(path, list, schema.sentence("sweep")));
        };
        if matches!(keys[0].as_str(), "format" | "kind" | "sweep") {
            return Err(Problem::bad(
                path,
                list,
                "a sweep changes any key but format, kind and sweep",
            ));
        }
        let target = KeyPath::from_keys(&keys);
        if let Some(outer) = axes
            .iter()
            .find(|axis| target.starts_with(&KeyPath::from_keys(&axis[0].keys)))
        {
            let allowed = format!("the same block already sweeps {}", outer[0].key);
            return Err(Problem::bad(path, list, allowed));
        }
        let list = list.as_array().map(Vec::as_slice).unwrap_or_default();
        if list.is_empty() {
            return Err(Problem::bad(
                path,
                &Value::Array(Vec::new()),
                schema.sentence("sweep"),
            ));
        }
        let values = list.iter().enumerate().map(|(i, value)| Chosen {
            key: key.clone(),
            keys: keys.clone(),
            value: value.clone(),
            source: path.element(i),
        });
        axes.push(values.collect());
    }
    Ok(axes)
}

/// Names for the folders of points: `packing_fraction=0.25,restitution=1`, each different from all others.
///
/// A key is shortened to its last part unless two keys of the case end alike.
#[derive(Debug)]
pub(super) struct Names {
    ambiguous: BTreeSet<String>,
    taken: BTreeSet<String>,
}

impl Names {
    pub(super) fn new(points: &[Vec<Chosen>]) -> Self {
        let keys: BTreeSet<&[String]> = points
            .iter()
            .flatten()
            .map(|one| one.keys.as_slice())
            .collect();
        let mut seen = BTreeSet::new();
        let mut ambiguous = BTreeSet::new();
        for last in keys.iter().filter_map(|keys| keys.last()) {
            if !seen.insert(last) {
                ambiguous.insert(last.clone());
            }
        }
        Self {
            ambiguous,
            taken: BTreeSet::new(),
        }
    }

    /// The name of a point; empty if it has no settings.
    pub(super) fn name(&mut self, point: &[Chosen]) -> String {
        /// Letters of a name, well below what file systems allow.
        const WIDTH: usize = 150;
        let parts: Vec<String> = point
            .iter()
            .map(|one| {
                let last = one.keys.last().map_or("", String::as_str);
                let key = if self.ambiguous.contains(last) {
                    one.key.trim()
                } else {
                    last
                };
                format!("{key}={}", plain(&one.value))
            })
            .collect();
        let safe = |c: char| {
            if c.is_ascii_alphanumeric() || "._-=,+".contains(c) {
                c
            } else {
                '_'
            }
        };
        let base: String = parts.join(",").chars().map(safe).take(WIDTH).collect();
        // Names that differ only in case are one folder on some systems.
        let mut name = base.clone();
        let mut number = 2;
        while !self.taken.insert(name.to_ascii_lowercase()) {
            name = format!("{base}-{number}");
            number += 1;
        }
        name
    }
}

/// A value in as few letters as a name needs.
fn plain(value: &Value) -> String {
    match value {
        Value::Float(number) if (1e-4..1e15).contains(&number.abs()) || *number == 0.0 => {
            number.to_string()
        }
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(plain).collect::<Vec<_>>().join("_"),
        Value::Table(table) => {
            let parts: Vec<String> = table
                .iter()
                .map(|(key, value)| format!("{key}_{}", plain(value)))
                .collect();
            parts.join("_")
        }
        other => schema::written(other),
    }
}
