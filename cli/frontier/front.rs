//! Error against cost: every measured setting with its replicas, and the settings that no cheaper one beats.

use serde::Serialize;
use stosszahl_analysis::accuracy::Accuracy;

use super::measure::{Sample, median};
use super::quantity::{Kind, Quantity};
use super::reference::{Reference, Source};
use super::setting::Setting;

/// Replicas for which rows are derived from the repetitions of one run.
pub(crate) const REPLICAS: [u64; 4] = [1, 4, 16, 64];

/// A setting with what its repetitions showed.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// The setting.
    pub(crate) setting: Setting,
    /// Its choices in words.
    pub(crate) label: String,
    /// Bias and noise of each quantity; none where a run does not have it.
    pub(crate) accuracies: Vec<Option<Accuracy>>,
    /// CPU time of one run, its start included, median over the repetitions \[s\].
    pub(crate) core_seconds: f64,
    /// Wall time of one run on one thread, median \[s\].
    pub(crate) wall_seconds: f64,
    /// Largest memory of the engine \[bytes\].
    pub(crate) bytes: usize,
    /// Pair collisions of one run, mean.
    pub(crate) collisions: f64,
    /// Monte Carlo steps of one run, mean.
    pub(crate) steps: f64,
}

impl Measured {
    /// From the runs of a setting.
    pub(crate) fn new(
        setting: Setting,
        disks: usize,
        samples: &[Sample],
        quantities: &[Quantity],
        references: &[Reference],
    ) -> Self {
        let accuracies = quantities.iter().zip(references).enumerate();
        let accuracies = accuracies.map(|(index, (quantity, reference))| {
            let values: Vec<f64> = samples.iter().map(|sample| sample.values[index]).collect();
            let unit = quantity.kind.unit(reference.known.value);
            Accuracy::new(&values, reference.known, unit)
        });
        let mean = |of: fn(&Sample) -> f64| {
            samples.iter().map(of).sum::<f64>() / samples.len().max(1) as f64
        };
        Self {
            label: setting.label(disks),
            accuracies: accuracies.collect(),
            core_seconds: median(samples.iter().map(Sample::core_seconds)),
            wall_seconds: median(samples.iter().map(|sample| sample.wall_seconds)),
            bytes: samples.iter().map(|sample| sample.bytes).max().unwrap_or(0),
            collisions: mean(|sample| sample.collisions as f64),
            steps: mean(|sample| sample.steps as f64),
            setting,
        }
    }

    /// The quantity of a kind whose total error is largest with so many replicas, and its accuracy; none if one of the kind
    /// has none.
    pub(crate) fn worst(
        &self,
        kind: Kind,
        quantities: &[Quantity],
        replicas: u64,
    ) -> Option<(usize, Accuracy)> {
        let of_kind = (0..quantities.len()).filter(|&index| quantities[index].kind == kind);
        let all: Option<Vec<(usize, Accuracy)>> = of_kind
            .map(|index| self.accuracies[index].map(|accuracy| (index, accuracy)))
            .collect();
        all?.into_iter()
            .max_by(|a, b| a.1.total(replicas).total_cmp(&b.1.total(replicas)))
    }
}

/// A row of `frontier.csv`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FrontierRow {
    /// Engine.
    pub(crate) engine: &'static str,
    /// Setting in words.
    pub(crate) setting: String,
    /// Disks.
    pub(crate) disks: usize,
    /// Quantity; `largest-` for that of the kind whose error is largest.
    pub(crate) quantity: String,
    /// When, in units of t0.
    pub(crate) time_over_t0: f64,
    /// Replicas that a mean is taken over.
    pub(crate) replicas: u64,
    /// Runs that the row rests on.
    pub(crate) repetitions: usize,
    /// Theory or ensemble.
    pub(crate) reference_source: Source,
    /// Reference.
    pub(crate) reference: f64,
    /// Its standard error.
    pub(crate) reference_se: f64,
    /// Mean of the runs.
    pub(crate) mean: f64,
    /// Systematic error in units of the reference, or absolute where that may vanish.
    pub(crate) systematic_error: f64,
    /// Its standard error.
    pub(crate) systematic_error_se: f64,
    /// Statistical error of one run.
    pub(crate) statistical_error: f64,
    /// Its range of 95 %.
    pub(crate) statistical_error_low: f64,
    /// Its range of 95 %.
    pub(crate) statistical_error_high: f64,
    /// Total error of the mean of the replicas.
    pub(crate) error: f64,
    /// Its range.
    pub(crate) error_low: f64,
    /// Its range.
    pub(crate) error_high: f64,
    /// Pair collisions of one run.
    pub(crate) collisions: f64,
    /// Steps of one run.
    pub(crate) steps: f64,
    /// Memory of one run \[bytes\].
    pub(crate) bytes: usize,
    /// CPU time of all replicas \[s\].
    pub(crate) core_seconds: f64,
    /// Wall time of all replicas, one after the other on one thread \[s\].
    pub(crate) wall_seconds: f64,
    /// Whether no cheaper setting has a smaller error.
    pub(crate) on_front: bool,
}

