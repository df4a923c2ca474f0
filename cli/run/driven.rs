//! A driven gas: its kicks, and the temperature between them.

use serde::{Deserialize, Serialize};

/// Parts of the run over which the temperature is averaged.
pub const PARTS: usize = 4;

/// Kicks so far, and the temperature averaged over quarters of the run.
///
/// Between two kicks the gas cools by a few per cent, so the mean of the temperature after one and before the next is
/// the mean over time to second order in that.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Driven {
    /// Kicks so far.
    pub kicks: u64,
    /// Energy that the kicks have added, over particles and the temperature of the start.
    pub gained: f64,
    start: f64,
    after: f64,
    sums: [f64; PARTS],
    intervals: [u64; PARTS],
}

impl Driven {
    /// Before the first kick, at temperature `temperature`.
    pub fn new(temperature: f64) -> Self {
        Self {
            kicks: 0,
            gained: 0.0,
            start: temperature,
            after: temperature,
            sums: [0.0; PARTS],
            intervals: [0; PARTS],
        }
    }

    /// Notes a kick that took the temperature from `before` to `after`, in the middle of an interval at the share
    /// `share` of the run.
    pub fn kick(&mut self, share: f64, before: f64, after: f64) {
        let part = ((share * PARTS as f64) as usize).min(PARTS - 1);
        self.sums[part] += 0.5 * (self.after + before);
        self.intervals[part] += 1;
        // Two degrees of freedom: K/N = T.
        self.gained += (after - before) / self.start;
        self.after = after;
        self.kicks += 1;
    }

    /// Mean temperature over that of the start, from part `first` to before part `end`; `None` without a kick there.
    pub fn temperature(&self, first: usize, end: usize) -> Option<f64> {
        let intervals: u64 = self.intervals[first..end].iter().sum();
        let sum: f64 = self.sums[first..end].iter().sum();
        (intervals > 0).then(|| sum / (self.start * intervals as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_a_saw_tooth() {
        let mut driven = Driven::new(2.0);
        for (share, before, after) in [(0.1, 1.0, 3.0), (0.6, 1.0, 3.0), (0.7, 2.0, 4.0)] {
            driven.kick(share, before, after);
        }
        assert_eq!((driven.kicks, driven.gained), (3, 3.0));
        assert_eq!(driven.temperature(0, 1), Some(0.75));
        assert_eq!(driven.temperature(2, 4), Some(0.5 * (1.0 + 1.25)));
        assert_eq!(driven.temperature(3, 4), None);
    }
}
