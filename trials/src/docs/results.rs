//! Runs of bundled cases, and numbers in their tables.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use stosszahl_case::PaperFile;
use stosszahl_model::Interrupt;
use stosszahl_reproduce::{ReproduceOptions, Reproduction};
use stosszahl_results::{Existing, Manifest, Stored, SweepPoint, Table, TableCell, VerdictText};
use stosszahl_study::{RunOptions, format, run_case};

use super::ROOT;
use crate::TrialError;

/// Tables of a finished run, or of the points of a sweep.
#[derive(Debug)]
pub struct FinishedRun {
    points: Vec<(SweepPoint, Stored)>,
}

/// Number with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeasuredNumber {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

impl MeasuredNumber {
    /// Formats value and error with `digits` digits after the point.
    pub(crate) fn digits(self, digits: usize) -> String {
        format!("{:.digits$} ± {:.digits$}", self.value, self.error)
    }

    /// Formats value and error with two digits of the error.
    pub(crate) fn text(self) -> String {
        let places = 1.0 - self.error.log10().floor();
        self.digits(if places.is_finite() {
            places.clamp(0.0, 9.0) as usize
        } else {
            4
        })
    }

    /// Divides the number and its error by an exact number.
    pub(crate) fn divided_by(self, unit: f64) -> Self {
        Self {
            value: self.value / unit,
            error: self.error / unit.abs(),
        }
    }
}

impl FinishedRun {
    /// Runs a bundled case, with settings `key=value`, into a folder; an existing run is replaced,
    /// unless `resume` is true. Also returns the commit of the results.
    ///
    /// # Errors
    /// The case is refused, or its run fails.
    pub fn run_case(
        case: &str,
        set: &[String],
        out: &Path,
        resume: bool,
        commit: &str,
    ) -> Result<(Self, String), TrialError> {
        let path = Path::new(ROOT).join("cases").join(format!("{case}.toml"));
        let file = format().read(&path, set)?;
        let stop = Interrupt::default();
        let existing = match (out.join("run.json").exists(), resume) {
            (true, true) => Existing::Resume,
            (true, false) => Existing::Replace,
            _ => Existing::Refuse,
        };
        let options = RunOptions {
            out: Some(out.to_owned()),
            existing,
            threads: None,
            ignore_memory_limit: false,
            stop: &stop,
            progress: &(),
            commit,
        };
        run_case(&file, &options)?;
        let points = Stored::points(out)?;
        if points.len() < file.points.len() {
            return Err(TrialError::failed(format!("{}: no results", out.display())));
        }
        let last = points.last().map(|(_, stored)| &stored.manifest.program);
        let of = last.map_or(commit, |program| &program.commit).to_owned();
        if fs::exists(out.join("checkpoints"))? {
            return Err(TrialError::failed(format!(
                "{}: the run is not finished",
                out.display()
            )));
        }
        Ok((Self { points }, of))
    }

    /// Reproduces all papers by quick runs, each in a folder of its name: a point for each, with
    /// the table of its claims.
    ///
    /// # Errors
    /// A paper is refused, or a run fails.
    pub fn of_papers(out: &Path, resume: bool, commit: &str) -> Result<(Self, String), TrialError> {
        let folder = Path::new(ROOT).join("cases/papers");
        let mut files = Vec::new();
        for entry in fs::read_dir(folder)? {
            files.push(entry?.path());
        }
        files.sort();
        let bundled = |name: &str| {
            let path = Path::new(ROOT).join("cases").join(format!("{name}.toml"));
            fs::read_to_string(path).ok()
        };
        let stop = Interrupt::default();
        let options = RunOptions {
            out: None,
            existing: Existing::Refuse,
            threads: None,
            ignore_memory_limit: false,
            stop: &stop,
            progress: &(),
            commit,
        };
        let (mut points, mut of) = (Vec::new(), commit.to_owned());
        for path in files {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            let file = PaperFile::read(&path)?;
            let demand = ReproduceOptions {
                figure: None,
                quick: true,
            };
            let paper = Reproduction::new(&file, demand, &bundled)?;
            let own = out.join(&*name);
            paper.run_cases(&own, &options, !resume)?;
            let judged = paper.judge(&own)?;
            // Commit of the stored runs: an earlier one for runs that were complete before.
            for entry in fs::read_dir(&own)? {
                let run = entry?.path();
                if run.is_dir()
                    && let Some((_, stored)) = Stored::points(&run)?.last()
                {
                    of.clone_from(&stored.manifest.program.commit);
                }
            }
            let point = SweepPoint {
                name: name.into_owned(),
                values: BTreeMap::new(),
            };
            let stored = Stored {
                manifest: Manifest::default(),
                tables: vec![judged.table()],
                changed: Vec::new(),
            };
            points.push((point, stored));
        }
        Ok((Self { points }, of))
    }

    /// Names of the points.
    pub(crate) fn points(&self) -> impl Iterator<Item = &str> {
        self.points.iter().map(|point| point.0.name.as_str())
    }

    /// Returns the number that a point of the sweep sets a key to.
    pub(crate) fn setting(&self, point: &str, key: &str) -> Result<f64, TrialError> {
        let value = self.point(point)?.0.values.get(key);
        let missing = || TrialError::failed(format!("{point}: no number in {key}"));
        value
            .and_then(serde_json::Value::as_f64)
            .ok_or_else(missing)
    }

