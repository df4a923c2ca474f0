//! Checks of the files of blocks.
//!
//! The text of a block with a file is a function of that file alone. So a check finds a page and a
//! file that are not of one run, however long that run was.

use std::path::Path;

use stosszahl_results::{Role, Table, TableCell};

use super::accuracy;
use super::block::find_block;
use super::compare::differences;
use super::data::{DataMaker, DataTable, Made, path};
use super::entries::ENTRIES;
use crate::{TrialError, table};

/// Largest number of rows of generated tables on a page.
pub const ROWS_OF_A_PAGE: usize = 30;

/// Names of blocks that no entry makes, each with its table.
const TYPED: [(&str, DataTable); 1] = [(
    "validation",
    DataTable {
        columns: table::columns,
        summary: accuracy::summary,
    },
)];

/// Returns the table in `docs/data` of a documentation block with this name; `None` if the block is
/// text alone.
fn data_table(name: &str) -> Option<&'static DataTable> {
    let entry = ENTRIES.iter().find(|entry| entry.name == name);
    match entry.map(|entry| &entry.make) {
        Some(DataMaker::Data { data, .. }) => Some(data),
        Some(DataMaker::Text(_)) => None,
        None => {
            let mut typed = TYPED.iter();
            Some(&typed.find(|typed| typed.0 == name)?.1)
        }
    }
}

/// Formats text and file of a block that no entry makes.
///
/// # Errors
/// No table has this name, or a row is not of its columns.
pub(super) fn typed(name: &str, table: &Table) -> Result<Made, TrialError> {
    let data = data_table(name).ok_or_else(|| TrialError::failed(format!("no table {name:?}")))?;
    data.made(name, table)
}

/// Reads the file of a block; `None` if the block has no file.
fn read_table(root: &Path, name: &str) -> Result<Option<(&'static DataTable, Table)>, TrialError> {
    let Some(data) = data_table(name) else {
        return Ok(None);
    };
    let (file, mut table) = (path(name), (data.columns)());
    table.read_rows(&root.join(&file))?;
    if table.rows.is_empty() {
        return Err(TrialError::failed(format!("{file}: no rows")));
    }
    Ok(Some((data, table)))
}

/// Formats the text of a block from its file; `None` if the block has no file.
///
/// # Errors
/// The file cannot be read, or lacks a column or a row.
pub(super) fn text(root: &Path, name: &str) -> Result<Option<String>, TrialError> {
    let Some((data, table)) = read_table(root, name)? else {
        return Ok(None);
    };
    Ok(Some(data.made(name, &table)?.text.trim().to_owned()))
}

/// Lists the reasons why the text of a block does not follow from its file; empty if it does, or
/// the block has no file.
pub fn unfounded(root: &Path, page: &str, name: &str) -> Vec<String> {
    let there = find_block(page, name).map_or(String::new(), |block| block.text);
    match text(root, name) {
        Err(error) => vec![error.to_string()],
        Ok(Some(wanted)) if there != wanted => {
            let mut lines = there.lines().zip(wanted.lines());
            let first = lines.find(|(there, wanted)| there != wanted);
            let file = path(name);
            vec![first.map_or_else(
                || format!("the text has more or fewer lines than {file} gives"),
                |(there, wanted)| format!("{there} stands there, {file} gives {wanted}"),
            )]
        }
        Ok(_) => Vec::new(),
    }
}

/// Lists the differences between the file of a block and a table: numbers with a standard error
/// within their errors, everything else exactly.
pub(super) fn moved(root: &Path, name: &str, made: &Table) -> Result<Vec<String>, TrialError> {
    let there = read_table(root, name)?.map_or(String::new(), |(_, table)| words(&table));
    Ok(differences(&there, &words(made)))
}

/// Formats the cells of a table in words, a value and its standard error as `a ± b`.
fn words(table: &Table) -> String {
    let mut all = String::new();
    for row in &table.rows {
        for (cell, column) in row.iter().zip(&table.columns) {
            let shown = match cell {
                TableCell::Text(text) => text.clone(),
                // In a file the last digit is no rounding.
                TableCell::Number(number) => format!("{number:.20}"),
                TableCell::Count(count) => count.to_string(),
                TableCell::Empty => "-".to_owned(),
            };
            let has_error = column.role == Role::StandardError && *cell != TableCell::Empty;
            all.push_str(if has_error { " ± " } else { " " });
            all.push_str(&shown);
        }
    }
    all
}

/// Counts the rows of all tables in the blocks of a page; rows of a block inside another count
/// once.
pub fn generated_rows(page: &str) -> usize {
    let (mut depth, mut rows) = (0_usize, 0_usize);
    for line in page.lines() {
        if line.starts_with("<!-- docs ") {
            depth += 1;
        } else if line.starts_with("<!-- end of ") {
            depth = depth.saturating_sub(1);
        } else if depth > 0 && line.starts_with("|---") {
            // The line above is the header of the table.
            rows = rows.saturating_sub(1);
        } else if depth > 0 && line.starts_with('|') {
            rows += 1;
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::docs::DATA;
    use crate::table::{RowPlace, estimate};

    #[test]
    fn a_file_agrees_within_errors() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        let rows = |part, found| {
            let place = RowPlace::new(part, "scheme", "setting", 0.25, 1.0);
            table::table(&[place.row("rate", 1.0, estimate(found, 0.01), None)])
        };
        fs::create_dir_all(root.join(DATA)).expect("a folder");
        let made = typed("validation", &rows("elastic", 1.0)).expect("a table");
        for (file, content) in &made.files {
            fs::write(root.join(file), content).expect("a file");
        }
        let faults = |part, found| {
            let found = moved(root, "validation", &rows(part, found));
            found.expect("a file").len()
        };
        assert_eq!(faults("elastic", 1.0), 0);
        // 5.7 errors of the difference are 0.081.
        assert_eq!(faults("elastic", 1.05), 0);
        assert_eq!(faults("elastic", 1.1), 1);
        assert_eq!(faults("cooling", 1.0), 1);
    }
}
