//! Validation of the engines: claims about accuracy, measured over replicas, with error bars and
//! verdicts.
//!
//! `stosszahl-trials validate` measures all claims, as one table. A part is missing only if others
//! are named or the time is up, and the output states this. Rows are printed as they come, and the
//! table is written after each part, so an interrupted validation keeps finished parts. The last
//! line is `pass` only if every claim of every part holds.
//!
//! `stosszahl-trials validate dsmc` measures the Monte Carlo schemes against kinetic theory and
//! against exact dynamics. The schemes and their claims are data, [`schemes::METHODS`].
//!
//! A claim passes if the value is within its tolerance and its standard error at most half of the
//! tolerance. It is unresolved if the error is wider. Initial states and random streams have fixed
//! seeds, so the table is the same in every run, with any number of threads.

mod bulk;
pub mod contact;
mod convergence;
mod cooling;
mod elastic;
mod exact;
mod gas;
pub mod schemes;
mod small_gas;
mod spheres;
mod structure;
pub mod subject;
mod unstable;
mod whole;

use std::fmt::Write as _;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use rayon::prelude::*;
use stosszahl_model::snapshot::write_whole;

use crate::docs;
use crate::table::{RowVerdict, TrialTableRow, markdown, table};
use crate::terminal::{parse_duration, say, trial_names};
use crate::trial::{ENDLESS, chosen};
use crate::{Done, Effort, TrialError, TrialRow};
use schemes::METHODS;

pub use whole::TRIALS;

/// Options of `stosszahl-trials validate` for all claims about accuracy.
#[derive(Clone, Debug, Args)]
pub struct ValidateAll {
    /// Part of the validation to run alone; may be repeated [default: all].
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = trial_names(TRIALS))]
    pub part: Vec<String>,
    /// Validate with few and small gases, in about five minutes.
    #[arg(long)]
    pub quick: bool,
    /// Time after which no further part of the validation begins: 90s, 5m or 1h [default: none].
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub budget: Option<Duration>,
    /// Markdown page to write, with the table data/validation.csv next to it; both are complete
    /// after each part.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Options of `stosszahl-trials validate dsmc`, the validation of Monte Carlo schemes.
#[derive(Clone, Debug, Args)]
pub struct ValidateDsmc {
    /// Part of the validation to run alone; may be repeated [default: all].
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = trial_names(parts::TRIALS))]
    pub part: Vec<String>,
    /// Monte Carlo scheme to validate alone; may be repeated [default: all].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub scheme: Vec<String>,
    /// Validate with few and small gases: errors are too wide for most verdicts, and unresolved
    /// claims do not fail.
    #[arg(long)]
    pub quick: bool,
    /// Folder for the written tables validation.csv and validation.md.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Parts of the validation of Monte Carlo schemes, as a table of trials.
pub mod parts {
    use super::{ENDLESS, convergence, cooling, elastic, structure, unstable};

    trials! {
        "elastic" => elastic::test_elastic,
            "are rate, pressure, transport, noise and structure of elastic gases at six packings those of Enskog's theory?",
            "what each scheme claims", ENDLESS;
        "structure" => structure::test_structure,
            "what is S(k) of an elastic gas at k d = 0.2, 0.5 and 1, over exact disks, with 1, 4, 16 and 64 simulators for each?",
            "measured, not claimed", ENDLESS;
        "cooling" => cooling::test_cooling,
            "does a gas too small for shear modes cool as Haff's law says?",
            "what each scheme claims", ENDLESS;
        "unstable" => unstable::test_unstable,
            "do shear modes of a large gas grow as linear theory and exact dynamics say?",
            "what each scheme claims", ENDLESS;
        "convergence" => convergence::test_convergence,
            "what is left at vanishing simulator weight, cell size and step, and of which order are the errors?",
            "what each scheme claims", ENDLESS;
    }
}

