//! Words and margins that verdicts of flows share.

use std::fmt::Display;

use stosszahl_results::{Verdict, VerdictKind};

/// Standard errors within which a number agrees.
pub const ERRORS: f64 = 3.0;

/// From here on numbers are shown with an exponent.
const LARGE: f64 = 1e6;

/// A number and its standard error.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error.filter(|error| error.is_finite()) {
        _ if !value.is_finite() => "unknown".to_owned(),
        Some(error) if value.abs().max(error) < LARGE => format!("{value:.4} ± {error:.4}"),
        Some(error) => format!("{value:.4e} ± {error:.4e}"),
        None if value.abs() < LARGE => format!("{value:.4} (error unknown)"),
        None => format!("{value:.4e} (error unknown)"),
    }
}

/// A relative deviation and its standard error, in per cent.
pub fn percent(off: f64, error: Option<f64>) -> String {
    let percent = 100.0 * off;
    match error
        .filter(|error| error.is_finite())
        .map(|error| 100.0 * error)
    {
        _ if !off.is_finite() => "unknown".to_owned(),
        Some(error) if percent.abs().max(error) < LARGE => format!("{percent:+.2} ± {error:.2} %"),
        Some(error) => format!("{percent:+.2e} ± {error:.2e} %"),
        None if percent.abs() < LARGE => format!("{percent:+.2} % (error unknown)"),
        None => format!("{percent:+.2e} % (error unknown)"),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// No infinity, no number that is none, and no number of three hundred digits.
    #[test]
    fn numbers_that_nobody_can_read_are_not_shown() {
        let all = [f64::NAN, f64::INFINITY, 0.0, -0.25, 1e300, -1e300];
        for value in all {
            for error in all.map(|error| Some(error.abs())).into_iter().chain([None]) {
                for said in [with_error(value, error), percent(value, error)] {
                    assert!(said.len() < 40, "{said}");
                    assert!(!said.contains("inf") && !said.contains("NaN"), "{said}");
                }
            }
        }
        assert_eq!(with_error(1.5, Some(0.25)), "1.5000 ± 0.2500");
        assert_eq!(percent(-0.5, None), "-50.00 % (error unknown)");
    }
}
