//! From the records of all replicas to the tables of a results folder.

use std::path::Path;

use stosszahl_analysis::statistics::Estimate;
use stosszahl_analysis::theory::TheoryError;
use stosszahl_dsmc::homogeneous::Moments;
use stosszahl_model::snapshot::SnapshotError;

use super::plan::{Group, Plan};
use super::record::{Sample, Sizes};
use super::run::Finished;
use super::tables::{
    CheckRow, ClusterRow, GasRow, SampleRow, SizeRow, SpeciesRow, TimeAveragedRow,
};
use super::theory::{self, Curve, GroupCurve, Predicted};
use super::{checks, steady};
use crate::export::{over, write_table};

/// All tables of a case.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// The gas as a whole.
    pub gas: Vec<GasRow>,
    /// Species by species.
    pub species: Vec<SpeciesRow>,
    /// Averages over time; empty unless paths are kept.
    pub time_averaged: Vec<TimeAveragedRow>,
    /// Clusters; empty unless particles stick.
    pub clusters: Vec<ClusterRow>,
    /// Numbers of clusters by size; empty unless particles stick.
    pub sizes: Vec<SizeRow>,
    /// Comparisons with theory.
    pub checks: Vec<CheckRow>,
    /// Single replicas.
    pub replicas: Vec<SampleRow>,
    /// Sonine orders that theory was solved in.
    pub sonine_orders: usize,
}

impl Tables {
    /// Averages all replicas.
    ///
    /// # Errors
    /// [`TheoryError`] if the curves of theory cannot be computed.
    pub fn new(plan: &Plan, runs: &[Finished]) -> Result<Self, TheoryError> {
        let curves = theory::curves(plan)?;
        let mut tables = Self {
            time_averaged: time_averaged(plan, curves.orders, runs),
            ..Self::default()
        };
        for (index, time) in plan.case.sample_times().into_iter().enumerate() {
            let samples: Vec<&Sample> = runs
                .iter()
                .filter_map(|run| run.record.samples.get(index))
                .collect();
            let curve = curves.at.get(index);
            let first: Vec<&Sample> = runs.iter().map(|run| &run.record.samples[0]).collect();
            tables.gas.push(gas(plan, time, &samples, &first, curve));
            if plan.case.sticking.is_some() {
                tables.clusters.push(clusters(time, &samples, &first));
            } else {
                let rows = plan.groups.iter().enumerate().map(|(number, group)| {
                    species(plan, (number, group), time, (&samples, &first), curve)
                });
                tables.species.extend(rows);
            }
        }
        tables.sizes = sizes(plan, runs);
        for (replica, run) in runs.iter().enumerate() {
            let rows = run.record.samples.iter().map(|sample| SampleRow {
                replica: replica as u64,
                time: sample.time,
                particles: sample.particles as u64,
                collisions: sample.collisions,
                energy: sample.energy,
            });
            tables.replicas.extend(rows);
        }
        tables.sonine_orders = curves.orders;
        tables.checks = checks::checks(plan, runs, &tables);
        Ok(tables)
    }

    /// Writes the tables into a folder; those without rows that the case does not ask for are left out.
    ///
    /// # Errors
    /// [`SnapshotError`] names the file that cannot be written.
    pub fn write(&self, plan: &Plan, folder: &Path) -> Result<(), SnapshotError> {
        write_table(folder, &self.gas)?;
        if plan.case.sticking.is_some() {
            write_table(folder, &self.clusters)?;
            write_table(folder, &self.sizes)?;
        } else {
            write_table(folder, &self.species)?;
        }
        if !plan.lags().is_empty() {
            write_table(folder, &self.time_averaged)?;
        }
        write_table(folder, &self.checks)?;
        write_table(folder, &self.replicas)
    }
}

/// A value with its standard error.
type Measured = (f64, Option<f64>);

/// Value and error of theory, as two columns.
fn split(predicted: Option<Predicted>) -> (Option<f64>, Option<f64>) {
    (
        predicted.map(|predicted| predicted.value),
        predicted.and_then(|predicted| predicted.error),
    )
}

/// Mean over replicas, and the larger of the two errors that are known.
fn measured<T>(runs: &[T], value: impl Fn(&T) -> f64, single: Option<f64>) -> Measured {
    let (mean, spread) = over(runs, |run| Some(value(run)));
    let within = single.map(|error| error / (runs.len() as f64).sqrt());
    let error = match (spread, within) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    (
        mean.unwrap_or(f64::NAN),
        error.filter(|error| error.is_finite()),
    )
}

