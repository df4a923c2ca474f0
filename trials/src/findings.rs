//! Log of a trial: its findings, its faults and its rows of claims.

use std::any::Any;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use stosszahl_analysis::statistics::Estimate;

use crate::table::{RowPlace, TrialTableRow};
use crate::{Done, Effort};

/// Log of one trial: findings as sentences, faults, and rows of claims.
#[derive(Debug)]
pub struct TrialLog {
    /// Amount of work of the trial: quick, normal or long.
    pub effort: Effort,
    trial: &'static str,
    about: String,
    found: Vec<String>,
    faults: Vec<String>,
    hidden: usize,
    rows: Vec<TrialTableRow>,
}

/// Largest number of faults of a trial that are listed; further ones are only counted.
const MOST_FAULTS: usize = 8;

impl TrialLog {
    /// Creates an empty log for a trial.
    pub fn new(trial: &'static str, effort: Effort) -> Self {
        Self {
            effort,
            trial,
            about: String::new(),
            found: Vec::new(),
            faults: Vec::new(),
            hidden: 0,
            rows: Vec::new(),
        }
    }

    /// Sets the name of the gas that precedes the faults recorded later.
    pub fn about(&mut self, what: impl Into<String>) {
        self.about = what.into();
    }

    fn with_gas_name(&self, text: &str) -> String {
        match &*self.about {
            "" => text.to_owned(),
            about => format!("{about}: {text}"),
        }
    }

    /// Records a finding of the trial, as a sentence.
    pub fn found(&mut self, text: impl Into<String>) {
        self.found.push(text.into());
    }

    /// Records a finding of the trial, preceded by the name of the current gas.
    pub fn found_in_gas(&mut self, text: &str) {
        self.found.push(self.with_gas_name(text));
    }

    /// Records a row of a claim, and prints it at once if rows are to be printed.
    pub fn add(&mut self, row: TrialTableRow) {
        if let Some(say) = self.effort.say {
            say(&row.line());
        }
        self.rows.push(row);
    }

    /// Records a claim about a measured quantity. The tolerance is absolute; `None` means that
    /// nothing is claimed.
    pub(crate) fn claim(
        &mut self,
        place: &RowPlace,
        quantity: impl Into<String>,
        expected: f64,
        found: Estimate,
        tolerance: Option<f64>,
    ) {
        self.add(place.row(quantity, expected, found, tolerance));
    }

    /// Returns the rows of all claims recorded so far.
    pub fn rows(&self) -> &[TrialTableRow] {
        &self.rows
    }

    /// Records a fault of the trial, preceded by the name of the current gas.
    pub fn fault(&mut self, text: impl AsRef<str>) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(self.with_gas_name(text.as_ref()));
        } else {
            self.hidden += 1;
        }
    }

    /// Records a fault unless `size` is at most `bound`; NaN is a fault.
    pub fn at_most(&mut self, what: &str, size: f64, bound: f64) {
        // Written so that NaN fails.
        let holds = size <= bound;
        must!(self, holds; "{what}: {size:.3e}, allowed {bound:.3e}");
    }

    /// Runs one of several attempts of a trial. An error or a panic becomes a fault and ends only
    /// this attempt.
    pub fn guard(&mut self, attempt: impl FnOnce(&mut Self) -> Done) {
        match catch_unwind(AssertUnwindSafe(|| attempt(self))) {
            Ok(Ok(())) => {}
            Ok(Err(trouble)) => self.fault(trouble.to_string()),
            Err(panic) => self.fault(format!("panic: {}", said(panic))),
        }
    }

    /// Prints the progress of a long trial to standard error, if progress is requested.
    pub fn progress(&self, share: f64, detail: &str) {
        if self.effort.tell {
            let (trial, share) = (self.trial, 100.0 * share);
            // Losing a line of progress harms nothing.
            let _ = writeln!(std::io::stderr(), "{trial}: {share:.1} % {detail}");
        }
    }

    /// Converts the log to its findings, faults and rows of claims.
    pub(crate) fn into_parts(mut self) -> (Vec<String>, Vec<String>, Vec<TrialTableRow>) {
        if self.hidden > 0 {
            self.faults.push(format!("and {} more", self.hidden));
        }
        (self.found, self.faults, self.rows)
    }
}

/// Returns the message of a caught panic.
pub(crate) fn said(panic: Box<dyn Any + Send>) -> String {
    match panic.downcast::<String>() {
        Ok(text) => *text,
        Err(panic) => panic.downcast::<&str>().map_or_else(
            |_| "without a message".to_owned(),
            |text| (*text).to_owned(),
        ),
    }
}
