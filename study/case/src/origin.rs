//! Parsing of a case, with the position in the text of every key, for error messages.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use crate::error::{CaseError, Fault, Problem, Refusal};

/// Text after the name of a key that is at the top level of a case, outside all tables.
pub(crate) const OUTSIDE: &str = " before the first [table]";

/// Path of a key: the names from the root; elements of lists are counted from 1.
pub(crate) type KeyPath = Vec<String>;

/// Returns the path of a key extended by one step.
pub(crate) fn below(key: &[String], step: impl Into<String>) -> KeyPath {
    let mut longer = key.to_vec();
    longer.push(step.into());
    longer
}

/// Splits a dotted key into its path; names must not be quoted.
pub(crate) fn split(dotted: &str) -> KeyPath {
    dotted.split('.').map(str::to_owned).collect()
}

/// Formats the path of a key with dots, quoted where TOML needs quotes.
pub(crate) fn dotted(key: &[String]) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let part = |step: &String| {
        if !step.is_empty() && step.chars().all(bare) {
            step.clone()
        } else {
            format!("\"{}\"", step.escape_debug())
        }
    };
    key.iter().map(part).collect::<Vec<_>>().join(".")
}

/// Returns the value at the path of a key in a table; `None` if there is none.
pub(crate) fn value_at<'a>(table: &'a toml::Table, key: &[String]) -> Option<&'a toml::Value> {
    let (first, rest) = key.split_first()?;
    rest.iter().try_fold(table.get(first)?, |value, step| {
        if let toml::Value::Array(list) = value {
            list.get(step.parse::<usize>().ok()?.checked_sub(1)?)
        } else {
            value.get(step)
        }
    })
}

/// Byte ranges of a key and of its value in the text of a case.
#[derive(Clone, Debug)]
struct Spans {
    key: Range<usize>,
    value: Range<usize>,
}

/// Source that replaced the value of a key: a command-line argument, or a sweep.
#[derive(Clone, Debug)]
enum Replaced {
    /// Command-line argument that sets the key.
    Argument(Arc<str>),
    /// Sweep that sets the key: byte ranges of the value and of the key in the sweep.
    Sweep(Range<usize>, Range<usize>),
}

/// Positions in the text of all keys of a case, and which were replaced.
#[derive(Clone, Debug)]
pub(crate) struct Origins {
    path: PathBuf,
    text: Arc<str>,
    spans: Arc<BTreeMap<KeyPath, Spans>>,
    replaced: Vec<(KeyPath, Replaced)>,
}

impl Origins {
    /// Parses TOML text, and records the positions of all keys.
    pub(crate) fn parse_toml(path: &Path, text: &str) -> Result<(toml::Table, Self), CaseError> {
        let mut origins = Self {
            path: path.to_owned(),
            text: text.into(),
            spans: Arc::default(),
            replaced: Vec::new(),
        };
        let document = DeTable::parse(text).map_err(|error| {
            let mut message = error.message().replace('\n', ", ");
            if message == "duplicate key"
                && let Some(key) = error.span().and_then(|span| text.get(span))
            {
                message = format!("{key} is there twice in its table; a key has one value");
            }
            let problem = Problem::new(&[], Fault::Syntax { message });
            origins.at(problem, error.span(), false)
        })?;
        let mut spans = BTreeMap::new();
        let table = read_table(document.get_ref(), &[], &mut spans);
        origins.spans = Arc::new(spans);
        let table = table.map_err(|problem| origins.refuse(problem))?;
        Ok((table, origins))
    }

    /// Records that a command-line argument sets a key and all keys below it.
    pub(crate) fn set_by_argument(&mut self, key: &[String], argument: &str) {
        let by = Replaced::Argument(argument.into());
        self.replaced.push((key.to_vec(), by));
    }

    /// Records that a sweep sets a key, and all keys below it; `source` is the path of the swept
    /// value.
    pub(crate) fn set_by_sweep(&mut self, key: &[String], source: &[String]) {
        /// Length of the path of a sweep's key, without the index of the value: `sweep`, number of
        /// the block, key.
        const TO_KEY: usize = 3;
        let axis = &source[..source.len().min(TO_KEY)];
        let spans = [
            self.find_span(source, false).0,
            self.find_span(axis, true).0,
        ];
        if let [Some(value), Some(name)] = spans {
            let by = Replaced::Sweep(value, name);
            self.replaced.push((key.to_vec(), by));
        }
    }

