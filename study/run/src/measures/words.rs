//! Words and margins that verdicts of flows share.

use std::fmt::Display;

use stosszahl_results::{Verdict, VerdictKind};

/// Standard errors within which a number agrees.
pub const ERRORS: f64 = 3.0;

/// A number and its standard error.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        _ if !value.is_finite() => "unknown".to_owned(),
        Some(error) if error.is_finite() => format!("{value:.4} ± {error:.4}"),
        _ => format!("{value:.4} (error unknown)"),
    }
}

/// A relative deviation and its standard error, in per cent.
pub fn percent(off: f64, error: Option<f64>) -> String {
    match error {
        _ if !off.is_finite() => "unknown".to_owned(),
        Some(error) => format!("{:+.2} ± {:.2} %", 100.0 * off, 100.0 * error),
        None => format!("{:+.2} % (error unknown)", 100.0 * off),
    }
}

/// What a deviation says that must not be larger than a margin: without an error, nothing.
pub fn within(off: f64, error: Option<f64>, margin: f64) -> VerdictKind {
    match error {
        Some(error) if off.is_finite() && error.is_finite() => {
            if off.abs() - ERRORS * error > margin {
                VerdictKind::Differ
            } else if off.abs() <= margin && error <= margin {
                VerdictKind::Agree
            } else {
                VerdictKind::Undecided
            }
        }
        _ => VerdictKind::Note,
    }
}

/// Fewest blocks of all replicas from which errors are known well enough for a normal test.
const FEWEST_PARTS: usize = 10;

/// What a test says whose errors come from some blocks of time.
pub fn test(holds: bool, parts: usize) -> VerdictKind {
    match holds {
        _ if parts < FEWEST_PARTS => VerdictKind::Undecided,
        true => VerdictKind::Agree,
        false => VerdictKind::Differ,
    }
}

/// A remark on errors that come from few blocks.
pub fn from_parts(parts: usize) -> String {
    if parts < FEWEST_PARTS {
        format!("; errors come from {parts} blocks only, {FEWEST_PARTS} are needed to tell")
    } else {
        String::new()
    }
}

/// What several comparisons say together.
pub fn worst(kinds: impl IntoIterator<Item = VerdictKind>) -> VerdictKind {
    let rank = |kind: &VerdictKind| match kind {
        VerdictKind::Agree => 0,
        VerdictKind::Note => 1,
        VerdictKind::Undecided => 2,
        VerdictKind::Warning => 3,
        VerdictKind::Differ => 4,
    };
    kinds
        .into_iter()
        .max_by_key(rank)
        .unwrap_or(VerdictKind::Note)
}

/// Theory that cannot be computed.
pub fn no_theory(topic: String, error: &dyn Display) -> Verdict {
    Verdict {
        topic,
        sentence: format!("Theory cannot be computed: {error}."),
        kind: VerdictKind::Warning,
    }
}
