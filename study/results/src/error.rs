//! Errors of results folders.

use std::io;
use std::path::{Path, PathBuf};

/// Error with which results cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// A table cannot be written as Parquet; an error of the program.
    #[cfg(feature = "parquet")]
    #[error("table {table}: cannot be written as Parquet: {message}")]
    Parquet {
        /// Name of the table.
        table: String,
        /// Message of the writer.
        message: String,
    },
    /// The results folder exists already, and was not to be continued or replaced.
    #[error("{} exists; use --resume to continue it, --force to replace it, or --out for another folder", path.display())]
    Exists {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The folder exists, but is not a results folder.
    #[error("{} is no results folder (it has no run.json of this program) and is not replaced; use --out for another folder", path.display())]
    NotResults {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The folder is of another version, which kept no list of its files.
    #[error("{}: run.json has format {found}, this program knows format {expected}; use --out for another folder, or delete this one", path.display())]
    OtherVersion {
        /// Path of the folder.
        path: PathBuf,
        /// Format of the folder's `run.json`.
        found: String,
        /// Format that this program knows.
        expected: u32,
    },
    /// The case or start file is inside the folder to be replaced.
    #[error("{} lies in the folder {} that would be replaced", input.display(), path.display())]
    InputInside {
        /// Path of the folder.
        path: PathBuf,
        /// Path of the case or start file.
        input: PathBuf,
    },
    /// There is nothing to continue.
    #[error("{}: nothing to resume here; expected a results folder of this case", path.display())]
    NothingToResume {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The `run.json` of the folder cannot be read.
    #[error("{}: run.json is damaged, so that nothing says which run this is; restore it, or use --out for another folder", path.display())]
    Damaged {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The folder belongs to another case.
    #[error("{} belongs to another run ({differences}); use --force to replace it, or --out for another folder", path.display())]
    Foreign {
        /// Path of the folder.
        path: PathBuf,
        /// Differences between the cases, in words.
        differences: String,
    },
    /// The run is finished, but its case now requests other output.
    #[error("{} is finished, but the case has changed since ({differences}); use --force to run it again, or --out for another folder", path.display())]
    Changed {
        /// Path of the folder.
        path: PathBuf,
        /// Differences between the cases, in words.
        differences: String,
    },
    /// Another process writes into the folder.
    #[error("{}: another process is writing here; wait for it, or use --out for another folder", path.display())]
    Locked {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The path no longer leads to the folder that was locked: it was moved or replaced.
    #[error("{}: this is no longer the folder that the run began in: it, or its run.files, was moved, removed or replaced; stopped, nothing more is written; a folder that was moved goes on with --resume --out", path.display())]
    Moved {
        /// Former path of the folder.
        path: PathBuf,
    },
    /// The file system or the operating system does not support the hard links of claims.
    #[error("{}: cannot be linked: {source}; processes that work in one folder need a file system with hard links; without, use --part and merge", path.display())]
    Links {
        /// Path of the claim.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Another process has taken over a task of this one.
    #[error("{}: {task} was taken over by another process, as nothing was heard of this one", path.display())]
    TakenOver {
        /// Path of the folder.
        path: PathBuf,
        /// Name of the task.
        task: String,
    },
    /// Files of a finished run differ from its manifest, which several processes cannot repair
    /// together.
    #[error("{}: files of the finished run are missing or changed; run it once with --resume", path.display())]
    Unsound {
        /// Folder of the run or point.
        path: PathBuf,
    },
    /// Files written by the run are missing.
    #[error("{}: {}, which this run has written; use --force to run it again", path.display(), absent(files))]
    Lost {
        /// Path of the folder.
        path: PathBuf,
        /// Names of the files, relative to the folder.
        files: Vec<String>,
    },
    /// Folder of a run without results.
    #[error("{}: {found}", path.display())]
    NoResults {
        /// Path of the folder.
        path: PathBuf,
        /// State of the folder, in words.
        found: &'static str,
    },
    /// A file name that points outside the folder.
    #[error("{name:?} is no name of a file inside the results folder")]
    Name {
        /// File name as given.
        name: String,
    },
    /// The operating system refused an operation.
    #[error("{}: cannot be {action}: {source}", path.display())]
    System {
        /// Path of the file or folder.
        path: PathBuf,
        /// Failed operation: `made`, `written`, `read`, `removed`.
        action: &'static str,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A JSON file cannot be parsed.
    #[error("{}, line {line}, key {key}: {source}", path.display())]
    Json {
        /// Path of the file.
        path: PathBuf,
        /// Path of the key inside the file.
        key: String,
        /// Line, from one.
        line: usize,
        /// Error of the parser: value found and expected.
        source: serde_json::Error,
    },
    /// A manifest or sweep index of another format.
    #[error("{}: found format {found}, this program reads format {expected}; use the version that wrote it, or run the case again", path.display())]
    Format {
        /// Path of the file.
        path: PathBuf,
        /// Format in the file.
        found: String,
        /// Format that this program reads.
        expected: u32,
    },
    /// The header line of a table differs from the manifest.
    #[error("{}: found the columns {}; the manifest has {}", path.display(), found.join(","), expected.join(","))]
    Columns {
        /// Path of the table.
        path: PathBuf,
        /// Columns in the file.
        found: Vec<String>,
        /// Columns in the manifest.
        expected: Vec<String>,
    },
    /// A table has too few or too many rows, or a row has too few or too many cells.
    #[error("{}, line {line}: found {found} {what}; expected {expected}", path.display())]
    Length {
        /// Path of the table.
        path: PathBuf,
        /// Line, from one.
        line: u64,
        /// Name of the counted items: `cells` or `rows`.
        what: &'static str,
        /// Number of items found.
        found: u64,
        /// Number of items expected.
        expected: u64,
    },
    /// A cell cannot be parsed.
    #[error("{}, line {line}, column {column}: found {found:?}; expected {expected}", path.display())]
    Cell {
        /// Path of the table.
        path: PathBuf,
        /// Line, from one.
        line: u64,
        /// Name of the column.
        column: String,
        /// Content of the cell.
        found: String,
        /// Type of the column.
        expected: &'static str,
    },
}

impl ResultsError {
    /// Returns true if the system is at fault, and not the request. A folder that cannot be made,
    /// or a path that is not writable, is a fault of the request.
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

/// Lists missing files in words.
fn absent(files: &[String]) -> String {
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
