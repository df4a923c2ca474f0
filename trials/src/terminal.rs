//! Terminal input and output that all commands of `stosszahl-trials` share.

use std::io::{self, Write as _};
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser};

use crate::trial::TrialRow;

/// Prints a line to standard output at once.
pub(crate) fn say(text: &str) {
    let mut out = io::stdout();
    // A closed standard output ends nothing.
    let _ = writeln!(out, "{text}").and_then(|()| out.flush());
}

/// Creates the command-line parser that accepts the names of the given trials.
pub(crate) fn trial_names(trials: &[TrialRow]) -> PossibleValuesParser {
    let value = |trial: &TrialRow| PossibleValue::new(trial.name).help(trial.tried);
    PossibleValuesParser::new(trials.iter().map(value))
}

/// Parses a duration such as 90s, 5m or 1h.
///
/// # Errors
///
/// The text found and the allowed forms.
pub(crate) fn parse_duration(text: &str) -> Result<Duration, String> {
    humantime::parse_duration(text)
        .map_err(|error| format!("{error}; allowed is a time such as 90s, 5m or 1h"))
}
