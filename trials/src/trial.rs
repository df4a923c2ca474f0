//! Definition of a trial with its log, and the function that runs it in a separate thread with a
//! time limit.

use std::fmt;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde::Serialize;
use stosszahl_model::Interrupt;
use stosszahl_results::Existing;
use stosszahl_study::RunOptions;

use crate::findings::said;
use crate::table::TrialTableRow;
use crate::validate::schemes::Method;
use crate::{Done, TrialError, TrialLog};

/// Macro that records a formatted fault in the trial's log unless a condition holds.
macro_rules! must {
    ($findings:expr, $holds:expr; $($text:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            let text = format!($($text)+);
            $findings.fault(text);
        }
    };
}

/// Macro that records a formatted finding in the trial's log.
macro_rules! found {
    ($findings:expr; $($text:tt)+) => {
        let text = format!($($text)+);
        $findings.found(text);
    };
}

/// Macro that records a formatted finding about the current gas in the trial's log.
macro_rules! found_in_gas {
    ($findings:expr; $($text:tt)+) => {
        let text = format!($($text)+);
        $findings.found_in_gas(&text);
    };
}

/// Macro that sets the name of the current gas in the trial's log.
macro_rules! about {
    ($findings:expr; $($text:tt)+) => {
        let text = format!($($text)+);
        $findings.about(text);
    };
}

/// Macro that defines a table of trials: `name => function, what is tried, what must hold` and, if
/// it is not [`LIMIT`], the time limit in seconds.
macro_rules! trials {
    ($($name:literal => $body:expr, $tried:literal, $required:literal $(, $limit:expr)?;)+) => {
        /// All trials of this module's table, in the order in which they are run.
        pub const TRIALS: &[$crate::TrialRow] = &[$({
            let trial = $crate::TrialRow::new($name, $body, $tried, $required);
            $(let trial = trial.with_limit($limit);)?
            trial
        }),+];
    };
}

/// Amount of work of trials, and the way in which they report.
#[derive(Clone, Debug, Default)]
pub struct Effort {
    /// True for quick trials: a minute instead of an hour, with few and small gases.
    pub quick: bool,
    /// True for long trials: hours instead of seconds.
    pub long: bool,
    /// Number of collisions of trials whose length can be set; `None` for each trial's own number.
    pub collisions: Option<u64>,
    /// Monte Carlo schemes that validation trials test.
    pub methods: Vec<Method>,
    /// True if trials print their progress to standard error.
    pub tell: bool,
    /// Function that prints the line of each claim; `None` for silence.
    pub say: Option<fn(&str)>,
}

/// Trial as a table row: name, description, required conditions, and the function that runs it.
#[derive(Clone, Copy, Debug)]
pub struct TrialRow {
    /// Name of the trial on the command line.
    pub name: &'static str,
    /// Description of what the trial tries.
    pub tried: &'static str,
    /// Conditions that must hold for the trial to pass.
    pub required: &'static str,
    body: fn(&mut TrialLog) -> Done,
    limit: Duration,
}

/// Time limit of a short trial, far above its usual time. A trial that exceeds it fails.
const LIMIT: Duration = Duration::from_mins(2);
/// Value of a trial's time limit that means no limit \[s\].
pub(crate) const ENDLESS: u64 = u64::MAX;

impl TrialRow {
    pub(crate) const fn new(
        name: &'static str,
        body: fn(&mut TrialLog) -> Done,
        tried: &'static str,
        required: &'static str,
    ) -> Self {
        Self {
            name,
            tried,
            required,
            body,
            limit: LIMIT,
        }
    }

    /// Sets the time limit of the trial \[s\].
    pub(crate) const fn with_limit(mut self, seconds: u64) -> Self {
        self.limit = Duration::from_secs(seconds);
        self
    }

