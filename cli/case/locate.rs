//! From a key to the place where it was written.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::error::{CaseError, Place, Problem};

/// One step from a table or list to what it holds.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// A key of a table.
    Key(String),
    /// An element of a list, from 0.
    Element(usize),
}

/// A dotted key, such as `engine.ed.contact_time` or `measure.structure_times[2]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct KeyPath(Vec<Step>);

impl KeyPath {
    /// The path of dot-separated plain keys.
    pub(crate) fn of(dotted: &str) -> Self {
        Self(
            dotted
                .split('.')
                .map(|key| Step::Key(key.to_owned()))
                .collect(),
        )
    }

    /// The path of keys from the root.
    pub(crate) fn from_keys(keys: &[String]) -> Self {
        Self(keys.iter().cloned().map(Step::Key).collect())
    }

    /// The path to a key of this table.
    pub(crate) fn key(&self, key: &str) -> Self {
        self.then(Step::Key(key.to_owned()))
    }

    /// The path to an element of this list.
    pub(crate) fn element(&self, index: usize) -> Self {
        self.then(Step::Element(index))
    }

    fn then(&self, step: Step) -> Self {
        let mut steps = self.0.clone();
        steps.push(step);
        Self(steps)
    }

    /// The steps from the root.
    pub fn steps(&self) -> &[Step] {
        &self.0
    }

    /// The table or list that holds this key; the root holds itself.
    #[must_use]
    pub fn parent(&self) -> Self {
        Self(self.0[..self.0.len().saturating_sub(1)].to_vec())
    }

    /// Whether this is the case as a whole.
    pub fn is_root(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether this path is `other` or something that `other` holds.
    pub fn starts_with(&self, other: &Self) -> bool {
        self.0.starts_with(&other.0)
    }
}

impl Display for KeyPath {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) => {
                    let dot = if i == 0 { "" } else { "." };
                    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
                    if !key.is_empty() && key.chars().all(bare) {
                        write!(out, "{dot}{key}")?;
                    } else {
                        write!(out, "{dot}\"{}\"", key.escape_debug())?;
                    }
                }
                Step::Element(index) => write!(out, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// Where one key was written.
#[derive(Clone, Debug)]
enum Spot {
    Line(usize),
    Override(String),
}

/// Where every key of a case was written.
#[derive(Clone, Debug)]
pub(super) struct Places<'a> {
    path: PathBuf,
    text: &'a str,
    spots: BTreeMap<KeyPath, Spot>,
}

impl<'a> Places<'a> {
    /// A file of which no key has been located yet.
    pub(super) fn new(path: &Path, text: &'a str) -> Self {
        Self {
            path: path.to_owned(),
            text,
            spots: BTreeMap::new(),
        }
    }

    /// The place of a key, or of the nearest table around it; the first line if there is none.
    pub(super) fn of(&self, key: &KeyPath) -> Place {
        let mut key = key.clone();
        loop {
            match self.spots.get(&key) {
                Some(Spot::Line(line)) => return self.line(*line),
                Some(Spot::Override(argument)) => {
                    return Place::Override {
                        argument: argument.clone(),
                    };
                }
                None if key.is_root() => return self.line(1),
                None => key = key.parent(),
            }
        }
    }

    /// The place of a key, as errors hold it.
    pub(super) fn boxed(&self, key: &KeyPath) -> Box<Place> {
        Box::new(self.of(key))
    }

    /// A place by its line number.
    fn line(&self, line: usize) -> Place {
        /// Letters of a line that are quoted in a message.
        const WIDTH: usize = 160;
        let whole = self
            .text
            .lines()
            .nth(line.saturating_sub(1))
            .unwrap_or_default();
        let mut text: String = printable(whole).take(WIDTH).collect();
        if whole.chars().nth(WIDTH).is_some() {
            text.push_str(" ...");
        }
        Place::Line {
            path: self.path.clone(),
            line,
            text,
        }
    }

    /// Puts a key, and everything it holds, where an override says.
    pub(super) fn set_override(&mut self, key: &KeyPath, argument: &str) {
        self.replace(key, &Spot::Override(argument.to_owned()));
    }

    /// Puts a key, and everything it holds, where another key was written.
    pub(super) fn set_as(&mut self, key: &KeyPath, source: &KeyPath) {
        if let Some(spot) = self.spots.get(source).cloned() {
            self.replace(key, &spot);
        }
    }

    fn replace(&mut self, key: &KeyPath, spot: &Spot) {
        self.spots.retain(|known, _| !known.starts_with(key));
        self.spots.insert(key.clone(), spot.clone());
        // Tables that exist only because of this key are where the key is.
        let mut table = key.parent();
        while !table.is_root() && !self.spots.contains_key(&table) {
            self.spots.insert(table.clone(), spot.clone());
            table = table.parent();
        }
    }

    /// Reads the text as TOML and locates every key in it.
    ///
    /// # Errors
    /// Text that is not TOML, or a whole number that does not fit into 64 bits.
    pub(super) fn parse(&mut self) -> Result<toml::Table, CaseError> {
        let document = DeTable::parse(self.text).map_err(|error| self.syntax(&error))?;
        self.table(document.get_ref(), &KeyPath::default())
            .map_err(|problem| problem.locate(self))
    }