/// Relative standard error of a temperature by the spread over particles: `sqrt(((D + 2)(1 + a2)/D - 1)/N)`, at least that
/// of Maxwellian velocities, `sqrt(2/(D N))`, as few particles do not know their own spread.
fn temperature_error(plan: &Plan, moments: &Moments) -> f64 {
    let d = plan.case.dimension as f64;
    let spread = (d + 2.0) * (1.0 + moments.fourth_cumulant) / d - 1.0;
    (spread.max(2.0 / d) / moments.count.max(1) as f64).sqrt()
}

/// Standard error of a mean squared displacement by the spread over particles, at least that of normally distributed
/// displacements.
fn displacement_error(plan: &Plan, moments: &Moments) -> f64 {
    let (d, mean) = (plan.case.dimension as f64, moments.displacement);
    let spread = moments.displacement_fourth - mean * mean;
    (spread.max(2.0 / d * mean * mean) / moments.count.max(1) as f64).sqrt()
}

/// Moments of all groups but tracers.
fn but_tracers<'a>(plan: &'a Plan, sample: &'a Sample) -> impl Iterator<Item = &'a Moments> {
    let groups = sample.groups.iter().enumerate();
    groups
        .filter(|(number, _)| plan.tracer != Some(*number as u32))
        .map(|(_, moments)| moments)
}

/// Kinetic energy of all particles but tracers.
fn energy_of(plan: &Plan, sample: &Sample) -> f64 {
    if plan.tracer.is_none() {
        return sample.energy;
    }
    let twice: f64 = but_tracers(plan, sample)
        .map(|moments| moments.count as f64 * moments.temperature)
        .sum();
    0.5 * plan.case.dimension as f64 * twice
}

fn gas(
    plan: &Plan,
    time: f64,
    samples: &[&Sample],
    first: &[&Sample],
    curve: Option<&Curve>,
) -> GasRow {
    let pairs: Vec<(&Sample, &Sample)> =
        samples.iter().copied().zip(first.iter().copied()).collect();
    let particles = measured(
        &pairs,
        |(now, start)| now.particles as f64 / start.particles as f64,
        None,
    );
    let colliding = plan.particles() as f64;
    let collisions = plan
        .tracer
        .is_none()
        .then(|| measured(samples, |now| 2.0 * now.collisions as f64 / colliding, None));
    // Energies of species add up, and so do their variances.
    let single = |sample: &Sample| {
        let (mut sum, mut square) = (0.0, 0.0);
        for moments in but_tracers(plan, sample) {
            let energy = moments.count as f64 * moments.temperature;
            sum += energy;
            square += (energy * temperature_error(plan, moments)).powi(2);
        }
        (sum > 0.0).then(|| square.sqrt() / sum)
    };
    let ratio = |pair: &(&Sample, &Sample)| energy_of(plan, pair.0) / energy_of(plan, pair.1);
    let relative = pairs
        .first()
        .filter(|_| plan.case.sticking.is_none())
        .and_then(|pair| Some(single(pair.0)? * ratio(pair)));
    let energy = measured(&pairs, ratio, relative);
    let displacement = plan.case.measure.displacement.then(|| {
        let mean = |sample: &&Sample| {
            let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
            for moments in but_tracers(plan, sample) {
                let n = moments.count as f64;
                count += n;
                sum += n * moments.displacement;
                square += (n * displacement_error(plan, moments)).powi(2);
            }
            (
                sum / f64::max(count, 1.0),
                square.sqrt() / f64::max(count, 1.0),
            )
        };
        measured(samples, |s| mean(s).0, samples.first().map(|s| mean(s).1))
    });
    let theory = |value: fn(&Curve) -> Predicted| split(curve.map(value));
    let collisions_theory = collisions.map_or((None, None), |_| theory(|curve| curve.collisions));
    let energy_theory = theory(|curve| curve.energy_ratio);
    let displacement_theory = displacement.map_or((None, None), |_| theory(|c| c.displacement));
    GasRow {
        time,
        particles_ratio: particles.0,
        particles_ratio_se: particles.1,
        collisions_per_particle: collisions.map(|found| found.0),
        collisions_per_particle_se: collisions.and_then(|found| found.1),
        collisions_per_particle_theory: collisions_theory.0,
        collisions_per_particle_theory_error: collisions_theory.1,
        energy_ratio: energy.0,
        energy_ratio_se: energy.1,
        energy_ratio_theory: energy_theory.0,
        energy_ratio_theory_error: energy_theory.1,
        displacement_square: displacement.map(|found| found.0),
        displacement_square_se: displacement.and_then(|found| found.1),
        displacement_square_theory: displacement_theory.0,
        displacement_square_theory_error: displacement_theory.1,
        replicas: samples.len() as u64,
    }
}

