//! Tables of a gas of several species.

use super::over;
use crate::run::Finished;
use crate::setup::Setup;
use crate::tables::{PairImpactRow, PartialTemperatureRow};

/// Temperatures of the species of one engine.
pub(super) fn partial(
    setup: &Setup,
    engine: &str,
    runs: &[&Finished],
) -> Vec<PartialTemperatureRow> {
    let Some(first) = runs.first().filter(|_| !setup.species.is_empty()) else {
        return Vec::new();
    };
    let times: Vec<f64> = first.record.partial.iter().map(|sample| sample.0).collect();
    let theory = setup.partial_temperatures(&times);
    let mut rows = Vec::new();
    for (index, &time) in times.iter().enumerate() {
        let expected = theory.as_ref().map(|theory| &theory[index]);
        for number in 0..setup.species.len() {
            let temperature = over(runs, |run| {
                let start = run.record.energies[0].1.temperature;
                Some(run.record.partial[index].1[number] / start)
            });
            let ratio = over(runs, |run| {
                let partial = &run.record.partial[index].1;
                Some(partial[number] / partial[0])
            });
            rows.push(PartialTemperatureRow {
                engine: engine.to_owned(),
                time_over_t0: time,
                species: number as u64 + 1,
                temperature_ratio: temperature.0.unwrap_or(f64::NAN),
                temperature_ratio_se: temperature.1,
                temperature_ratio_theory: expected.map(|all| all[number]),
                ratio_to_first: ratio.0.unwrap_or(f64::NAN),
                ratio_to_first_se: ratio.1,
                ratio_to_first_theory: expected.map(|all| all[number] / all[0]),
                replicas: runs.len() as u64,
            });
        }
    }
    rows
}

/// P(b/d) by kind of pair of one engine.
pub(super) fn impact(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<PairImpactRow> {
    let all: Vec<_> = runs
        .iter()
        .filter_map(|run| run.record.windows.pairs.as_ref())
        .collect();
    let Some(first) = all.first() else {
        return Vec::new();
    };
    let bins = setup.case.measure.impact_bins;
    let mut rows = Vec::new();
    for (kind, pair) in first.kinds().iter().enumerate() {
        for (window, &[start, end]) in setup.case.measure.impact_windows.iter().enumerate() {
            let counts: Vec<u64> = (0..bins)
                .map(|bin| {
                    all.iter()
                        .map(|pairs| pairs.counts(window, kind)[bin])
                        .sum()
                })
                .collect();
            let total: u64 = counts.iter().sum();
            for (bin, &count) in counts.iter().enumerate() {
                let scale = bins as f64 / total.max(1) as f64;
                rows.push(PairImpactRow {
                    engine: engine.to_owned(),
                    species_a: pair.species[0] as u64 + 1,
                    species_b: pair.species[1] as u64 + 1,
                    window_start: start,
                    window_end: end,
                    bin_low: bin as f64 / bins as f64,
                    bin_high: (bin + 1) as f64 / bins as f64,
                    count,
                    density: count as f64 * scale,
                    // Collisions are counted, each once.
                    density_se: (count > 0).then(|| (count as f64).sqrt() * scale),
                });
            }
        }
    }
    rows
}
