//! Errors of case files, with line and column in the file.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use annotate_snippets::{AnnotationKind, Element, Level, Renderer, Snippet};

/// Error with which a case cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// The case file cannot be opened or read.
    #[error("{}: the case file cannot be read: {source}", path.display())]
    Unreadable {
        /// Path of the case file.
        path: PathBuf,
        /// Error of the operating system when it was read.
        source: io::Error,
    },
    /// There is neither a file nor a bundled case of the given name.
    #[error("{}: there is no such file, and no bundled case of that name{}; `stosszahl cases` lists them", path.display(), did_you_mean(*close))]
    NoCase {
        /// Path or name of the case as given.
        path: PathBuf,
        /// Name of a similar bundled case; `None` if none is similar.
        close: Option<&'static str>,
    },
    /// The path of the case is that of a folder.
    #[error("{}: this is a folder; a case is one TOML file", path.display())]
    Folder {
        /// Path of the folder that was given as a case.
        path: PathBuf,
    },
    /// The case file is far larger than a case can be.
    #[error("{}: the file is larger than {limit} bytes; a case is one short TOML file", path.display())]
    TooLarge {
        /// Path of the case file.
        path: PathBuf,
        /// Largest size of a case file \[bytes\].
        limit: u64,
    },
    /// The case file is not UTF-8 text.
    #[error("{}:{line}: byte 0x{byte:02x} is not UTF-8; a case is UTF-8 text", path.display())]
    NotUtf8 {
        /// Path of the case file.
        path: PathBuf,
        /// Line of the first byte that is not UTF-8, from 1.
        line: usize,
        /// First byte that is not UTF-8.
        byte: u8,
    },
    /// A key or value of the case is not allowed.
    #[error("{0}")]
    Refused(Box<Refusal>),
}

/// Formats the name of a similar bundled case as a question in parentheses; empty if there is none.
fn did_you_mean(close: Option<&str>) -> String {
    close.map_or_else(String::new, |name| format!(" (did you mean {name}?)"))
}

impl CaseError {
    /// Returns the refused key or value; `None` if the error concerns the file as a whole.
    pub fn refusal(&self) -> Option<&Refusal> {
        match self {
            Self::Refused(refusal) => Some(refusal),
            _ => None,
        }
    }

    /// Formats the error for people: with the line of the file, a mark below the column, and
    /// advice.
    pub fn report(&self, colour: bool) -> String {
        let renderer = if colour {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let mut elements: Vec<Element<'_>> = Vec::new();
        let Self::Refused(refusal) = self else {
            let title = Level::ERROR.primary_title(self.to_string());
            return renderer.render(&[title.elements(elements)]);
        };
        let path = refusal.path.to_string_lossy();
        if let Some(span) = &refusal.span {
            let mark = AnnotationKind::Primary.span(span.clone());
            let snippet = Snippet::source(&*refusal.text).path(path).annotation(mark);
            elements.push(snippet.into());
        }
        if let Some(close) = &refusal.suggestion {
            elements.push(Level::HELP.message(format!("did you mean {close}?")).into());
        }
        let title = match &refusal.argument {
            Some(argument) => format!("--set {argument}: {}", refusal.fault(false)),
            None => refusal.fault(false),
        };
        let group = Level::ERROR.primary_title(title).elements(elements);
        renderer.render(&[group])
    }
}

/// Refused key or value of a case, with its position in the file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Refusal {
    /// Path of the case file.
    pub path: PathBuf,
    /// Line and column of the refused key or value, from 1; `None` for an argument of the command
    /// line.
    pub place: Option<(usize, usize)>,
    /// Refused command-line argument, as `key=value`; `None` for a key of the file.
    pub argument: Option<String>,
    /// True if the refused value comes from a sweep.
    pub swept: bool,
    /// Dotted name of the refused key; elements of lists are counted from 1.
    pub key: String,
    /// Kind of error in the key or value.
    pub fault: Fault,
    /// Allowed word that is similar to the one given.
    pub suggestion: Option<String>,
    pub(crate) text: Arc<str>,
    pub(crate) span: Option<Range<usize>>,
}

