//! Output folder of a reproduced paper: one results folder for each run, the table of claims and
//! the HTML page.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use stosszahl_report::{figure_anchor, paper, write_held_report};
use stosszahl_results::{Existing, FinishedPoints, write_file};
use stosszahl_study::{RunOptions, run_case};

use crate::ReproduceError;
use crate::judged::Judged;
use crate::plan::Reproduction;

/// Name of the file that identifies the output folder of a paper. It holds the title, and whether
/// runs are full or quick.
const MARK: &str = "paper.txt";
/// File names of the table of claims and of the HTML page of a whole paper.
const NAMES: [&str; 2] = ["claims.csv", "report.html"];

impl Reproduction<'_> {
    /// Creates the output folder of this paper, or accepts the one that exists.
    ///
    /// # Errors
    ///
    /// The folder holds something else, or cannot be created.
    pub fn open(&self, folder: &Path) -> Result<(), ReproduceError> {
        let failed = |source| ReproduceError::System {
            path: folder.to_owned(),
            source,
        };
        let mark = format!("{}\n{}\n", self.file.paper.title, self.kind());
        let path = folder.join(MARK);
        let occupied = |found: String| {
            let path = folder.to_owned();
            Err(ReproduceError::Occupied { path, found })
        };
        match fs::read_to_string(&path) {
            Ok(found) if found == mark => return Ok(()),
            Ok(found) => {
                let found = found.trim().replace('\n', ", ");
                return occupied(format!(
                    "this folder is of another paper or demand ({found})"
                ));
            }
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(failed(error)),
            Err(_) => {}
        }
        let is_empty = match fs::read_dir(folder) {
            Ok(mut entries) => entries.next().is_none(),
            Err(error) if error.kind() == ErrorKind::NotFound => true,
            Err(error) => return Err(failed(error)),
        };
        if !is_empty {
            return occupied(format!("this folder is not empty and has no {MARK}"));
        }
        fs::create_dir_all(folder).map_err(failed)?;
        Ok(write_file(&path, mark.as_bytes())?)
    }

    /// Returns the name of the run size: full or quick.
    pub(crate) fn kind(&self) -> &'static str {
        if self.demand.quick {
            "quick runs"
        } else {
            "full runs"
        }
    }

    /// Runs all unfinished cases of the paper, each in its own folder below `folder`, and writes
    /// their reports. A stopped run is resumed unless `replace` is true.
    ///
    /// # Errors
    ///
    /// The error of the first run that fails. Results of the runs before it stay.
    pub fn run_cases(
        &self,
        folder: &Path,
        options: &RunOptions<'_>,
        replace: bool,
    ) -> Result<(), ReproduceError> {
        self.open(folder)?;
        for (name, case) in &self.cases {
            let out = folder.join(name);
            let existing = match (out.join("run.json").exists(), replace) {
                (false, _) => Existing::Refuse,
                (true, true) => Existing::Replace,
                (true, false) => Existing::Resume,
            };
            let options = RunOptions {
                out: Some(out),
                existing,
                ..*options
            };
            let done = run_case(case, &options)?;
            write_held_report(&done.held)?;
        }
        Ok(())
    }

    /// Reads the results of finished runs and compares them with all claims of the paper.
    ///
    /// # Errors
    /// A results folder cannot be read.
    pub fn judge(&self, folder: &Path) -> Result<Judged<'_>, ReproduceError> {
        let mut results = BTreeMap::new();
        for &name in self.cases.keys() {
            results.insert(name, FinishedPoints::read_folder(&folder.join(name))?);
        }
        Ok(Judged::new(self, &results))
    }

    /// Writes the table of claims, then the HTML page of the paper, and returns the path of the
    /// page. A single figure has file names of its own.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn write(&self, folder: &Path, judged: &Judged<'_>) -> Result<PathBuf, ReproduceError> {
        let [table, page] = NAMES.map(|name| match self.demand.figure {
            None => folder.join(name),
            Some(figure) => folder.join(format!("{}-{name}", figure_anchor(figure))),
        });
        write_file(&table, &judged.table().to_csv()?)?;
        let text = paper(folder, &judged.page())?;
        write_file(&page, text.as_bytes())?;
        Ok(page)
    }
}
