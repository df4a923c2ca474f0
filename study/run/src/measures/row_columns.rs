//! Columns of a table that depend on what the gas has: each with the estimate that fills it.

use stosszahl_results::{Table, TableEstimate};

/// Method of a table that adds a column with its errors, by name, unit and meaning.
pub(super) type AddColumn = fn(Table, &'static str, &'static str, &'static str) -> Table;

/// Column of a table, filled from rows of type `R`.
pub(super) struct RowColumn<R> {
    /// Method that adds the column, which decides whether it has an error and a theory.
    pub add: AddColumn,
    /// Name of the column.
    pub name: &'static str,
    /// Unit of its numbers.
    pub unit: &'static str,
    /// Meaning of the column, in words.
    pub meaning: &'static str,
    /// Function that picks the estimate from a row.
    pub value: fn(&R) -> TableEstimate,
}

/// Adds columns to a table.
pub(super) fn add_columns<R>(table: Table, columns: &[RowColumn<R>]) -> Table {
    columns.iter().fold(table, |table, one| {
        (one.add)(table, one.name, one.unit, one.meaning)
    })
}

/// Returns the estimates of a row, in the order of the columns.
pub(super) fn estimates<R>(columns: &[RowColumn<R>], row: &R) -> Vec<TableEstimate> {
    columns.iter().map(|column| (column.value)(row)).collect()
}
