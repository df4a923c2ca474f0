//! Parameter sweeps: expansion of `[[sweep]]` blocks into the settings of each point.

use std::collections::{BTreeMap, BTreeSet};

use toml::{Table, Value};

use crate::error::Problem;
use crate::format::{SweepAxis, SweepRange};
use crate::origin::{KeyPath, below, value_at};
use crate::overrides::{Override, bare_keys};
use crate::schema::Format;

/// Largest number of sweep points of one case.
const MOST_POINTS: usize = 10_000;

/// Key and value that a sweep sets at one point.
#[derive(Clone, Debug)]
pub(crate) struct ChosenValue {
    /// Dotted key as written in the sweep.
    pub(crate) written: String,
    /// Path of the key from the root of the case.
    pub(crate) key: KeyPath,
    /// Value that the key takes at the point.
    pub(crate) value: Value,
    /// Path of the value inside the sweep block.
    pub(crate) source: KeyPath,
}

/// Sweeps of a case, expanded into points.
pub(crate) struct Expanded {
    /// Keys and values of each point.
    pub(crate) points: Vec<Vec<ChosenValue>>,
    /// Swept keys, as written, that are fixed by an override and no longer swept.
    pub(crate) fixed: Vec<String>,
}

/// Expands the sweeps of a case and removes them from its table. An override of a swept key, or of
/// a table around it, replaces the sweep.
///
/// Each block is the product of its axes, the last key (in alphabetical order) running fastest.
pub(crate) fn expand(
    format: &Format,
    table: &mut Table,
    overrides: &[Override],
) -> Result<Expanded, Problem> {
    let mut sweep = table.remove("sweep").unwrap_or(Value::Array(Vec::new()));
    format.check_part("sweep", &mut sweep)?;
    let blocks = sweep.as_array().map(Vec::as_slice).unwrap_or_default();
    if blocks.is_empty() {
        return Ok(Expanded {
            points: vec![Vec::new()],
            fixed: Vec::new(),
        });
    }
    let mut points = Vec::new();
    let mut fixed = Vec::new();
    for (index, block) in blocks.iter().enumerate() {
        let path = below(&["sweep".to_owned()], (index + 1).to_string());
        let read: Result<BTreeMap<String, SweepAxis>, _> = block.clone().try_into();
        let axes = read.map_err(|error| Problem::bad(&path, block, error.message()))?;
        if axes.is_empty() {
            let allowed = "a block of a sweep has at least one quoted dotted key with its values";
            return Err(Problem::bad(&path, block, allowed));
        }
        let mut product = vec![Vec::new()];
        let mut swept: Vec<KeyPath> = Vec::new();
        for (written, axis) in &axes {
            let path = below(&path, written);
            let refuse = |allowed: &str| {
                let value = value_at_of(block, written);
                Err(Problem::bad(&path, &value, allowed))
            };
            let Some(key) = bare_keys(written) else {
                return refuse(
                    "the key of a sweep is quoted and dotted, such as \"gas.restitution\"",
                );
            };
            if matches!(key[0].as_str(), "format" | "sweep") {
                return refuse("a sweep changes any key but format and sweep");
            }
            if swept.iter().any(|outer| key.starts_with(outer)) {
                return refuse("the same block already sweeps what holds this key");
            }
            swept.push(key.clone());
            let inside = |set: &&Override| set.key.len() > key.len() && set.key.starts_with(&key);
            if let Some(set) = overrides.iter().find(inside) {
                let allowed = format!(
                    "the case sweeps {written:?}, the whole table that holds this key: set it in the values of the sweep, or set \
                     {written} as a whole, which ends the sweep"
                );
                return Err(Problem::bad(&set.key, &set.value, allowed));
            }
            if overrides.iter().any(|set| key.starts_with(&set.key)) {
                fixed.push(written.clone());
                continue;
            }
            let values = match axis {
                SweepAxis::List(list) => list.clone(),
                SweepAxis::Range(range) => {
                    match range_values(range, format.type_of(&key) == Some("integer")) {
                        Ok(values) => values,
                        Err(allowed) => return refuse(&allowed),
                    }
                }
            };
            if product.len() * values.len() + points.len() > MOST_POINTS {
                return refuse(&too_many());
            }
            let list = matches!(axis, SweepAxis::List(_));
            let chosen = |(index, value): (usize, &Value)| ChosenValue {
                written: written.clone(),
                key: key.clone(),
                value: value.clone(),
                source: if list {
                    below(&path, (index + 1).to_string())
                } else {
                    path.clone()
                },
            };
            let chosen: Vec<ChosenValue> = values.iter().enumerate().map(chosen).collect();
            product = product
                .iter()
                .flat_map(|point: &Vec<ChosenValue>| {
                    let with =
                        |one: &ChosenValue| [point.as_slice(), std::slice::from_ref(one)].concat();
                    chosen.iter().map(with).collect::<Vec<_>>()
                })
                .collect();
        }
        points.append(&mut product);
    }
    Ok(Expanded { points, fixed })
}

