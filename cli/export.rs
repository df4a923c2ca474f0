//! From the records of all replicas to the tables of a results folder.

mod species;

use std::path::Path;

use stosszahl_analysis::compare::{Quotient, quotients};
use stosszahl_analysis::statistics::{Estimate, holm, uniform_test};
use stosszahl_analysis::windows::Dissipation;
use stosszahl_model::kinetic;
use stosszahl_model::snapshot::{SnapshotError, write_whole};

use crate::error_budget;
use crate::run::{Finished, PARTS, Replica};
use crate::setup::Setup;
use crate::tables::{
    ComparisonRow, DisplacementRow, DissipationRow, EnergyRow, ErrorBudgetRow, ImpactParameterRow,
    ImpactSummaryRow, PairCorrelationRow, PairImpactRow, PartialTemperatureRow, ReplicaRow, Row,
    SteadyRow, StructureFactorRow,
};

/// All tables of a case.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// K(t), a2 and collisions.
    pub energy: Vec<EnergyRow>,
    /// Engine against engine.
    pub comparison: Vec<ComparisonRow>,
    /// P(b/d).
    pub impact: Vec<ImpactParameterRow>,
    /// P(b/d) in one line a window.
    pub impact_summary: Vec<ImpactSummaryRow>,
    /// S(k).
    pub structure: Vec<StructureFactorRow>,
    /// g(r).
    pub pairs: Vec<PairCorrelationRow>,
    /// The dissipation identity.
    pub dissipation: Vec<DissipationRow>,
    /// Quarters of a driven run; empty in a gas that cools freely.
    pub steady: Vec<SteadyRow>,
    /// Mean squared displacement; empty unless it is measured.
    pub displacements: Vec<DisplacementRow>,
    /// Sources of error.
    pub budget: Vec<ErrorBudgetRow>,
    /// Temperatures of the species; empty in a gas of one.
    pub partial: Vec<PartialTemperatureRow>,
    /// P(b/d) by kind of pair; empty in a gas of one species.
    pub pair_impact: Vec<PairImpactRow>,
    /// Single replicas.
    pub replicas: Vec<ReplicaRow>,
}

impl Tables {
    /// Gathers the tables.
    pub fn new(setup: &Setup, replicas: &[Replica]) -> Self {
        let mut tables = Self::default();
        let runs: Vec<(String, Vec<&Finished>)> = setup
            .case
            .engines
            .iter()
            .enumerate()
            .map(|(index, engine)| {
                let all = replicas
                    .iter()
                    .map(|replica| &replica.engines[index])
                    .collect();
                (engine.name().to_owned(), all)
            })
            .collect();
        for (engine, runs) in &runs {
            tables.energy.extend(energy(setup, engine, runs));
            tables.structure.extend(structure(engine, runs));
            tables.pairs.extend(pairs(engine, runs));
            tables.impact(setup, engine, runs);
            if setup.has_theory() {
                tables.dissipation.extend(dissipation(setup, engine, runs));
            }
            tables.partial.extend(species::partial(setup, engine, runs));
            tables
                .pair_impact
                .extend(species::impact(setup, engine, runs));
            tables.steady.extend(steady(setup, engine, runs));
            tables
                .displacements
                .extend(displacements(setup, engine, runs));
            for (replica, run) in runs.iter().enumerate() {
                let samples = run.record.energies.iter().enumerate();
                tables
                    .replicas
                    .extend(samples.map(|(index, (time, sample))| ReplicaRow {
                        replica: replica as u64,
                        engine: engine.clone(),
                        time_over_t0: *time,
                        energy_ratio: run.record.energy_ratio(index),
                        fourth_cumulant: sample.fourth_cumulant,
                        collisions_per_particle: sample.collisions_per_particle,
                    }));
            }
        }
        for (engine, (_, runs)) in setup.case.engines.iter().zip(&runs) {
            let last = tables
                .energy
                .iter()
                .rfind(|row| row.engine == engine.name());
            let budget = error_budget::budget(setup, engine, runs, last);
            tables.budget.extend(budget);
        }
        let samples = setup.case.sample_times().len();
        let rows: Vec<&[EnergyRow]> = tables.energy.chunks(samples).collect();
        for a in 0..runs.len() {
            for b in a + 1..runs.len() {
                let both = comparison(setup, [rows[a], rows[b]], [&runs[a].1, &runs[b].1]);
                tables.comparison.extend(both);
            }
        }
        tables
    }

