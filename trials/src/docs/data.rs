//! Text and files of a block. A long table is a file `docs/data/NAME.csv`, and the text on the page
//! follows from it.

use stosszahl_results::Table;

use super::results::{FinishedRun, ResultRow};
use crate::TrialError;

/// Folder of the tables of documentation blocks, from the root of the repository.
pub const FOLDER: &str = "docs/data";

/// Markdown text and files of a documentation block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Made {
    /// Markdown text of the block, as it stands on the documentation page.
    pub text: String,
    /// Pictures and tables of the block: path from the root of the repository, and content.
    pub files: Vec<(String, String)>,
}

impl From<String> for Made {
    fn from(text: String) -> Self {
        Self {
            text,
            files: Vec::new(),
        }
    }
}

/// Maker of the text and the files of a documentation block from the results of a run.
pub enum DataMaker {
    /// Function that makes the text and the files of a block from a finished run.
    Text(fn(&FinishedRun) -> Result<Made, TrialError>),
    /// Function that makes a table, which is the file `docs/data/NAME.csv`. The text follows from
    /// the file.
    Data {
        /// Function that makes the table.
        table: fn(&FinishedRun) -> Result<Table, TrialError>,
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

/// Returns the path of the table of a block, from the root.
pub fn path(name: &str) -> String {
    format!("{FOLDER}/{name}.csv")
}

impl DataTable {
    /// Formats the text of a block, and its file.
    pub(super) fn made(&self, name: &str, table: &Table) -> Result<Made, TrialError> {
        Ok(Made {
            text: (self.summary)(table, &format!("data/{name}.csv"))?,
            files: vec![(path(name), text(table)?)],
        })
    }
}

/// Formats a table as CSV.
pub(super) fn text(table: &Table) -> Result<String, TrialError> {
    Ok(String::from_utf8(table.to_csv()?)?)
}

/// Counts the rows that have a word in a column.
pub(super) fn count(rows: &[ResultRow<'_>], column: &str, word: &str) -> Result<usize, TrialError> {
    let mut found = 0;
    for row in rows {
        found += usize::from(row.words(column)? == word);
    }
    Ok(found)
}
