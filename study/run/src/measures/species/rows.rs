//! Averages of each species over replicas at each sample time, for one engine.

use stosszahl_analysis::replicas::of_sums;
use stosszahl_dsmc::homogeneous::SpeciesMoments;
use stosszahl_results::TableEstimate;

use super::super::gas_series::{self, GasSeries, SpeciesSums};
use super::super::species_record::{
    self as record, SpeciesRecord, SpeciesSample, against, has_correlation, measured,
};
use super::super::{mean_over_replicas, tau};
use crate::plan::CasePlan;
use crate::plan::{GroupCurve, Predicted, TheoryPoint};
use crate::theory::homogeneous;

/// Row of the table `species.csv`: one species at one time, averaged over replicas.
#[derive(Default)]
pub(crate) struct SpeciesRow {
    /// Sample time of the row, in the case's unit of time.
    pub time: f64,
    /// Index of the species, from 0.
    pub species: usize,
    /// Number of particles of the species.
    pub particles: TableEstimate,
    /// Dimensionless time `tau_1` of Bodrova & Osinsky: collisions per particle of species 1 with
    /// its own species since the start.
    pub tau: TableEstimate,
    /// Granular temperature of the species \[energy\].
    pub temperature: TableEstimate,
    /// Granular temperature of the species over that of the first species.
    pub ratio_to_first: TableEstimate,
    /// Rotational temperature of the species \[energy\].
    pub spin_temperature: TableEstimate,
    /// Fourth cumulant a2 of the velocities of the species.
    pub fourth_cumulant: TableEstimate,
    /// Mean squared displacement of the species since the start \[length^2\].
    pub displacement: TableEstimate,
    /// Self-diffusion coefficient of the species \[length^2/time\].
    pub diffusion: TableEstimate,
    /// Relaxation time of the velocities of the species \[time\].
    pub relaxation: TableEstimate,
    /// Correlation of velocities with initial velocities, 1 at the start.
    pub correlation: TableEstimate,
    /// Number of replicas in the averages of the row.
    pub replicas: usize,
}

/// Computes the rows of `species.csv` for a gas without positions, for all species and sample
/// times.
pub(crate) fn homogeneous_rows(plan: &CasePlan, records: &[&SpeciesRecord]) -> Vec<SpeciesRow> {
    let curves = homogeneous::curves(plan).ok();
    let taus = tau::tau_at_samples(plan, records);
    let mut rows = Vec::new();
    for (index, time) in plan.sample_times().into_iter().enumerate() {
        let curve = curves.and_then(|curves| curves.at.get(index));
        let pairs = record::pairs(records, index);
        let tau = taus.get(index).copied().unwrap_or_default();
        let of = |species| SpeciesRow {
            tau,
            ..row(plan, species, time, &pairs, curve)
        };
        rows.extend((0..plan.gas.species.len()).map(of));
    }
    rows
}

fn row(
    plan: &CasePlan,
    species: usize,
    time: f64,
    pairs: &record::ReplicaPairs<'_>,
    curve: Option<&TheoryPoint>,
) -> SpeciesRow {
    let of = |sample: &SpeciesSample| of_species(sample, species);
    let one = pairs
        .first()
        .map_or_else(SpeciesMoments::default, |pair| of(pair.0));
    let first = curve.and_then(|curve| curve.groups.first());
    let curve = curve.and_then(|curve| curve.groups.get(species));
    let theory = |value: fn(&GroupCurve) -> Predicted| curve.map(value);
    let temperature = {
        let relative =
            record::temperature_error(plan.gas.dimension, one.count as f64, one.fourth_cumulant);
        let single = relative * one.temperature;
        measured(
            pairs,
            |pair| of(pair.0).temperature,
            (one.count > 0).then_some(single),
        )
    };
    let ratios: Vec<[f64; 2]> = pairs
        .iter()
        .map(|pair| [species, 0].map(|one| of_species(pair.0, one).temperature))
        .collect();
    let expected = curve
        .zip(first)
        .map(|(own, first)| own.temperature.value / first.temperature.value);
    let cumulant = measured(pairs, |pair| of(pair.0).fourth_cumulant, None);
    let displacement = record::has_displacement(plan).then(|| {
        let single = (one.count > 1).then(|| record::displacement_error(plan, &one));
        let found = measured(pairs, |pair| of(pair.0).displacement, single);
        against(found, theory(|group| group.displacement))
    });
    let [diffusion, relaxation] = diffusion(plan, species, pairs, curve);
    let correlation = has_correlation(plan).then(|| {
        let kept = |pair: &(&SpeciesSample, &SpeciesSample)| {
            of(pair.0).velocity_correlation / of(pair.1).velocity_correlation
        };
        against(
            measured(pairs, kept, None),
            theory(|group| group.correlation),
        )
    });
    // In the first order the cumulant is zero by assumption, which is no prediction.
    let predicted = theory(|group| group.fourth_cumulant).filter(|theory| theory.error.is_some());
    SpeciesRow {
        time,
        species,
        particles: measured(pairs, |pair| of(pair.0).count as f64, None),
        ratio_to_first: mean_ratio(&ratios).against(expected),
        replicas: pairs.len(),
        temperature: against(temperature, theory(|group| group.temperature)),
        fourth_cumulant: against(cumulant, predicted),
        displacement: displacement.unwrap_or_default(),
        diffusion,
        relaxation,
        correlation: correlation.unwrap_or_default(),
        ..SpeciesRow::default()
    }
}