/// Kind of error in a key or value of a case, without its position.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The text of the case is not valid TOML.
    Syntax {
        /// Message of the TOML parser.
        message: String,
    },
    /// The key is not part of the case format.
    UnknownKey {
        /// Keys that are allowed in the table of the unknown key.
        allowed: Vec<String>,
    },
    /// A required key of the case is missing.
    MissingKey {
        /// Reason why the key is required, such as a default that does not go with other keys.
        found: Option<String>,
        /// Description of the value that the missing key needs.
        allowed: String,
    },
    /// The value has the wrong type, is out of range, or contradicts another key.
    BadValue {
        /// The refused value as written.
        value: String,
        /// Cause outside the case file, such as in a file that the value names.
        found: Option<String>,
        /// Description of the allowed values.
        allowed: String,
    },
    /// A command-line override is not of the form `key=value`.
    BadArgument {
        /// Allowed form of the override.
        allowed: String,
    },
}

impl Refusal {
    /// Describes the error in words, without its position; with a suggested word if `suggest`.
    fn fault(&self, suggest: bool) -> String {
        let key = &self.key;
        let close = did_you_mean(self.suggestion.as_deref().filter(|_| suggest));
        match &self.fault {
            Fault::Syntax { message } => format!("this is not TOML: {message}"),
            Fault::UnknownKey { allowed } => {
                let list = allowed.join(", ");
                match key.rsplit_once('.') {
                    Some((table, _)) if allowed.is_empty() => {
                        format!("unknown key {key}: {table} has no keys")
                    }
                    Some((table, _)) => {
                        format!("unknown key {key}{close}: the keys of {table} are {list}")
                    }
                    None => {
                        format!("unknown key {key}{close}: the keys outside of tables are {list}")
                    }
                }
            }
            Fault::MissingKey {
                found: None,
                allowed,
            } => format!("{key} is missing: {allowed}"),
            Fault::MissingKey {
                found: Some(found),
                allowed,
            } => format!("{key} is missing ({found}); the rule: {allowed}"),
            Fault::BadValue {
                value,
                found,
                allowed,
            } => {
                let found = match found {
                    Some(found) => format!(" ({found})"),
                    None => String::new(),
                };
                format!("{key} = {value} is refused{found}{close}; the rule: {allowed}")
            }
            Fault::BadArgument { allowed } => allowed.clone(),
        }
    }
}

impl Display for Refusal {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match (&self.argument, self.place) {
            (Some(argument), _) => write!(out, "--set {argument}: ")?,
            (None, Some((line, column))) => {
                write!(out, "{}:{line}:{column}: ", self.path.display())?;
            }
            (None, None) => write!(out, "{}: ", self.path.display())?,
        }
        if self.swept {
            write!(out, "in a sweep, ")?;
        }
        write!(out, "{}", self.fault(true))
    }
}

/// Problem found in a key of a case, before its position in the file is known.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) key: Vec<String>,
    pub(crate) fault: Fault,
    pub(crate) suggestion: Option<String>,
}

impl Problem {
    pub(crate) fn new(key: &[String], fault: Fault) -> Self {
        Self {
            key: key.to_vec(),
            fault,
            suggestion: None,
        }
    }

    /// Creates a problem: the value of a key is not allowed.
    pub(crate) fn bad(key: &[String], value: &toml::Value, allowed: impl Into<String>) -> Self {
        let fault = Fault::BadValue {
            value: format_toml(value),
            found: None,
            allowed: allowed.into(),
        };
        Self::new(key, fault)
    }

    /// Creates a problem: a required key is missing.
    pub(crate) fn missing(key: &[String], allowed: impl Into<String>) -> Self {
        let fault = Fault::MissingKey {
            found: None,
            allowed: allowed.into(),
        };
        Self::new(key, fault)
    }
}

