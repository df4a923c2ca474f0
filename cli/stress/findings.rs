//! What a case finds.

use std::any::Any;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::Trouble;

/// Numbers and faults of one case.
#[derive(Debug)]
pub struct Findings {
    name: &'static str,
    tell: bool,
    found: Vec<String>,
    faults: Vec<String>,
    hidden: usize,
}

/// Faults of one case that are listed; more are counted.
const MOST_FAULTS: usize = 8;

impl Findings {
    pub(super) fn new(name: &'static str, tell: bool) -> Self {
        Self {
            name,
            tell,
            found: Vec::new(),
            faults: Vec::new(),
            hidden: 0,
        }
    }

    /// Notes what was found.
    pub(super) fn found(&mut self, text: impl Into<String>) {
        self.found.push(text.into());
    }

    /// Notes what does not hold.
    pub(super) fn fault(&mut self, text: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(text.into());
        } else {
            self.hidden += 1;
        }
    }

    /// Notes a fault unless something holds.
    pub(super) fn require(&mut self, holds: bool, otherwise: impl FnOnce() -> String) {
        if !holds {
            self.fault(otherwise());
        }
    }

    /// Notes a fault unless a size is at most its bound; a size that is no number is a fault.
    pub(super) fn at_most(&mut self, what: &str, size: f64, bound: f64) {
        // Written so that NaN fails.
        let holds = size <= bound;
        self.require(holds, || format!("{what}: {size:.3e}, allowed {bound:.3e}"));
    }

    /// Does one of several things that a case tries; a panic in it is a fault and ends only this one.
    pub(super) fn guard(
        &mut self,
        what: &str,
        attempt: impl FnOnce(&mut Self) -> Result<(), Trouble>,
    ) {
        let done = catch_unwind(AssertUnwindSafe(|| attempt(self)));
        match done {
            Ok(Ok(())) => {}
            Ok(Err(trouble)) => self.fault(format!("{what}: {trouble}")),
            Err(panic) => self.fault(format!("{what}: panic: {}", said(panic))),
        }
    }

    /// Tells how far long work is.
    pub(super) fn progress(&self, share: f64, detail: &str) {
        if self.tell {
            // Losing a line of progress harms nothing.
            let _ = writeln!(
                std::io::stderr(),
                "{}: {:.1} % {detail}",
                self.name,
                100.0 * share
            );
        }
    }

    pub(super) fn into_parts(mut self) -> (Vec<String>, Vec<String>) {
        if self.hidden > 0 {
            self.faults.push(format!("and {} more", self.hidden));
        }
        (self.found, self.faults)
    }
}

/// The message of a panic.
pub(super) fn said(panic: Box<dyn Any + Send>) -> String {
    match panic.downcast::<String>() {
        Ok(text) => *text,
        Err(panic) => panic.downcast::<&str>().map_or_else(
            |_| "without a message".to_owned(),
            |text| (*text).to_owned(),
        ),
    }
}