/// Returns the moments of one species in a sample; zeros for a species without particles.
fn of_species(sample: &SpeciesSample, species: usize) -> SpeciesMoments {
    sample.groups.get(species).copied().unwrap_or_default()
}

/// Estimates the self-diffusion coefficient `<R · v>/D` of displacements R and velocities v in D
/// dimensions, and the velocity relaxation time, m/T times it. The relaxation time is empty if the
/// masses in a species differ.
fn diffusion(
    plan: &CasePlan,
    species: usize,
    pairs: &record::ReplicaPairs<'_>,
    curve: Option<&GroupCurve>,
) -> [TableEstimate; 2] {
    if !record::has_displacement(plan) {
        return [TableEstimate::default(); 2];
    }
    let of = |sample: &SpeciesSample| of_species(sample, species);
    let one = pairs
        .first()
        .map_or_else(SpeciesMoments::default, |pair| of(pair.0));
    let d = plan.gas.dimension as f64;
    let single = (one.count > 1).then(|| {
        let spread = one.displacement_velocity_square - one.displacement_velocity.powi(2);
        (spread.max(0.0) / one.count as f64).sqrt() / d
    });
    let found = measured(pairs, |pair| of(pair.0).displacement_velocity / d, single);
    let diffusion = against(found, curve.map(|curve| curve.diffusion));
    let mass = plan.gas.species[species].mass;
    if plan.gas.classes.len() != plan.gas.species.len() {
        return [diffusion, TableEstimate::default()];
    }
    let time =
        |moments: SpeciesMoments| moments.displacement_velocity * mass / (d * moments.temperature);
    let single = single.map(|error| error * mass / one.temperature);
    let found = measured(pairs, |pair| time(of(pair.0)), single);
    [
        diffusion,
        against(found, curve.map(|curve| curve.relaxation)),
    ]
}

/// Estimates the ratio of two means over replicas, with its jackknife error.
pub(super) fn mean_ratio(sums: &[[f64; 2]]) -> TableEstimate {
    mean_over_replicas(of_sums(sums, |[a, b]| a / b).into_iter().map(Some))
}

/// Returns the temperature of a species in engine units: `m <v²>/D` in a uniform gas, and about the
/// species' mean velocity in a flow.
pub(super) fn temperature(plan: &CasePlan, share: &SpeciesSums) -> f64 {
    if plan.is_uniform() {
        2.0 * share.translation / (plan.gas.dimension as f64 * share.number.max(1.0))
    } else {
        share.temperature(gas_series::freedom(plan))
    }
}

/// Computes the rows of `species.csv` for a gas in a box, for all species and sample times.
pub(super) fn rows_in_box(plan: &CasePlan, all_series: &[&GasSeries]) -> Vec<SpeciesRow> {
    let (freedom, unit) = (gas_series::freedom(plan), plan.scale.energy);
    if all_series.is_empty() {
        return Vec::new();
    }
    let theory = plan.partial_temperatures();
    let mut rows = Vec::new();
    for index in 0..gas_series::shortest(all_series) {
        let expected = theory.and_then(|all| all.get(index));
        for species in 0..plan.gas.species.len() {
            let share = |series: &GasSeries, species: usize| series[index].species[species];
            let of = |value: &dyn Fn(&SpeciesSums) -> Option<f64>| {
                let each = all_series
                    .iter()
                    .map(|series| value(&share(series, species)));
                mean_over_replicas(each)
            };
            let own = expected.map(|all| all[species]);
            let ratio = expected.map(|all| all[species] / all[0]);
            let pairs = all_series.iter().map(|series| {
                [species, 0].map(|species| temperature(plan, &share(series, species)))
            });
            rows.push(SpeciesRow {
                time: all_series[0][index].time,
                species,
                particles: of(&|share| Some(share.number)),
                temperature: of(&|share| Some(temperature(plan, share)))
                    .against(own)
                    .times(unit),
                ratio_to_first: mean_ratio(&pairs.collect::<Vec<_>>()).against(ratio),
                spin_temperature: of(&|share| share.spin_temperature(freedom)).times(unit),
                fourth_cumulant: of(&|share| Some(share.fourth_cumulant(plan.gas.dimension))),
                replicas: all_series.len(),
                ..SpeciesRow::default()
            });
        }
    }
    rows
}