    /// Converts a problem into an error with the position of its key in the text.
    pub(crate) fn refuse(&self, problem: Problem) -> CaseError {
        let key = &problem.key;
        let over = |(known, _): &&(KeyPath, Replaced)| key.starts_with(known);
        let mut replaced = self.replaced.iter().rev().find(over);
        let is_key = matches!(problem.fault, Fault::UnknownKey { .. });
        let (span, depth) = self.find_span(key, is_key);
        if replaced.is_none() && depth < key.len() {
            // The table exists only because a value in it was replaced.
            let beside = |(known, _): &&(KeyPath, Replaced)| known.starts_with(&key[..=depth]);
            replaced = self.replaced.iter().rev().find(beside);
        }
        match replaced {
            Some((_, Replaced::Argument(argument))) => {
                let argument: String = argument.escape_debug().collect();
                let mut error = self.at(problem, None, false);
                if let CaseError::Refused(refusal) = &mut error {
                    refusal.argument = Some(argument);
                    // An argument has no place before or after tables.
                    let close = refusal.suggestion.as_mut();
                    if let Some(name) = close
                        && let Some(end) = name.find(OUTSIDE)
                    {
                        name.truncate(end);
                    }
                }
                error
            }
            Some((_, Replaced::Sweep(value, name))) => {
                let span = if is_key { name } else { value };
                self.at(problem, Some(span.clone()), true)
            }
            None => self.at(problem, Some(span.unwrap_or(0..0)), false),
        }
    }

    /// Returns the byte range of a key, or of the nearest table around it, and how many steps of
    /// its path were found.
    fn find_span(&self, key: &[String], is_key: bool) -> (Option<Range<usize>>, usize) {
        for depth in (1..=key.len()).rev() {
            if let Some(spans) = self.spans.get(&key[..depth]) {
                let whole = depth == key.len() && !is_key;
                let span = if whole { &spans.value } else { &spans.key };
                return (Some(span.clone()), depth);
            }
        }
        (None, 0)
    }

    fn at(&self, problem: Problem, span: Option<Range<usize>>, swept: bool) -> CaseError {
        let place = span.as_ref().map(|span| {
            let before = self.text.get(..span.start).unwrap_or(&self.text);
            let line = before.matches('\n').count() + 1;
            let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
            (line, column)
        });
        CaseError::Refused(Box::new(Refusal {
            path: self.path.clone(),
            place,
            argument: None,
            swept,
            key: dotted(&problem.key),
            fault: problem.fault,
            suggestion: problem.suggestion,
            text: self.text.clone(),
            span,
        }))
    }
}

type Found = BTreeMap<KeyPath, Spans>;

fn read_table(
    table: &DeTable<'_>,
    path: &[String],
    found: &mut Found,
) -> Result<toml::Table, Problem> {
    let mut read = toml::Table::new();
    for (key, value) in table {
        let path = below(path, key.get_ref().as_ref());
        // The header of a table alone, because its text includes all that is below it.
        let plain = !matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_));
        let shown = if plain { value.span() } else { key.span() };
        let spans = Spans {
            key: key.span(),
            value: shown,
        };
        found.insert(path.clone(), spans);
        read.insert(
            key.get_ref().to_string(),
            read_value(value.get_ref(), &path, found)?,
        );
    }
    Ok(read)
}

fn read_value(
    value: &DeValue<'_>,
    path: &[String],
    found: &mut Found,
) -> Result<toml::Value, Problem> {
    Ok(match value {
        DeValue::String(text) => toml::Value::String(text.to_string()),
        DeValue::Integer(number) => {
            let parsed = i64::from_str_radix(number.as_str(), number.radix());
            toml::Value::Integer(parsed.map_err(|_| {
                let value = toml::Value::String(number.to_string());
                let allowed = format!("a whole number from {} to {}", i64::MIN, i64::MAX);
                Problem::bad(path, &value, allowed)
            })?)
        }
        // A number beyond the largest one becomes infinite here, and is refused with the
        // infinities.
        DeValue::Float(number) => toml::Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => toml::Value::Boolean(*truth),
        DeValue::Datetime(date) => toml::Value::Datetime(*date),
        DeValue::Array(list) => {
            let mut read = Vec::with_capacity(list.len());
            for (index, value) in list.iter().enumerate() {
                let path = below(path, (index + 1).to_string());
                let span = value.span();
                let spans = Spans {
                    key: span.clone(),
                    value: span,
                };
                found.insert(path.clone(), spans);
                read.push(read_value(value.get_ref(), &path, found)?);
            }
            toml::Value::Array(read)
        }
        DeValue::Table(table) => toml::Value::Table(read_table(table, path, found)?),
    })
}
