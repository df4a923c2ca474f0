//! What can be wrong with a results folder.

use std::io;
use std::path::{Path, PathBuf};

/// Why results cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// There are results already.
    #[error("{} exists; use --resume to continue it, --force to replace it, or --out for another folder", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("{} is no results folder (it has no run.json of this program) and is not replaced; use --out for another folder", path.display())]
    NotResults {
        /// The folder.
        path: PathBuf,
    },
    /// The folder is of another version, which kept no list of its files.
    #[error("{}: run.json has format {found}, this program knows format {expected}; use --out for another folder, or delete this one", path.display())]
    OtherVersion {
        /// The folder.
        path: PathBuf,
        /// Format of its `run.json`.
        found: String,
        /// Format that this program knows.
        expected: u32,
    },
    /// The case or start file is inside.
    #[error("{} lies in the folder {} that would be replaced", input.display(), path.display())]
    InputInside {
        /// The folder.
        path: PathBuf,
        /// The file.
        input: PathBuf,
    },
    /// There is nothing to continue.
    #[error("{}: nothing to resume here; expected a results folder of this case", path.display())]
    NothingToResume {
        /// The folder.
        path: PathBuf,
    },
    /// The mark of the folder cannot be understood.
    #[error("{}: run.json is damaged, so that nothing says which run this is; restore it, or use --out for another folder", path.display())]
    Damaged {
        /// The folder.
        path: PathBuf,
    },
    /// The folder belongs to another case.
    #[error("{} belongs to another run ({differences}); use --force to replace it, or --out for another folder", path.display())]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// What differs.
        differences: String,
    },
    /// The run is finished, but the case now asks for another output of the same numbers.
    #[error("{} is finished, but the case has changed since ({differences}); use --force to run it again, or --out for another folder", path.display())]
    Changed {
        /// The folder.
        path: PathBuf,
        /// What differs.
        differences: String,
    },
    /// Another process writes there.
    #[error("{}: another process is writing here; wait for it, or use --out for another folder", path.display())]
    Locked {
        /// The folder.
        path: PathBuf,
    },
    /// The folder is not the one that was locked.
    #[error("{}: this is no longer the folder that the run began in: it, or its run.files, was moved, removed or replaced; stopped, nothing more is written; a folder that was moved goes on with --resume --out", path.display())]
    Moved {
        /// Where the folder was.
        path: PathBuf,
    },
    /// The file system, or the system, cannot make the links that claims are.
    #[error("{}: cannot be linked: {source}; processes that work in one folder need a file system with hard links; without, use --part and merge", path.display())]
    Links {
        /// The claim.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Another process has taken over a task of this one.
    #[error("{}: {task} was taken over by another process, as nothing was heard of this one", path.display())]
    TakenOver {
        /// The folder.
        path: PathBuf,
        /// The task.
        task: String,
    },
    /// A finished run whose files are not those of its manifest, which several processes cannot mend together.
    #[error("{}: files of the finished run are missing or changed; run it once with --resume", path.display())]
    Unsound {
        /// The folder of the run or point.
        path: PathBuf,
    },
    /// Files that the run has written are gone.
    #[error("{}: {}, which this run has written; use --force to run it again", path.display(), absent(files))]
    Lost {
        /// The folder.
        path: PathBuf,
        /// The files, relative to it.
        files: Vec<String>,
    },
    /// A run without results.
    #[error("{}: {found}", path.display())]
    NoResults {
        /// The folder.
        path: PathBuf,
        /// What was found.
        found: &'static str,
    },
    /// A file name that leads out of the folder.
    #[error("{name:?} is no name of a file inside the results folder")]
    Name {
        /// The name.
        name: String,
    },
    /// The system refused.
    #[error("{}: cannot be {action}: {source}", path.display())]
    System {
        /// Where.
        path: PathBuf,
        /// What was tried: `made`, `written`, `read`, `removed`.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// A JSON file cannot be understood.
    #[error("{}, line {line}, key {key}: {source}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Path of the key inside the file.
        key: String,
        /// Line, from one.
        line: usize,
        /// What was found and what was expected.
        source: serde_json::Error,
    },
    /// A manifest or an index of another format.
    #[error("{}: found format {found}, this program reads format {expected}; use the version that wrote it, or run the case again", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Format in the file.
        found: String,
        /// Format that this program reads.
        expected: u32,
    },
    /// The header line of a table is not that of the manifest.
    #[error("{}: found the columns {}; the manifest has {}", path.display(), found.join(","), expected.join(","))]
    Columns {
        /// The table.
        path: PathBuf,
        /// Columns in the file.
        found: Vec<String>,
        /// Columns in the manifest.
        expected: Vec<String>,
    },
    /// A table has too few or too many rows, or a row has too few or too many cells.
    #[error("{}, line {line}: found {found} {what}; expected {expected}", path.display())]
    Length {
        /// The table.
        path: PathBuf,
        /// Line, from one.
        line: u64,
        /// What is counted: `cells`, `rows`.
        what: &'static str,
        /// How many were found.
        found: u64,
        /// How many belong there.
        expected: u64,
    },
    /// A cell cannot be understood.
    #[error("{}, line {line}, column {column}: found {found:?}; expected {expected}", path.display())]
    Cell {
        /// The table.
        path: PathBuf,
        /// Line, from one.
        line: u64,
        /// Name of the column.
        column: String,
        /// What was found.
        found: String,
        /// What the column holds.
        expected: &'static str,
    },
}

impl ResultsError {
    /// Whether the system is at fault, and not what was asked. A folder that cannot be made, and a place where nothing may be written,
    /// are what was asked.
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
            // A folder that cannot be made, as below /proc, is not found.
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

/// Files that are missing, in words.
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