fn species(
    plan: &Plan,
    (number, group): (usize, &Group),
    time: f64,
    (samples, first): (&[&Sample], &[&Sample]),
    curve: Option<&Curve>,
) -> SpeciesRow {
    let none = Moments::default();
    let of = |sample: &Sample| *sample.groups.get(number).unwrap_or(&none);
    let one = samples.first().map_or(none, |sample| of(sample));
    let theory = curve.and_then(|curve| curve.groups.get(number));
    let temperature = measured(
        samples,
        |sample| of(sample).temperature,
        Some(temperature_error(plan, &one) * one.temperature).filter(|_| one.count > 0),
    );
    let cumulant = measured(samples, |sample| of(sample).fourth_cumulant, None);
    let measure = &plan.case.measure;
    let displacement = measure.displacement.then(|| {
        measured(
            samples,
            |sample| of(sample).displacement,
            Some(displacement_error(plan, &one)).filter(|_| one.count > 1),
        )
    });
    let correlation = measure.velocity_correlation.then(|| {
        let pairs: Vec<(&Sample, &Sample)> =
            samples.iter().copied().zip(first.iter().copied()).collect();
        measured(
            &pairs,
            |(now, start)| of(now).velocity_correlation / of(start).velocity_correlation,
            None,
        )
    });
    let theory = |value: fn(&GroupCurve) -> Predicted| split(theory.map(value));
    let temperature_theory = theory(|group| group.temperature);
    // Of the first order it is zero because no more is asked, which is no prediction.
    let cumulant_theory = theory(|group| group.fourth_cumulant);
    let cumulant_theory = cumulant_theory.1.map_or((None, None), |_| cumulant_theory);
    let displacement_theory = displacement.map_or((None, None), |_| theory(|g| g.displacement));
    let correlation_theory = correlation.map_or((None, None), |_| theory(|g| g.correlation));
    SpeciesRow {
        time,
        species: number as u64 + 1,
        mass: group.mass,
        diameter: group.diameter,
        count: group.count as u64,
        temperature: temperature.0,
        temperature_se: temperature.1,
        temperature_theory: temperature_theory.0,
        temperature_theory_error: temperature_theory.1,
        fourth_cumulant: cumulant.0,
        fourth_cumulant_se: cumulant.1,
        fourth_cumulant_theory: cumulant_theory.0,
        fourth_cumulant_theory_error: cumulant_theory.1,
        displacement_square: displacement.map(|found| found.0),
        displacement_square_se: displacement.and_then(|found| found.1),
        displacement_square_theory: displacement_theory.0,
        displacement_square_theory_error: displacement_theory.1,
        velocity_correlation: correlation.map(|found| found.0),
        velocity_correlation_se: correlation.and_then(|found| found.1),
        velocity_correlation_theory: correlation_theory.0,
        velocity_correlation_theory_error: correlation_theory.1,
    }
}

fn time_averaged(plan: &Plan, orders: usize, runs: &[Finished]) -> Vec<TimeAveragedRow> {
    let theory = theory::time_averaged(plan, orders);
    let mut rows = Vec::new();
    for (number, group) in plan.groups.iter().enumerate() {
        for (index, lag) in plan.lags().into_iter().enumerate() {
            let found = over(runs, |run| {
                run.record.time_averaged.get(number)?.get(index).copied()
            });
            let theory = split(theory.as_ref().map(|theory| theory[number][index]));
            rows.push(TimeAveragedRow {
                lag,
                species: number as u64 + 1,
                mass: group.mass,
                displacement_square: found.0.unwrap_or(f64::NAN),
                displacement_square_se: found.1,
                displacement_square_theory: theory.0,
                displacement_square_theory_error: theory.1,
                paths: group.count.min(plan.case.measure.paths) as u64,
            });
        }
    }
    rows
}

