//! Numbers in finished runs: points of a sweep, rows by their keys, values with their errors.

use std::fmt;
use std::path::Path;

use crate::error::ResultsError;
use crate::manifest::{Stored, SweepPoint};
use crate::table::{Role, Table, TableCell, TableEstimate};

/// Largest relative distance of a number from that of a row: times have three digits in words.
const NEAR: f64 = 4e-3;

/// Error of a number that the results do not have, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NumberNotFound(String);

/// Condition on a cell of a key column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyCondition<'a> {
    /// Word that the cell holds.
    Is(&'a str),
    /// Number that the cell holds, up to rounding and to the three digits of a time.
    At(f64),
    /// Closed range of the number.
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

/// Key column, with the condition on its cell.
pub type RowKey<'a> = (&'a str, KeyCondition<'a>);

/// Row of a table.
#[derive(Clone, Copy, Debug)]
pub struct TableRow<'a> {
    table: &'a Table,
    cells: &'a [TableCell],
}

impl Table {
    /// Returns all rows.
    pub fn all_rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        let row = |cells| TableRow { table: self, cells };
        self.rows.iter().map(Vec::as_slice).map(row)
    }

    /// Finds the rows whose cells meet all conditions.
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
    /// Cells of the row, in the order of the columns.
    pub fn cells(&self) -> &'a [TableCell] {
        self.cells
    }

    fn empty(&self, column: &str) -> NumberNotFound {
        NumberNotFound(format!("{column} of {} is empty there", self.table.name))
    }

    /// Returns the number in a column.
    ///
    /// # Errors
    /// [`NumberNotFound`] if the column is absent, or its cell has no number.
    pub fn number(&self, column: &str) -> Result<f64, NumberNotFound> {
        let place = self.table.known_column(column)?;
        let number = self.cells[place].number();
        number.ok_or_else(|| self.empty(column))
    }

    /// Returns the words in a column; empty for an empty cell.
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

    /// Returns the number in a column with the error in the column next to it, if there is one. A
    /// theory without an error column has the error zero.
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

    /// Returns the number in a column with its standard error.
    ///
    /// # Errors
    /// [`NumberNotFound`] if one of them is absent.
    pub fn measured(&self, column: &str) -> Result<TableEstimate, NumberNotFound> {
        let error = self.number(&format!("{column}_se"))?;
        Ok(TableEstimate::with_error(self.number(column)?, Some(error)))
    }
}

impl Stored {
    /// Finds a table by its name.
    ///
    /// # Errors
    /// [`NumberNotFound`] if there is none.
    pub fn table(&self, name: &str) -> Result<&Table, NumberNotFound> {
        let found = self.tables.iter().find(|table| table.name == name);
        found.ok_or_else(|| NumberNotFound(format!("there is no table {name}")))
    }
}

/// Finished points of a run.
#[derive(Debug)]
pub struct FinishedPoints(pub Vec<(SweepPoint, Stored)>);

impl FinishedPoints {
    /// Reads a results folder; points that are not finished are left out.
    ///
    /// # Errors
    /// As [`Stored::read`].
    pub fn read_folder(folder: &Path) -> Result<Self, ResultsError> {
        Ok(Self(Stored::points(folder)?))
    }

    /// Names of the points.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|point| &*point.0.name)
    }

    /// Finds a point by its name; a run without a sweep has one without a name.
    ///
    /// # Errors
    /// [`NumberNotFound`] if it is not finished.
    pub fn point(&self, name: &str) -> Result<&(SweepPoint, Stored), NumberNotFound> {
        let found = self.0.iter().find(|point| point.0.name == name);
        found.ok_or_else(|| NumberNotFound(format!("the point {name} is not finished")))
    }

    /// Returns the number that a point of the sweep sets a key to.
    ///
    /// # Errors
    /// [`NumberNotFound`] if there is none.
    pub fn setting(&self, point: &str, key: &str) -> Result<f64, NumberNotFound> {
        let value = self.point(point)?.0.values.get(key);
        let number = value.and_then(serde_json::Value::as_f64);
        number.ok_or_else(|| NumberNotFound(format!("the point {point} sets no number {key}")))
    }

    /// Finds the rows of a table of a point whose cells meet all conditions.
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

    /// Finds the only row of a table of a point whose cells meet all conditions.
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