    fn point(&self, name: &str) -> Result<&(SweepPoint, Stored), TrialError> {
        let mut points = self.points.iter();
        let missing = || TrialError::failed(format!("no point {name:?} in the results"));
        points.find(|one| one.0.name == name).ok_or_else(missing)
    }

    /// Returns a table of a point.
    fn table(&self, point: &str, name: &str) -> Result<&Table, TrialError> {
        let mut tables = self.point(point)?.1.tables.iter();
        let table = tables.find(|one| one.name == name);
        table.ok_or_else(|| TrialError::failed(format!("no {name} of {point:?} in the results")))
    }

    /// Returns a table of a point with the rows whose cells agree with all of these keys.
    pub(crate) fn part(
        &self,
        point: &str,
        table: &str,
        keys: &[(&str, KeyCondition<'_>)],
    ) -> Result<Table, TrialError> {
        let rows = self.rows(point, table, keys)?;
        let rows = rows.iter().map(|row| row.cells.to_vec()).collect();
        let table = self.table(point, table)?.clone();
        Ok(Table { rows, ..table })
    }

    /// Returns a number that follows from the case of a point.
    pub(crate) fn derived(&self, point: &str, name: &str) -> Result<f64, TrialError> {
        let mut derived = self.point(point)?.1.manifest.derived.iter();
        let found = derived.find(|one| one.name == name);
        let missing = || TrialError::failed(format!("no {name} of {point:?} in the manifest"));
        found.map(|one| one.value).ok_or_else(missing)
    }

    /// Returns the verdicts of a point.
    pub(crate) fn verdicts(&self, point: &str) -> Result<&[VerdictText], TrialError> {
        Ok(&self.point(point)?.1.manifest.verdicts)
    }

    /// Returns the rows of a table of a point whose cells agree with all of these keys.
    pub(crate) fn rows<'a>(
        &'a self,
        point: &str,
        table: &str,
        keys: &[(&str, KeyCondition<'_>)],
    ) -> Result<Vec<ResultRow<'a>>, TrialError> {
        let table = self.table(point, table)?;
        let fits = |row: &&Vec<TableCell>| {
            keys.iter().all(|(name, key)| {
                let cell = table.find_column(name).map(|column| &row[column]);
                cell.is_some_and(|cell| key.fits(cell))
            })
        };
        let rows = table.rows.iter().filter(fits);
        Ok(rows.map(|cells| ResultRow { table, cells }).collect())
    }

    /// Returns the only row of a table of a point whose cells agree with all of these keys.
    pub(crate) fn row<'a>(
        &'a self,
        point: &str,
        table: &str,
        keys: &[(&str, KeyCondition<'_>)],
    ) -> Result<ResultRow<'a>, TrialError> {
        let mut rows = self.rows(point, table, keys)?;
        match (rows.pop(), rows.len()) {
            (Some(row), 0) => Ok(row),
            (_, more) => Err(TrialError::failed(format!(
                "{table}: not one row of {keys:?} but {}",
                more + 1
            ))),
        }
    }
}

/// Condition on a cell of a key column.
#[derive(Clone, Copy, Debug)]
pub(crate) enum KeyCondition<'a> {
    /// Cell that holds this word.
    Is(&'a str),
    /// Cell that holds this number, up to rounding and to the three digits of a time.
    At(f64),
}

impl KeyCondition<'_> {
    fn fits(self, cell: &TableCell) -> bool {
        match (self, cell) {
            (Self::Is(word), TableCell::Text(text)) => word == text,
            (Self::At(at), cell) => {
                number(cell).is_some_and(|found| (found - at).abs() <= 4e-3 * at.abs())
            }
            _ => false,
        }
    }
}

fn number(cell: &TableCell) -> Option<f64> {
    match cell {
        TableCell::Number(number) => Some(*number),
        TableCell::Count(count) => Some(*count as f64),
        _ => None,
    }
}

/// Row of a table of results.
#[derive(Clone, Copy)]
pub(crate) struct ResultRow<'a> {
    table: &'a Table,
    cells: &'a [TableCell],
}

impl<'a> ResultRow<'a> {
    /// Returns all rows of a table.
    pub(crate) fn all_rows(table: &'a Table) -> impl Iterator<Item = Self> {
        table.rows.iter().map(move |cells| Self { table, cells })
    }

    /// Returns the number in a column.
    pub(crate) fn number(&self, column: &str) -> Result<f64, TrialError> {
        let cell = self
            .table
            .find_column(column)
            .map(|place| &self.cells[place]);
        let missing = || TrialError::failed(format!("{}: no number in {column}", self.table.name));
        cell.and_then(number).ok_or_else(missing)
    }

    /// Returns the words in a column; empty for an empty cell.
    pub(crate) fn words(&self, column: &str) -> Result<&'a str, TrialError> {
        let cell = self
            .table
            .find_column(column)
            .map(|place| &self.cells[place]);
        match cell {
            Some(TableCell::Text(text)) => Ok(text),
            Some(TableCell::Empty) => Ok(""),
            _ => Err(TrialError::failed(format!(
                "{}: no words in {column}",
                self.table.name
            ))),
        }
    }

    /// Returns the number in a column, if it has one.
    pub(crate) fn maybe(&self, column: &str) -> Option<f64> {
        self.number(column).ok()
    }

    /// Returns the number in a column with the error next to it.
    pub(crate) fn measured(&self, column: &str) -> Result<MeasuredNumber, TrialError> {
        Ok(MeasuredNumber {
            value: self.number(column)?,
            error: self.number(&format!("{column}_se"))?,
        })
    }
}
