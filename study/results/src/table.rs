//! Tables of results: descriptions of columns and figures, and rows of cells.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// Text of a table description: known at compile time, or read back from a manifest.
type Text = Cow<'static, str>;

/// Name of the folder of drawings inside the results folder of a run.
pub const FIGURES: &str = "figures";

/// Table of a results folder: described columns, rows and figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the table, and of its file without the ending `.csv`.
    pub name: Text,
    /// Content of the table in one sentence.
    pub about: Text,
    /// Columns of the table.
    pub columns: Vec<TableColumn>,
    /// Rows, each with one cell for each column.
    pub rows: Vec<Vec<TableCell>>,
    /// Figures of the table; empty for tables that are not drawn.
    pub figures: Vec<Figure>,
}

/// Column of a table: name, unit, meaning and role.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableColumn {
    /// Name of the column in the header line of the file.
    pub name: Text,
    /// Unit of the numbers; `1` for pure numbers, empty for words.
    pub unit: Text,
    /// Meaning of the column, in words.
    pub meaning: Text,
    /// Role of the column, such as key, value or standard error.
    pub role: Role,
}

/// Role of a table column, such as key, value or error of the value before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Key that identifies a row: an engine, a time, a species.
    Key,
    /// Measured quantity (value).
    Value,
    /// Standard error of the value in the column before it.
    StandardError,
    /// Theoretical value of the value column before it.
    Theory,
    /// Error of the theoretical value in the column before it.
    TheoryError,
    /// Count or remark next to the measured quantities.
    Note,
}

/// Cell of a table row: text, number, count, or empty.
#[derive(Clone, Debug, PartialEq)]
pub enum TableCell {
    /// Text of a text column.
    Text(String),
    /// Floating-point number; a number that is not finite is written as an empty cell.
    Number(f64),
    /// Whole number, such as a count.
    Count(u64),
    /// Empty cell: no value is known.
    Empty,
}

/// Measured quantity with its error and its theory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableEstimate {
    /// Measured value; `None` if it is unknown.
    pub value: Option<f64>,
    /// Standard error of the measured value; `None` if it is unknown.
    pub standard_error: Option<f64>,
    /// Number of replicas behind the standard error; `None` if the error is known otherwise.
    pub replicas: Option<usize>,
    /// Theoretical value; `None` if there is none.
    pub theory: Option<f64>,
    /// Error of the theoretical value; `None` if there is none.
    pub theory_error: Option<f64>,
}

impl TableEstimate {
    /// Creates an estimate without theory from a value and its standard error.
    pub fn with_error(value: f64, standard_error: Option<f64>) -> Self {
        Self {
            value: Some(value),
            standard_error,
            ..Self::default()
        }
    }

    /// Sets the theoretical value of the estimate.
    #[must_use]
    pub fn against(self, theory: Option<f64>) -> Self {
        Self { theory, ..self }
    }

    /// Converts the estimate to another unit: multiplies value, errors and theory by `unit`, the
    /// size of the old unit in the new one.
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

/// Description of a figure that is drawn from the columns of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Title of the figure.
    pub title: Text,
    /// Caption: a sentence or two below the figure.
    pub caption: Text,
    /// Column and scale of the figure's horizontal axis.
    pub x: FigureAxis,
    /// Column and scale of the figure's vertical axis.
    pub y: FigureAxis,
    /// Key columns that distinguish the curves, such as `engine`.
    pub curves: Vec<Text>,
    /// Key columns for each value of which there is one panel, such as a time window.
    pub panels: Vec<Text>,
    /// Style in which data points are drawn.
    pub mark: PointMark,
    /// Reference lines, such as a law or the value under molecular chaos.
    pub lines: Vec<ReferenceLine>,
    /// Colour axis of a map; `None` for the first value column.
    #[serde(default)]
    pub colour: Option<FigureAxis>,
}

/// Column along the horizontal or vertical axis of a figure, with label and scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FigureAxis {
    /// Name of the column along the axis.
    pub column: Text,
    /// Label of the axis, with symbol and unit.
    pub label: Text,
    /// Scale of the axis: linear or logarithmic.
    pub scale: AxisScale,
}