    fn impact(&mut self, setup: &Setup, engine: &str, runs: &[&Finished]) {
        let spans = &setup.case.measure.impact_windows;
        let first = self.impact_summary.len();
        for (window, &[start, end]) in spans.iter().enumerate() {
            let all: Vec<_> = runs
                .iter()
                .map(|run| &run.record.windows.windows[window])
                .collect();
            let bins = setup.case.measure.impact_bins;
            let counts: Vec<u64> = (0..bins)
                .map(|bin| all.iter().map(|w| w.bins[bin]).sum())
                .collect();
            let total: u64 = counts.iter().sum();
            let density = |count: u64, total: u64| count as f64 * bins as f64 / total as f64;
            for (bin, &count) in counts.iter().enumerate() {
                let each: Vec<f64> = all
                    .iter()
                    .filter(|w| w.collisions > 0)
                    .map(|w| density(w.bins[bin], w.collisions))
                    .collect();
                self.impact.push(ImpactParameterRow {
                    engine: engine.to_owned(),
                    window_start: start,
                    window_end: end,
                    bin_low: bin as f64 / bins as f64,
                    bin_high: (bin + 1) as f64 / bins as f64,
                    count,
                    density: if total > 0 {
                        density(count, total)
                    } else {
                        0.0
                    },
                    density_se: Estimate::over_replicas(&each).and_then(|e| e.standard_error),
                });
            }
            let slopes: Vec<f64> = all.iter().filter_map(|w| w.slope()).collect();
            let slope = Estimate::over_replicas(&slopes);
            let means: Vec<f64> = all.iter().filter_map(|w| w.mean_impact()).collect();
            let test = uniform_test(&counts).ok();
            self.impact_summary.push(ImpactSummaryRow {
                engine: engine.to_owned(),
                window_start: start,
                window_end: end,
                collisions: total,
                slope: slope.as_ref().map(|s| s.value),
                // One replica: from the spread of its collisions.
                slope_se: slope
                    .and_then(|s| s.standard_error)
                    .or_else(|| all.first().and_then(|w| w.slope_error())),
                mean_b_over_d: Estimate::over_replicas(&means).map(|m| m.value),
                chi_squared: test.map(|t| t.statistic),
                degrees_of_freedom: test.map_or(0, |t| t.degrees_of_freedom as u64),
                p_value: test.map(|t| t.p_value),
                verdict: String::new(),
            });
        }
        // All windows of one engine together.
        let rows = &mut self.impact_summary[first..];
        let p_values: Vec<f64> = rows
            .iter()
            .map(|row| row.p_value.unwrap_or(f64::NAN))
            .collect();
        for (row, rejected) in rows
            .iter_mut()
            .zip(holm(&p_values, setup.case.verdict.false_alarm))
        {
            let slope = row.slope.unwrap_or(0.0);
            // A slope of 2 % moves the outer of 20 bins by 1 %.
            // Few replicas may lie close together by chance, so the spread of the collisions counts too.
            let counting = (12.0 / row.collisions.max(1) as f64).sqrt();
            let seen = row.slope_se.is_some_and(|error| error.max(counting) < 0.02);
            let verdict = match (row.p_value, rejected) {
                (None, _) => "too few collisions",
                (_, true) if slope > 0.0 => "grazing excess",
                (_, true) => "central excess",
                (_, false) if seen => "uniform",
                (_, false) => "undecided",
            };
            verdict.clone_into(&mut row.verdict);
        }
    }

    /// Writes the tables of a case into a folder.
    ///
    /// # Errors
    /// [`SnapshotError`] names the file that cannot be written.
    pub fn write(&self, setup: &Setup, folder: &Path) -> Result<(), SnapshotError> {
        write_table(folder, &self.energy)?;
        write_table(folder, &self.comparison)?;
        write_table(folder, &self.impact)?;
        write_table(folder, &self.impact_summary)?;
        write_table(folder, &self.structure)?;
        write_table(folder, &self.pairs)?;
        write_table(folder, &self.dissipation)?;
        if !setup.species.is_empty() {
            write_table(folder, &self.partial)?;
            write_table(folder, &self.pair_impact)?;
        }
        if setup.case.drive.is_some() {
            write_table(folder, &self.steady)?;
        }
        if setup.case.measure.displacement_start.is_some() {
            write_table(folder, &self.displacements)?;
        }
        write_table(folder, &self.budget)?;
        write_table(folder, &self.replicas)
    }
}