/// Runs a job for each seed in parallel. Returns the results in the order of seeds, and the summed
/// computing time \[s\].
fn over_seeds<T: Send>(
    seeds: Range<u64>,
    job: impl Fn(u64) -> Result<T, TrialError> + Sync + Send,
) -> Result<(Vec<T>, f64), TrialError> {
    let timed = |seed| {
        let began = Instant::now();
        job(seed).map(|done| (done, began.elapsed().as_secs_f64()))
    };
    let done: Vec<(T, f64)> = seeds.into_par_iter().map(timed).collect::<Result<_, _>>()?;
    let (found, seconds): (Vec<T>, Vec<f64>) = done.into_iter().unzip();
    Ok((found, seconds.iter().sum()))
}

/// Outcome of the requested parts of a validation: rows of claims, and missing parts.
#[derive(Default)]
struct Outcome {
    rows: Vec<TrialTableRow>,
    /// Parts of the validation that were not run or not completed, with the reason.
    missing: Vec<String>,
}

impl Outcome {
    /// Runs parts of the validation in order, and starts none after the time budget is spent.
    /// Writes the page at first and after each part, so that an interrupted validation keeps
    /// finished parts.
    fn run_parts(
        parts: &[TrialRow],
        effort: &Effort,
        budget: Option<Duration>,
        write: impl Fn(&Self) -> Done,
    ) -> Result<Self, TrialError> {
        let began = Instant::now();
        let mut whole = Self::default();
        write(&whole)?;
        for part in parts {
            let passed = began.elapsed();
            let faults = if budget.is_some_and(|budget| passed > budget) {
                vec![format!(
                    "the time was up after {:.0} s",
                    passed.as_secs_f64()
                )]
            } else {
                let report = part.run_trial(effort);
                whole.rows.extend(report.rows);
                report.faults
            };
            if !faults.is_empty() {
                whole
                    .missing
                    .push(format!("{}: {}", part.name, faults.join("; ")));
            }
            write(&whole)?;
        }
        Ok(whole)
    }

    /// Counts the claims of the default scheme that hold, that fail, and that are allowed to stay
    /// unresolved.
    fn standing(&self, may_stay_open: impl Fn(&TrialTableRow) -> bool) -> [usize; 3] {
        let mut counts = [0; 3];
        for row in self.rows.iter().filter(|row| row.place.default) {
            match row.verdict {
                RowVerdict::Pass => counts[0] += 1,
                RowVerdict::Unresolved if may_stay_open(row) => counts[2] += 1,
                RowVerdict::Fail | RowVerdict::Unresolved => counts[1] += 1,
                RowVerdict::Measured => {}
            }
        }
        counts
    }

    /// Returns the last line of the validation, with the number of claims that hold, and whether
    /// everything passed. Only the part of the default scheme may leave claims unresolved.
    fn verdict(&self) -> (String, bool) {
        let [passed, failed, open] =
            self.standing(|row| ["cooling", "elastic", "unstable"].contains(&row.place.part));
        let missing = self.missing.len();
        let word = match (failed, missing) {
            _ if failed > 0 || passed == 0 => "FAIL",
            (_, 0) => "pass",
            _ => "incomplete",
        };
        let claims = passed + failed + open;
        let text = format!(
            "{claims} claims: {passed} hold, {failed} do not, {open} open; {missing} parts missing: {word}"
        );
        (text, word == "pass")
    }

    /// Returns the total computing time behind all rows \[s\]. Rows of one scheme, setting and
    /// packing share it and count once.
    fn work(&self) -> f64 {
        let mut rows: Vec<_> = self.rows.iter().map(|row| &row.place).collect();
        rows.retain(|place| !place.setting.ends_with("to 0"));
        rows.dedup();
        rows.iter().map(|place| place.seconds).sum()
    }

    /// Writes the validation page, and the table of claims next to it.
    fn write(&self, path: &Path, quick: bool) -> Done {
        let option = if quick { " --quick" } else { "" };
        let command = format!("stosszahl-trials validate{option}");
        let block = docs::claims_block(&command, &table(&self.rows), path)?;
        let mut text = format!(
            "# Validation\n\nWritten by `{command}`, version {}. A claim passes if the value is within its tolerance and \
             the standard error at most half of that; with a wider error it is unresolved, and what is not claimed is \
             measured. Starts and streams have fixed seeds, so only times differ between two runs.\n\n{block}\n",
            env!("CARGO_PKG_VERSION")
        );
        // Writing to a string cannot fail.
        for missing in &self.missing {
            let _ = writeln!(text, "\nMissing: {missing}.");
        }
        let _ = writeln!(text, "\n{}", self.verdict().0);
        Ok(write_whole(path, text.as_bytes())?)
    }
}

