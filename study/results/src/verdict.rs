//! Verdicts: conclusions of a run in one vocabulary.

use serde::{Deserialize, Serialize};

/// Verdict: a conclusion in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictText {
    /// Topic of the conclusion.
    pub topic: String,
    /// Conclusion in one short sentence that names its margin.
    pub sentence: String,
    /// Kind of the conclusion.
    pub kind: VerdictKind,
    /// Compared number, chosen before the run; `None` if nothing is compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<ComparedNumber>,
}

/// Difference behind a verdict, at a time or in a window chosen before the run: the last one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedNumber {
    /// Quantity in words, such as "energy".
    pub quantity: String,
    /// Time or window of the difference in words, such as "at t = 20".
    pub place: String,
    /// True if the difference is relative to the quantity.
    pub relative: bool,
    /// Difference found, in the units of the quantity, or relative to it.
    pub difference: f64,
    /// Standard error of the difference, over replicas or blocks of time.
    pub standard_error: Option<f64>,
    /// Degrees of freedom of the standard error; `None` where it is known without replicas.
    pub degrees_of_freedom: Option<u64>,
    /// Largest difference that counts as agreement, in the unit of the difference.
    pub margin: f64,
    /// Difference beyond which the whole interval must lie to count as a difference.
    pub differ_beyond: f64,
    /// Probability that the interval of the verdict misses the true difference.
    pub level: f64,
}

/// Outcome of a verdict: of a comparison, or a warning or note without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerdictKind {
    /// The whole interval of the difference lies inside the margin that the sentence names.
    Agree,
    /// The whole interval lies on one side of zero, or beyond the margin if that is requested.
    Differ,
    /// The interval allows agreement and difference; the sentence says which bound holds.
    Undecided,
    /// The result must be read with care.
    Warning,
    /// Informative number without a comparison.
    Note,
    /// The compared number is known not to represent its quantity; the sentence says why.
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
    /// Name of the kind in tables and reports.
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
