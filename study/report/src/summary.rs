//! Summary table of a sweep: for each point its settings, verdict, and the last value of each
//! estimate.

use std::collections::BTreeMap;

use serde_json::Value;
use stosszahl_results::{Role, Stored, Sweep, Table, TableCell, TableColumn, headlines};

use crate::discoveries::Numbers;
use crate::words::setting;

/// Returns true if a key column holds times, windows or lags, so that a summary takes the last of
/// them.
fn is_time(name: &str) -> bool {
    name == "time" || name.starts_with("window") || name.starts_with("lag")
}

/// Returns the estimate columns of a table with their values at the last time, named after table
/// and engines. Empty for tables in which other keys have several values.
fn estimates(table: &Table) -> Vec<(TableColumn, TableCell)> {
    let keys = || {
        let columns = table.columns.iter().enumerate();
        columns.filter(|(_, column)| column.role == Role::Key)
    };
    let mut other =
        keys().filter(|(_, column)| !column.name.starts_with("engine") && !is_time(&column.name));
    if other.any(|(place, _)| {
        table
            .rows
            .iter()
            .any(|row| row[place] != table.rows[0][place])
    }) {
        return Vec::new();
    }
    // Rows are ordered in time, so the last of each engine wins.
    let mut last: Vec<(String, &Vec<TableCell>)> = Vec::new();
    for row in &table.rows {
        let engines = keys().filter(|(_, column)| column.name.starts_with("engine"));
        let names: Vec<&str> = engines
            .filter_map(|(place, _)| match &row[place] {
                TableCell::Text(text) => Some(text.as_str()),
                _ => None,
            })
            .collect();
        let of = names.join("/");
        match last.iter_mut().find(|one| one.0 == of) {
            Some(one) => one.1 = row,
            None => last.push((of, row)),
        }
    }
    let mut found = Vec::new();
    for (of, row) in last {
        for (place, column) in table.columns.iter().enumerate() {
            let is_estimate = column.role == Role::Value
                && table
                    .columns
                    .get(place + 1)
                    .is_some_and(|next| next.role == Role::StandardError);
            let belongs = matches!(column.role, Role::StandardError | Role::Theory);
            if !is_estimate && !belongs {
                continue;
            }
            let of = if of.is_empty() {
                String::new()
            } else {
                format!("[{of}]")
            };
            let column = TableColumn {
                name: format!("{}.{}{of}", table.name, column.name).into(),
                ..column.clone()
            };
            found.push((column, row[place].clone()));
        }
    }
    found
}

/// Builds the summary table of a sweep, with one row for each point; unfinished points have empty
/// cells.
pub(crate) fn summary(
    sweep: &Sweep,
    points: &[Option<Stored>],
    keys: &[&String],
    numbers: &Numbers,
) -> Table {
    let mut table = Table::new(
        "sweep",
        "One row for each point of the sweep: the last value of each estimate",
    )
    .key("point", "", "Folder of the point");
    let is_number = |key: &str| {
        let mut values = sweep
            .points
            .iter()
            .filter_map(|point| point.values.get(key));
        values.all(Value::is_number)
    };
    table.columns.extend(keys.iter().map(|key| TableColumn {
        name: (*key).clone().into(),
        unit: if is_number(key) { "1" } else { "" }.into(),
        meaning: "A swept key".into(),
        role: Role::Key,
    }));
    table = table
        .note("verdict", "", "What the first conclusion of the point is")
        .note("conclusion", "", "It in words")
        .note("difference", "1", "Difference that was chosen before the run: that at the last time, or in the last window")
        .note("difference_se", "1", "Its standard error")
        .note("difference_low", "1", "Lower end of its interval at the level of the point alone")
        .note("difference_high", "1", "Upper end")
        .note("corrected_low", "1", "Lower end of its interval that is corrected for all points (Benjamini and Hochberg)")
        .note("corrected_high", "1", "Upper end")
        .note("corrected_verdict", "", "agree, differ or undecided by the corrected interval");
    let found: Vec<BTreeMap<String, (TableColumn, TableCell)>> = (points.iter())
        .map(|stored| {
            let tables = stored.iter().flat_map(|stored| &stored.tables);
            let all = tables.flat_map(estimates);
            all.map(|one| (one.0.name.to_string(), one)).collect()
        })
        .collect();
    let first = table.columns.len();
    for stored in points.iter().flatten() {
        for (column, _) in stored.tables.iter().flat_map(estimates) {
            if table.find_column(&column.name).is_none() {
                table.columns.push(column);
            }
        }
    }
    for (((point, stored), found), number) in
        sweep.points.iter().zip(points).zip(found).zip(numbers)
    {
        let mut row = vec![TableCell::Text(point.name.clone())];
        row.extend(keys.iter().map(|key| match point.values.get(*key) {
            Some(Value::Number(value)) if is_number(key) => {
                value.as_f64().map_or(TableCell::Empty, TableCell::Number)
            }
            None => TableCell::Empty,
            other => TableCell::Text(setting(other)),
        }));
        let verdicts = stored
            .as_ref()
            .map(|stored| headlines(&stored.manifest.verdicts));
        match verdicts.as_deref() {
            Some([verdict, ..]) => row.extend([
                TableCell::Text(verdict.kind.name().to_owned()),
                TableCell::Text(verdict.sentence.clone()),
            ]),
            Some([]) => row.extend([TableCell::Empty, TableCell::Empty]),
            None => row.extend([TableCell::Text("not finished".into()), TableCell::Empty]),
        }
        row.extend(match number {
            Some((number, corrected)) => {
                let ends = [corrected.own, corrected.corrected].into_iter();
                let ends = ends.flat_map(|ends| {
                    ends.map_or([TableCell::Empty, TableCell::Empty], |ends| {
                        ends.map(TableCell::Number)
                    })
                });
                let mut cells = vec![TableCell::Number(number.difference)];
                cells.push(
                    number
                        .standard_error
                        .map_or(TableCell::Empty, TableCell::Number),
                );
                cells.extend(ends);
                cells.push(TableCell::Text(corrected.kind.name().to_owned()));
                cells
            }
            None => vec![TableCell::Empty; 7],
        });
        let cells = table.columns[first..].iter().map(|column| {
            let known = found.get(&*column.name);
            known.map_or(TableCell::Empty, |one| one.1.clone())
        });
        row.extend(cells);
        table.rows.push(row);
    }
    table
}
