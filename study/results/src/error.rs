//! Error type of results folders and their files.

use std::io;
use std::path::{Path, PathBuf};

/// Error with which a results folder or one of its files cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// A table cannot be written as a Parquet file; this is an error of the program.
    #[cfg(feature = "parquet")]
    #[error("table {table}: cannot be written as Parquet: {message}")]
    Parquet {
        /// Name of the table that cannot be written.
        table: String,
        /// Message of the Parquet writer.
        message: String,
    },
    /// The results folder exists already, and the run was not to resume or replace it.
    #[error("{} exists; use --resume to continue it, --force to replace it, or --out for another folder", path.display())]
    Exists {
        /// Path of the existing results folder.
        path: PathBuf,
    },
    /// The folder exists, but is not a results folder of this program.
    #[error("{} is no results folder (it has no run.json of this program) and is not replaced; use --out for another folder", path.display())]
    NotResults {
        /// Path of the folder that is no results folder.
        path: PathBuf,
    },
    /// The results folder is of another program version, which kept no list of its files.
    #[error("{}: run.json has format {found}, this program knows format {expected}; use --out for another folder, or delete this one", path.display())]
    OtherVersion {
        /// Path of the results folder.
        path: PathBuf,
        /// Format number in the folder's `run.json`.
        found: String,
        /// Format number that this program writes.
        expected: u32,
    },
    /// The case file or start file lies inside the results folder to be replaced.
    #[error("{} lies in the folder {} that would be replaced", input.display(), path.display())]
    InputInside {
        /// Path of the results folder to be replaced.
        path: PathBuf,
        /// Path of the case file or start file.
        input: PathBuf,
    },
    /// A run is to be resumed, but the folder has no results of this program.
    #[error("{}: nothing to resume here; expected a results folder of this case", path.display())]
    NothingToResume {
        /// Path of the results folder.
        path: PathBuf,
    },
    /// The `run.json` of the results folder cannot be read.
    #[error("{}: run.json is damaged, so that nothing says which run this is; restore it, or use --out for another folder", path.display())]
    Damaged {
        /// Path of the results folder.
        path: PathBuf,
    },
    /// The results folder belongs to another case.
    #[error("{} belongs to another run ({differences}); use --force to replace it, or --out for another folder", path.display())]
    Foreign {
        /// Path of the results folder.
        path: PathBuf,
        /// Differences between this case and that of the folder, in words.
        differences: String,
    },
    /// The run in the results folder is finished, but its case now requests other output.
    #[error("{} is finished, but the case has changed since ({differences}); use --force to run it again, or --out for another folder", path.display())]
    Changed {
        /// Path of the results folder.
        path: PathBuf,
        /// Differences between this case and that of the folder, in words.
        differences: String,
    },
    /// Another process is writing into the results folder.
    #[error("{}: another process is writing here; wait for it, or use --out for another folder", path.display())]
    Locked {
        /// Path of the results folder.
        path: PathBuf,
    },
    /// The results folder that this process has locked was moved or replaced.
    #[error("{}: this is no longer the folder that the run began in: it, or its run.files, was moved, removed or replaced; stopped, nothing more is written; a folder that was moved goes on with --resume --out", path.display())]
    Moved {
        /// Path at which the locked folder was.
        path: PathBuf,
    },
    /// The file system or operating system does not support hard links, which claims of tasks need.
    #[error("{}: cannot be linked: {source}; processes that work in one folder need a file system with hard links; without, use --part and merge", path.display())]
    Links {
        /// Path of the claim that could not be created.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Another process has taken over a task that this process had claimed.
    #[error("{}: {task} was taken over by another process, as nothing was heard of this one", path.display())]
    TakenOver {
        /// Path of the results folder.
        path: PathBuf,
        /// Name of the task that was taken over.
        task: String,
    },
    /// Files of a finished run differ from its manifest, and several processes cannot repair them
    /// together.
    #[error("{}: files of the finished run are missing or changed; run it once with --resume", path.display())]
    Unsound {
        /// Path of the folder of the run or point.
        path: PathBuf,
    },
    /// Files that the run has written are missing.
    #[error("{}: {}, which this run has written; use --force to run it again", path.display(), missing_files(files))]
    Lost {
        /// Path of the results folder.
        path: PathBuf,
        /// Names of the missing files, relative to the folder.
        files: Vec<String>,
    },
    /// The folder of a run has no results.
    #[error("{}: {found}", path.display())]
    NoResults {
        /// Path of the folder without results.
        path: PathBuf,
        /// State of the folder, such as unfinished, in words.
        found: &'static str,
    },
    /// A file name points outside the results folder.
    #[error("{name:?} is no name of a file inside the results folder")]
    Name {
        /// Invalid file name as given.
        name: String,
    },
    /// The operating system refused an operation on a file or folder.
    #[error("{}: cannot be {action}: {source}", path.display())]
    System {
        /// Path of the file or folder of the operation.
        path: PathBuf,
        /// Failed operation: `made`, `written`, `read`, `removed`.
        action: &'static str,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A JSON file of the results folder cannot be parsed.
    #[error("{}, line {line}, key {key}: {source}", path.display())]
    Json {
        /// Path of the JSON file.
        path: PathBuf,
        /// Path of the key inside the JSON file at which parsing failed.
        key: String,
        /// Line of the JSON file at which parsing failed, from 1.
        line: usize,
        /// Error of the JSON parser: value found and expected.
        source: serde_json::Error,
    },
    /// A manifest or sweep index has another format version.
    #[error("{}: found format {found}, this program reads format {expected}; use the version that wrote it, or run the case again", path.display())]
    Format {
        /// Path of the manifest or sweep index.
        path: PathBuf,
        /// Format number in the file.
        found: String,
        /// Format number that this program reads.
        expected: u32,
    },
    /// The header line of a CSV table differs from the manifest.
    #[error("{}: found the columns {}; the manifest has {}", path.display(), found.join(","), expected.join(","))]
    Columns {
        /// Path of the CSV table.
        path: PathBuf,
        /// Column names in the file.
        found: Vec<String>,
        /// Column names in the manifest.
        expected: Vec<String>,
    },
    /// A CSV table has the wrong number of rows, or a row has the wrong number of cells.
    #[error("{}, line {line}: found {found} {what}; expected {expected}", path.display())]
    Length {
        /// Path of the CSV table.
        path: PathBuf,
        /// Line of the CSV table, from 1.
        line: u64,
        /// Items that were counted: `cells` or `rows`.
        what: &'static str,
        /// Number of cells or rows found.
        found: u64,
        /// Number of cells or rows expected.
        expected: u64,
    },
    /// A cell of a CSV table cannot be parsed.
    #[error("{}, line {line}, column {column}: found {found:?}; expected {expected}", path.display())]
    Cell {
        /// Path of the CSV table.
        path: PathBuf,
        /// Line of the cell in the CSV table, from 1.
        line: u64,
        /// Name of the cell's column.
        column: String,
        /// Content of the cell that cannot be parsed.
        found: String,
        /// Type of number or text that the column has.
        expected: &'static str,
    },
}

impl ResultsError {
    /// Returns true if the operating system failed, and the request was valid. A folder that cannot
    /// be created, or a path that is not writable, is a fault of the request.
    pub fn is_system(&self) -> bool {
        use io::ErrorKind::{AlreadyExists, NotADirectory, PermissionDenied};
        use io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        let refused = [
            AlreadyExists,
            NotADirectory,
            PermissionDenied,
            ReadOnlyFilesystem,
        ];
        match self {
            Self::Moved { .. } | Self::TakenOver { .. } => true,
            Self::System {
                source,
                action: "made",
                ..
            } => matches!(source.kind(), StorageFull | QuotaExceeded),
            // A folder that cannot be made, as below /proc, reads as not found.
            Self::System { source, action, .. } => {
                let absent = *action == "written" && source.kind() == io::ErrorKind::NotFound;
                !absent && !refused.contains(&source.kind())
            }
            _ => false,
        }
    }

    pub(crate) fn system(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::System {
            path: path.to_owned(),
            action,
            source,
        }
    }
}

/// Formats a list of missing files for a message.
fn missing_files(files: &[String]) -> String {
    match files {
        [one] => format!("{one} is missing"),
        _ => format!("{} are missing", files.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_is_missing_and_several_are() {
        let lost = |files: &[&str]| {
            let (path, files) = ("out".into(), files.iter().map(|&file| file.to_owned()));
            let files = files.collect();
            ResultsError::Lost { path, files }.to_string()
        };
        assert!(lost(&["a.csv"]).starts_with("out: a.csv is missing, which"));
        assert!(lost(&["a.csv", "b.csv"]).starts_with("out: a.csv, b.csv are missing, which"));
    }
}
