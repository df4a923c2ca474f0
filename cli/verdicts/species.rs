//! What is said of several species: how energy is shared among them.

use stosszahl_analysis::statistics::Estimate;

use super::with_error;
use crate::manifest::{Verdict, VerdictKind};
use crate::run::Finished;
use crate::setup::Setup;

/// The early state, in units of `t_0`: after the ratios have settled, before the gas can have become inhomogeneous.
const EARLY: [f64; 2] = [1.0, 5.0];

/// Standard errors up to which a ratio is that of theory.
const SIGNIFICANT: f64 = 3.0;

/// Ratios of the temperatures of all species to that of the first, over theory, in the early state.
pub(super) fn verdicts(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<Verdict> {
    let Some(first) = runs.first() else {
        return Vec::new();
    };
    let times: Vec<f64> = first.record.partial.iter().map(|sample| sample.0).collect();
    let Some(theory) = setup.partial_temperatures(&times) else {
        return Vec::new();
    };
    let early: Vec<usize> = (0..times.len())
        .filter(|&index| (EARLY[0]..=EARLY[1]).contains(&times[index]))
        .collect();
    if early.is_empty() {
        return Vec::new();
    }
    let ratio = |temperatures: &[f64], number: usize| temperatures[number] / temperatures[0];
    (1..setup.species.len())
        .filter_map(|number| {
            let mean = |quotient: &dyn Fn(usize) -> f64| {
                early.iter().map(|&index| quotient(index)).sum::<f64>() / early.len() as f64
            };
            let measured: Vec<f64> = runs
                .iter()
                .map(|run| mean(&|index| ratio(&run.record.partial[index].1, number)))
                .collect();
            let estimate = Estimate::over_replicas(&measured)?;
            let expected = mean(&|index| ratio(&theory[index], number));
            let z = estimate
                .standard_error
                .filter(|&error| error > 0.0)
                .map(|error| (estimate.value - expected) / error);
            let kind = match z {
                None => VerdictKind::Undecided,
                Some(z) if z.abs() <= SIGNIFICANT => VerdictKind::Agree,
                Some(_) => VerdictKind::Differ,
            };
            Some(Verdict {
                topic: format!("partial temperatures, {engine}"),
                sentence: format!(
                    "From t/t0 = {} to {} the ratio T_{}/T_1 is {}; Enskog's equations give {expected:.4}{}.",
                    EARLY[0],
                    EARLY[1],
                    number + 1,
                    with_error(estimate.value, estimate.standard_error),
                    z.map_or(String::new(), |z| format!(" ({z:+.1} standard errors)"))
                ),
                kind,
            })
        })
        .collect()
}
