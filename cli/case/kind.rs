//! The kinds of cases, and how a file says of which kind it is.

use std::fmt::Debug;
use std::path::Path;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::error::{CaseError, Problem};
use super::locate::{KeyPath, Places};
use super::nearest::nearest;
use super::schema::{self, Schema};
use super::{check_format, read_text};

/// The kind of a case, which its key `kind` names. Each has keys, engines, tables and a report of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Event-driven and Monte Carlo disks from one initial state; a case without the key.
    #[default]
    Paired,
    /// Grains between walls, with spin, gravity, inflow and obstacles.
    Flow,
    /// Monte Carlo of a gas without positions: mixtures, diffusion, sticking and breaking.
    Homogeneous,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Paired, Self::Homogeneous, Self::Flow];

    /// Whether this is the kind of a case that does not name one.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Name in case files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paired => "paired",
            Self::Flow => "flow",
            Self::Homogeneous => "homogeneous",
        }
    }

    /// The JSON Schema of case files of this kind.
    pub fn schema(self) -> &'static Schema {
        match self {
            Self::Paired => super::Case::schema(),
            Self::Flow => crate::flow::case::Flow::schema(),
            Self::Homogeneous => crate::homogeneous::case::Case::schema(),
        }
    }

    /// The kind of a case file.
    ///
    /// # Errors
    /// As [`Kind::of_text`], and a file that cannot be read.
    pub fn of_file(path: &Path) -> Result<Self, CaseError> {
        Self::of_text(path, &read_text(path)?)
    }

    /// The kind of a case with this text; `path` stands in messages.
    ///
    /// # Errors
    /// Text that is not TOML or of another format, and a kind that does not exist.
    pub fn of_text(path: &Path, text: &str) -> Result<Self, CaseError> {
        let mut places = Places::new(path, text);
        let table = places.parse()?;
        check_format(&table)
            .and_then(|()| Self::of_table(&table))
            .map_err(|problem| problem.locate(&places))
    }

    fn of_table(table: &Table) -> Result<Self, Problem> {
        let Some(value) = table.get("kind") else {
            return Ok(Self::default());
        };
        let names = || Self::ALL.into_iter().map(Self::name);
        let found = value.as_str().unwrap_or_default();
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == found)
            .ok_or_else(|| {
                let quoted: Vec<String> = names().map(|name| format!("\"{name}\"")).collect();
                Problem::Bad {
                    key: KeyPath::of("kind"),
                    value: schema::written(value),
                    allowed: format!(
                        "the kind of a case is one of {}; without this key it is \"{}\"",
                        quoted.join(", "),
                        Self::default().name()
                    ),
                    suggestion: nearest(found, names()).map(|name| format!("\"{name}\"")),
                }
            })
    }

    /// Refuses a case of another kind than the one that is wanted.
    pub(super) fn expect(self, table: &Table) -> Result<(), Problem> {
        let found = Self::of_table(table)?;
        if found == self {
            return Ok(());
        }
        Err(Problem::bad(
            KeyPath::of("kind"),
            &Value::String(found.name().to_owned()),
            format!("a case of the kind \"{}\" is expected here", self.name()),
        ))
    }
}

/// How a case of one kind is written and what it means.
pub trait Form: Clone + Debug + Serialize {
    /// The kind.
    const KIND: Kind;

    /// The schema of its files.
    fn schema() -> &'static Schema;

    /// Checks a table and gives the case that it means. `folder` holds the case file.
    ///
    /// # Errors
    /// [`Problem`] names the key.
    fn from_table(table: &Table, folder: &Path) -> Result<Self, Problem>;

    /// The overrides that leave out what lies beyond a new, earlier end, so that a run can be shortened by one argument.
    fn shortened(_path: &Path, _until: f64) -> Vec<String> {
        Vec::new()
    }
}
