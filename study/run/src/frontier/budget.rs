//! Distribution of a frontier's budget of CPU time over the reference, the settings, and the test
//! of recommendations.
//!
//! The shares rest on counts of work and nominal speeds, never on a clock, so the same case and
//! budget give the same runs on any machine. A machine slower than the nominal one by more than
//! [`PATIENCE`] leaves out runs that are then too costly, and says so.

use super::setting::RunSetting;
use crate::plan::CasePlan;

/// Share of the CPU time budget for the reference ensemble.
const REFERENCE: f64 = 0.2;
/// Share of the CPU time budget for the measured settings.
const SETTINGS: f64 = 0.5;
/// Share of the CPU time budget that is reserved for the test of recommendations.
pub(crate) const TESTS: f64 = 0.3;
/// Fewest and most runs of the reference ensemble of exact dynamics.
const REFERENCE_RUNS: [usize; 2] = [16, 1000];
/// Fewest and most repetitions of a measured setting.
const REPETITIONS: [u64; 2] = [4, 256];
/// CPU time, over the budget, after which no further run begins.
pub(crate) const PATIENCE: f64 = 4.0;

/// Division of a budget: number of runs of each setting and of the reference ensemble.
pub(crate) struct Shares {
    /// Repetitions of each setting, in the order of the settings; `None` for settings that are left
    /// out.
    pub repetitions: Vec<Option<u64>>,
    /// Number of runs of the reference ensemble.
    pub reference: usize,
}

/// Returns the number of repetitions of a setting that fit into a CPU time `share` \[s\], at
/// `seconds` of CPU time for one run; from 4 to 256.
fn repetitions_in(share: f64, seconds: f64) -> u64 {
    ((share / seconds) as u64).clamp(REPETITIONS[0], REPETITIONS[1])
}

/// Distributes a budget of CPU time \[s\] over settings and the reference ensemble.
///
/// Each setting gets the same CPU time, and at least four repetitions; the costliest settings are
/// left out until that is possible.
pub(crate) fn shared(plan: &CasePlan, settings: &[RunSetting], budget: f64) -> Shares {
    let costs: Vec<f64> = settings
        .iter()
        .map(|one| one.nominal_seconds(plan))
        .collect();
    let exact = RunSetting::exact(plan.count());
    let reference = REFERENCE * budget / exact.nominal_seconds(plan);
    let reference = (reference as usize).clamp(REFERENCE_RUNS[0], REFERENCE_RUNS[1]);
    let mut repetitions = shares(&costs, SETTINGS * budget);
    for (setting, count) in settings.iter().zip(&mut repetitions) {
        // The method of the reference is judged by its spread, which must be known well.
        if setting.is_reference(plan.count()) {
            let least = reference as u64 / 8;
            *count = Some(count.unwrap_or(0).max(least).max(REPETITIONS[0]));
        }
    }
    Shares {
        repetitions,
        reference,
    }
}

fn shares(costs: &[f64], budget: f64) -> Vec<Option<u64>> {
    let mut kept: Vec<usize> = (0..costs.len()).collect();
    kept.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
    let total = |kept: &[usize], share: f64| -> f64 {
        let cost = |&index: &usize| costs[index] * repetitions_in(share, costs[index]) as f64;
        kept.iter().map(cost).sum()
    };
    while kept.len() > 1 && total(&kept, 0.0) > budget {
        kept.pop();
    }
    // The share at which the whole is spent, by bisection: time rises with it.
    let [mut low, mut high] = [0.0, budget];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if total(&kept, middle) > budget {
            high = middle;
        } else {
            low = middle;
        }
    }
    let mut all = vec![None; costs.len()];
    for index in kept {
        all[index] = Some(repetitions_in(low, costs[index]));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_shared_equally_and_the_costliest_are_left_out() {
        let shares = shares(&[0.1, 1.0, 10.0, 1000.0], 300.0);
        assert_eq!(shares[0], Some(REPETITIONS[1]), "no more than is useful");
        assert_eq!(shares[3], None);
        let [one, ten] = [1, 2].map(|index: usize| shares[index].unwrap_or(0) as f64);
        let spent = 0.1 * 256.0 + one + 10.0 * ten;
        assert!(spent <= 300.0 && spent > 250.0, "{spent}: {shares:?}");
        assert!((one / (10.0 * ten) - 1.0).abs() < 0.1, "{shares:?}");
    }

    #[test]
    fn a_tiny_budget_keeps_the_cheapest() {
        assert_eq!(shares(&[2.0, 1.0], 0.5), [None, Some(REPETITIONS[0])]);
        assert_eq!(shares(&[], 1.0), []);
    }
}
