//! Looks up the numbers that the claims of a paper name in the result tables of finished runs.

use std::array;

use stosszahl_case::paper::{Errors, number};
use stosszahl_results::{FinishedPoints, KeyCondition, RowKey, Stored, TableEstimate};
use stosszahl_study::measures::mean_over_replicas;
use toml::Value;

use crate::number_location::{COLLISIONS, NumberLocation, NumberSource, SECONDS, same_name};

/// Name of the key column `replica`, whose rows are averaged with their spread as error.
const REPLICA: &str = "replica";

/// Looks up one number of a claim and its standard error in the results of a finished run.
///
/// # Errors
///
/// The reason why the run has no such number, as text.
pub(crate) fn find_number(
    points: &FinishedPoints,
    spot: &NumberLocation<'_>,
) -> Result<TableEstimate, String> {
    let stored = &points
        .point(&spot.point)
        .map_err(|error| error.to_string())?
        .1;
    let (table, column) = match spot.source {
        NumberSource::Derived(name) => {
            return derived(stored, name)
                .ok_or_else(|| format!("{name} does not follow from the case"));
        }
        NumberSource::Column(table, column) => (table, column),
    };
    let find = || {
        let table = stored.table(table)?;
        let keys: Vec<RowKey<'_>> = spot.keys.iter().map(condition).collect();
        let rows = table.find_rows(&keys)?;
        let found: Result<Vec<_>, _> = rows.iter().map(|row| row.estimate(column)).collect();
        Ok((table, found?))
    };
    let (table, found) =
        find().map_err(|error: stosszahl_results::NumberNotFound| error.to_string())?;
    let mut all = if table.find_column(REPLICA).is_some() && !spot.keys.contains_key(REPLICA) {
        mean_over_replicas(found.iter().map(|one| one.value))
    } else {
        mean(&found, spot)?
    };
    all.replicas = (spot.errors == Errors::Replicas && all.standard_error != Some(0.0))
        .then(|| all.replicas.unwrap_or(stored.manifest.replicas as usize));
    Ok(all)
}

/// Converts one key of a claim to a condition on table rows: a text, a number, or a range of two
/// numbers.
fn condition<'a>((&key, value): (&&'a str, &'a Value)) -> RowKey<'a> {
    let condition = match value {
        Value::String(word) => KeyCondition::Is(word),
        Value::Array(ends) => {
            let end = |at: usize| ends.get(at).and_then(number).unwrap_or(f64::NAN);
            KeyCondition::Within(array::from_fn(end))
        }
        value => KeyCondition::At(number(value).unwrap_or(f64::NAN)),
    };
    (key, condition)
}

/// Returns a quantity derived from a case, or the total computing time \[s\] or number of
/// collisions of all its engines and replicas.
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

/// Averages the values of the table rows that fit a claim. Several rows fit only if a key is a
/// range; their errors count as independent.
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

/// Divides two estimates with independent errors. With a `growth` factor of the key, returns the
/// exponent of the power law between them instead.
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
