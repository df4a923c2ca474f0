//! Verdicts on the numbers and bounds that a paper states.

use stosszahl_results::{TableEstimate, VerdictKind, VerdictText, format_number};

use super::{VerdictRule, interval_of, verdict, verdict_within, with_error};

/// Number or bound that a paper states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClaimedValue {
    /// Number that a paper states, with an error and a margin.
    Value {
        /// Number that the paper states.
        value: f64,
        /// Standard error that the paper states; `None` if it states none.
        error: Option<f64>,
        /// Largest deviation from the paper's number that counts as agreement.
        margin: f64,
    },
    /// Lower bound that a paper states for a number.
    Above(f64),
    /// Upper bound that a paper states for a number.
    Below(f64),
}

impl ClaimedValue {
    /// Formats the paper's number or bound for a sentence.
    fn words(self) -> String {
        match self {
            Self::Value { value, error, .. } if error.is_some() => with_error(value, error),
            Self::Value { value, .. } => format_number(value),
            Self::Above(bound) => format!("above {}", format_number(bound)),
            Self::Below(bound) => format!("below {}", format_number(bound)),
        }
    }

    /// Decides the verdict on a measured number against the paper's, with a confidence interval at
    /// error probability `level`.
    ///
    /// A value agrees if the whole interval of the difference lies inside the margin, which is how
    /// well the paper can be read, and differs if it lies beyond the margin; the error of the paper
    /// counts. A bound holds if the whole interval lies beyond it, and does not if the interval
    /// lies on its other side.
    pub fn kind(self, found: &TableEstimate, level: f64) -> VerdictKind {
        let Some(ours) = found.value.filter(|value| value.is_finite()) else {
            return VerdictKind::Undecided;
        };
        let side = |excess: f64| {
            let off = TableEstimate {
                value: Some(excess),
                ..*found
            };
            match interval_of(&off, level).ends {
                Some([low, _]) if low >= 0.0 => VerdictKind::Agree,
                Some([_, high]) if high < 0.0 => VerdictKind::Differ,
                _ => VerdictKind::Undecided,
            }
        };
        match self {
            Self::Value {
                value,
                error,
                margin,
            } => {
                let ours_se = found.standard_error;
                let off = TableEstimate {
                    value: Some(ours - value),
                    standard_error: ours_se.map(|se| se.hypot(error.unwrap_or(0.0))),
                    ..*found
                };
                let rule = VerdictRule {
                    level,
                    margin,
                    differ_beyond: margin,
                };
                verdict_within(&off, &rule)
            }
            Self::Above(bound) => side(ours - bound),
            Self::Below(bound) => side(bound - ours),
        }
    }
}

