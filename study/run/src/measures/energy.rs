//! Measurement of the whole gas against time: particles, collisions, energies, temperatures and
//! fourth cumulant. Verdicts compare engines with each other and with theory. Every case has this
//! measurement.

mod flow_verdicts;
mod tables;
mod uniform_verdicts;

use stosszahl_results::{Table, VerdictText};

use super::gas_series::{GasSample, GasSampling, GasSeries};
use super::time_blocks::{self};
use crate::judge::power::ReplicaSpread;
use crate::judge::title;
use crate::measure::{
    BadOption, Measure, NoOptions, Probe, ReplicaRecords, SampleProbe, described,
};
use crate::plan::{CasePlan, EnginePlan};

pub(crate) use flow_verdicts::two_temperature_theory;
pub(super) use tables::{GasRow, rows};
pub(super) use uniform_verdicts::{pairs_of, void_for};

/// Measurement of the whole gas against time, with the table `energy.csv`.
pub struct EnergyMeasure;

impl Measure for EnergyMeasure {
    described!(
        "energy",
        "The whole gas in time: collisions, energies, temperatures, fourth cumulant; engines against each other and against theory.",
        NoOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, _plan: &CasePlan) -> bool {
        true
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        self.read_options(plan)?;
        if plan.is_uniform() {
            return Ok(());
        }
        time_blocks::check_blocks(plan, 1)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        times(plan).split_off(1)
    }

    fn kept_per_look(&self, plan: &CasePlan) -> f64 {
        super::KEPT_PER_SPECIES * (1 + plan.gas.species.len()) as f64
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let sampling = GasSampling::from_plan(plan);
        Box::new(SampleProbe::from_start(
            GasSeries::new(),
            move |series, moment| {
                series.push(GasSample::sample_gas(&sampling, moment));
            },
        ))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let several = plan.engines.len() > 1 && plan.has_box() && !has_energies_apart(plan);
        let tables = [
            Some(tables::energy(plan, runs)),
            several.then(|| uniform_verdicts::comparison(plan, runs)),
            Some(tables::replicas(plan, runs)),
        ];
        tables.into_iter().flatten().collect()
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        if !plan.has_box() {
            0
        } else if has_energies_apart(plan) {
            flow_verdicts::test_count(plan)
        } else {
            uniform_verdicts::test_count(plan)
        }
    }

    fn quantity_spreads(&self, plan: &CasePlan) -> Vec<ReplicaSpread> {
        if has_energies_apart(plan) || self.test_count(plan) == 0 {
            return Vec::new();
        }
        uniform_verdicts::quantity_spreads(plan)
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        if !plan.has_box() {
            // The measure `checks` compares a gas without positions with theory.
            Vec::new()
        } else if has_energies_apart(plan) {
            flow_verdicts::verdicts(plan, runs)
        } else {
            uniform_verdicts::verdicts(plan, runs)
        }
    }
}

/// Returns the sample times of the whole gas, start included, in the case's unit of time. A flow
/// has equal intervals, from which its steady state is found.
pub(crate) fn times(plan: &CasePlan) -> Vec<f64> {
    if plan.is_uniform() {
        plan.sample_times()
    } else {
        time_blocks::times(plan)
    }
}

/// Returns true if flow, gravity or rotation holds part of the energy, so that Haff's law for
/// translation alone does not apply.
fn has_energies_apart(plan: &CasePlan) -> bool {
    plan.has_box() && (!plan.is_uniform() || plan.is_rough())
}

/// Returns true if the number of particles changes, by aggregation, inflow or outflow.
fn has_changing_number(plan: &CasePlan) -> bool {
    plan.case.aggregation.is_some() || plan.case.is_open() || !plan.case.inflow.is_empty()
}

/// Returns K/K(0), the translational kinetic energy at a sample over that at the start, without
/// tracers.
pub(crate) fn energy_ratio(plan: &CasePlan, series: &GasSeries, sample: usize) -> f64 {
    untraced(plan, &series[sample]) / untraced(plan, &series[0])
}

/// Returns the translational kinetic energy of all particles but tracers, in engine units.
fn untraced(plan: &CasePlan, sample: &GasSample) -> f64 {
    let kept = |species: usize| plan.gas.species.get(species).is_none_or(|one| !one.tracer);
    sample.total_of(kept).translation
}
