//! Hard cases: what `stosszahl stress` runs, for the event-driven engine, gases without positions and walls here, and for
//! the Monte Carlo engine in [`dsmc`].
//!
//! A case says what it tries and what must hold, and finds out. Tolerances are stated where they are used; those that
//! several cases share are constants of the module `gas`, with their origin. A case runs in a thread of its own: a panic
//! or an endless loop fails it and spares the others. Cases also cut their runs at random moments and continue them from
//! serialised checkpoints.
//!
//! ```
//! use stosszahl::stress::{Effort, case};
//! let report = case("rest").expect("a case of this name").run(Effort::default());
//! assert!(report.passed(), "{report}");
//! ```

mod boxes;
mod collapse;
mod command;
mod contacts;
mod crystals;
pub mod dsmc;
mod endurance;
mod extremes;
mod findings;
mod gas;
mod homogeneous;
mod mixtures;
mod resume;
mod starts;
mod still;
mod ties;
mod walls;

use std::fmt;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde::Serialize;

pub use command::{StressError, command};
pub use findings::Findings;
use findings::said;

/// How much work is put into a case.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effort {
    /// Hours instead of seconds.
    pub long: bool,
    /// Collisions of the runs whose length can be set; otherwise each case has its own number.
    pub collisions: Option<u64>,
    /// Whether progress is told on standard error.
    pub tell: bool,
}

/// A hard case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name on the command line.
    pub name: &'static str,
    /// What is tried.
    pub tried: &'static str,
    /// What must hold.
    pub required: &'static str,
    body: fn(Effort, &mut Findings) -> Result<(), Trouble>,
    limit: Duration,
}

/// Seconds after which a short case counts as one that does not end: far above what any of them takes.
const LIMIT: Duration = Duration::from_mins(2);

impl Case {
    const fn new(
        name: &'static str,
        tried: &'static str,
        required: &'static str,
        body: fn(Effort, &mut Findings) -> Result<(), Trouble>,
    ) -> Self {
        Self {
            name,
            tried,
            required,
            body,
            limit: LIMIT,
        }
    }

    /// The same case with a limit of its own.
    const fn within(mut self, seconds: u64) -> Self {
        self.limit = Duration::from_secs(seconds);
        self
    }

    /// Runs the case and says what it found; neither a panic nor an endless loop in it harms the caller, but the latter keeps a thread busy
    /// until the program ends.
    pub fn run(self, effort: Effort) -> Report {
        let began = Instant::now();
        let (sender, receiver) = channel();
        let worker = thread::Builder::new()
            .name(self.name.to_owned())
            .spawn(move || {
                let mut findings = Findings::new(self.name, effort.tell);
                if let Err(trouble) = (self.body)(effort, &mut findings) {
                    findings.fault(trouble.to_string());
                }
                // The receiver is gone if the time was up.
                let _ = sender.send(findings);
            });
        let failed = |fault: String| {
            let mut findings = Findings::new(self.name, false);
            findings.fault(fault);
            findings
        };
        let findings = match worker {
            Err(error) => failed(format!("no thread: {error}")),
            Ok(worker) => {
                // Long runs take what they take, unless a case is about its end.
                let received = if effort.long && self.limit == LIMIT {
                    receiver.recv().map_err(|_| RecvTimeoutError::Disconnected)
                } else {
                    receiver.recv_timeout(self.limit)
                };
                match received {
                    Ok(findings) => findings,
                    Err(RecvTimeoutError::Timeout) => {
                        failed(format!("no end within {} s", self.limit.as_secs()))
                    }
                    Err(RecvTimeoutError::Disconnected) => failed(format!(
                        "panic: {}",
                        worker.join().err().map_or_else(String::new, said)
                    )),
                }
            }
        };
        let (found, faults) = findings.into_parts();
        Report {
            name: self.name,
            tried: self.tried,
            required: self.required,
            found,
            faults,
            seconds: began.elapsed().as_secs_f64(),
        }
    }
}

/// What came of a case.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the case.
    pub name: &'static str,
    /// What was tried.
    pub tried: &'static str,
    /// What must hold.
    pub required: &'static str,
    /// What was found, in numbers.
    pub found: Vec<String>,
    /// What does not hold; empty if the case passed.
    pub faults: Vec<String>,
    /// Wall time \[s\].
    pub seconds: f64,
}

impl Report {
    /// Whether all that must hold held.
    pub fn passed(&self) -> bool {
        self.faults.is_empty()
    }
}

impl fmt::Display for Report {
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

/// What keeps a case from being tried at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// The engine refused what it must take.
    #[error("the engine refused: {0}")]
    Engine(#[from] stosszahl_ed::EngineError),
    /// The engine without positions refused what it must take.
    #[error("the engine refused: {0}")]
    Homogeneous(#[from] stosszahl_dsmc::homogeneous::GasError),
    /// The Monte Carlo engine refused what it must take.
    #[error("the engine refused: {0}")]
    MonteCarlo(#[from] stosszahl_dsmc::EngineError),
    /// A start could not be made.
    #[error("no start: {0}")]
    Start(#[from] crate::bench::BenchError),
    /// A start could not be made.
    #[error("no start: {0}")]
    NoStart(&'static str),
    /// A checkpoint could not be written or read.
    #[error("checkpoint: {0}")]
    Checkpoint(#[from] postcard::Error),
}

/// All cases of the event-driven engine, in the order in which they are run.
pub fn cases() -> Vec<Case> {
    [
        collapse::CASES,
        crystals::CASES,
        ties::CASES,
        contacts::CASES,
        endurance::CASES,
        still::CASES,
        boxes::CASES,
        mixtures::CASES,
        resume::CASES,
        // Last, as one of its cases may leave a busy thread behind.
        extremes::CASES,
    ]
    .concat()
}

/// All cases of gases without positions.
pub fn mixture_cases() -> Vec<Case> {
    homogeneous::CASES.to_vec()
}

/// All cases of walls, obstacles, gravity and openings, for both engines.
pub fn wall_cases() -> Vec<Case> {
    walls::CASES.to_vec()
}

/// The case of a name.
pub fn case(name: &str) -> Option<Case> {
    let mut all = (cases().into_iter())
        .chain(mixture_cases())
        .chain(wall_cases());
    all.find(|case| case.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A case whose body is at fault does not pass, whatever the fault.
    #[test]
    fn faults_panics_and_endless_loops_fail() {
        let fault = |case: Case| case.run(Effort::default()).faults.join("; ");
        let wrong = Case::new("wrong", "", "", |_, findings| {
            findings.at_most("size", f64::NAN, 1.0);
            Ok(())
        });
        assert!(fault(wrong).contains("size: NaN"));
        let refused = Case::new("refused", "", "", |_, _| {
            Err(Trouble::NoStart("nothing fits"))
        });
        assert!(fault(refused).contains("nothing fits"));
        let panics = Case::new("panics", "", "", |_, _| panic!("out of order"));
        assert_eq!(fault(panics), "panic: out of order");
        let guarded = Case::new("guarded", "", "", |_, findings| {
            findings.guard("first", |_| panic!("one of many"));
            findings.fault("second");
            Ok(())
        });
        assert_eq!(fault(guarded), "first: panic: one of many; second");
        let endless = Case::new("endless", "", "", |_, _| {
            thread::sleep(Duration::from_secs(5));
            Ok(())
        });
        assert!(fault(endless.within(0)).contains("no end"));
    }
}
