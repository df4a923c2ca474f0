//! `stosszahl stress`.

use super::{Case, Effort};
use crate::arguments::StressCases;

/// Why the command does not succeed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StressError {
    /// No case has this name.
    #[error("--case {found}: allowed are {}", allowed.join(", "))]
    Unknown {
        /// What was asked for.
        found: String,
        /// The names of all cases.
        allowed: Vec<&'static str>,
    },
    /// Something does not hold.
    #[error("{} of {of} hard cases failed: {}", failed.len(), failed.join(", "))]
    Failed {
        /// Names of the cases that failed.
        failed: Vec<&'static str>,
        /// How many were run.
        of: usize,
    },
}

/// Runs those of the cases that are asked for, one after the other, and says what was found. `collisions`: of the runs whose
/// length can be set.
///
/// # Errors
/// [`StressError`] if a case fails or has an unknown name.
pub fn command(
    cases: &[Case],
    arguments: &StressCases,
    collisions: Option<u64>,
    say: impl Fn(&str),
) -> Result<(), StressError> {
    let named = |name: &String| {
        let known = cases.iter().find(|case| case.name == name).copied();
        known.ok_or_else(|| StressError::Unknown {
            found: name.clone(),
            allowed: cases.iter().map(|case| case.name).collect(),
        })
    };
    let chosen: Vec<Case> = if arguments.case.is_empty() {
        cases.to_vec()
    } else {
        arguments.case.iter().map(named).collect::<Result<_, _>>()?
    };
    if arguments.list {
        for case in chosen {
            say(&format!(
                "{}\n  tried  {}\n  must   {}",
                case.name, case.tried, case.required
            ));
        }
        return Ok(());
    }
    let effort = Effort {
        long: arguments.long,
        collisions,
        tell: arguments.long || collisions.is_some(),
    };
    let mut reports = Vec::with_capacity(chosen.len());
    for case in chosen {
        let report = case.run(effort);
        if !arguments.json {
            say(&report.to_string());
        }
        reports.push(report);
    }
    let of = reports.len();
    let failed: Vec<_> = reports
        .iter()
        .filter(|report| !report.passed())
        .map(|report| report.name)
        .collect();
    if arguments.json {
        say(&serde_json::to_string_pretty(&reports).unwrap_or_default());
    } else {
        let seconds: f64 = reports.iter().map(|report| report.seconds).sum();
        say(&format!(
            "{} of {of} hard cases passed in {seconds:.0} s",
            of - failed.len()
        ));
    }
    if failed.is_empty() {
        Ok(())
    } else {
        Err(StressError::Failed { failed, of })
    }
}
