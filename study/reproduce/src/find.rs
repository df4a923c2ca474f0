//! Numbers in the tables of finished runs.

use std::path::Path;

use stosszahl_case::paper::{Errors, number};
use stosszahl_results::{Role, Stored, SweepPoint, Table, TableCell, TableColumn, TableEstimate};
use stosszahl_study::measures::mean_over_replicas;
use toml::Value;

use crate::ReproduceError;
use crate::number_location::{COLLISIONS, NumberLocation, NumberSource, SECONDS, same_name};

/// Name of the column that distinguishes replicas.
const REPLICA: &str = "replica";
/// Largest relative distance of a number from that of a row: times have three digits in words.
const NEAR: f64 = 4e-3;

/// Finished points of a run.
pub(crate) struct FinishedPoints(Vec<(SweepPoint, Stored)>);

impl FinishedPoints {
    /// Reads a results folder; points that are not finished are left out.
    pub(crate) fn read_folder(folder: &Path) -> Result<Self, ReproduceError> {
        Ok(Self(Stored::points(folder)?))
    }

    /// Finds a number with its error.
    ///
    /// # Errors
    /// The reason why there is none.
    pub(crate) fn find_number(&self, spot: &NumberLocation<'_>) -> Result<TableEstimate, String> {
        let point = self.0.iter().find(|point| point.0.name == spot.point);
        let (_, stored) =
            point.ok_or_else(|| format!("the point {} is not finished", spot.point))?;
        let (table, column) = match spot.source {
            NumberSource::Derived(name) => {
                return derived(stored, name)
                    .ok_or_else(|| format!("{name} does not follow from the case"));
            }
            NumberSource::Column(table, column) => (table, column),
        };
        let table = stored.tables.iter().find(|one| one.name == table);
        let table = table.ok_or("there is no such table")?;
        let column = table.find_column(column).ok_or("there is no such column")?;
        let rows = rows(table, spot)?;
        let found = estimates(table, column, &rows)?;
        let is_replica = |column: &TableColumn| column.name == REPLICA;
        let mut all = if table.columns.iter().any(is_replica) && !spot.keys.contains_key(REPLICA) {
            mean_over_replicas(found.iter().map(|one| one.value))
        } else {
            mean(&found, spot)?
        };
        all.replicas = (spot.errors == Errors::Replicas && all.standard_error != Some(0.0))
            .then(|| all.replicas.unwrap_or(stored.manifest.replicas as usize));
        Ok(all)
    }
}

/// Returns a quantity that follows from a case, or the work of its engines, over all of them and
/// all replicas.
fn derived(stored: &Stored, name: &str) -> Option<TableEstimate> {
    let engines = &stored.manifest.engines;
    let work = match name {
        SECONDS => engines.iter().map(|engine| engine.seconds).sum(),
        COLLISIONS => engines.iter().map(|engine| engine.collisions as f64).sum(),
        _ => {
            let mut all = stored.manifest.derived.iter();
            let found = all.find(|one| same_name(&one.name, name))?;
            return Some(TableEstimate::with_error(found.value, Some(0.0)));
        }
    };
    // Unknown fluctuation between runs.
    Some(TableEstimate::with_error(work, None))
}

/// Returns the rows whose key columns fit.
fn rows<'t>(table: &'t Table, spot: &NumberLocation<'_>) -> Result<Vec<&'t [TableCell]>, String> {
    let mut rows: Vec<&[TableCell]> = table.rows.iter().map(Vec::as_slice).collect();
    for (&key, value) in &spot.keys {
        let column = table
            .find_column(key)
            .ok_or_else(|| format!("there is no column {key}"))?;
        rows.retain(|row| fits(&row[column], value));
        if rows.is_empty() {
            return Err(format!(
                "the table {} has no row where {key} = {value}",
                table.name
            ));
        }
    }
    Ok(rows)
}

/// Returns true if a cell has the requested value.
fn fits(cell: &TableCell, value: &Value) -> bool {
    match (cell, value) {
        (TableCell::Text(text), Value::String(asked)) => text == asked,
        (TableCell::Text(text), Value::Integer(asked)) => *text == asked.to_string(),
        (_, Value::Array(ends)) => {
            let ends: Vec<f64> = ends.iter().filter_map(number).collect();
            matches!((cell.number(), &ends[..]), (Some(found), [from, to]) if (*from..=*to).contains(&found))
        }
        (cell, value) => {
            let both = cell.number().zip(number(value));
            both.is_some_and(|(found, asked)| (found - asked).abs() <= NEAR * asked.abs() + 1e-12)
        }
    }
}