/// Formats a total of shares or particles with four decimals, for messages.
pub(crate) fn format_total(value: f64) -> String {
    if value.abs() < 1e6 {
        format!("{value:.4}")
    } else {
        format!("{value:.3e}")
    }
}

/// Formats a TOML value on one line, shortened if it is long.
pub(crate) fn format_toml(value: &toml::Value) -> String {
    const WIDTH: usize = 60;
    let text = match value {
        // Rust writes 1e300 so, where the TOML writer would give three hundred zeros.
        toml::Value::Float(number) if number.is_finite() => format!("{number:?}"),
        toml::Value::Array(all) => {
            // Further values would lie beyond the width at which the text is cut.
            let all: Vec<String> = all.iter().take(WIDTH).map(format_toml).collect();
            format!("[{}]", all.join(", "))
        }
        toml::Value::Table(all) => {
            let entry = |(key, value)| format!("{key} = {}", format_toml(value));
            let all: Vec<String> = all.iter().take(WIDTH).map(entry).collect();
            format!("{{ {} }}", all.join(", "))
        }
        toml::Value::String(text) => {
            let start: String = text.chars().take(WIDTH).collect();
            format!("\"{}\"", start.escape_debug())
        }
        other => other.to_string().replace('\n', " "),
    };
    if text.chars().nth(WIDTH).is_none() {
        return text;
    }
    text.chars().take(WIDTH).chain("...".chars()).collect()
}

/// Synonyms for suggestions: names in other programs and papers, with the keys and words of the
/// case format that correspond to them.
pub const SYNONYMS: &[(&str, &str)] = &[
    ("coalescence", "aggregation"),
    ("boundary", "walls"),
    ("boundaries", "walls"),
    ("coefficient_of_restitution", "restitution"),
    ("count", "number"),
    ("density", "packing_fraction"),
    ("diffusion", "displacement"),
    ("dimensions", "size"),
    ("domain", "box"),
    ("duration", "until"),
    ("force", "gravity"),
    ("forces", "gravity"),
    ("hard", "specular"),
    ("length", "size"),
    ("lengths", "size"),
    ("mean_squared_displacement", "displacement"),
    ("msd", "displacement"),
    ("n", "number"),
    ("observables", "measure"),
    ("particles", "number"),
    ("profile", "fields"),
    ("profiles", "fields"),
    ("radial_distribution", "pair_correlation"),
    ("rdf", "pair_correlation"),
    ("reflecting", "specular"),
    ("reflective", "specular"),
    ("series", "energy"),
    ("shaking", "vibration"),
    ("sides", "size"),
    ("solid_fraction", "packing_fraction"),
    ("species_temperatures", "species"),
    ("temperature", "energy"),
    ("time_series", "energy"),
    ("trajectory", "snapshots"),
    ("vacf", "velocity_autocorrelation"),
    ("velocities", "velocity_distribution"),
    ("vibrates", "vibration"),
    ("viscosity", "transport"),
    ("volume_fraction", "packing_fraction"),
];

/// Returns the allowed word that is most similar to a given one: a synonym, a word at most two
/// letters away, or one that begins with it. `None` if none is similar.
pub fn nearest<'a>(word: &str, choices: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A word from a file may be of any length, and nothing this long is close.
    if word.len() > 64 {
        return None;
    }
    let choices: Vec<&str> = choices.into_iter().collect();
    let means = |choice: &&&str| SYNONYMS.contains(&(word, **choice));
    if let Some(choice) = choices.iter().find(means) {
        return Some(choice);
    }
    let close = |choice: &&str| {
        let distance = strsim::osa_distance(word, choice);
        (distance <= 2 && distance < choice.len().min(word.len())).then_some(distance)
    };
    let scored = choices
        .iter()
        .filter_map(|choice| Some((close(choice)?, *choice)));
    // A word may also be the beginning of another.
    let begun = |choice: &&&str| word.len() >= 3 && choice.starts_with(word);
    let longer = || choices.iter().filter(begun).min_by_key(|one| one.len());
    let near = scored.min().map(|(_, choice)| choice);
    near.or_else(|| longer().copied())
}
