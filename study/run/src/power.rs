//! What the replicas of a case can tell, before it is run: the power of its verdicts, from spreads that are known.

use stosszahl_analysis::replicas::{MOST_REPLICAS, replicas_needed, smallest_effect};

use crate::judge::margin;

/// The chance with which a difference is to be found.
pub const FOUND: f64 = 0.9;

/// How far the replicas of one quantity lie apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// What is tested: "energy, one engine against another".
    pub quantity: String,
    /// Standard deviation of one replica.
    pub of_one: f64,
    /// Where that is from.
    pub source: String,
    /// A difference that one would like to see.
    pub wanted: f64,
    /// Tests of the verdict that share its chance of a false alarm.
    pub tests: usize,
    /// Whether differences are shares, shown in per cent.
    pub relative: bool,
}

impl Spread {
    /// What so many replicas find with the chance [`FOUND`] at a chance `level` of a false alarm, and how many it takes to find
    /// what one would like to see.
    pub fn power(&self, replicas: usize, level: f64) -> String {
        let shown = |difference: f64| {
            if self.relative {
                margin(difference)
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
                format!("{:.2} %", 100.0 * self.of_one)
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
        let spread = Spread {
            quantity: "energy".into(),
            of_one: 0.03,
            source: "a guess".into(),
            wanted: 0.05,
            tests: 1,
            relative: true,
        };
        // Student's test at 1 %: 4 replicas find 4.3 standard deviations, 1.67 of them take 9.
        let said = spread.power(4, 0.01);
        let wanted = "energy: 4 replicas find a difference of 14 % in 90 of 100 cases; 5 % takes 9 replicas (spread of one 3.00 %: \
                      a guess)";
        assert_eq!(said, wanted);
        assert!(spread.power(1, 0.01).contains("one replica finds nothing"));
    }
}
