//! What can be wrong with a case file, and where.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use super::locate::KeyPath;

/// Where a setting was written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A line of a case file, counted from 1.
    Line {
        /// The case file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// The line itself, without unprintable characters and cut if it is very long.
        text: String,
    },
    /// An override on the command line.
    Override {
        /// The `key=value` that was given.
        argument: String,
    },
}

impl Place {
    /// The number of the line, if the place is in a file.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Line { line, .. } => Some(*line),
            Self::Override { .. } => None,
        }
    }

    /// The quoted line, to stand below a message.
    fn quote(&self) -> Quote<'_> {
        Quote(self)
    }
}

impl Display for Place {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { path, line, .. } => write!(out, "{}:{line}", path.display()),
            Self::Override { argument } => write!(out, "--set {}", argument.escape_debug()),
        }
    }
}

/// The line of a place, numbered.
struct Quote<'a>(&'a Place);

impl Display for Quote<'_> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Place::Line { line, text, .. } => write!(out, "\n  {line} | {text}"),
            Place::Override { .. } => Ok(()),
        }
    }
}

/// Why a case could not be read. Each message names the file, the line, the key, what was found there and
/// what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// The file cannot be opened or read.
    #[error("{}: the case file cannot be read: {source}", path.display())]
    Unreadable {
        /// The case file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The path names a directory.
    #[error("{}: this is a directory; a case is one TOML file", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The file is far larger than a case can be.
    #[error("{}: the file is larger than {limit} bytes; a case is one short TOML file", path.display())]
    TooLarge {
        /// The case file.
        path: PathBuf,
        /// Most bytes that are read.
        limit: u64,
    },
    /// The file is not text.
    #[error("{}:{line}: byte 0x{byte:02x} is not UTF-8; a case is UTF-8 text", path.display())]
    NotUtf8 {
        /// The case file.
        path: PathBuf,
        /// Line of the first bad byte, from 1.
        line: usize,
        /// The first bad byte.
        byte: u8,
    },
    /// The file is not TOML. A key that is given twice is found here too.
    #[error("{place}: this is not TOML: {message}{}{}", Found(found), place.quote())]
    Syntax {
        /// Where.
        place: Box<Place>,
        /// What was found there; empty at the end of a line.
        found: String,
        /// What the TOML reader said.
        message: String,
    },
    /// The case is written in a format that this program does not know.
    #[error("{place}: format = {found} is not supported: the only format is {supported}{}", place.quote())]
    UnsupportedFormat {
        /// Where.
        place: Box<Place>,
        /// The format that was found.
        found: String,
        /// The format that is supported.
        supported: i64,
    },
    /// A key that means nothing.
    #[error("{place}: unknown key {key}{}: {}{}", Suggested(suggestion.as_ref()), Keys(key, allowed), place.quote())]
    UnknownKey {
        /// Where.
        place: Box<Place>,
        /// The key that was found.
        key: KeyPath,
        /// The keys of that table.
        allowed: Vec<String>,
        /// A known key that is close.
        suggestion: Option<String>,
    },
    /// A key that has to be there.
    #[error("{place}: {key} is missing: {allowed}{}", place.quote())]
    MissingKey {
        /// The table where it should be, or what makes it necessary.
        place: Box<Place>,
        /// The key.
        key: KeyPath,
        /// What should be there.
        allowed: String,
    },
    /// A value of the wrong type, out of range, or at odds with another key.
    #[error("{place}: {key} = {value} is not allowed{}: {allowed}{}", Suggested(suggestion.as_ref()), place.quote())]
    BadValue {
        /// Where.
        place: Box<Place>,
        /// The key, down to the element of a list.
        key: KeyPath,
        /// What was found.
        value: String,
        /// What is allowed.
        allowed: String,
        /// An allowed value that is close.
        suggestion: Option<String>,
    },
    /// An override that is not `key=value`.
    #[error("--set {}: not allowed: {allowed}", argument.escape_debug())]
    BadOverride {
        /// The override as given.
        argument: String,
        /// What is allowed.
        allowed: String,
    },
}

impl CaseError {
    /// The place that the error names, unless it concerns the file as a whole.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Syntax { place, .. }
            | Self::UnsupportedFormat { place, .. }
            | Self::UnknownKey { place, .. }
            | Self::MissingKey { place, .. }
            | Self::BadValue { place, .. } => Some(place),
            _ => None,
        }
    }

    /// The line that the error names, from 1.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::NotUtf8 { line, .. } => Some(*line),
            _ => self.place().and_then(Place::line),
        }
    }
}

/// What stood at a syntax error, if anything.
struct Found<'a>(&'a str);

impl Display for Found<'_> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            Ok(())
        } else {
            write!(out, " (found `{}`)", self.0)
        }
    }
}

/// A close alternative, if any.
struct Suggested<'a>(Option<&'a String>);

impl Display for Suggested<'_> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        self.0
            .map_or(Ok(()), |word| write!(out, " (did you mean {word}?)"))
    }
}

/// The keys of the table that a key was looked for in.
struct Keys<'a>(&'a KeyPath, &'a [String]);

impl Display for Keys<'_> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        let table = self.0.parent();
        if table.is_root() {
            write!(out, "the keys of a case are ")?;
        } else {
            write!(out, "the keys of {table} are ")?;
        }
        write!(out, "{}", self.1.join(", "))
    }
}

/// Something wrong with a case, before it is known where the key was written.
#[derive(Debug)]
pub enum Problem {
    /// A format that this program does not know.
    Format {
        /// The format that was found.
        found: String,
    },
    /// A key that means nothing.
    Unknown {
        /// The key.
        key: KeyPath,
        /// The keys of that table.
        allowed: Vec<String>,
        /// A known key that is close.
        suggestion: Option<String>,
    },
    /// A key that has to be there.
    Missing {
        /// The key.
        key: KeyPath,
        /// What should be there.
        allowed: String,
    },
    /// A value that is not allowed.
    Bad {
        /// The key.
        key: KeyPath,
        /// The value as found.
        value: String,
        /// What is allowed.
        allowed: String,
        /// An allowed value that is close.
        suggestion: Option<String>,
    },
}

impl Problem {
    /// A value that is not allowed.
    pub(crate) fn bad(key: KeyPath, value: &toml::Value, allowed: impl Into<String>) -> Self {
        let value = super::schema::written(value);
        Self::Bad {
            key,
            value,
            allowed: allowed.into(),
            suggestion: None,
        }
    }

    /// The error, with the place of the key.
    pub(super) fn locate(self, places: &super::locate::Places) -> CaseError {
        match self {
            Self::Format { found } => CaseError::UnsupportedFormat {
                place: places.boxed(&KeyPath::of("format")),
                found,
                supported: super::FORMAT,
            },
            Self::Unknown {
                key,
                allowed,
                suggestion,
            } => CaseError::UnknownKey {
                place: places.boxed(&key),
                key,
                allowed,
                suggestion,
            },
            Self::Missing { key, allowed } => CaseError::MissingKey {
                place: places.boxed(&key.parent()),
                key,
                allowed,
            },
            Self::Bad {
                key,
                value,
                allowed,
                suggestion,
            } => CaseError::BadValue {
                place: places.boxed(&key),
                key,
                value,
                allowed,
                suggestion,
            },
        }
    }
}
