//! Tables: columns that say what they are, rows, and the figures that show them.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// Text that is known at compile time, or read back from a manifest.
type Text = Cow<'static, str>;

/// Name of the folder of drawings inside that of a run.
pub const FIGURES: &str = "figures";

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
    /// Replicas that the error is from; none if it is known otherwise.
    pub replicas: Option<usize>,
    /// What theory says.
    pub theory: Option<f64>,
    /// The error of that.
    pub theory_error: Option<f64>,
}

impl Estimate {
    /// A value with its standard error.
    pub fn of(value: f64, standard_error: Option<f64>) -> Self {
        Self {
            value: Some(value),
            standard_error,
            ..Self::default()
        }
    }

    /// The same beside a theory.
    #[must_use]
    pub fn against(self, theory: Option<f64>) -> Self {
        Self { theory, ..self }
    }

    /// All of it in units of which one of its own is `unit`.
    #[must_use]
    pub fn times(self, unit: f64) -> Self {
        let scaled = |value: Option<f64>| value.map(|value| value * unit);
        Self {
            value: scaled(self.value),
            standard_error: scaled(self.standard_error),
            replicas: self.replicas,
            theory: scaled(self.theory),
            theory_error: scaled(self.theory_error),
        }
    }
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
    pub fn theory(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Theory)
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

    /// Adds a row: its cells in the order of the columns, an estimate filling all of its columns.
    pub fn add(&mut self, cells: impl Cells) {
        self.rows.push(Vec::with_capacity(self.columns.len()));
        cells.fill(self);
    }

    fn push(&mut self, cell: Cell) {
        if let Some(row) = self.rows.last_mut() {
            row.push(cell);
        }
    }

    /// Names of the drawings of its figures inside a results folder: `figures/NAME.svg`, `figures/NAME-2.svg` and so on.
    pub fn drawings(&self) -> Vec<String> {
        let number = |figure: usize| match figure {
            1 => String::new(),
            more => format!("-{more}"),
        };
        (1..=self.figures.len())
            .map(|figure| format!("{FIGURES}/{}{}.svg", self.name, number(figure)))
            .collect()
    }

    /// The number of a column.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}

/// What fills cells of the last row of a table.
pub trait Cells {
    /// Fills them, in the order of the columns.
    fn fill(self, table: &mut Table);
}

impl Cells for Cell {
    fn fill(self, table: &mut Table) {
        table.push(self);
    }
}

impl Cells for &str {
    fn fill(self, table: &mut Table) {
        table.push(Cell::Text(self.to_owned()));
    }
}

impl Cells for f64 {
    fn fill(self, table: &mut Table) {
        table.push(Cell::Number(self));
    }
}

impl Cells for Option<f64> {
    fn fill(self, table: &mut Table) {
        table.push(self.map_or(Cell::Empty, Cell::Number));
    }
}

impl Cells for u64 {
    fn fill(self, table: &mut Table) {
        table.push(Cell::Count(self));
    }
}

impl Cells for usize {
    fn fill(self, table: &mut Table) {
        table.push(Cell::Count(self as u64));
    }
}

/// As many cells as the quantity has columns.
impl Cells for Estimate {
    fn fill(self, table: &mut Table) {
        self.value.fill(table);
        for (role, value) in [
            (Role::StandardError, self.standard_error),
            (Role::Theory, self.theory),
            (Role::TheoryError, self.theory_error),
        ] {
            let at = table.rows.last().map_or(0, Vec::len);
            if table.columns.get(at).map(|column| column.role) == Some(role) {
                value.fill(table);
            }
        }
    }
}

impl<T: Cells> Cells for Vec<T> {
    fn fill(self, table: &mut Table) {
        for cells in self {
            cells.fill(table);
        }
    }
}

impl<T: Cells, const N: usize> Cells for [T; N] {
    fn fill(self, table: &mut Table) {
        for cells in self {
            cells.fill(table);
        }
    }
}

impl Cells for () {
    fn fill(self, _table: &mut Table) {}
}

macro_rules! cells_of_tuples {
    ($($name:ident)*) => {
        impl<$($name: Cells),*> Cells for ($($name,)*) {
            #[allow(non_snake_case, reason = "one name for a type and its value")]
            fn fill(self, table: &mut Table) {
                let ($($name,)*) = self;
                $($name.fill(table);)*
            }
        }
    };
}
cells_of_tuples!(A B);
cells_of_tuples!(A B C);
cells_of_tuples!(A B C D);
cells_of_tuples!(A B C D E);
cells_of_tuples!(A B C D E F);
cells_of_tuples!(A B C D E F G);
cells_of_tuples!(A B C D E F G H);

/// A table without rows, described line by line: what a column is, which is the method of [`Table`] that adds it, its name,
/// its unit, and its meaning.
#[macro_export]
macro_rules! table {
    ($name:expr, $about:expr; $($role:ident $column:expr, $unit:expr, $meaning:expr;)*) => {
        $crate::Table::new($name, $about)$(.$role($column, $unit, $meaning))*
    };
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

    /// The key columns that tell curves apart.
    #[must_use]
    pub fn by(self, columns: &[&'static str]) -> Self {
        let curves = columns.iter().map(|&name| name.into()).collect();
        Self { curves, ..self }
    }

    /// The key columns of which each value has a panel.
    #[must_use]
    pub fn panels(self, columns: &[&'static str]) -> Self {
        let panels = columns.iter().map(|&name| name.into()).collect();
        Self { panels, ..self }
    }

    /// A sentence or two below it.
    #[must_use]
    pub fn caption(self, caption: &'static str) -> Self {
        let caption = caption.into();
        Self { caption, ..self }
    }

    /// How points are drawn.
    #[must_use]
    pub fn mark(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }

    /// Adds a line that is no data.
    #[must_use]
    pub fn line(mut self, label: &'static str, y: f64) -> Self {
        let label = label.into();
        self.lines.push(Line { label, y });
        self
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
