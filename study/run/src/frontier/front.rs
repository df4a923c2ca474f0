//! Pareto front of error against cost: every measured setting with several numbers of replicas, and
//! which of them no cheaper one surpasses.

use stosszahl_analysis::accuracy::SettingAccuracy;
use stosszahl_results::{Table, TableEstimate, table};

use super::measure::median;
use super::quantity::{FrontierQuantity, QuantityKind};
use super::reference::Reference;
use super::run_record::RunResult;
use super::setting::RunSetting;
use crate::plan::CasePlan;

/// Numbers of replicas for which the error of a setting is derived from its repetitions.
pub(crate) const REPLICAS: [u64; 4] = [1, 4, 16, 64];

/// Numerical setting of an engine with the results of its repeated runs.
#[derive(Clone, Debug)]
pub(crate) struct MeasuredSetting {
    /// Numerical setting of the repeated runs.
    pub setting: RunSetting,
    /// Description of the setting in words.
    pub label: String,
    /// Systematic and statistical error of each quantity, in the order of the quantities; `None` if
    /// a run lacks the value.
    pub accuracies: Vec<Option<SettingAccuracy>>,
    /// CPU time of one run with its start \[s\], median over the repetitions.
    pub core_seconds: f64,
    /// Wall time of one run on one thread \[s\], median over the repetitions.
    pub wall_seconds: f64,
    /// Largest memory of the engine in a run \[bytes\].
    pub bytes: usize,
    /// Mean number of pair collisions of one run.
    pub collisions: f64,
    /// Mean number of Monte Carlo time steps of one run; 0 for exact dynamics.
    pub steps: f64,
}

impl MeasuredSetting {
    /// Computes errors and costs of a setting from its repeated runs.
    pub(crate) fn new(
        setting: RunSetting,
        plan: &CasePlan,
        samples: &[RunResult],
        quantities: &[FrontierQuantity],
        references: &[Reference],
    ) -> Self {
        let accuracies = quantities.iter().zip(references).enumerate();
        let accuracies = accuracies.map(|(index, (quantity, reference))| {
            let values: Vec<f64> = samples.iter().map(|sample| sample.values[index]).collect();
            let unit = quantity.kind.unit(reference.known.value);
            SettingAccuracy::new(&values, reference.known, unit)
        });
        let mean = |of: fn(&RunResult) -> f64| {
            samples.iter().map(of).sum::<f64>() / samples.len().max(1) as f64
        };
        Self {
            label: setting.label(plan),
            accuracies: accuracies.collect(),
            core_seconds: median(samples.iter().map(|sample| sample.core_seconds)),
            wall_seconds: median(samples.iter().map(|sample| sample.wall_seconds)),
            bytes: samples.iter().map(|sample| sample.bytes).max().unwrap_or(0),
            collisions: mean(|sample| sample.collisions as f64),
            steps: mean(|sample| sample.steps as f64),
            setting,
        }
    }

    /// Returns the quantity of a kind whose total error is largest with `replicas` replicas, and
    /// its accuracy; `None` if the accuracy of a quantity of the kind is unknown.
    pub(crate) fn worst(
        &self,
        kind: QuantityKind,
        quantities: &[FrontierQuantity],
        replicas: u64,
    ) -> Option<(usize, SettingAccuracy)> {
        let of_kind = (0..quantities.len()).filter(|&index| quantities[index].kind == kind);
        let all: Option<Vec<(usize, SettingAccuracy)>> = of_kind
            .map(|index| self.accuracies[index].map(|accuracy| (index, accuracy)))
            .collect();
        all?.into_iter()
            .max_by(|a, b| a.1.total(replicas).total_cmp(&b.1.total(replicas)))
    }
}

/// Row of the table `frontier.csv`: a setting with a number of replicas, and its error in one
/// quantity.
#[derive(Clone, Debug)]
pub(crate) struct FrontierRow<'a> {
    /// Measured setting that the row is about.
    pub one: &'a MeasuredSetting,
    /// Kind of the quantity. The prefix `largest-` marks the row of the quantity that has the
    /// largest error of its kind.
    pub name: String,
    /// Quantity whose error is in the row.
    pub quantity: FrontierQuantity,
    /// Reference value of the quantity, from theory or from exact dynamics.
    pub reference: Reference,
    /// Number of replicas over which the quantity is averaged.
    pub replicas: u64,
    /// Systematic and statistical error of the setting in this quantity.
    pub found: SettingAccuracy,
    /// True if the row is on the Pareto front: no cheaper setting has a smaller error.
    pub on_front: bool,
}

impl FrontierRow<'_> {
    /// Returns the CPU time of all replicas together \[s\].
    pub(crate) fn core_seconds(&self) -> f64 {
        self.replicas as f64 * self.one.core_seconds
    }

    /// Returns the total error, systematic and statistical, of the mean over the replicas. It is
    /// divided by the unit of the quantity's kind (`QuantityKind::unit`).
    pub(crate) fn error(&self) -> f64 {
        self.found.total(self.replicas)
    }
}

