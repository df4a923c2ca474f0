//! Generated text and files of a documentation block, and the check that its text follows from its
//! file.
//!
//! A long table is a file `docs/data/NAME.csv`. The text on the page is a function of that file
//! alone, so a check finds a page and a file that are not of one run, however long that run was.

use std::path::Path;

use stosszahl_results::{FinishedPoints, Table};

use super::accuracy;
use super::block::find_block;
use super::entries::ENTRIES;
use crate::{TrialError, table};

/// Folder of the tables of documentation blocks, relative to the repository root.
pub const FOLDER: &str = "docs/data";
/// Largest number of rows of generated tables on one page; longer tables are files.
pub const ROWS_OF_A_PAGE: usize = 30;

/// Generated Markdown text and files of a documentation block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Made {
    /// Markdown text of the block, as on its documentation page.
    pub text: String,
    /// Generated pictures and tables of the block: path relative to the repository root, and
    /// content.
    pub files: Vec<(String, String)>,
}

impl From<String> for Made {
    fn from(text: String) -> Self {
        let files = Vec::new();
        Self { text, files }
    }
}

/// Generator of the text and the files of a documentation block from the results of a run.
pub enum DataMaker {
    /// Function that generates the text and the files of a block from a finished run.
    Text(fn(&FinishedPoints) -> Result<Made, TrialError>),
    /// Function that creates a table, written to `docs/data/NAME.csv`, and a function of the table
    /// for the text.
    Data {
        /// Function that creates the table of the block from a finished run.
        table: fn(&FinishedPoints) -> Result<Table, TrialError>,
        /// Columns of the table, and the formatter of the text on the page.
        data: DataTable,
    },
}

/// File table of a documentation block, with the text derived from it.
pub struct DataTable {
    /// Function that creates the table with columns and without rows.
    pub columns: fn() -> Table,
    /// Function that formats the text on the page from the table and the link to its file.
    pub summary: fn(&Table, &str) -> Result<String, TrialError>,
}

/// File table of the claims about accuracy, whose block `stosszahl-trials validate` generates.
const CLAIMS: DataTable = DataTable {
    columns: table::columns,
    summary: accuracy::summary,
};

/// Returns the path of a block's table file, relative to the repository root.
pub fn path(name: &str) -> String {
    format!("{FOLDER}/{name}.csv")
}

/// Formats a result table as CSV text.
pub(super) fn csv_text(table: &Table) -> Result<String, TrialError> {
    Ok(String::from_utf8(table.to_csv()?)?)
}

impl DataTable {
    /// Returns the file table of the block with this name; `None` if the block has text only.
    fn of_block(name: &str) -> Option<&'static Self> {
        let entry = ENTRIES.iter().find(|entry| entry.name == name);
        match entry.map(|entry| &entry.make) {
            Some(DataMaker::Data { data, .. }) => Some(data),
            Some(DataMaker::Text(_)) => None,
            None => (name == "validation").then_some(&CLAIMS),
        }
    }

    /// Generates the text and the file of a block from its table.
    pub(super) fn made(&self, name: &str, table: &Table) -> Result<Made, TrialError> {
        Ok(Made {
            text: (self.summary)(table, &format!("data/{name}.csv"))?,
            files: vec![(path(name), csv_text(table)?)],
        })
    }
}

/// Generates the text and the file of the block of claims about accuracy.
pub(super) fn claims_block(table: &Table) -> Result<Made, TrialError> {
    CLAIMS.made("validation", table)
}

/// Reads the table file of a block; `None` if the block has text only.
fn read_table(root: &Path, name: &str) -> Result<Option<(&'static DataTable, Table)>, TrialError> {
    let Some(data) = DataTable::of_block(name) else {
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

/// Counts the table rows in the generated blocks of a page. Rows of nested blocks count once.
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
