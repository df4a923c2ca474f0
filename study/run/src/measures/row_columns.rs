//! Table columns that exist only if the gas has the quantity, each with the function that computes
//! its cells.

use stosszahl_results::{Table, TableEstimate};

/// Method of a table that appends a column with its name, unit and description, and columns for its
/// errors.
pub(super) type AddColumn = fn(Table, &'static str, &'static str, &'static str) -> Table;

/// Table column with its name, unit and description, filled from rows of type `R`.
pub(super) struct RowColumn<R> {
    /// Method that appends the column to a table, with or without columns for error and theory.
    pub add: AddColumn,
    /// Name of the table column.
    pub name: &'static str,
    /// Unit of the numbers in the table column.
    pub unit: &'static str,
    /// Description of the table column, as shown to users.
    pub meaning: &'static str,
    /// Function that returns the column's value, error and theory from a row.
    pub value: fn(&R) -> TableEstimate,
}

/// Appends the columns to a table, in order.
pub(super) fn add_columns<R>(table: Table, columns: &[RowColumn<R>]) -> Table {
    columns.iter().fold(table, |table, one| {
        (one.add)(table, one.name, one.unit, one.meaning)
    })
}

/// Returns the values of one row in the order of the columns.
pub(super) fn estimates<R>(columns: &[RowColumn<R>], row: &R) -> Vec<TableEstimate> {
    columns.iter().map(|column| (column.value)(row)).collect()
}