/// Returns the numbers of some rows in a column, with the errors next to them.
fn estimates(
    table: &Table,
    column: usize,
    rows: &[&[TableCell]],
) -> Result<Vec<TableEstimate>, String> {
    let companion = |role: Role| {
        let next = table.columns.get(column + 1)?;
        (next.role == role).then_some(column + 1)
    };
    let is_theory = table.columns[column].role == Role::Theory;
    let error = companion(if is_theory {
        Role::TheoryError
    } else {
        Role::StandardError
    });
    let one = |row: &&[TableCell]| {
        let value = row[column].number();
        let value = value.ok_or_else(|| {
            format!(
                "{} of {} is empty there",
                table.columns[column].name, table.name
            )
        })?;
        let known = error.and_then(|error| row[error].number());
        // Error zero for a theory without an error column.
        Ok(TableEstimate::with_error(
            value,
            known.or(is_theory.then_some(0.0)),
        ))
    };
    rows.iter().map(one).collect()
}

/// Returns the value of the only row found, or the mean over the rows if the keys give a range. The
/// errors of rows count as independent.
fn mean(found: &[TableEstimate], spot: &NumberLocation<'_>) -> Result<TableEstimate, String> {
    let is_range = spot.keys.values().any(Value::is_array);
    match found {
        [one] => Ok(*one),
        several if is_range => {
            let count = several.len() as f64;
            let sum: f64 = several.iter().filter_map(|one| one.value).sum();
            let squares = several
                .iter()
                .map(|one| one.standard_error.map(|error| error.powi(2)));
            let square: Option<f64> = squares.sum();
            Ok(TableEstimate::with_error(
                sum / count,
                square.map(|square| square.sqrt() / count),
            ))
        }
        several => Err(format!(
            "{} rows fit, and where should choose one",
            several.len()
        )),
    }
}

/// Divides two numbers with independent errors. If the key grows by the factor `growth`, returns
/// the exponent of the power law instead.
pub(crate) fn quotient(a: &TableEstimate, b: &TableEstimate, growth: Option<f64>) -> TableEstimate {
    let [x, y] = [a, b].map(|one| one.value.unwrap_or(f64::NAN));
    let errors = a.standard_error.zip(b.standard_error);
    let share = errors.map(|(a, b)| (a / x).hypot(b / y).abs());
    let (value, error) = match growth {
        None => (x / y, share.map(|share| share * (x / y).abs())),
        Some(growth) => {
            let by = growth.ln();
            ((x / y).ln() / by, share.map(|share| (share / by).abs()))
        }
    };
    TableEstimate {
        replicas: [a.replicas, b.replicas].into_iter().flatten().min(),
        ..TableEstimate::with_error(value, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_and_powers_carry_both_errors() {
        let a = TableEstimate::with_error(8.0, Some(0.08));
        let b = TableEstimate::with_error(2.0, Some(0.04));
        let share = 0.01_f64.hypot(0.02);
        let found = quotient(&a, &b, None);
        assert_eq!(found.value, Some(4.0));
        // Rounding of a few operations.
        assert!((found.standard_error.unwrap_or(0.0) - 4.0 * share).abs() < 1e-14);
        let found = quotient(&a, &b, Some(4.0));
        assert!((found.value.unwrap_or(0.0) - 1.0).abs() < 1e-14);
        assert!((found.standard_error.unwrap_or(0.0) - share / 4.0_f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn replicas_give_mean_and_error() {
        let all = [1.0, 2.0, 3.0].map(Some);
        let found = mean_over_replicas(all);
        assert_eq!((found.value, found.replicas), (Some(2.0), Some(3)));
        // Spread of the numbers: one.
        assert!((found.standard_error.unwrap_or(0.0) - 1.0 / 3.0_f64.sqrt()).abs() < 1e-14);
        assert_eq!(mean_over_replicas([Some(1.0)]).standard_error, None);
    }
}