/// Runs the requested parts of the whole validation, prints each row and writes the page. It fails
/// unless everything holds.
pub(crate) fn command(asked: &ValidateAll) -> Done {
    let effort = Effort {
        quick: asked.quick,
        say: Some(say),
        ..Effort::default()
    };
    let parts = chosen(TRIALS, |part| part.name, "part", &asked.part)?;
    let whole = Outcome::run_parts(&parts, &effort, asked.budget, |whole| match &asked.out {
        None => Ok(()),
        Some(path) => whole.write(path, asked.quick),
    })?;
    let (verdict, holds) = whole.verdict();
    say(&verdict);
    if holds {
        Ok(())
    } else {
        Err(TrialError::failed("not all that is claimed holds"))
    }
}

/// Runs the requested parts for the requested Monte Carlo schemes, prints each row and writes the
/// tables.
pub(crate) fn schemes_command(asked: &ValidateDsmc) -> Done {
    let effort = Effort {
        quick: asked.quick,
        methods: chosen(METHODS, |method| method.name, "scheme", &asked.scheme)?,
        say: Some(say),
        ..Effort::default()
    };
    let parts = chosen(parts::TRIALS, |part| part.name, "part", &asked.part)?;
    let all = Outcome::run_parts(&parts, &effort, None, |all| {
        let Some(folder) = &asked.out else {
            return Ok(());
        };
        fs::create_dir_all(folder)
            .map_err(|error| TrialError::failed(format!("{}: {error}", folder.display())))?;
        write_whole(&folder.join("validation.csv"), &table(&all.rows).to_csv()?)?;
        Ok(write_whole(
            &folder.join("validation.md"),
            markdown(&all.rows).as_bytes(),
        )?)
    })?;
    let count = |verdict| all.rows.iter().filter(|row| row.verdict == verdict).count();
    say(&format!(
        "{} rows: {} pass, {} fail, {} unresolved, {} measured; {:.0} s of work",
        all.rows.len(),
        count(RowVerdict::Pass),
        count(RowVerdict::Fail),
        count(RowVerdict::Unresolved),
        count(RowVerdict::Measured),
        all.work(),
    ));
    // A quick run is not meant to resolve anything.
    let [passed, failed, open] = all.standing(|_| asked.quick);
    if !all.missing.is_empty() {
        return Err(TrialError::failed(all.missing.join("; ")));
    }
    match (failed, passed + failed + open) {
        (0, _) => Ok(()),
        (_, claims) => Err(TrialError::failed(format!(
            "{failed} of {claims} claims of the default scheme do not hold"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{RowPlace, estimate};

    #[test]
    fn all_is_well_only_if_every_claim_of_every_part_holds() {
        let word = |part, found: &[(f64, f64)], missing: bool| {
            let row = |&(value, error): &(f64, f64)| {
                let place = RowPlace::new(part, "a", "b", 0.25, 1.0);
                place.row("rate", 1.0, estimate(value, error), Some(0.01))
            };
            let whole = Outcome {
                rows: found.iter().map(row).collect(),
                missing: vec!["stress: the time was up".to_owned(); usize::from(missing)],
            };
            let (text, holds) = whole.verdict();
            assert_eq!(holds, text.ends_with(": pass"), "{text}");
            text.rsplit(' ')
                .next()
                .map(str::to_owned)
                .unwrap_or_default()
        };
        let (good, wrong, wide) = ((1.0, 0.001), (1.1, 0.001), (1.0, 0.02));
        assert_eq!(word("engines", &[good], false), "pass");
        assert_eq!(word("engines", &[good, wrong], false), "FAIL");
        assert_eq!(word("engines", &[good, wide], false), "FAIL");
        assert_eq!(word("engines", &[good], true), "incomplete");
        assert_eq!(word("engines", &[], false), "FAIL");
        assert_eq!(word("cooling", &[good, wide], false), "pass");
    }
}
