//! `stosszahl validate dsmc`.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use stosszahl_model::snapshot::{SnapshotError, write_whole};

use super::schemes::{METHODS, Method};
use super::table::{self, Row, Verdict};
use super::{Effort, Part, Trouble};
use crate::arguments::ValidateDsmc;

/// Why the command does not succeed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ValidateError {
    /// No scheme has this name.
    #[error("--scheme {found}: allowed are {}", names().join(", "))]
    Unknown {
        /// What was asked for.
        found: String,
    },
    /// A gas could not be made or measured.
    #[error(transparent)]
    Trouble(#[from] Trouble),
    /// The table cannot be made.
    #[error("table: {0}")]
    Table(#[from] csv::Error),
    /// The results folder cannot be made.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A table cannot be written.
    #[error(transparent)]
    Write(#[from] SnapshotError),
    /// `--budget` is no time.
    #[error(
        "--budget {found}: allowed is a time such as 90s, 5m or 1h, above 0 and at most a year"
    )]
    Budget {
        /// What was found.
        found: String,
    },
    /// Something of the whole does not hold.
    #[error("{failed} of {claims} claims do not hold, {missing} parts are missing")]
    Whole {
        /// How many failed or were not resolved.
        failed: usize,
        /// How many were made.
        claims: usize,
        /// Parts that were not run to the end.
        missing: usize,
    },
    /// A claim of the default scheme does not hold.
    #[error("{failed} of {claims} claims of the default scheme do not hold")]
    Failed {
        /// How many failed or were not resolved.
        failed: usize,
        /// How many were made.
        claims: usize,
    },
}

fn names() -> Vec<&'static str> {
    METHODS.iter().map(|method| method.name).collect()
}

fn chosen(wanted: &[String]) -> Result<Vec<Method>, ValidateError> {
    if wanted.is_empty() {
        return Ok(METHODS.to_vec());
    }
    wanted
        .iter()
        .map(|name| {
            let known = METHODS.iter().find(|method| method.name == name);
            known.copied().ok_or_else(|| ValidateError::Unknown {
                found: name.clone(),
            })
        })
        .collect()
}

/// Runs the parts asked for on the schemes asked for, says each row, and writes the tables.
///
/// # Errors
/// [`ValidateError`] if a scheme is unknown, something cannot be done, or a claim of the default scheme does not hold.
pub fn command(arguments: &ValidateDsmc, say: impl Fn(&str) + Sync) -> Result<(), ValidateError> {
    let methods = chosen(&arguments.scheme)?;
    if let Some(folder) = &arguments.out {
        // Before the work, not after it.
        fs::create_dir_all(folder).map_err(|source| ValidateError::Folder {
            path: folder.clone(),
            source,
        })?;
    }
    let effort = Effort {
        quick: arguments.quick,
    };
    let parts = if arguments.part.is_empty() {
        &Part::ALL[..]
    } else {
        &arguments.part
    };
    let mut rows = Vec::new();
    for part in parts {
        let found = part.run(effort, &methods, &|row| {
            say(&table::line(row));
            // Losing a line of output ends nothing.
            let _ = io::stdout().flush();
        })?;
        rows.extend(found);
        if let Some(folder) = &arguments.out {
            // After each part, so that a later one that is stopped takes nothing away.
            write(folder, &rows)?;
        }
    }
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    say(&format!(
        "{} rows: {} pass, {} fail, {} unresolved, {} measured; {:.0} s of work",
        rows.len(),
        count(Verdict::Pass),
        count(Verdict::Fail),
        count(Verdict::Unresolved),
        count(Verdict::Measured),
        work(&rows),
    ));
    let claims = || {
        rows.iter()
            .filter(|row| row.default && row.tolerance.is_some())
    };
    // A quick run is not meant to resolve anything.
    let failed = |row: &&Row| match row.verdict {
        Verdict::Fail => true,
        Verdict::Unresolved => !arguments.quick,
        Verdict::Pass | Verdict::Measured => false,
    };
    match claims().filter(failed).count() {
        0 => Ok(()),
        failed => Err(ValidateError::Failed {
            failed,
            claims: claims().count(),
        }),
    }
}

/// Work behind all rows \[s\]: those of one scheme, setting and packing share theirs.
fn work(rows: &[Row]) -> f64 {
    let mut total = 0.0;
    let mut last = None;
    for row in rows.iter().filter(|row| !row.setting.ends_with("to 0")) {
        let here = (row.part, &row.scheme, &row.setting, row.packing.to_bits());
        if last != Some(here) {
            total += row.seconds;
        }
        last = Some(here);
    }
    total
}

fn write(folder: &Path, rows: &[Row]) -> Result<(), ValidateError> {
    write_whole(&folder.join("validation.csv"), &table::csv(rows)?)?;
    write_whole(
        &folder.join("validation.md"),
        table::markdown(rows).as_bytes(),
    )?;
    Ok(())
}
