//! Conclusions: one vocabulary for all of them.

use serde::{Deserialize, Serialize};

/// A conclusion in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// What the conclusion is about.
    pub topic: String,
    /// The conclusion, one short sentence that names its margin.
    pub sentence: String,
    /// Its kind.
    pub kind: VerdictKind,
}

/// Kind of a conclusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerdictKind {
    /// The compared quantities agree within the margin that the sentence names.
    Agree,
    /// They differ beyond their errors.
    Differ,
    /// The errors are too wide to tell.
    Undecided,
    /// The result must be read with care.
    Warning,
    /// Nothing is compared: a number, for information.
    Note,
    /// What was compared is known not to stand for what it should; the sentence says why.
    Void,
}

/// The conclusion that answers the question of a case, and up to three that come next, of those in the order of the judge; numbers
/// for information and warnings are none.
pub fn headlines(verdicts: &[Verdict]) -> Vec<&Verdict> {
    let rank = |verdict: &&Verdict| match verdict.kind {
        VerdictKind::Agree | VerdictKind::Differ | VerdictKind::Undecided => Some(0),
        VerdictKind::Void => Some(1),
        VerdictKind::Note | VerdictKind::Warning => None,
    };
    let mut all: Vec<_> = verdicts.iter().filter(|one| rank(one).is_some()).collect();
    all.sort_by_key(rank);
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