/// Scale of an axis or of colours: linear or logarithmic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AxisScale {
    /// Linear scale: equal steps of the value.
    Linear,
    /// Logarithmic scale: equal factors of the value.
    Logarithmic,
}

/// Style of the points of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PointMark {
    /// Points with error bars, joined by a line; theory is a dashed line.
    Line,
    /// Points with error bars, not joined.
    Points,
    /// Bars of a histogram, from the column of the x axis to the next column.
    Bars,
    /// Map over the plane: x and y are positions, colours are [`Figure::colour`].
    Map,
}

/// Horizontal reference line of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceLine {
    /// Label of the reference line.
    pub label: Text,
    /// Ordinate of the reference line.
    pub y: f64,
}

impl Table {
    /// Creates a table without columns and rows.
    pub fn new(name: &'static str, about: &'static str) -> Self {
        Self {
            name: name.into(),
            about: about.into(),
            columns: Vec::new(),
            rows: Vec::new(),
            figures: Vec::new(),
        }
    }

    /// Adds a key column to the table, such as an engine or a time.
    #[must_use]
    pub fn key(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Key)
    }

    /// Adds a column of counts or remarks to the table.
    #[must_use]
    pub fn note(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Note)
    }

    /// Adds a value column to the table, without error and theory.
    #[must_use]
    pub fn value(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Value)
    }

    /// Adds a value column and the column of its standard error to the table, `NAME` and `NAME_se`.
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

    /// Adds columns to the table: a value, its standard error and its theory `NAME_theory`.
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

    /// Adds columns to the table: a value, its standard error, its theory, and the error of the
    /// theory `NAME_theory_error`.
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

    /// Adds a column to the table with the theory of the value column before it.
    #[must_use]
    pub fn theory(self, name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        self.column(name.into(), unit, meaning, Role::Theory)
    }

    fn column(mut self, name: Text, unit: &'static str, meaning: &'static str, role: Role) -> Self {
        self.columns.push(TableColumn {
            name,
            unit: unit.into(),
            meaning: meaning.into(),
            role,
        });
        self
    }

    /// Adds the description of a figure to the table.
    #[must_use]
    pub fn figure(mut self, figure: Figure) -> Self {
        self.figures.push(figure);
        self
    }

    /// Adds a row to the table: one cell for each column, in order; an estimate fills all of its
    /// columns.
    pub fn add(&mut self, cells: impl CellValues) {
        self.rows.push(Vec::with_capacity(self.columns.len()));
        cells.fill_cells(self);
    }

    fn push(&mut self, cell: TableCell) {
        if let Some(row) = self.rows.last_mut() {
            row.push(cell);
        }
    }

    /// Returns the names of the drawings of the table's figures inside a results folder:
    /// `figures/NAME.svg`, `figures/NAME-2.svg` and so on.
    pub fn drawings(&self) -> Vec<String> {
        let number = |figure: usize| match figure {
            1 => String::new(),
            more => format!("-{more}"),
        };
        (1..=self.figures.len())
            .map(|figure| format!("{FIGURES}/{}{}.svg", self.name, number(figure)))
            .collect()
    }

    /// Returns the position of the column with a given name; `None` if there is none.
    pub fn find_column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}

/// Values that can fill cells of the last row of a table, such as numbers, text and estimates.
pub trait CellValues {
    /// Fills the next cells of the last row of a table, in the order of the columns.
    fn fill_cells(self, table: &mut Table);
}

impl CellValues for TableCell {
    fn fill_cells(self, table: &mut Table) {
        table.push(self);
    }
}

impl CellValues for &str {
    fn fill_cells(self, table: &mut Table) {
        table.push(TableCell::Text(self.to_owned()));
    }
}

impl CellValues for String {
    fn fill_cells(self, table: &mut Table) {
        table.push(TableCell::Text(self));
    }
}

impl CellValues for f64 {
    fn fill_cells(self, table: &mut Table) {
        table.push(TableCell::Number(self));
    }
}

impl CellValues for Option<f64> {
    fn fill_cells(self, table: &mut Table) {
        table.push(self.map_or(TableCell::Empty, TableCell::Number));
    }
}

