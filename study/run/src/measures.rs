//! List of all measurements; each has a file of its own in this folder.

mod boundaries;
mod checks;
mod clusters;
mod collision_log;
#[cfg(test)]
mod contact_tests;
mod contacts;
mod displacement;
pub(crate) mod energy;
mod error_budget;
mod fields;
mod frames;
mod gas_series;
#[cfg(test)]
mod hydrodynamic_tests;
mod impact_parameters;
mod intermediate_scattering;
mod pair_correlation;
#[cfg(test)]
mod positionless_tests;
#[cfg(test)]
mod record_tests;
mod row_columns;
mod selection;
mod shear_balance;
mod snapshots;
mod species;
mod species_record;
mod spectra;
mod steady_state;
mod stress;
mod structure_factor;
mod tau;
#[cfg(test)]
mod tests;
mod time_averaged_displacement;
mod time_blocks;
#[cfg(test)]
pub(crate) mod toy;
mod transport;
mod velocity_autocorrelation;
mod velocity_distribution;

use stosszahl_analysis::pair_correlation::PairCounts;
use stosszahl_analysis::statistics::Estimate as Mean;
use stosszahl_analysis::stress::KineticStress;
use stosszahl_analysis::structure_factor::LatticePoints;
use stosszahl_analysis::{flow, modes, velocities};
use stosszahl_dsmc::SimulatorWeights;
use stosszahl_model::sum::{self, ReductionFactory};
use stosszahl_model::{DynReduction, VelocityMoments};
use stosszahl_results::TableEstimate;

use crate::measure::{self, BadOption, Measure};
use crate::plan::{CasePlan, EnginePlan, logarithmic};

pub(crate) use gas_series::GasSeries;
pub use snapshots::extended_xyz;
pub(crate) use structure_factor::last_structure_factor;

/// Memory of the sums over one species at one time, in the records of time series \[bytes\].
const KEPT_PER_SPECIES: f64 = 80.0;

/// All measures of the program, in the order of tables and reports.
pub const ALL: &[&dyn Measure] = &[
    &energy::EnergyMeasure,
    &checks::TheoryComparison,
    &species::SpeciesMeasure,
    &species::VelocityCorrelation,
    &steady_state::SteadyState,
    &stress::StressMeasure,
    &shear_balance::ShearBalance,
    &transport::TransportMeasure,
    &impact_parameters::ImpactMeasure,
    &contacts::ContactMeasure,
    &fields::FieldMeasure,
    &boundaries::BoundaryMeasure,
    &structure_factor::StructureFactors,
    &spectra::HydrodynamicSpectra,
    &pair_correlation::PairCorrelations,
    &displacement::DisplacementMeasure,
    &time_averaged_displacement::TimeAveragedDisplacement,
    &velocity_autocorrelation::VelocityAutocorrelation,
    &velocity_distribution::VelocityDistributionMeasure,
    &intermediate_scattering::IntermediateScattering,
    &clusters::ClusterMeasure,
    &collision_log::CollisionLog,
    &snapshots::SnapshotMeasure,
    &frames::FrameMeasure,
    &error_budget::ErrorBudget,
];
/// Returns sample times in equal factors from the first sample on, in the unit of time of the case;
/// the last is exactly `until`.
pub(crate) fn grid(plan: &CasePlan, until: f64) -> impl Iterator<Item = f64> + use<> {
    logarithmic(plan.first_sample(), until, plan.samples_per_decade())
}

/// Creates an empty particle reduction by the name with which the root process requests it; `empty`
/// holds its serialized options.
pub(crate) fn sum(name: &str, empty: &[u8]) -> Option<Box<dyn DynReduction>> {
    let kinds: [ReductionFactory; 11] = [
        sum::restore_reduction::<VelocityMoments>,
        sum::restore_reduction::<flow::SpeciesFlows>,
        sum::restore_reduction::<flow::Warmth>,
        sum::restore_reduction::<KineticStress>,
        sum::restore_reduction::<velocities::VelocityCounts>,
        sum::restore_reduction::<LatticePoints>,
        sum::restore_reduction::<modes::Amplitudes>,
        sum::restore_reduction::<PairCounts>,
        sum::restore_reduction::<frames::FrameReduction>,
        sum::restore_reduction::<frames::ChosenParticles>,
        sum::restore_reduction::<gas_series::GasReduction>,
    ];
    kinds.iter().find_map(|made| made(name, empty))
}

/// Returns an error if the simulators of an engine come and go, so that their indices are not
/// permanent.
pub(crate) fn require_kept(plan: &CasePlan) -> Result<(), BadOption> {
    let weighted = |engine: &&EnginePlan| engine.weights != SimulatorWeights::uniform();
    let Some(name) = plan.engines.iter().find(weighted).map(|engine| engine.name) else {
        return Ok(());
    };
    let allowed =
        format!("engines that keep particles; {name} splits and merges simulators by its weights");
    measure::require(false, "", allowed)
}

/// Meaning of the table column `parts` of time averages, for documentation.
const PARTS: &str = "Independent parts of the runs behind the errors, at least: blocks of time, or replicas where no blocks are long enough; \
                     intervals are Student's with one degree of freedom less";

/// Returns the smallest number of independent parts of the runs behind the standard errors of some
/// averages over time.
fn fewest_parts<'a>(averages: impl IntoIterator<Item = &'a TableEstimate>) -> usize {
    let parts = averages.into_iter().filter_map(|one| one.replicas);
    parts.min().unwrap_or(1)
}

/// Computes mean and standard error over replicas; replicas without a finite value are left out.
pub fn mean_over_replicas(values: impl IntoIterator<Item = Option<f64>>) -> TableEstimate {
    let known: Vec<f64> = values
        .into_iter()
        .flatten()
        .filter(|value| value.is_finite())
        .collect();
    let mean = Mean::over_replicas(&known);
    TableEstimate {
        value: mean.map(|mean| mean.value),
        standard_error: mean.and_then(|mean| mean.standard_error),
        replicas: mean.map(|mean| mean.replicas),
        ..TableEstimate::default()
    }
}
