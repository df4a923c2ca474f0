//! Text and files of a block, and checks of its files.
//!
//! A long table is a file `docs/data/NAME.csv`. The text on the page is a function of that file
//! alone, so a check finds a page and a file that are not of one run, however long that run was.

use std::path::Path;

use stosszahl_results::{FinishedPoints, Table};

use super::accuracy;
use super::block::find_block;
use super::entries::ENTRIES;
use crate::{TrialError, table};

/// Folder of the tables of documentation blocks, from the root of the repository.
pub const FOLDER: &str = "docs/data";
/// Largest number of rows of generated tables on a page.
pub const ROWS_OF_A_PAGE: usize = 30;

/// Markdown text and files of a documentation block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Made {
    /// Markdown text of the block, as it stands on the documentation page.
    pub text: String,
    /// Pictures and tables of the block: path from the root of the repository, and content.
    pub files: Vec<(String, String)>,
}

impl From<String> for Made {
    fn from(text: String) -> Self {
        let files = Vec::new();
        Self { text, files }
    }
}

/// Maker of the text and the files of a documentation block from the results of a run.
pub enum DataMaker {
    /// Function that makes the text and the files of a block from a finished run.
    Text(fn(&FinishedPoints) -> Result<Made, TrialError>),
    /// Function that makes a table, which is the file `docs/data/NAME.csv`. The text follows from
    /// the file.
    Data {
        /// Function that makes the table.
        table: fn(&FinishedPoints) -> Result<Table, TrialError>,
        /// Columns of the table, and the text of the page.
        data: DataTable,
    },
}

/// Table of a block that is a file, with the text on the page.
pub struct DataTable {
    /// Function that creates the table without rows.
    pub columns: fn() -> Table,
    /// Function that formats the text on the page; the second argument is the link to the file.
    pub summary: fn(&Table, &str) -> Result<String, TrialError>,
}

/// Table of all claims about accuracy, whose block no entry makes.
const CLAIMS: DataTable = DataTable {
    columns: table::columns,
    summary: accuracy::summary,
};

/// Returns the path of the table of a block, from the root.
pub fn path(name: &str) -> String {
    format!("{FOLDER}/{name}.csv")
}

/// Formats a table as CSV.
pub(super) fn csv_text(table: &Table) -> Result<String, TrialError> {
    Ok(String::from_utf8(table.to_csv()?)?)
}

impl DataTable {
    /// Returns the table in `docs/data` of a block with this name; `None` if the block is text
    /// alone.
    fn of_block(name: &str) -> Option<&'static Self> {
        let entry = ENTRIES.iter().find(|entry| entry.name == name);
        match entry.map(|entry| &entry.make) {
            Some(DataMaker::Data { data, .. }) => Some(data),
            Some(DataMaker::Text(_)) => None,
            None => (name == "validation").then_some(&CLAIMS),
        }
    }

    /// Formats the text of a block, and its file.
    pub(super) fn made(&self, name: &str, table: &Table) -> Result<Made, TrialError> {
        Ok(Made {
            text: (self.summary)(table, &format!("data/{name}.csv"))?,
            files: vec![(path(name), csv_text(table)?)],
        })
    }
}

/// Formats text and file of the block of claims about accuracy.
pub(super) fn claims_block(table: &Table) -> Result<Made, TrialError> {
    CLAIMS.made("validation", table)
}

/// Reads the file of a block; `None` if the block has no file.
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

/// Formats the text of a block from its file; `None` if the block has no file.
///
/// # Errors
/// The file cannot be read, or lacks a column or a row.
pub(super) fn text_of_file(root: &Path, name: &str) -> Result<Option<String>, TrialError> {
    let Some((data, table)) = read_table(root, name)? else {
        return Ok(None);
    };
    Ok(Some(data.made(name, &table)?.text.trim().to_owned()))
}

/// Lists the reasons why the text of a block does not follow from its file; empty if it does, or
/// the block has no file.
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