impl CellValues for u64 {
    fn fill_cells(self, table: &mut Table) {
        table.push(TableCell::Count(self));
    }
}

impl CellValues for usize {
    fn fill_cells(self, table: &mut Table) {
        table.push(TableCell::Count(self as u64));
    }
}

/// Fills as many cells as the quantity has columns.
impl CellValues for TableEstimate {
    fn fill_cells(self, table: &mut Table) {
        self.value.fill_cells(table);
        for (role, value) in [
            (Role::StandardError, self.standard_error),
            (Role::Theory, self.theory),
            (Role::TheoryError, self.theory_error),
        ] {
            let at = table.rows.last().map_or(0, Vec::len);
            if table.columns.get(at).map(|column| column.role) == Some(role) {
                value.fill_cells(table);
            }
        }
    }
}

impl<T: CellValues> CellValues for Vec<T> {
    fn fill_cells(self, table: &mut Table) {
        for cells in self {
            cells.fill_cells(table);
        }
    }
}

impl<T: CellValues, const N: usize> CellValues for [T; N] {
    fn fill_cells(self, table: &mut Table) {
        for cells in self {
            cells.fill_cells(table);
        }
    }
}

impl CellValues for () {
    fn fill_cells(self, _table: &mut Table) {}
}

macro_rules! cells_of_tuples {
    ($($name:ident)*) => {
        impl<$($name: CellValues),*> CellValues for ($($name,)*) {
            #[allow(non_snake_case, reason = "one name for a type and its value")]
            fn fill_cells(self, table: &mut Table) {
                let ($($name,)*) = self;
                $($name.fill_cells(table);)*
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

/// Creates a table without rows. Each column is given by the [`Table`] method that adds it, its
/// name, unit, and meaning.
#[macro_export]
macro_rules! table {
    ($name:expr, $about:expr; $($role:ident $column:expr, $unit:expr, $meaning:expr;)*) => {
        $crate::Table::new($name, $about)$(.$role($column, $unit, $meaning))*
    };
}

impl Figure {
    /// Creates a figure of curves, one for each engine, from the columns of its axes.
    pub fn curves(title: &'static str, x: FigureAxis, y: FigureAxis) -> Self {
        Self {
            title: title.into(),
            caption: "".into(),
            x,
            y,
            curves: vec!["engine".into()],
            panels: Vec::new(),
            mark: PointMark::Line,
            lines: Vec::new(),
            colour: None,
        }
    }

    /// Sets the key columns that distinguish the curves of the figure.
    #[must_use]
    pub fn by(self, columns: &[&'static str]) -> Self {
        let curves = columns.iter().map(|&name| name.into()).collect();
        Self { curves, ..self }
    }

    /// Sets the key columns for each value of which the figure has one panel.
    #[must_use]
    pub fn panels(self, columns: &[&'static str]) -> Self {
        let panels = columns.iter().map(|&name| name.into()).collect();
        Self { panels, ..self }
    }

    /// Sets the caption of the figure, a sentence or two.
    #[must_use]
    pub fn caption(self, caption: &'static str) -> Self {
        let caption = caption.into();
        Self { caption, ..self }
    }

    /// Sets the style in which the figure draws data points.
    #[must_use]
    pub fn mark(self, mark: PointMark) -> Self {
        Self { mark, ..self }
    }

    /// Adds a horizontal reference line to the figure.
    #[must_use]
    pub fn line(mut self, label: &'static str, y: f64) -> Self {
        let label = label.into();
        self.lines.push(ReferenceLine { label, y });
        self
    }
}

impl FigureAxis {
    /// Creates a linear axis for a column, with a label.
    pub fn linear(column: &'static str, label: &'static str) -> Self {
        Self {
            column: column.into(),
            label: label.into(),
            scale: AxisScale::Linear,
        }
    }

    /// Creates a logarithmic axis for a column, with a label.
    pub fn logarithmic(column: &'static str, label: &'static str) -> Self {
        Self {
            scale: AxisScale::Logarithmic,
            ..Self::linear(column, label)
        }
    }
}
