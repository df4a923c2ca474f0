//! Lookup of numbers in finished runs: sweep points by name, table rows by their keys, values with
//! standard errors.

use std::fmt;
use std::path::Path;

use crate::error::ResultsError;
use crate::manifest::{Stored, SweepPoint};
use crate::table::{Role, Table, TableCell, TableEstimate};

/// Largest relative difference at which a table's number equals a requested one. Times in the text
/// of tables have only three digits.
const NEAR: f64 = 4e-3;

/// Error of a number that is absent from the results, with the reason as text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NumberNotFound(String);

/// Condition that selects table rows by the cell in one key column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyCondition<'a> {
    /// Condition that the cell holds this text.
    Is(&'a str),
    /// Condition that the cell holds this number, within rounding to three digits.
    At(f64),
    /// Condition that the cell's number lies in a closed range.
    Within([f64; 2]),
}

impl KeyCondition<'_> {
    fn fits(self, cell: &TableCell) -> bool {
        match (self, cell) {
            (Self::Is(word), TableCell::Text(text)) => word == text,
            (Self::At(at), TableCell::Text(text)) => text.parse() == Ok(at),
            (Self::At(at), cell) => cell
                .number()
                .is_some_and(|found| (found - at).abs() <= NEAR * at.abs() + 1e-12),
            (Self::Within([from, to]), cell) => cell
                .number()
                .is_some_and(|found| (from..=to).contains(&found)),
            (Self::Is(_), _) => false,
        }
    }
}

impl fmt::Display for KeyCondition<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Is(word) => write!(out, "{word:?}"),
            Self::At(at) => write!(out, "{at}"),
            Self::Within(ends) => write!(out, "{ends:?}"),
        }
    }
}

/// Name of a key column, with the condition on its cell.
pub type RowKey<'a> = (&'a str, KeyCondition<'a>);

/// One row of a result table, with access to its cells by column name.
#[derive(Clone, Copy, Debug)]
pub struct TableRow<'a> {
    table: &'a Table,
    cells: &'a [TableCell],
}

impl Table {
    /// Returns all rows of the table, in order.
    pub fn all_rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        let row = |cells| TableRow { table: self, cells };
        self.rows.iter().map(Vec::as_slice).map(row)
    }

    /// Finds the table rows whose cells meet all key conditions.
    ///
    /// # Errors
    /// [`NumberNotFound`] if a column is absent, or no row is left.
    pub fn find_rows(&self, keys: &[RowKey<'_>]) -> Result<Vec<TableRow<'_>>, NumberNotFound> {
        let mut rows: Vec<_> = self.all_rows().collect();
        for (key, condition) in keys {
            let column = self.known_column(key)?;
            rows.retain(|row| condition.fits(&row.cells[column]));
            if rows.is_empty() {
                let text = format!(
                    "the table {} has no row where {key} = {condition}",
                    self.name
                );
                return Err(NumberNotFound(text));
            }
        }
        Ok(rows)
    }

    fn known_column(&self, name: &str) -> Result<usize, NumberNotFound> {
        let missing = || NumberNotFound(format!("the table {} has no column {name}", self.name));
        self.find_column(name).ok_or_else(missing)
    }
}

impl<'a> TableRow<'a> {
    /// Returns the cells of the row, in the order of the columns.
    pub fn cells(&self) -> &'a [TableCell] {
        self.cells
    }

    fn empty(&self, column: &str) -> NumberNotFound {
        NumberNotFound(format!("{column} of {} is empty there", self.table.name))
    }

    /// Returns the number in a named column of the row.
    ///
    /// # Errors
    /// [`NumberNotFound`] if the column is absent, or its cell has no number.
    pub fn number(&self, column: &str) -> Result<f64, NumberNotFound> {
        let place = self.table.known_column(column)?;
        let number = self.cells[place].number();
        number.ok_or_else(|| self.empty(column))
    }

    /// Returns the text in a named column of the row; empty for an empty cell.
    ///
    /// # Errors
    /// [`NumberNotFound`] if the column is absent, or its cell has a number.
    pub fn words(&self, column: &str) -> Result<&'a str, NumberNotFound> {
        match &self.cells[self.table.known_column(column)?] {
            TableCell::Text(text) => Ok(text),
            TableCell::Empty => Ok(""),
            _ => Err(self.empty(column)),
        }
    }

    /// Returns the number in a named column of the row, with the standard error in the column next
    /// to it. Without an error column, the error is zero for theory and absent otherwise.
    ///
    /// # Errors
    /// As [`TableRow::number`].
    pub fn estimate(&self, column: &str) -> Result<TableEstimate, NumberNotFound> {
        let (value, place) = (self.number(column)?, self.table.known_column(column)?);
        let is_theory = self.table.columns[place].role == Role::Theory;
        let role = if is_theory {
            Role::TheoryError
        } else {
            Role::StandardError
        };
        let next = self.table.columns.get(place + 1);
        let error = next.filter(|next| next.role == role);
        let error = error.and_then(|_| self.cells[place + 1].number());
        let error = error.or(is_theory.then_some(0.0));
        Ok(TableEstimate::with_error(value, error))
    }

    /// Returns the number in a named column of the row with its standard error, which must exist.
    ///
    /// # Errors
    /// [`NumberNotFound`] if one of them is absent.
    pub fn measured(&self, column: &str) -> Result<TableEstimate, NumberNotFound> {
        let error = self.number(&format!("{column}_se"))?;
        Ok(TableEstimate::with_error(self.number(column)?, Some(error)))
    }
}