    /// Runs the trial in a separate thread with a time limit. A panic becomes a fault. An endless
    /// loop also fails, but keeps its thread busy until the program ends.
    pub fn run_trial(self, effort: &Effort) -> TrialReport {
        let began = Instant::now();
        let (sender, receiver) = channel();
        let mut findings = TrialLog::new(self.name, effort.clone());
        let worker = thread::Builder::new().name(self.name.to_owned());
        let worker = worker.spawn(move || {
            if let Err(trouble) = (self.body)(&mut findings) {
                findings.about("");
                findings.fault(trouble.to_string());
            }
            // Failure only if the receiver is gone after the time limit.
            let _ = sender.send(findings.into_parts());
        });
        let failed = |fault: String| (Vec::new(), vec![fault], Vec::new());
        let (found, faults, rows) = match worker {
            Err(error) => failed(format!("no thread: {error}")),
            Ok(worker) => {
                // No limit for long runs, unless a trial has its own.
                let received = if effort.long && self.limit == LIMIT {
                    receiver.recv().map_err(|_| RecvTimeoutError::Disconnected)
                } else {
                    receiver.recv_timeout(self.limit)
                };
                received.unwrap_or_else(|error| {
                    failed(match error {
                        RecvTimeoutError::Timeout => {
                            format!("no end within {} s", self.limit.as_secs())
                        }
                        RecvTimeoutError::Disconnected => {
                            let panic = worker.join().err();
                            format!("panic: {}", panic.map_or_else(String::new, said))
                        }
                    })
                })
            }
        };
        TrialReport {
            name: self.name,
            tried: self.tried,
            required: self.required,
            found,
            faults,
            seconds: began.elapsed().as_secs_f64(),
            rows,
        }
    }
}

/// Returns the list elements whose names were requested on the command line; all elements without a
/// request.
pub(crate) fn chosen<T: Copy>(
    all: &[T],
    name: impl Fn(&T) -> &'static str,
    option: &str,
    wanted: &[String],
) -> Result<Vec<T>, TrialError> {
    let named = |found: &String| {
        let known = all.iter().find(|one| name(one) == found).copied();
        known.ok_or_else(|| {
            let allowed = all.iter().map(&name).collect::<Vec<_>>().join(", ");
            TrialError::refused(format!("--{option} {found}: allowed are {allowed}"))
        })
    };
    if wanted.is_empty() {
        return Ok(all.to_vec());
    }
    wanted.iter().map(named).collect()
}

/// Returns the options to run a case from a trial: on all cores, without progress output.
pub(crate) fn run_options<'a>(
    out: Option<&Path>,
    existing: Existing,
    stop: &'a Interrupt,
    commit: &'a str,
) -> RunOptions<'a> {
    RunOptions {
        out: out.map(Path::to_owned),
        existing,
        threads: None,
        ignore_memory_limit: false,
        stop,
        progress: &(),
        commit,
    }
}

/// Outcome of a trial: findings, faults, claims and its run time.
#[derive(Clone, Debug, Serialize)]
pub struct TrialReport {
    /// Name of the trial on the command line and in reports.
    pub name: &'static str,
    /// Description of what the trial tried.
    pub tried: &'static str,
    /// Conditions that had to hold for the trial to pass.
    pub required: &'static str,
    /// Findings of the trial, one sentence each.
    pub found: Vec<String>,
    /// Conditions of the trial that did not hold; empty if it passed.
    pub faults: Vec<String>,
    /// Wall time that the trial took \[s\].
    pub seconds: f64,
    /// Claims about accuracy that the trial tested, with their verdicts.
    #[serde(skip)]
    pub rows: Vec<TrialTableRow>,
}

impl TrialReport {
    /// Returns true if the trial has no faults.
    pub fn passed(&self) -> bool {
        self.faults.is_empty()
    }
}

impl fmt::Display for TrialReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = if self.passed() { "pass" } else { "FAIL" };
        writeln!(out, "{verdict}  {} ({:.1} s)", self.name, self.seconds)?;
        writeln!(out, "      tried  {}", self.tried)?;
        writeln!(out, "      must   {}", self.required)?;
        write!(out, "      found  {}", self.found.join("; "))?;
        for fault in &self.faults {
            write!(out, "\n      FAULT  {fault}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that every kind of fault in the body of a trial fails it.
    #[test]
    fn faults_panics_and_endless_loops_fail() {
        let trial = |body| TrialRow::new("trial", body, "", "");
        let fault = |trial: TrialRow| trial.run_trial(&Effort::default()).faults.join("; ");
        let wrong = trial(|log| {
            log.at_most("size", f64::NAN, 1.0);
            Ok(())
        });
        assert!(fault(wrong).contains("size: NaN"));
        let refused = trial(|_| Err(TrialError::refused("nothing fits")));
        assert!(fault(refused).contains("nothing fits"));
        assert_eq!(
            fault(trial(|_| panic!("out of order"))),
            "panic: out of order"
        );
        let guarded = trial(|log| {
            log.about("first");
            log.guard(|_| panic!("one of many"));
            log.about("");
            log.fault("second");
            Ok(())
        });
        assert_eq!(fault(guarded), "first: panic: one of many; second");
        let endless = trial(|_| {
            thread::sleep(Duration::from_secs(5));
            Ok(())
        });
        assert!(fault(endless.with_limit(0)).contains("no end"));
    }
}
