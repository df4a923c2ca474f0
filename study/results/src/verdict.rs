//! Verdicts of a run: conclusions as text, with their kind and the compared number.

use serde::{Deserialize, Serialize};

/// Verdict of a run: a conclusion in words, with its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictText {
    /// Topic of the verdict, such as a measure or an engine.
    pub topic: String,
    /// Conclusion in one short sentence that names its margin.
    pub sentence: String,
    /// Kind of the conclusion, such as agreement or difference.
    pub kind: VerdictKind,
    /// Compared number, chosen before the run; `None` if nothing is compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<ComparedNumber>,
}

/// Compared number behind a verdict: a difference with its error and its margin, at a time or in a
/// window chosen before the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedNumber {
    /// Name of the compared quantity in words, such as "energy".
    pub quantity: String,
    /// Time or window of the difference in words, such as "at t = 20".
    pub place: String,
    /// True if the difference is relative to the quantity.
    pub relative: bool,
    /// Measured difference, in the units of the quantity, or relative to it.
    pub difference: f64,
    /// Standard error of the difference, over replicas or blocks of time.
    pub standard_error: Option<f64>,
    /// Degrees of freedom of the standard error; `None` where it is known without replicas.
    pub degrees_of_freedom: Option<u64>,
    /// Largest difference that counts as agreement, in the unit of the difference.
    pub margin: f64,
    /// Threshold beyond which the whole confidence interval must lie to count as a difference.
    pub differ_beyond: f64,
    /// Probability that the interval of the verdict misses the true difference.
    pub level: f64,
}

/// Outcome of a verdict: of a comparison, or a warning or note without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerdictKind {
    /// Agreement: the whole interval of the difference lies inside the margin that the sentence
    /// names.
    Agree,
    /// Difference: the whole interval lies on one side of zero, or beyond the margin if that is
    /// requested.
    Differ,
    /// Neither agreement nor difference: the interval allows both; the sentence says which bound
    /// holds.
    Undecided,
    /// Warning: the result must be interpreted with care.
    Warning,
    /// Note: an informative number without a comparison.
    Note,
    /// Void comparison: the compared number is known not to represent its quantity; the sentence
    /// says why.
    Void,
}

/// Returns the headlines: the verdict that answers the question of a case, and up to three more.
///
/// The first headline is the first comparison, even if it is void, so that no other verdict takes
/// its place silently. Void comparisons come last among the others. Notes and warnings are no
/// headlines.
pub fn headlines(verdicts: &[VerdictText]) -> Vec<&VerdictText> {
    let compares =
        |one: &&VerdictText| !matches!(one.kind, VerdictKind::Note | VerdictKind::Warning);
    let mut all: Vec<_> = verdicts.iter().filter(compares).collect();
    if let Some((_, others)) = all.split_first_mut() {
        others.sort_by_key(|one| one.kind == VerdictKind::Void);
    }
    all.truncate(4);
    all
}

impl VerdictKind {
    /// Returns the name of the verdict kind in tables and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Differ => "differ",
            Self::Undecided => "undecided",
            Self::Warning => "warning",
            Self::Note => "note",
            Self::Void => "void",
        }
    }
}