/// Which of some points of (cost, error) no other one beats in both. Of equal ones the first stays; a point with a number
/// that is none is never on the front.
pub(crate) fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..points.len())
        .filter(|&index| points[index].0.is_finite() && points[index].1.is_finite())
        .collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (points[a], points[b]);
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut on = vec![false; points.len()];
    let mut least = f64::INFINITY;
    for index in order {
        if points[index].1 < least {
            least = points[index].1;
            on[index] = true;
        }
    }
    on
}

/// All rows of one quantity, or of the worst of a kind: every setting with every number of replicas.
fn rows_of(
    measured: &[Measured],
    references: &[Reference],
    name: &str,
    quantities: &[Quantity],
    pick: impl Fn(&Measured, u64) -> Option<(usize, Accuracy)>,
) -> Vec<FrontierRow> {
    let mut rows = Vec::new();
    for one in measured {
        for replicas in REPLICAS {
            let Some((index, accuracy)) = pick(one, replicas) else {
                continue;
            };
            let reference = references[index];
            let [low, high] = accuracy.total_range(replicas);
            let [quiet, loud] = accuracy.statistical_range();
            rows.push(FrontierRow {
                engine: one.setting.engine_name(),
                setting: one.label.clone(),
                disks: one.setting.disks,
                quantity: name.to_owned(),
                time_over_t0: quantities[index].time,
                replicas,
                repetitions: accuracy.repetitions,
                reference_source: reference.source,
                reference: reference.known.value,
                reference_se: reference.known.standard_error,
                mean: accuracy.mean,
                systematic_error: accuracy.systematic,
                systematic_error_se: accuracy.systematic_error,
                statistical_error: accuracy.statistical,
                statistical_error_low: quiet,
                statistical_error_high: loud,
                error: accuracy.total(replicas),
                error_low: low,
                error_high: high,
                collisions: one.collisions,
                steps: one.steps,
                bytes: one.bytes,
                core_seconds: replicas as f64 * one.core_seconds,
                wall_seconds: replicas as f64 * one.wall_seconds,
                on_front: false,
            });
        }
    }
    let points: Vec<_> = rows
        .iter()
        .map(|row| (row.core_seconds, row.error))
        .collect();
    for (row, on) in rows.iter_mut().zip(front(&points)) {
        row.on_front = on;
    }
    rows
}

/// The name of the rows of the worst quantity of a kind.
pub(crate) fn largest(kind: Kind) -> String {
    format!("largest-{}", kind.name())
}

/// All rows: each quantity, and for kinds of several quantities the worst of them.
pub(crate) fn rows(
    measured: &[Measured],
    quantities: &[Quantity],
    references: &[Reference],
    kinds: &[Kind],
) -> Vec<FrontierRow> {
    let mut rows = Vec::new();
    for &kind in kinds {
        for (index, quantity) in quantities.iter().enumerate() {
            if quantity.kind == kind {
                let pick = |one: &Measured, _| Some((index, one.accuracies[index]?));
                rows.extend(rows_of(measured, references, kind.name(), quantities, pick));
            }
        }
        let pick = |one: &Measured, replicas| one.worst(kind, quantities, replicas);
        rows.extend(rows_of(
            measured,
            references,
            &largest(kind),
            quantities,
            pick,
        ));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_has_no_point_that_another_beats() {
        let points = [
            (1.0, 0.5),
            (2.0, 0.6),
            (2.0, 0.3),
            (3.0, 0.3),
            (4.0, 0.1),
            (0.5, f64::NAN),
            (f64::INFINITY, 0.0),
        ];
        assert_eq!(
            front(&points),
            [true, false, true, false, true, false, false]
        );
    }

    /// Every point off the front is beaten by one on it, whatever the points.
    #[test]
    fn the_front_beats_all_others() {
        let points: Vec<(f64, f64)> = (0..200_u32)
            .map(|i| (f64::from(i * 7919 % 211), f64::from(i * 104_729 % 199)))
            .collect();
        let on = front(&points);
        for (point, _) in points.iter().zip(&on).filter(|(_, on)| !**on) {
            let beats = |other: &(f64, f64)| other.0 <= point.0 && other.1 <= point.1;
            assert!(
                points
                    .iter()
                    .zip(&on)
                    .any(|(other, on)| *on && beats(other))
            );
        }
        let mut chosen: Vec<_> = points.iter().zip(&on).filter(|(_, on)| **on).collect();
        chosen.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
        assert!(chosen.windows(2).all(|pair| pair[0].0.1 > pair[1].0.1));
    }
}
