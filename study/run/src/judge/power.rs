//! Statistical power of a case before its run: the differences that its replicas can detect, from
//! the expected spread.

use stosszahl_analysis::replicas::{MOST_REPLICAS, replicas_needed, smallest_effect};
use stosszahl_results::format_percent;

use crate::judge::format_margin;

/// Probability with which a difference is to be detected, the statistical power.
pub const FOUND: f64 = 0.9;

/// Expected spread of one tested quantity over replicas, and the difference to detect.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplicaSpread {
    /// Name of the tested quantity, such as "energy, one engine against another".
    pub quantity: String,
    /// Standard deviation of the tested quantity over single replicas.
    pub of_one: f64,
    /// Origin of the standard deviation over replicas, as text.
    pub source: String,
    /// Difference of the quantity that the case should detect.
    pub wanted: f64,
    /// Number of tests that share the verdict's false-alarm probability (Bonferroni).
    pub tests: usize,
    /// True if differences are relative to the quantity, and shown in per cent.
    pub relative: bool,
}

impl ReplicaSpread {
    /// Formats the difference that `replicas` replicas detect with power [`FOUND`] at false-alarm
    /// probability `level`. The text also has the number of replicas that detect the wanted
    /// difference.
    pub fn power(&self, replicas: usize, level: f64) -> String {
        let shown = |difference: f64| {
            if self.relative {
                format_margin(difference)
            } else {
                format!("{difference:.3}")
            }
        };
        let level = level / self.tests as f64;
        let least = smallest_effect(replicas, level, FOUND) * self.of_one;
        let now = if least.is_finite() {
            format!("{replicas} replicas find a difference of {}", shown(least))
        } else {
            "one replica finds nothing".to_owned()
        };
        let needed = replicas_needed(self.wanted / self.of_one, level, FOUND);
        let more = if needed < MOST_REPLICAS {
            ""
        } else {
            "more than "
        };
        format!(
            "{}: {now} in {:.0} of 100 cases; {} takes {more}{needed} replicas (spread of one {}: {})",
            self.quantity,
            100.0 * FOUND,
            shown(self.wanted),
            if self.relative {
                format_percent(self.of_one)
            } else {
                format!("{:.4}", self.of_one)
            },
            self.source
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_said_in_one_line() {
        let spread = ReplicaSpread {
            quantity: "energy".into(),
            of_one: 0.03,
            source: "a guess".into(),
            wanted: 0.05,
            tests: 1,
            relative: true,
        };
        // Student's test at 1 %: 4 replicas detect 4.3 standard deviations; 1.67 of them take 9.
        let said = spread.power(4, 0.01);
        let wanted = "energy: 4 replicas find a difference of 14 % in 90 of 100 cases; 5 % takes 9 replicas (spread of one 3 %: \
                      a guess)";
        assert_eq!(said, wanted);
        assert!(spread.power(1, 0.01).contains("one replica finds nothing"));
    }
}
