//! Steady state of aggregation and fragmentation: balance of both, and a power-law fit of cluster
//! sizes.

use stosszahl_analysis::statistics::Estimate;
use stosszahl_results::VerdictText;

use super::{ClusterRecord, Half, Schedule, Sizes};
use crate::judge::{MeasuredPoint, VerdictRule, against_theory, verdict_note, with_error};
use crate::plan::CasePlan;

/// Sums the numbers of clusters by size over all sample times in the steady state; also returns the
/// number of these times.
pub(super) fn all_steady(record: &ClusterRecord) -> (Sizes, u64) {
    let mut sum = Sizes::new();
    for half in &record.steady {
        for (&monomers, &count) in &half.sizes {
            *sum.entry(monomers).or_default() += count;
        }
    }
    let times = record.steady.iter().map(|half| half.times).sum();
    (sum, times)
}

/// Computes the number of clusters in the second half of the steady state over that in the first
/// half.
fn number_drift(records: &[&ClusterRecord]) -> Option<Estimate> {
    let mean = |half: &Half| {
        let clusters: u64 = half.sizes.values().sum();
        clusters as f64 / half.times.max(1) as f64
    };
    let ratios: Vec<f64> = records
        .iter()
        .map(|record| mean(&record.steady[1]) / mean(&record.steady[0]))
        .filter(|ratio| ratio.is_finite())
        .collect();
    Estimate::over_replicas(&ratios)
}

/// Fits a power law with an exponential cut-off, `n_k = c k^-exponent exp(-k/cutoff)`, to the
/// cluster sizes of each replica. Returns exponent and inverse cut-off with errors from the spread
/// over replicas. `None` if a replica lacks three sizes with clusters.
fn fit_power_law(records: &[&ClusterRecord], range: [u32; 2]) -> Option<[Estimate; 2]> {
    let fits: Option<Vec<[f64; 2]>> = records
        .iter()
        .map(|record| fit_one(&all_steady(record).0, range))
        .collect();
    let fits = fits?;
    let of = |place: usize| {
        let values: Vec<f64> = fits.iter().map(|fit| fit[place]).collect();
        Estimate::over_replicas(&values)
    };
    Some([of(0)?, of(1)?])
}

/// Fits exponent and inverse cut-off to one size distribution: least squares of `ln n_k` on `ln k`
/// and k, each size with the weight of its count, which is the inverse variance of the logarithm of
/// a Poisson number.
fn fit_one(sizes: &Sizes, [low, high]: [u32; 2]) -> Option<[f64; 2]> {
    let points: Vec<[f64; 4]> = sizes
        .range(low..=high)
        .filter(|&(_, &count)| count > 0)
        .map(|(&monomers, &count)| {
            let (k, n) = (f64::from(monomers), count as f64);
            [k.ln(), k, n.ln(), n]
        })
        .collect();
    if points.len() < 3 {
        return None;
    }
    let weight: f64 = points.iter().map(|point| point[3]).sum();
    let mean = |place: usize| {
        let sum: f64 = points.iter().map(|point| point[3] * point[place]).sum();
        sum / weight
    };
    let means = [mean(0), mean(1), mean(2)];
    let product = |a: usize, b: usize| -> f64 {
        points
            .iter()
            .map(|point| point[3] * (point[a] - means[a]) * (point[b] - means[b]))
            .sum()
    };
    let (aa, ab, bb) = (product(0, 0), product(0, 1), product(1, 1));
    let determinant = aa * bb - ab * ab;
    let (ay, by) = (product(0, 2), product(1, 2));
    let exponent = (ab * by - bb * ay) / determinant;
    let inverse_cutoff = (ab * ay - aa * by) / determinant;
    (exponent.is_finite() && inverse_cutoff.is_finite()).then_some([exponent, inverse_cutoff])
}

/// Decides the verdicts on whether aggregation and fragmentation balance, and on the power law of
/// the steady cluster sizes.
pub(super) fn steady_state(
    plan: &CasePlan,
    records: &[&ClusterRecord],
    rule: &VerdictRule,
) -> Vec<VerdictText> {
    let (Some(steady), Some(drift)) = (Schedule::of(plan).steady, number_drift(records)) else {
        return Vec::new();
    };
    let point = MeasuredPoint {
        time: steady.from,
        measured: drift.value,
        error: drift.standard_error,
        replicas: Some(drift.replicas),
        theory: 1.0,
        theory_error: None,
    };
    let mut list: Vec<VerdictText> = Vec::new();
    list.extend(against_theory(
        "steady state",
        [
            "The second half of the steady state",
            "its first half",
            "number of clusters",
        ],
        &[point],
        rule,
    ));
    if let Some([exponent, cutoff]) = fit_power_law(records, steady.fit_monomers) {
        let [low, high] = steady.fit_monomers;
        let d = plan.gas.dimension as f64;
        list.push(verdict_note(
            "sizes in the steady state",
            // With k ~ R^D and dk ~ R^(D - 1) dR, k^-q dk is R^-(D q - D + 1) dR.
            format!(
                "Numbers of clusters of {low} to {high} monomers follow k^-q exp(-k/K) with q = {}, which is {:.3} for their \
                 radii, and 1/K = {:.5}{}.",
                with_error(exponent.value, exponent.standard_error),
                d * exponent.value - d + 1.0,
                cutoff.value,
                cutoff
                    .standard_error
                    .map_or(String::new(), |error| format!(" ± {error:.5}"))
            ),
        ));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts by a known law, rounded to whole numbers of 1e5 and more: relative errors below 1e-5
    /// in the logarithms, of which the fit makes less than 1e-3.
    #[test]
    fn fits_return_the_law_of_the_counts() {
        let sizes: Sizes = (1..=60_u32)
            .map(|k| {
                let k_real = f64::from(k);
                let number = 1e9 * k_real.powf(-1.7) * (-k_real / 25.0).exp();
                (k, number.round() as u64)
            })
            .collect();
        let [exponent, inverse] = fit_one(&sizes, [2, 50]).expect("a fit");
        assert!((exponent - 1.7).abs() < 1e-3, "{exponent}");
        assert!((inverse - 0.04).abs() < 1e-4, "{inverse}");
        assert_eq!(fit_one(&sizes, [2, 3]), None);
    }
}