/// Marks the Pareto front of points (cost, error): true if no other point is at least as good in
/// both and better in one. Of equal points the first is on the front; a point with NaN never is.
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

/// Builds the rows of one quantity, or of the worst of a kind: every setting with every number of
/// replicas.
fn rows_of<'a>(
    measured: &'a [MeasuredSetting],
    references: &[Reference],
    name: &str,
    quantities: &[FrontierQuantity],
    pick: impl Fn(&MeasuredSetting, u64) -> Option<(usize, SettingAccuracy)>,
) -> Vec<FrontierRow<'a>> {
    let all = measured
        .iter()
        .flat_map(|one| REPLICAS.map(|replicas| (one, replicas)));
    let row = |(one, replicas)| {
        let (index, found) = pick(one, replicas)?;
        Some(FrontierRow {
            one,
            name: name.to_owned(),
            quantity: quantities[index],
            reference: references[index],
            replicas,
            found,
            on_front: false,
        })
    };
    let mut rows: Vec<FrontierRow<'a>> = all.filter_map(row).collect();
    let points: Vec<_> = rows
        .iter()
        .map(|row| (row.core_seconds(), row.error()))
        .collect();
    for (row, on) in rows.iter_mut().zip(front(&points)) {
        row.on_front = on;
    }
    rows
}

/// Builds the table `frontier.csv` from rows.
pub(crate) fn table<'a>(rows: impl IntoIterator<Item = &'a FrontierRow<'a>>) -> Table {
    let mut table = table! {
        "frontier", "Error against cost of every measured setting.";
        key "engine", "", "Engine";
        key "setting", "", "Setting in words";
        key "disks", "1", "Disks";
        key "quantity", "", "Quantity; largest- for that of its kind whose error is largest";
        key "time", "time", "When";
        key "replicas", "1", "Replicas that a mean is taken over";
        note "repetitions", "1", "Runs that the row rests on";
        note "reference_source", "", "theory, or an ensemble of exact dynamics";
        estimate "reference", "of the quantity", "Reference";
        value "mean", "of the quantity", "Mean of the runs";
        estimate "systematic_error", "1", "Systematic error in units of the reference, or absolute where that may vanish";
        value "statistical_error", "1", "Statistical error of one run";
        note "statistical_error_low", "1", "Its range of 95 %";
        note "statistical_error_high", "1", "Its range of 95 %";
        value "error", "1", "Total error of the mean of the replicas";
        note "error_low", "1", "Its range of 95 %";
        note "error_high", "1", "Its range of 95 %";
        note "collisions", "1", "Pair collisions of one run";
        note "steps", "1", "Time steps of one run";
        note "bytes", "B", "Memory of one run";
        value "core_seconds", "s", "CPU time of all replicas";
        value "wall_seconds", "s", "Wall time of all replicas, one after the other on one thread";
        note "on_front", "", "Whether no cheaper setting has a smaller error";
    };
    for row in rows {
        let (one, found, known) = (row.one, &row.found, row.reference.known);
        let source = if row.reference.is_ensemble {
            "ensemble"
        } else {
            "theory"
        };
        let on_front = if row.on_front { "true" } else { "false" };
        table.add((
            (one.setting.engine.name, &*one.label, one.setting.disks),
            (
                &*row.name,
                row.quantity.time,
                row.replicas,
                found.repetitions,
                source,
            ),
            TableEstimate::with_error(known.value, Some(known.standard_error)),
            (
                found.mean,
                TableEstimate::with_error(found.systematic, Some(found.systematic_error)),
            ),
            (found.statistical, found.statistical_range()),
            (row.error(), found.total_range(row.replicas)),
            (one.collisions, one.steps, one.bytes),
            (
                row.core_seconds(),
                row.replicas as f64 * one.wall_seconds,
                on_front,
            ),
        ));
    }
    table
}

/// Returns the row name of the worst quantity of a kind, `largest-` and the kind.
pub(crate) fn largest(kind: QuantityKind) -> String {
    format!("largest-{}", kind.name())
}

/// Builds all rows of the frontier: for each quantity, and for the worst of each kind that has
/// several.
pub(crate) fn rows<'a>(
    measured: &'a [MeasuredSetting],
    quantities: &[FrontierQuantity],
    references: &[Reference],
) -> Vec<FrontierRow<'a>> {
    let mut rows = Vec::new();
    for kind in QuantityKind::ALL {
        for (index, quantity) in quantities.iter().enumerate() {
            if quantity.kind == kind {
                let pick = |one: &MeasuredSetting, _| Some((index, one.accuracies[index]?));
                rows.extend(rows_of(measured, references, kind.name(), quantities, pick));
            }
        }
        let pick = |one: &MeasuredSetting, replicas| one.worst(kind, quantities, replicas);
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
