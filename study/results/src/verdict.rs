//! Conclusions: one vocabulary for all of them.

use serde::{Deserialize, Serialize};

/// A conclusion in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// What the conclusion is about.
    pub topic: String,
    /// The conclusion, one short sentence that names its margin.
    pub sentence: String,
    /// Its kind.
    pub kind: VerdictKind,
    /// The number that it is about, chosen before the run; `None` if nothing is compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<ComparedNumber>,
}

/// Difference that a verdict is about, at the place that is chosen before the run: the last time, or the last window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedNumber {
    /// Quantity in words, such as "energy".
    pub quantity: String,
    /// Place in words, such as "at t = 20".
    pub place: String,
    /// Whether the difference is a share of the quantity.
    pub relative: bool,
    /// The difference.
    pub difference: f64,
    /// Its standard error over replicas, or blocks of time.
    pub standard_error: Option<f64>,
    /// Degrees of freedom of the standard error; `None` where it is known without replicas.
    pub degrees_of_freedom: Option<u64>,
    /// Largest difference that counts as agreement.
    pub margin: f64,
    /// Difference beyond which an interval must lie to be called one.
    pub differ_beyond: f64,
    /// Chance that the interval of the verdict misses this difference.
    pub level: f64,
}

/// Kind of a conclusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerdictKind {
    /// The whole interval of the difference lies inside the margin that the sentence names.
    Agree,
    /// The whole interval lies on one side of zero, or of the margin where that is asked for.
    Differ,
    /// The interval allows both; the sentence says which bound holds.
    Undecided,
    /// The result must be read with care.
    Warning,
    /// Nothing is compared: a number, for information.
    Note,
    /// What was compared is known not to stand for what it should; the sentence says why.
    Void,
}

/// The conclusion that answers the question of a case, and up to three that come next. The first is the first that compares, even if it
/// is void: its place is never given to another without a word. Void ones come last of the others; numbers for information and warnings
/// are none.
pub fn headlines(verdicts: &[Verdict]) -> Vec<&Verdict> {
    let compares = |one: &&Verdict| !matches!(one.kind, VerdictKind::Note | VerdictKind::Warning);
    let mut all: Vec<_> = verdicts.iter().filter(compares).collect();
    if let Some((_, others)) = all.split_first_mut() {
        others.sort_by_key(|one| one.kind == VerdictKind::Void);
    }
    all.truncate(4);
    all
}

impl VerdictKind {
    /// Its word in tables and reports.
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
