//! Check that the text of a documentation block follows from its table file: it finds a page and a
//! file that are not of one run, however long that run was.

use std::path::Path;

use stosszahl_results::Table;

use super::accuracy;
use super::block::find_block;
use super::data::{DataMaker, DataTable, Made, path};
use super::entries::ENTRIES;
use crate::{TrialError, table};

/// File table of the claims about accuracy, whose block `stosszahl-trials validate` generates.
const CLAIMS: DataTable = DataTable {
    columns: table::columns,
    summary: accuracy::summary,
};

/// Returns the file table of the block with this name; `None` if the block has text only.
fn data_table(name: &str) -> Option<&'static DataTable> {
    let entry = ENTRIES.iter().find(|entry| entry.name == name);
    match entry.map(|entry| &entry.make) {
        Some(DataMaker::Data { data, .. }) => Some(data),
        Some(DataMaker::Text(_)) => None,
        None => (name == "validation").then_some(&CLAIMS),
    }
}

/// Generates the text and the file of the block of claims about accuracy.
pub(super) fn claims_block(table: &Table) -> Result<Made, TrialError> {
    CLAIMS.made("validation", table)
}

/// Reads the table file of a block; `None` if the block has text only.
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

/// Formats the text of a block from its table file; `None` if the block has text only.
///
/// # Errors
///
/// The file cannot be read, or lacks a column or a row.
pub(super) fn text_of_file(root: &Path, name: &str) -> Result<Option<String>, TrialError> {
    let Some((data, table)) = read_table(root, name)? else {
        return Ok(None);
    };
    Ok(Some(data.made(name, &table)?.text.trim().to_owned()))
}

/// Lists the reasons why a block's text on a page does not follow from its table file; empty if it
/// does, or without a file.
pub fn unfounded(root: &Path, page: &str, name: &str) -> Vec<String> {
    let there = find_block(page, name).map_or(String::new(), |block| block.text);
    match text_of_file(root, name) {
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