fn clusters(time: f64, samples: &[&Sample], first: &[&Sample]) -> ClusterRow {
    let pairs: Vec<(&Sample, &Sample)> =
        samples.iter().copied().zip(first.iter().copied()).collect();
    let mean = |value: &dyn Fn(&Sample, &Sample) -> f64| {
        measured(&pairs, |(now, start)| value(now, start), None)
    };
    let known = |sample: &Sample| sample.clusters;
    let of = |value: &dyn Fn(&super::record::Clusters) -> f64| {
        mean(&|now, _| known(now).as_ref().map_or(f64::NAN, value))
    };
    let energy = |value: &dyn Fn(&super::record::Clusters) -> f64| {
        mean(&|now, start| known(now).as_ref().map_or(f64::NAN, value) / start.energy).0
    };
    let each = |value: &dyn Fn(&super::record::Clusters) -> f64| {
        mean(&|now, start| known(now).as_ref().map_or(f64::NAN, value) / start.particles as f64).0
    };
    let ratio = mean(&|now, start| now.particles as f64 / start.particles as f64);
    let energy_ratio = mean(&|now, start| now.energy / start.energy);
    let monomers = of(&|clusters| clusters.mean_by_mass);
    ClusterRow {
        time,
        clusters_ratio: ratio.0,
        clusters_ratio_se: ratio.1,
        single_ratio: each(&|clusters| clusters.single as f64),
        mean_monomers: monomers.0,
        mean_monomers_se: monomers.1,
        largest_monomers: of(&|clusters| f64::from(clusters.largest)).0,
        energy_ratio: energy_ratio.0,
        energy_ratio_se: energy_ratio.1,
        stuck_energy: energy(&|clusters| clusters.ledger.stuck),
        shattered_energy: energy(&|clusters| clusters.ledger.shattered),
        heating_energy: energy(&|clusters| clusters.heated),
        mergers_per_monomer: each(&|clusters| clusters.ledger.mergers as f64),
        shatterings_per_monomer: each(&|clusters| clusters.ledger.shatterings as f64),
        refused: samples
            .iter()
            .filter_map(|sample| Some(known(sample)?.ledger.refused))
            .sum(),
    }
}

/// Every size by itself up to here, then bins of ten to a decade.
const SINGLE: u64 = 16;

/// The bin of a number of monomers: its smallest and largest.
fn bin(monomers: u64) -> (u64, u64) {
    if monomers <= SINGLE {
        return (monomers, monomers);
    }
    let edge = |number: i32| (SINGLE as f64 * 10_f64.powf(f64::from(number) / 10.0)).floor() as u64;
    let mut number = (10.0 * (monomers as f64 / SINGLE as f64).log10()).floor() as i32;
    // Edges are whole numbers: rounding may have put the number beside its bin.
    while edge(number) >= monomers {
        number -= 1;
    }
    while edge(number + 1) < monomers {
        number += 1;
    }
    (edge(number) + 1, edge(number + 1))
}

/// Rows of one distribution, from the numbers of each replica and what they are to be divided by.
fn size_rows(average: &str, time: f64, replicas: &[(&Sizes, f64)]) -> Vec<SizeRow> {
    let mut bins: Vec<(u64, u64)> = replicas
        .iter()
        .flat_map(|(sizes, _)| sizes.keys().map(|&size| bin(u64::from(size))))
        .collect();
    bins.sort_unstable();
    bins.dedup();
    bins.into_iter()
        .map(|(low, high)| {
            let count = |sizes: &Sizes| -> u64 {
                let range = low as u32..=high.min(u64::from(u32::MAX)) as u32;
                sizes.range(range).map(|(_, count)| count).sum()
            };
            let width = (high - low + 1) as f64;
            let density: Vec<f64> = replicas
                .iter()
                .map(|(sizes, norm)| count(sizes) as f64 / width / norm)
                .collect();
            let estimate = Estimate::over_replicas(&density);
            SizeRow {
                average: average.to_owned(),
                time,
                monomers_low: low,
                monomers_high: high,
                clusters_per_monomer: estimate.as_ref().map_or(f64::NAN, |found| found.value),
                clusters_per_monomer_se: estimate.and_then(|found| found.standard_error),
                counted: replicas.iter().map(|(sizes, _)| count(sizes)).sum(),
            }
        })
        .collect()
}

fn sizes(plan: &Plan, runs: &[Finished]) -> Vec<SizeRow> {
    let monomers = plan.particles() as f64;
    let mut rows = Vec::new();
    for (index, &time) in plan.case.measure.size_distribution_times.iter().enumerate() {
        let replicas: Vec<(&Sizes, f64)> = runs
            .iter()
            .filter_map(|run| Some((&run.record.sizes.get(index)?.1, monomers)))
            .collect();
        rows.extend(size_rows("instant", time, &replicas));
    }
    if let Some(steady) = plan.case.measure.steady {
        let sums: Vec<(Sizes, u64)> = runs.iter().map(|run| steady::all(&run.record)).collect();
        let replicas: Vec<(&Sizes, f64)> = sums
            .iter()
            .map(|(sizes, times)| (sizes, monomers * (*times).max(1) as f64))
            .collect();
        rows.extend(size_rows("steady", steady.from, &replicas));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_of_sizes_leave_no_gap() {
        let mut next = 1;
        while next < 1_000_000 {
            let (low, high) = bin(next);
            assert_eq!(low, next);
            assert!(high >= low && bin(high) == (low, high));
            next = high + 1;
        }
    }
}
