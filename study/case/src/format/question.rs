//! The table `[question]` of a case: question text, and the number that answers it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Case;

/// Question of a case. Its quantity is the headline, the first figure of the report, and the map of
/// a sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct QuestionSpec {
    /// The question in words. Default: the comment that the file begins with, up to its question
    /// mark.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub text: Option<String>,
    /// Measurement whose verdict comes first. Default: the energy, or the first that compares.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub measure: Option<String>,
    /// Engine whose verdict in this measurement comes first, against the first engine where engines
    /// are compared. Default: the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub engine: Option<String>,
    /// Column of one of its tables that the first figure shows. Default: that of its first figure.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub column: Option<String>,
}

impl QuestionSpec {
    /// Returns true if no key of the question is set.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Returns the question in the comment at the beginning of a case, up to the question mark; `None`
/// without one.
///
/// ```
/// use stosszahl_case::format::leading_question;
///
/// let text = "# Does it cool\n# as Haff says?\n# More.\nformat = 2\n";
/// assert_eq!(leading_question(text).as_deref(), Some("Does it cool as Haff says?"));
/// assert_eq!(leading_question("# No question.\n"), None);
/// ```
pub fn leading_question(text: &str) -> Option<String> {
    let comment = text.lines().map_while(|line| line.strip_prefix('#'));
    let words: Vec<&str> = comment.flat_map(str::split_whitespace).collect();
    let text = words.join(" ");
    Some(text[..=text.find('?')?].to_owned())
}

impl Case {
    /// Derives a title from what is run: "Free cooling of 2500 disks, packing 0.25, restitution
    /// 0.8".
    pub(crate) fn derived_title(&self) -> String {
        let particles = match (self.is_rough(), self.gas.dimension) {
            (false, 2) => "disks",
            (false, _) => "spheres",
            (true, 2) => "rough disks",
            (true, _) => "rough spheres",
        };
        let what = if !self.is_uniform() {
            "Flow"
        } else if self.is_sheared() {
            "Shear flow"
        } else if self.bath().is_some() {
            "Driven gas"
        } else if self.thermostat.is_some() {
            "Gas at constant energy"
        } else if self.aggregation.is_some() {
            "Aggregation"
        } else if self.cools_freely() {
            "Free cooling"
        } else if self.is_elastic() {
            "Elastic gas"
        } else {
            "Gas"
        };
        let number = self
            .gas
            .number
            .map_or(String::new(), |number| format!("{number} "));
        let packing = self.domain.as_ref().and_then(|one| one.packing_fraction);
        let packing = packing.map_or(String::new(), |packing| format!(", packing {packing}"));
        let law = self.gas.restitution.title();
        format!("{what} of {number}{particles}{packing}, {law}")
    }
}
