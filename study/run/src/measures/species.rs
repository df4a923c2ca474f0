//! Measurement of each species against time: temperature and fourth cumulant. Gases without
//! positions also have displacement, diffusion and velocity correlation.

mod rows;
mod table;
mod verdicts;

use stosszahl_results::{Table, VerdictText};

use super::energy;
use super::species_record::{self as record, CORRELATION, SpeciesProbe, has_correlation};
use crate::measure::{
    self, BadOption, Measure, Needs, NoOptions, Probe, ReplicaRecords, SampleProbe, described,
};
use crate::plan::{CasePlan, EnginePlan};

pub(super) use rows::{SpeciesRow, homogeneous_rows};

/// Measurement of each species against time, with the table `species.csv`. In a box it uses the
/// samples of the measurement `energy`.
pub struct SpeciesMeasure;

/// Measurement of the correlation of velocities with initial velocities, shown in the table
/// `species.csv`.
pub struct VelocityCorrelation;

impl Measure for SpeciesMeasure {
    described!(
        "species",
        "Each species in time: temperature and fourth cumulant; without positions also displacement and velocity correlation.",
        NoOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        if plan.has_box() {
            plan.gas.species.len() > 1
        } else {
            plan.case.aggregation.is_none()
        }
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        if plan.has_box() {
            let allowed = "several species, by [[species]]; this gas has one";
            measure::require(plan.gas.species.len() > 1, "", allowed)?;
        } else {
            lasting_only(plan)?;
        }
        self.read_options(plan)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        if plan.has_box() {
            Vec::new()
        } else {
            energy::times(plan)
        }
    }

    fn kept_per_particle(&self, plan: &CasePlan) -> f64 {
        if has_correlation(plan) {
            size_of::<[f64; 3]>() as f64
        } else {
            0.0
        }
    }

    fn kept_per_look(&self, plan: &CasePlan) -> f64 {
        super::KEPT_PER_SPECIES * (1 + plan.gas.species.len()) as f64
    }

    fn engine_needs(&self, plan: &CasePlan) -> Needs {
        Needs {
            displacements: !plan.has_box() && record::has_displacement(plan),
            ..Needs::default()
        }
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        if plan.has_box() {
            Box::new(SampleProbe::new((), |(), _| {}))
        } else {
            Box::new(SpeciesProbe::new(plan))
        }
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut rows = Vec::new();
        for (index, engine) in plan.engines.iter().enumerate() {
            let own = if plan.has_box() {
                rows::rows_in_box(plan, &runs.records_of(index))
            } else {
                homogeneous_rows(plan, &runs.records(index))
            };
            rows.push((engine.name, own));
        }
        vec![table::species(plan, &rows)]
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        verdicts::test_count(plan)
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        verdicts::verdicts(plan, runs)
    }
}

impl Measure for VelocityCorrelation {
    described!(
        CORRELATION,
        "Correlation of the velocities with those of the start, as columns of the table of the species.",
        NoOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        lasting_only(plan)?;
        self.read_options(plan)
    }
}

/// Rejects a measurement that follows single particles, unless the gas has no positions and no
/// aggregation.
pub(super) fn lasting_only(plan: &CasePlan) -> Result<(), BadOption> {
    record::homogeneous_only(plan)?;
    let allowed = "not with [aggregation], as clusters do not last";
    measure::require(plan.case.aggregation.is_none(), "", allowed)
}
