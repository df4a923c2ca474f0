//! CSV files of tables: numbers in the shortest form that reads back exactly, empty cells where
//! nothing is known.
//!
//! Words that spreadsheets would take for a formula, beginning with `=`, `+`, `-` or `@`, are
//! written behind an apostrophe, which spreadsheets do not show; numbers stay numbers.
//!
//! A column with a unit (`1` for pure numbers) holds numbers, one without holds words. Numbers with
//! a point or an exponent are read as numbers, all others as counts. So a table that is written and
//! read back is unchanged, except for non-finite numbers and empty words, which become empty cells.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, WriterBuilder};
use serde::{Serialize, Serializer};

use crate::error::ResultsError;
use crate::table::{Table, TableCell, TableColumn};

impl Serialize for TableCell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) if is_formula(text) => serializer.serialize_str(&format!("'{text}")),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Number(number) if number.is_finite() => serializer.serialize_f64(*number),
            Self::Count(count) => serializer.serialize_u64(*count),
            Self::Number(_) | Self::Empty => serializer.serialize_none(),
        }
    }
}

impl TableCell {
    /// Returns the number in the cell; `None` for words, empty cells and numbers that are not
    /// finite.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number).filter(|number| number.is_finite()),
            Self::Count(count) => Some(*count as f64),
            Self::Text(_) | Self::Empty => None,
        }
    }

    fn read(text: &str, column: &TableColumn) -> Option<Self> {
        if text.is_empty() {
            return Some(Self::Empty);
        }
        if column.unit.is_empty() {
            let inner = text.strip_prefix('\'').filter(|inner| is_formula(inner));
            return Some(Self::Text(inner.unwrap_or(text).to_owned()));
        }
        let number = || text.parse().ok().filter(|number: &f64| number.is_finite());
        let count = text.parse().ok().map(Self::Count);
        count.or_else(|| number().map(Self::Number))
    }
}

/// Returns true if a spreadsheet would take text for a formula, as it is or after an apostrophe is
/// removed.
fn is_formula(text: &str) -> bool {
    let begin = text.trim_start_matches('\'');
    begin.starts_with(['=', '+', '-', '@', '\t', '\r'])
}

impl Table {
    /// Returns the name of the table's CSV file.
    pub fn file(&self) -> String {
        format!("{}.csv", self.name)
    }

    /// Formats the table as CSV: a line of names, and one line for each row.
    ///
    /// # Errors
    /// [`ResultsError`] if a row has more or fewer cells than the table has columns, or a column
    /// with a unit holds words. Both are errors of the program.
    pub fn to_csv(&self) -> Result<Vec<u8>, ResultsError> {
        self.check()?;
        let write = || -> Result<Vec<u8>, csv::Error> {
            let mut writer = WriterBuilder::new().has_headers(false).from_writer(vec![]);
            writer.write_record(self.columns.iter().map(|column| &*column.name))?;
            for row in &self.rows {
                writer.serialize(row)?;
            }
            let bytes = writer.into_inner();
            bytes.map_err(|error| error.into_error().into())
        };
        write().map_err(|error| csv_error(Path::new(&self.file()), &error))
    }

    /// Checks that every row has one cell for each column, and that columns with a unit hold no
    /// words; either is an error of the program.
    pub(crate) fn check(&self) -> Result<(), ResultsError> {
        let path = || self.file().into();
        for (row, line) in self.rows.iter().zip(2..) {
            if row.len() != self.columns.len() {
                return Err(ResultsError::Length {
                    path: path(),
                    line,
                    what: "cells",
                    found: row.len() as u64,
                    expected: self.columns.len() as u64,
                });
            }
            for (cell, column) in row.iter().zip(&self.columns) {
                if let (TableCell::Text(text), false) = (cell, column.unit.is_empty()) {
                    return Err(ResultsError::Cell {
                        path: path(),
                        line,
                        column: column.name.to_string(),
                        found: text.clone(),
                        expected: "a number, for the column has a unit",
                    });
                }
            }
        }
        Ok(())
    }

    /// Reads the rows of this table, which has columns but no rows yet, from a CSV file.
    ///
    /// # Errors
    /// [`ResultsError`] if the file cannot be read, has other columns, or a cell is not of its
    /// column.
    pub fn read_rows(&mut self, path: &Path) -> Result<(), ResultsError> {
        let mut reader = ReaderBuilder::new()
            .flexible(true)
            .from_path(path)
            .map_err(|error| csv_error(path, &error))?;
        let header = reader.headers().map_err(|error| csv_error(path, &error))?;
        let expected = self.columns.iter().map(|column| &*column.name);
        if header.iter().ne(expected.clone()) {
            return Err(ResultsError::Columns {
                path: path.to_owned(),
                found: header.iter().map(str::to_owned).collect(),
                expected: expected.map(str::to_owned).collect(),
            });
        }
        let mut record = StringRecord::new();
        while (reader.read_record(&mut record)).map_err(|error| csv_error(path, &error))? {
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != self.columns.len() {
                return Err(ResultsError::Length {
                    path: path.to_owned(),
                    line,
                    what: "cells",
                    found: record.len() as u64,
                    expected: self.columns.len() as u64,
                });
            }
            let cells = record.iter().zip(&self.columns).map(|(text, column)| {
                TableCell::read(text, column).ok_or_else(|| ResultsError::Cell {
                    path: path.to_owned(),
                    line,
                    column: column.name.to_string(),
                    found: text.chars().take(80).collect(),
                    expected: "a finite number",
                })
            });
            self.rows.push(cells.collect::<Result<_, _>>()?);
        }
        Ok(())
    }
}

/// Converts an error of the CSV parser to an error of results, with its position.
fn csv_error(path: &Path, error: &csv::Error) -> ResultsError {
    let line = error.position().map_or(0, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::Utf8 { .. } => ResultsError::Cell {
            path: path.to_owned(),
            line,
            column: "unknown".into(),
            found: "bytes that are not UTF-8".into(),
            expected: "text",
        },
        csv::ErrorKind::Io(source) => ResultsError::System {
            path: path.to_owned(),
            action: "read",
            source: std::io::Error::new(source.kind(), source.to_string()),
        },
        other => ResultsError::System {
            path: path.to_owned(),
            action: "read",
            source: std::io::Error::other(format!("{other:?}")),
        },
    }
}
