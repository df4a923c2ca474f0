//! Table columns that exist only if the gas has the quantity, each with the function that computes
//! its cells.

use stosszahl_results::{Table, TableEstimate};

/// Method of a table that appends a column with its name, unit and description, and columns for its
/// errors.
pub(super) type AddColumn = fn(Table, &'static str, &'static str, &'static str) -> Table;

/// Table column with its name, unit and description, filled from rows of type `R`.
struct RowColumn<R> {
    /// Method that appends the column to a table, with or without columns for error and theory.
    add: AddColumn,
    /// Name of the table column, its unit, and its description for users.
    words: [&'static str; 3],
    /// Function that returns the column's value, error and theory from a row.
    value: fn(&R) -> TableEstimate,
}

/// Columns of a table that is filled from rows of type `R`, in order.
pub(super) struct RowColumns<R>(Vec<RowColumn<R>>);

impl<R> RowColumns<R> {
    /// Creates an empty list of columns.
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    /// Appends a column if it is used: the method that adds it to a table, its name, unit and
    /// description, and the function that computes its cells from a row.
    pub(super) fn column(
        &mut self,
        used: bool,
        add: AddColumn,
        words: [&'static str; 3],
        value: fn(&R) -> TableEstimate,
    ) {
        self.0
            .extend(used.then_some(RowColumn { add, words, value }));
    }

    /// Appends the columns to a table.
    pub(super) fn add_to(&self, table: Table) -> Table {
        self.0.iter().fold(table, |table, column| {
            let [name, unit, meaning] = column.words;
            (column.add)(table, name, unit, meaning)
        })
    }

    /// Returns the values of one row in the order of the columns.
    pub(super) fn estimates(&self, row: &R) -> Vec<TableEstimate> {
        let columns = self.0.iter();
        columns.map(|column| (column.value)(row)).collect()
    }
}