impl Stored {
    /// Finds a result table of a point by its name.
    ///
    /// # Errors
    /// [`NumberNotFound`] if there is none.
    pub fn table(&self, name: &str) -> Result<&Table, NumberNotFound> {
        let found = self.tables.iter().find(|table| table.name == name);
        found.ok_or_else(|| NumberNotFound(format!("there is no table {name}")))
    }
}

/// Finished points of a run's sweep, each with its stored results.
#[derive(Debug)]
pub struct FinishedPoints(pub Vec<(SweepPoint, Stored)>);

impl FinishedPoints {
    /// Reads the results folder of a run; unfinished points are left out.
    ///
    /// # Errors
    /// As [`Stored::read`].
    pub fn read_folder(folder: &Path) -> Result<Self, ResultsError> {
        Ok(Self(Stored::points(folder)?))
    }

    /// Returns the names of the finished points of the sweep.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|point| &*point.0.name)
    }

    /// Finds a finished sweep point by its name. A run without a sweep has one point with an empty
    /// name.
    ///
    /// # Errors
    /// [`NumberNotFound`] if it is not finished.
    pub fn point(&self, name: &str) -> Result<&(SweepPoint, Stored), NumberNotFound> {
        let found = self.0.iter().find(|point| point.0.name == name);
        found.ok_or_else(|| NumberNotFound(format!("the point {name} is not finished")))
    }

    /// Returns the numeric value of a swept key at a point of the sweep.
    ///
    /// # Errors
    /// [`NumberNotFound`] if there is none.
    pub fn setting(&self, point: &str, key: &str) -> Result<f64, NumberNotFound> {
        let value = self.point(point)?.0.values.get(key);
        let number = value.and_then(serde_json::Value::as_f64);
        number.ok_or_else(|| NumberNotFound(format!("the point {point} sets no number {key}")))
    }

    /// Finds the rows of a table at a sweep point that meet all key conditions.
    ///
    /// # Errors
    /// As [`Table::find_rows`], or the table is absent.
    pub fn rows(
        &self,
        point: &str,
        table: &str,
        keys: &[RowKey<'_>],
    ) -> Result<Vec<TableRow<'_>>, NumberNotFound> {
        self.point(point)?.1.table(table)?.find_rows(keys)
    }

    /// Finds the only row of a table at a sweep point that meets all key conditions.
    ///
    /// # Errors
    /// As [`FinishedPoints::rows`], or several rows fit.
    pub fn row(
        &self,
        point: &str,
        table: &str,
        keys: &[RowKey<'_>],
    ) -> Result<TableRow<'_>, NumberNotFound> {
        match self.rows(point, table, keys)?[..] {
            [row] => Ok(row),
            ref rows => {
                let count = rows.len();
                let text = format!("{count} rows of {table} fit {keys:?}, not one");
                Err(NumberNotFound(text))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::KeyCondition::{At, Is, Within};
    use super::*;

    fn table() -> Table {
        let mut table = crate::table! {
            "energy", "Energies.";
            key "engine", "", "Engine";
            key "time", "t0", "Time";
            with_theory "energy", "1", "Energy";
        };
        for (engine, time) in [("ed", 0.1), ("ed", 1.0), ("dsmc", 1.0)] {
            let found = TableEstimate::with_error(2.0 * time, Some(0.5)).against(Some(time));
            table.add((engine, time, found));
        }
        table
    }

    #[test]
    fn rows_are_found_by_words_numbers_and_ranges() {
        let table = table();
        let count = |keys: &[RowKey<'_>]| table.find_rows(keys).map(|rows| rows.len());
        assert_eq!(count(&[("engine", Is("ed"))]), Ok(2));
        assert_eq!(count(&[("engine", Is("ed")), ("time", At(1.003))]), Ok(1));
        assert_eq!(count(&[("time", Within([0.05, 0.5]))]), Ok(1));
        let said = |keys: &[RowKey<'_>]| count(keys).expect_err("nothing fits").to_string();
        assert_eq!(
            said(&[("time", At(1.005))]),
            "the table energy has no row where time = 1.005"
        );
        assert_eq!(
            said(&[("place", At(1.0))]),
            "the table energy has no column place"
        );
    }

    #[test]
    fn numbers_have_the_errors_next_to_them() {
        let table = table();
        let row = table.find_rows(&[("engine", Is("dsmc"))]).expect("a row")[0];
        assert_eq!(row.words("engine"), Ok("dsmc"));
        let found = TableEstimate::with_error(2.0, Some(0.5));
        assert_eq!(row.estimate("energy"), Ok(found));
        assert_eq!(row.measured("energy"), Ok(found));
        let theory = TableEstimate::with_error(1.0, Some(0.0));
        assert_eq!(row.estimate("energy_theory"), Ok(theory));
        assert!(
            row.estimate("time")
                .is_ok_and(|time| time.standard_error.is_none())
        );
        assert!(row.measured("time").is_err() && row.number("engine").is_err());
    }
}
