//! Generated text and files of a documentation block.
//!
//! A long table is a file `docs/data/NAME.csv`. The text on the page is a function of that file
//! alone.

use stosszahl_results::{FinishedPoints, Table};

use crate::TrialError;

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

/// Returns the path of a block's table file, relative to the repository root.
pub fn path(name: &str) -> String {
    format!("{FOLDER}/{name}.csv")
}

/// Formats a result table as CSV text.
pub(super) fn csv_text(table: &Table) -> Result<String, TrialError> {
    Ok(String::from_utf8(table.to_csv()?)?)
}

impl DataTable {
    /// Generates the text and the file of a block from its table.
    pub(super) fn made(&self, name: &str, table: &Table) -> Result<Made, TrialError> {
        Ok(Made {
            text: (self.summary)(table, &format!("data/{name}.csv"))?,
            files: vec![(path(name), csv_text(table)?)],
        })
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