fn value_at_of(block: &Value, key: &str) -> Value {
    let table = block.as_table().cloned().unwrap_or_default();
    value_at(&table, &[key.to_owned()])
        .cloned()
        .unwrap_or(Value::Table(table))
}

/// Returns the error message for more points than `MOST_POINTS`.
fn too_many() -> String {
    format!("all sweeps together make at most {MOST_POINTS} points")
}

/// Returns the values of a swept range, or an error message; whole numbers if `whole`.
fn range_values(range: &SweepRange, whole: bool) -> Result<Vec<Value>, String> {
    let &SweepRange {
        from,
        to,
        points,
        step,
        log,
    } = range;
    if log && !(from > 0.0 && to > 0.0) {
        return Err("the ends of a range in equal factors lie above 0".into());
    }
    // Scale of the steps: logarithmic where they are factors.
    let along = |value: f64| if log { value.ln() } else { value };
    let (last, to) = match (points, step) {
        (Some(points), None) => (points - 1, to),
        (None, Some(step)) => {
            let stride = along(step);
            let count = (along(to) - along(from)) / stride;
            if count.is_finite() && count >= MOST_POINTS as f64 {
                return Err(too_many());
            }
            if !(count.is_finite() && count * (1.0 + 1e-9) >= 1.0) {
                return Err(
                    "the step leads from `from` to `to` in one step or more: it is negative where `to` is less, and with log a \
                     factor, below 1 where `to` is less"
                        .into(),
                );
            }
            // Number of steps, robust against rounding below a whole number.
            let whole = (count * (1.0 + 1e-9)).floor();
            let end = along(from) + whole * stride;
            (whole as u64, if log { end.exp() } else { end })
        }
        _ => return Err("a range has either points or a step".into()),
    };
    let value = |index: u64| {
        let share = index as f64 / last as f64;
        let value = match index {
            0 => from,
            _ if index == last => to,
            _ if log => from * (to / from).powf(share),
            // Twelve digits keep 0.3 from being 0.30000000000000004.
            _ => from + (to - from) * share,
        };
        let value = format!("{value:.11e}").parse().unwrap_or(value);
        if whole {
            Value::Integer(f64::round(value) as i64)
        } else {
            Value::Float(value)
        }
    };
    Ok((0..=last).map(value).collect())
}

/// Generator of folder names for sweep points, such as `packing_fraction=0.25,restitution=1`, each
/// different from all others.
///
/// A key is shortened to its last part unless two keys of the case end alike.
#[derive(Debug)]
pub(crate) struct Names {
    ambiguous: BTreeSet<String>,
    taken: BTreeSet<String>,
}

impl Names {
    pub(crate) fn new(points: &[Vec<ChosenValue>]) -> Self {
        let keys: BTreeSet<&KeyPath> = points.iter().flatten().map(|one| &one.key).collect();
        let mut seen = BTreeSet::new();
        let lasts = keys.iter().filter_map(|key| key.last());
        let ambiguous = lasts.filter(|&last| !seen.insert(last)).cloned().collect();
        Self {
            ambiguous,
            taken: BTreeSet::new(),
        }
    }

    /// Returns the folder name of a sweep point; empty if it has no settings.
    pub(crate) fn name(&mut self, point: &[ChosenValue]) -> String {
        /// Longest folder name of a sweep point \[characters\], well below the limits of file
        /// systems.
        const WIDTH: usize = 150;
        let part = |one: &ChosenValue| {
            let last = one.key.last().map_or("", String::as_str);
            let ambiguous = self.ambiguous.contains(last);
            let key = if ambiguous { one.written.trim() } else { last };
            format!("{key}={}", format_value(&one.value))
        };
        let parts: Vec<String> = point.iter().map(part).collect();
        let safe = |c: char| {
            let fine = c.is_ascii_alphanumeric() || "._-=,+".contains(c);
            if fine { c } else { '_' }
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

/// Formats a swept value in few letters, for a folder name.
fn format_value(value: &Value) -> String {
    match value {
        Value::Float(number) if (1e-4..1e15).contains(&number.abs()) || *number == 0.0 => {
            number.to_string()
        }
        Value::Float(number) => format!("{number:e}"),
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(format_value).collect::<Vec<_>>().join("_"),
        Value::Table(table) => {
            let part = |(key, value): (&String, &Value)| format!("{key}_{}", format_value(value));
            table.iter().map(part).collect::<Vec<_>>().join("_")
        }
        other => other.to_string(),
    }
}