/// Decides the verdict on one claim of a paper, and words it.
pub fn claim(
    topic: impl Into<String>,
    found: &TableEstimate,
    said: ClaimedValue,
    level: f64,
) -> VerdictText {
    let kind = said.kind(found, level);
    let value = found.value.unwrap_or(f64::NAN);
    let freedom = match found.replicas {
        Some(replicas) if replicas > 1 => format!(" ({} degrees of freedom)", replicas - 1),
        _ => String::new(),
    };
    let ours = match found.standard_error {
        Some(0.0) => format_number(value),
        Some(error) => with_error(value, Some(error)) + &freedom,
        None => with_error(value, None),
    };
    let words = said.words();
    let sentence = match (kind, said) {
        (VerdictKind::Agree, ClaimedValue::Value { margin, .. }) => {
            format!(
                "Found {ours} agrees with {words} within {}.",
                format_number(margin)
            )
        }
        (VerdictKind::Differ, ClaimedValue::Value { margin, .. }) => {
            format!(
                "Found {ours} differs from {words} by more than {}.",
                format_number(margin)
            )
        }
        (VerdictKind::Agree, _) => format!("Found {ours} is {words}."),
        (VerdictKind::Differ, _) => format!("Found {ours} is not {words}."),
        (_, ClaimedValue::Value { margin, .. }) => {
            let margin = format_number(margin);
            format!("Whether {ours} is {words} within {margin} is undecided.")
        }
        (_, _) => format!("Whether {ours} is {words} is undecided."),
    };
    verdict(topic, sentence, kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value: f64, error: f64, replicas: Option<usize>) -> TableEstimate {
        TableEstimate {
            replicas,
            ..TableEstimate::with_error(value, Some(error))
        }
    }

    #[test]
    fn a_value_within_its_margin_agrees_and_one_beyond_it_differs() {
        let said = |value: f64| ClaimedValue::Value {
            value,
            error: None,
            margin: 0.02,
        };
        let kind = |found: f64, error: f64, value: f64| {
            said(value).kind(&estimate(found, error, None), 0.001)
        };
        assert_eq!(kind(1.0, 0.001, 1.01), VerdictKind::Agree);
        assert_eq!(kind(1.0, 0.002, 1.018), VerdictKind::Undecided);
        assert_eq!(kind(1.0, 0.001, 1.1), VerdictKind::Differ);
        assert_eq!(kind(1.0, 0.001, 0.9), VerdictKind::Differ);
        // 3.3 standard errors are the interval at this level.
        assert_eq!(kind(1.0, 0.04, 1.1), VerdictKind::Undecided);
        assert_eq!(kind(1.0, 0.02, 1.0), VerdictKind::Undecided);
        assert_eq!(kind(-1.0, 0.001, -1.1), VerdictKind::Differ);
        assert_eq!(kind(0.01, 0.001, 0.0), VerdictKind::Agree);
    }

    #[test]
    fn exact_numbers_have_five_digits() {
        let words = [
            0.042_966_4,
            12_072_722.0,
            32.594,
            0.125,
            1.0,
            240.0,
            0.0,
            99_856.0,
        ];
        let expected = [
            "0.042966", "1.2073e7", "32.594", "0.125", "1", "240", "0", "99856",
        ];
        assert_eq!(words.map(format_number), expected);
    }

    #[test]
    fn the_error_of_the_paper_counts() {
        let said = |error| ClaimedValue::Value {
            value: 1.1,
            error,
            margin: 0.02,
        };
        let found = estimate(1.0, 0.001, None);
        assert_eq!(said(None).kind(&found, 0.001), VerdictKind::Differ);
        assert_eq!(said(Some(0.05)).kind(&found, 0.001), VerdictKind::Undecided);
    }

    #[test]
    fn a_bound_holds_if_the_interval_lies_beyond_it() {
        let kind = |bound: ClaimedValue, error: f64| bound.kind(&estimate(1.0, error, None), 0.001);
        assert_eq!(kind(ClaimedValue::Above(0.9), 0.01), VerdictKind::Agree);
        assert_eq!(kind(ClaimedValue::Above(0.9), 0.1), VerdictKind::Undecided);
        assert_eq!(kind(ClaimedValue::Above(1.2), 0.01), VerdictKind::Differ);
        assert_eq!(kind(ClaimedValue::Below(1.2), 0.01), VerdictKind::Agree);
        assert_eq!(kind(ClaimedValue::Below(0.9), 0.01), VerdictKind::Differ);
        assert_eq!(kind(ClaimedValue::Below(0.9), 0.05), VerdictKind::Undecided);
        // Two replicas know their error badly.
        let two = estimate(1.0, 0.01, Some(2));
        assert_eq!(
            ClaimedValue::Below(0.9).kind(&two, 0.001),
            VerdictKind::Undecided
        );
    }

    #[test]
    fn nothing_is_agreement_whose_error_is_unknown() {
        let found = TableEstimate::with_error(1.0, None);
        assert_eq!(
            ClaimedValue::Above(0.0).kind(&found, 0.05),
            VerdictKind::Undecided
        );
        let said = claim("it", &found, ClaimedValue::Below(2.0), 0.05);
        assert_eq!(said.kind, VerdictKind::Undecided);
        assert!(said.sentence.contains("error unknown"), "{}", said.sentence);
    }
}
