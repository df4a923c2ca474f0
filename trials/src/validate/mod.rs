//! Claims about accuracy, over replicas, with error bars and verdicts.
//!
//! `stosszahl-trials validate` measures everything that is claimed, as one table. A part is left out only by name or when
//! the time is up, and both are said. Rows are told as they come and the table is written after each part, so that a run
//! that is stopped leaves what it had. The end is `pass` only if every claim of every part passed.
//!
//! `stosszahl-trials validate dsmc` measures the Monte Carlo schemes against kinetic theory and against exact dynamics.
//! The schemes and their claims are data, [`schemes::METHODS`].
//!
//! A claim passes if the value is within its tolerance and its standard error at most half of that; it is unresolved if
//! the error is wider. Starts and streams are addressed by fixed seeds, so the table is the same in every run, whatever
//! the number of threads.

mod convergence;
mod cooling;
mod elastic;
pub mod exact;
mod gas;
pub mod schemes;
mod spheres;
pub mod subject;
mod unstable;
mod whole;

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;
use stosszahl_model::snapshot::write_whole;

use crate::arguments::ValidateDsmc;
use crate::commands::say;
use crate::table::{Row, Verdict, csv, markdown};
use crate::trial::ENDLESS;
use crate::{Done, Effort, Trial, Trouble};
use schemes::{METHODS, Method};

pub use whole::{TRIALS, command};

/// The parts of the validation of the schemes.
pub mod parts {
    use super::{ENDLESS, convergence, cooling, elastic, unstable};

    trials! {
        "elastic" => elastic::run,
            "are rate, pressure, transport, noise and structure of elastic gases at four packings those of Enskog's theory?",
            "what each scheme claims", ENDLESS;
        "cooling" => cooling::run,
            "does a gas too small for shear modes cool as Haff's law says?",
            "what each scheme claims", ENDLESS;
        "unstable" => unstable::run,
            "do shear modes of a large gas grow as linear theory and exact dynamics say?",
            "what each scheme claims", ENDLESS;
        "convergence" => convergence::run,
            "what is left at vanishing simulator weight, cell size and step, and of which order are the errors?",
            "what each scheme claims", ENDLESS;
    }
}

/// Does something for each of some seeds in parallel: results in their order, and the seconds that all took.
fn over_seeds<T: Send>(
    seeds: Range<u64>,
    job: impl Fn(u64) -> Result<T, Trouble> + Sync + Send,
) -> Result<(Vec<T>, f64), Trouble> {
    let timed = |seed| {
        let began = Instant::now();
        job(seed).map(|done| (done, began.elapsed().as_secs_f64()))
    };
    let done: Vec<(T, f64)> = seeds.into_par_iter().map(timed).collect::<Result<_, _>>()?;
    let (found, seconds): (Vec<T>, Vec<f64>) = done.into_iter().unzip();
    Ok((found, seconds.iter().sum()))
}

fn chosen(wanted: &[String]) -> Result<Vec<Method>, Trouble> {
    let named = |name: &String| {
        let known = METHODS.iter().find(|method| method.name == name).copied();
        known.ok_or_else(|| Trouble::Unknown {
            option: "scheme",
            found: name.clone(),
            allowed: METHODS.iter().map(|method| method.name).collect(),
        })
    };
    if wanted.is_empty() {
        return Ok(METHODS.to_vec());
    }
    wanted.iter().map(named).collect()
}

/// Runs the parts asked for on the schemes asked for, says each row, and writes the tables.
///
/// # Errors
/// [`Trouble`] if a scheme is unknown, something cannot be done, or a claim of the default scheme does not hold.
pub fn schemes_command(asked: &ValidateDsmc) -> Done {
    let effort = Effort {
        quick: asked.quick,
        methods: chosen(&asked.scheme)?,
        say: Some(say),
        ..Effort::default()
    };
    if let Some(folder) = &asked.out {
        // Before the work, not after it.
        fs::create_dir_all(folder).map_err(|source| Trouble::Folder {
            path: folder.clone(),
            source,
        })?;
    }
    let mut rows: Vec<Row> = Vec::new();
    for part in Trial::chosen(parts::TRIALS, "part", &asked.part)? {
        let report = part.run(&effort);
        if !report.passed() {
            return Err(Trouble::Failed(report.faults.join("; ")));
        }
        rows.extend(report.rows);
        if let Some(folder) = &asked.out {
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
    // A quick run is not meant to resolve anything.
    let [passed, failed, open] = standing(&rows, |_| asked.quick);
    let claims = passed + failed + open;
    match failed {
        0 => Ok(()),
        _ => Err(Trouble::Failed(format!(
            "{failed} of {claims} claims of the default scheme do not hold"
        ))),
    }
}

/// Claims of the default scheme that hold, that do not, and that are left open where that is allowed.
fn standing(rows: &[Row], may_stay_open: impl Fn(&Row) -> bool) -> [usize; 3] {
    let mut counts = [0; 3];
    for row in rows.iter().filter(|row| row.default) {
        match row.verdict {
            Verdict::Pass => counts[0] += 1,
            Verdict::Unresolved if may_stay_open(row) => counts[2] += 1,
            Verdict::Fail | Verdict::Unresolved => counts[1] += 1,
            Verdict::Measured => {}
        }
    }
    counts
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

fn write(folder: &Path, rows: &[Row]) -> Done {
    write_whole(&folder.join("validation.csv"), &csv(rows)?)?;
    write_whole(&folder.join("validation.md"), markdown(rows).as_bytes())?;
    Ok(())
}