/// Writes a table so that its file appears only when it is complete.
pub(crate) fn write_table<R: Row>(folder: &Path, rows: &[R]) -> Result<(), SnapshotError> {
    let path = folder.join(R::FILE);
    let failed = |error: std::io::Error| SnapshotError::File {
        path: path.clone(),
        source: error,
    };
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    writer
        .write_record(R::COLUMNS)
        .map_err(|error| failed(error.into()))?;
    for row in rows {
        writer
            .serialize(row)
            .map_err(|error| failed(error.into()))?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| failed(error.into_error()))?;
    write_whole(&path, &bytes)
}

/// Mean and standard error over replicas of a quantity; empty replicas are left out.
pub(crate) fn over<T>(
    runs: &[T],
    quantity: impl Fn(&T) -> Option<f64>,
) -> (Option<f64>, Option<f64>) {
    let values: Vec<f64> = runs
        .iter()
        .filter_map(quantity)
        .filter(|value| value.is_finite())
        .collect();
    let estimate = Estimate::over_replicas(&values);
    (
        estimate.as_ref().map(|e| e.value),
        estimate.and_then(|e| e.standard_error),
    )
}

fn energy(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<EnergyRow> {
    let times = setup.case.sample_times();
    let mut rows = Vec::with_capacity(times.len());
    for (index, &time) in times.iter().enumerate() {
        let sample = |run: &&Finished| run.record.energies[index].1;
        let ratio = over(runs, |run| Some(run.record.energy_ratio(index)));
        let cumulant = over(runs, |run| Some(sample(run).fourth_cumulant));
        let collisions = over(runs, |run| Some(sample(run).collisions_per_particle));
        rows.push(EnergyRow {
            engine: engine.to_owned(),
            time: time * setup.time * setup.scale.time(),
            time_over_t0: time,
            collisions_per_particle: collisions.0.unwrap_or(0.0),
            energy_ratio: ratio.0.unwrap_or(f64::NAN),
            energy_ratio_se: ratio.1,
            haff_ratio: setup.haff_ratio(time),
            fourth_cumulant: cumulant.0.unwrap_or(f64::NAN),
            fourth_cumulant_se: cumulant.1,
            replicas: runs.len() as u64,
        });
    }
    rows
}

/// Two engines at the sample times, from their rows of the energy table and their replicas.
fn comparison(
    setup: &Setup,
    rows: [&[EnergyRow]; 2],
    runs: [&[&Finished]; 2],
) -> Vec<ComparisonRow> {
    let pairs: Vec<Vec<(f64, f64)>> = (0..rows[0].len())
        .map(|sample| {
            let ratio = |run: &&Finished| run.record.energy_ratio(sample);
            runs[0]
                .iter()
                .map(ratio)
                .zip(runs[1].iter().map(ratio))
                .collect()
        })
        .collect();
    quotients(&pairs, setup.case.verdict.false_alarm)
        .into_iter()
        .zip(rows[0].iter().zip(rows[1]))
        .map(|(quotient, (a, b))| ComparisonRow {
            engine_a: a.engine.clone(),
            engine_b: b.engine.clone(),
            time_over_t0: a.time_over_t0,
            energy_ratio_a: a.energy_ratio,
            energy_ratio_b: b.energy_ratio,
            quotient: quotient.quotient.value,
            quotient_se: quotient.quotient.standard_error,
            z: quotient.z,
            verdict: quotient.verdict.name().to_owned(),
        })
        .collect()
}

fn structure(engine: &str, runs: &[&Finished]) -> Vec<StructureFactorRow> {
    let mut rows = Vec::new();
    for (index, (time, first)) in runs[0].record.structure.iter().enumerate() {
        for (shell, known) in first.shells.iter().enumerate() {
            let (value, error) = over(runs, |run| {
                Some(run.record.structure[index].1.shells[shell].value)
            });
            rows.push(StructureFactorRow {
                engine: engine.to_owned(),
                time_over_t0: *time,
                k: known.wave_number,
                structure_factor: value.unwrap_or(f64::NAN),
                structure_factor_se: error,
                modes: known.modes as u64,
            });
        }
    }
    rows
}

fn pairs(engine: &str, runs: &[&Finished]) -> Vec<PairCorrelationRow> {
    let mut rows = Vec::new();
    for (index, (time, first)) in runs[0].record.pairs.iter().enumerate() {
        for (bin, known) in first.bins.iter().enumerate() {
            let (value, error) = over(runs, |run| Some(run.record.pairs[index].1.bins[bin].g));
            rows.push(PairCorrelationRow {
                engine: engine.to_owned(),
                time_over_t0: *time,
                r_over_d: known.r_over_d,
                g: value.unwrap_or(0.0),
                g_se: error,
            });
        }
    }
    rows
}

fn dissipation(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<DissipationRow> {
    let theory = kinetic::collision_rate(setup.packing_fraction, setup.contact_value, 0.0);
    let spans = setup.case.measure.impact_windows.iter().enumerate();
    spans
        .map(|(window, &[start, end])| {
            let each: Vec<Option<Dissipation>> = runs
                .iter()
                .map(|run| run.record.windows.windows[window].dissipation(theory, setup.disks))
                .collect();
            let factor = |of: fn(&Dissipation) -> f64| over(&each, |known| known.as_ref().map(of));
            let rate = factor(|d| d.rate);
            let speed = factor(|d| d.speed);
            let impact = factor(|d| d.impact);
            let correlation = factor(|d| d.correlation);
            let total = factor(|d| d.dissipation);
            DissipationRow {
                engine: engine.to_owned(),
                window_start: start,
                window_end: end,
                collisions: runs
                    .iter()
                    .map(|run| run.record.windows.windows[window].collisions)
                    .sum(),
                rate_ratio: rate.0,
                rate_ratio_se: rate.1,
                speed_ratio: speed.0,
                speed_ratio_se: speed.1,
                impact_ratio: impact.0,
                impact_ratio_se: impact.1,
                correlation_ratio: correlation.0,
                correlation_ratio_se: correlation.1,
                dissipation_ratio: total.0,
                dissipation_ratio_se: total.1,
                replicas: runs.len() as u64,
            }
        })
        .collect()
}

fn steady(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<SteadyRow> {
    if setup.case.drive.is_none() {
        return Vec::new();
    }
    let edge = |part: usize| setup.case.run.until * part as f64 / PARTS as f64;
    (0..PARTS)
        .map(|part| {
            let ratio = over(runs, |run| {
                run.record.driven.as_ref()?.temperature(part, part + 1)
            });
            SteadyRow {
                engine: engine.to_owned(),
                window_start: edge(part),
                window_end: edge(part + 1),
                temperature_ratio: ratio.0,
                temperature_ratio_se: ratio.1,
                theory_ratio: setup.steady_temperature(),
                replicas: runs.len() as u64,
            }
        })
        .collect()
}

fn displacements(setup: &Setup, engine: &str, runs: &[&Finished]) -> Vec<DisplacementRow> {
    let times = setup.case.displacement_times();
    let rows = times.iter().enumerate().map(|(index, &(time, elapsed))| {
        let square = over(runs, |run| Some(run.record.displacements[index].1));
        DisplacementRow {
            engine: engine.to_owned(),
            time_over_t0: time,
            elapsed_over_t0: elapsed,
            displacement_square_over_d2: square.0.unwrap_or(f64::NAN),
            displacement_square_over_d2_se: square.1,
            theory_over_d2: setup.displacement_theory(elapsed),
            replicas: runs.len() as u64,
        }
    });
    rows.collect()
}

/// The quotients of an engine's energies and Haff's law; empty where there is no law.
pub fn theory_quotients(setup: &Setup, runs: &[&Finished]) -> Vec<Quotient> {
    let times = setup.case.sample_times();
    let pairs: Option<Vec<Vec<(f64, f64)>>> = times
        .iter()
        .enumerate()
        .map(|(index, &time)| {
            let law = setup.haff_ratio(time)?;
            let ratio = |run: &&Finished| run.record.energy_ratio(index);
            Some(runs.iter().map(|run| (ratio(run), law)).collect())
        })
        .collect();
    pairs.map_or_else(Vec::new, |pairs| {
        quotients(&pairs, setup.case.verdict.false_alarm)
    })
}
