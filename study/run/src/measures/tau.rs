//! Reduced time `tau_1` of Bodrova & Osinsky (2024), Eqs. 6 and 7, which counts collisions of a
//! reference species, by integration over samples.
//!
//! `d tau_1/dt = 4 n_1 d_1^2 chi sqrt(pi T_1/m_1)` is the rate at which a particle of species 1
//! hits its like in a Maxwellian gas. Between two samples `1/sqrt(T_1)` is taken to be linear in
//! time, which Haff's law makes exact.

use stosszahl_results::TableEstimate;

use super::species_record::{SpeciesRecord, SpeciesSample, against, measured};
use crate::plan::{CasePlan, Predicted};
use crate::theory::homogeneous;

/// Computes the rate at which a particle of species 1 collides with its like at temperature 1
/// \[1/time\], `d tau_1/dt`; `None` if species 1 is a tracer or has many sizes.
pub(super) fn rate(plan: &CasePlan) -> Option<f64> {
    let single =
        plan.gas.classes.len() == plan.gas.species.len() && plan.case.aggregation.is_none();
    let mixture = plan.mixture().ok().filter(|_| single)?;
    Some(mixture.like_collisions(0, 1.0)).filter(|&rate| rate > 0.0)
}

/// Computes `tau_1` at all sample times; empty if the case has no such time.
pub(super) fn tau_at_samples(plan: &CasePlan, records: &[&SpeciesRecord]) -> Vec<TableEstimate> {
    let Some(rate) = rate(plan) else {
        return Vec::new();
    };
    let times: Vec<f64> = plan.sample_times();
    let times: Vec<f64> = times.iter().map(|&time| plan.engine_time(time)).collect();
    let first =
        |sample: &SpeciesSample| sample.groups.first().map_or(0.0, |group| group.temperature);
    let found: Vec<Vec<f64>> = records
        .iter()
        .map(|record| {
            let temperatures: Vec<f64> = record.samples.iter().map(first).collect();
            integrated_rate(rate, &times, &temperatures)
        })
        .collect();
    let theory = homogeneous::curves(plan).ok().map(|curves| {
        let groups = curves.at.iter().filter_map(|curve| curve.groups.first());
        let temperatures: Vec<f64> = groups.map(|group| group.temperature.value).collect();
        integrated_rate(rate, &times, &temperatures)
    });
    let one = |index: usize| {
        let at: Vec<f64> = found
            .iter()
            .filter_map(|all| all.get(index).copied())
            .collect();
        let theory = theory.as_ref().and_then(|all| all.get(index));
        let theory = theory.map(|&value| Predicted { value, error: None });
        against(measured(&at, |&tau| tau, None), theory)
    };
    (0..times.len()).map(one).collect()
}

/// Integrates the rate `rate sqrt(T)` from the first time to each time, with 1/sqrt(T) linear
/// between samples.
fn integrated_rate(rate: f64, times: &[f64], temperatures: &[f64]) -> Vec<f64> {
    let slowness: Vec<f64> = temperatures.iter().map(|t| t.sqrt().recip()).collect();
    let mut sum = 0.0;
    let steps = times.windows(2).zip(slowness.windows(2));
    let sums = steps.map(|(time, slow)| {
        let grown = slow[1] / slow[0] - 1.0;
        // The mean of 1/x over an interval is ln(b/a)/(b - a).
        let mean = if grown == 0.0 {
            1.0
        } else {
            grown.ln_1p() / grown
        };
        sum += rate * (time[1] - time[0]) * mean / slow[0];
        sum
    });
    std::iter::once(0.0).chain(sums).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of a run: five a decade.
    fn times() -> Vec<f64> {
        let later = (0..=25).map(|index| 0.1 * 10.0_f64.powf(0.2 * f64::from(index)));
        std::iter::once(0.0).chain(later).collect()
    }

    #[test]
    fn haffs_law_is_integrated_exactly() {
        let haff: Vec<f64> = times().iter().map(|t| (1.0 + t / 3.0).powi(-2)).collect();
        let found = integrated_rate(0.5, &times(), &haff);
        for (time, tau) in times().iter().zip(found) {
            let exact = 0.5 * 3.0 * (1.0 + time / 3.0).ln();
            // Rounding of thirty steps.
            assert!((tau - exact).abs() < 1e-13 * (1.0 + exact), "{time}: {tau}");
        }
        // Without dissipation time and collisions go together.
        assert_eq!(
            integrated_rate(0.5, &[0.0, 2.0, 8.0], &[1.0; 3]),
            [0.0, 1.0, 4.0]
        );
    }

    #[test]
    fn a_viscoelastic_gas_is_integrated_closely() {
        let power: Vec<f64> = times().iter().map(|t| (1.0 + t).powf(-5.0 / 3.0)).collect();
        let found = integrated_rate(1.0, &times(), &power);
        for (time, tau) in times().iter().zip(found) {
            let exact = 6.0 * ((1.0 + time).powf(1.0 / 6.0) - 1.0);
            // The curvature of t^(5/6) over a fifth of a decade: its chord is off by
            // (5/6)(1/6)(0.46)^2/12 = 0.25 %.
            assert!((tau - exact).abs() <= 2.5e-3 * exact, "{time}: {tau}");
        }
    }
}