    fn syntax(&self, error: &toml::de::Error) -> CaseError {
        let span = error.span().unwrap_or(0..0);
        let found = self.text.get(span.clone()).unwrap_or_default();
        let found = printable(found.lines().next().unwrap_or_default())
            .take(60)
            .collect();
        let place = Box::new(self.line(line_of(self.text, span.start)));
        CaseError::Syntax {
            place,
            found,
            message: error.message().replace('\n', ", "),
        }
    }

    fn table(&mut self, table: &DeTable<'_>, path: &KeyPath) -> Result<toml::Table, Problem> {
        let mut read = toml::Table::new();
        for (key, value) in table {
            let inner = path.key(key.get_ref());
            let line = line_of(self.text, key.span().start);
            self.spots.insert(inner.clone(), Spot::Line(line));
            let value = self.value(value.get_ref(), &inner)?;
            read.insert(key.get_ref().to_string(), value);
        }
        Ok(read)
    }

    fn value(&mut self, value: &DeValue<'_>, path: &KeyPath) -> Result<toml::Value, Problem> {
        Ok(match value {
            DeValue::String(text) => toml::Value::String(text.to_string()),
            DeValue::Integer(number) => {
                let parsed = i64::from_str_radix(number.as_str(), number.radix());
                toml::Value::Integer(parsed.map_err(|_| Problem::Bad {
                    key: path.clone(),
                    value: number.to_string(),
                    allowed: format!("a whole number lies between {} and {}", i64::MIN, i64::MAX),
                    suggestion: None,
                })?)
            }
            // A number beyond the largest one becomes infinite here, and is refused with the infinities.
            DeValue::Float(number) => {
                toml::Value::Float(number.as_str().parse().unwrap_or(f64::NAN))
            }
            DeValue::Boolean(truth) => toml::Value::Boolean(*truth),
            DeValue::Datetime(date) => toml::Value::Datetime(*date),
            DeValue::Array(list) => {
                let mut read = Vec::with_capacity(list.len());
                for (i, value) in list.iter().enumerate() {
                    let inner = path.element(i);
                    let line = line_of(self.text, value.span().start);
                    self.spots.insert(inner.clone(), Spot::Line(line));
                    read.push(self.value(value.get_ref(), &inner)?);
                }
                toml::Value::Array(read)
            }
            DeValue::Table(table) => toml::Value::Table(self.table(table, path)?),
        })
    }
}

/// The text with a question mark for each character that a terminal might obey.
fn printable(text: &str) -> impl Iterator<Item = char> + '_ {
    text.chars().map(|c| match c {
        '\t' => ' ',
        c if c.is_control() => '?',
        c => c,
    })
}

/// The line, from 1, of a byte of the text.
fn line_of(text: &str, offset: usize) -> usize {
    text.get(..offset)
        .map_or(1, |before| before.matches('\n').count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "a = 1\n[gas]\nb = [\n  1,\n  2,\n]\n[engine.ed]\nc.d = 3\r\n[[sweep]]\n\"x.y\" = [1]\n";

    fn line(key: &KeyPath) -> Option<usize> {
        let mut places = Places::new(Path::new("t.toml"), TEXT);
        places.parse().expect("the text is TOML");
        places.of(key).line()
    }

    #[test]
    fn keys_tables_and_elements_are_found() {
        assert_eq!(line(&KeyPath::of("a")), Some(1));
        assert_eq!(line(&KeyPath::of("gas")), Some(2));
        assert_eq!(line(&KeyPath::of("gas.b")), Some(3));
        assert_eq!(line(&KeyPath::of("gas.b").element(1)), Some(5));
        assert_eq!(line(&KeyPath::of("engine")), Some(7));
        assert_eq!(line(&KeyPath::of("engine.ed.c.d")), Some(8));
        assert_eq!(
            line(&KeyPath::of("sweep").element(0).key("x.y").element(0)),
            Some(10)
        );
    }

    #[test]
    fn an_absent_key_is_where_its_table_is() {
        assert_eq!(line(&KeyPath::of("gas.mass")), Some(2));
        assert_eq!(line(&KeyPath::of("run.until")), Some(1));
    }

    #[test]
    fn an_override_covers_what_it_replaces() {
        let mut places = Places::new(Path::new("t.toml"), TEXT);
        places.parse().expect("the text is TOML");
        places.set_override(&KeyPath::of("gas"), "gas=1");
        places.set_override(&KeyPath::of("run.until"), "run.until=2");
        assert_eq!(
            places.of(&KeyPath::of("gas.b").element(1)).to_string(),
            "--set gas=1"
        );
        assert_eq!(
            places.of(&KeyPath::of("run")).to_string(),
            "--set run.until=2"
        );
        assert_eq!(places.of(&KeyPath::of("engine")).line(), Some(7));
    }

    #[test]
    fn paths_are_shown_as_written() {
        let path = KeyPath::of("measure.structure_times").element(2);
        assert_eq!(path.to_string(), "measure.structure_times[2]");
        assert_eq!(
            KeyPath::default().key("a b").key("c").to_string(),
            "\"a b\".c"
        );
    }
}
