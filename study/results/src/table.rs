//! Tables: columns that say what they are, rows, and the figures that show them.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// Text that is known at compile time, or read back from a manifest.
type Text = Cow<'static, str>;

/// A table of a results folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its name, which is that of its file without the ending `.csv`.
    pub name: Text,
    /// What it holds, in one sentence.
    pub about: Text,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each with one cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// How it is drawn; none for tables that only list.
    pub figures: Vec<Figure>,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Its name, as the header line of the file spells it.
    pub name: Text,
    /// Unit of its numbers; `1` for pure numbers, empty for words.
    pub unit: Text,
    /// What it means.
    pub meaning: Text,
    /// What it is to other columns.
    pub role: Role,
}

/// What a column is to other columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Says what a row is about: an engine, a time, a species.
    Key,
    /// A measured quantity.
    Value,
    /// Standard error of the value before it.
    StandardError,
    /// Theory of the value before it.
    Theory,
    /// Error of that theory.
    TheoryError,
    /// A count or a remark.
    Note,
}

/// What stands in one row and column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number; one that is not finite is written as an empty cell.
    Number(f64),
    /// A count.
    Count(u64),
    /// Nothing is known.
    Empty,
}

/// A measured quantity with all that is known of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// What theory says.
    pub theory: Option<f64>,
    /// The error of that.
    pub theory_error: Option<f64>,
}

/// A figure of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What it shows.
    pub title: Text,
    /// A sentence or two below it.
    pub caption: Text,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Key columns that tell the curves apart, such as `engine`.
    pub curves: Vec<Text>,
    /// Key columns of which each value has a panel of its own, such as a window of time.
    pub panels: Vec<Text>,
    /// How points are drawn.
    pub mark: Mark,
    /// Lines that are no data: chaos, a law.
    pub lines: Vec<Line>,
    /// The column of the colours of a map; without one it is the first value column.
    #[serde(default)]
    pub colour: Option<Axis>,
}

/// An axis of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// The column.
    pub column: Text,
    /// Its label, with symbol and unit.
    pub label: Text,
    /// Its scale.
    pub scale: Scale,
}

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal factors.
    Logarithmic,
}

/// How the points of a curve are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// Points with error bars, joined by a line; theory is a dashed line.
    Line,
    /// Points with error bars.
    Points,
    /// Bars of a histogram, from the column of the x axis to the next column.
    Bars,
    /// A map: x and y are the place, the colour is [`Figure::colour`].
    Map,
}

/// A line that is no data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// What it is.
    pub label: Text,
    /// Its height.
    pub y: f64,
}

impl Table {
    /// A table without columns and rows.
    pub fn new(name: &'static str, about: &'static str) -> Self {
        Self {
            name: name.into(),
            about: about.into(),
            columns: Vec::new(),
            rows: Vec::new(),
            figures: Vec::new(),
        }
    }

    /// Adds a column that says what a row is about.
    #[must_use]
    pub fn key(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Key)
    }

    /// Adds a count or a remark.
    #[must_use]
    pub fn note(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Note)
    }

    /// Adds a quantity that has neither error nor theory.
    #[must_use]
    pub fn value(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Value)
    }

    /// Adds a quantity and its standard error, `NAME` and `NAME_se`.
    #[must_use]
    pub fn estimate(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        let about = "Standard error over replicas";
        self.value(name, unit, meaning).column(
            format!("{name}_se").into(),
            unit,
            about,
            Role::StandardError,
        )
    }

    /// Adds a quantity, its standard error and its theory: also `NAME_theory`.
    #[must_use]
    pub fn with_theory(
        self,
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
    ) -> Self {
        let about = "The same by theory; empty where there is none";
        self.estimate(name, unit, meaning).column(
            format!("{name}_theory").into(),
            unit,
            about,
            Role::Theory,
        )
    }

    /// Adds a quantity, its standard error, its theory and the error of that: also `NAME_theory_error`.
    #[must_use]
    pub fn with_theory_error(
        self,
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
    ) -> Self {
        let about = "Error of the theory: the change from one order less";
        let column = format!("{name}_theory_error").into();
        self.with_theory(name, unit, meaning)
            .column(column, unit, about, Role::TheoryError)
    }

    /// Adds the theory of the quantity before it, under a name of its own.
    #[must_use]
    pub fn theory(self, name: &'static str, unit: &'static str) -> Self {
        let about = "The same by theory; empty where there is none";
        self.column(name.into(), unit, about, Role::Theory)
    }

    fn column(mut self, name: Text, unit: &'static str, meaning: &'static str, role: Role) -> Self {
        self.columns.push(Column {
            name,
            unit: unit.into(),
            meaning: meaning.into(),
            role,
        });
        self
    }

    /// Adds a figure.
    #[must_use]
    pub fn figure(mut self, figure: Figure) -> Self {
        self.figures.push(figure);
        self
    }

    /// Begins a row: its cells are pushed in the order of the columns, an estimate fills all of its columns.
    pub fn row(&mut self) -> RowOf<'_> {
        self.rows.push(Vec::with_capacity(self.columns.len()));
        RowOf { table: self }
    }

    /// The number of a column.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}

/// A row that is being filled.
pub struct RowOf<'a> {
    table: &'a mut Table,
}

impl RowOf<'_> {
    fn push(self, cell: Cell) -> Self {
        if let Some(row) = self.table.rows.last_mut() {
            row.push(cell);
        }
        self
    }

    /// Words.
    pub fn text(self, text: impl Into<String>) -> Self {
        self.push(Cell::Text(text.into()))
    }

    /// A number.
    pub fn number(self, number: impl Into<Option<f64>>) -> Self {
        let cell = number.into().map_or(Cell::Empty, Cell::Number);
        self.push(cell)
    }

    /// A count.
    pub fn count(self, count: u64) -> Self {
        self.push(Cell::Count(count))
    }

    /// An estimate: as many cells as the quantity has columns.
    pub fn estimate(mut self, estimate: Estimate) -> Self {
        self = self.number(estimate.value);
        let next = |row: &Self| {
            let at = row.table.rows.last().map_or(0, Vec::len);
            row.table.columns.get(at).map(|column| column.role)
        };
        for (role, value) in [
            (Role::StandardError, estimate.standard_error),
            (Role::Theory, estimate.theory),
            (Role::TheoryError, estimate.theory_error),
        ] {
            if next(&self) == Some(role) {
                self = self.number(value);
            }
        }
        self
    }
}

impl Figure {
    /// A figure of curves against a column, one for each engine.
    pub fn curves(title: &'static str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            caption: "".into(),
            x,
            y,
            curves: vec!["engine".into()],
            panels: Vec::new(),
            mark: Mark::Line,
            lines: Vec::new(),
            colour: None,
        }
    }
}

impl Axis {
    /// A linear axis.
    pub fn linear(column: &'static str, label: &'static str) -> Self {
        Self {
            column: column.into(),
            label: label.into(),
            scale: Scale::Linear,
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(column: &'static str, label: &'static str) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(column, label)
        }
    }
}
