//! Measure `shear_balance`: energy balance of a gas in uniform shear flow.

use stosszahl_results::{Table, VerdictKind, VerdictText, engine_title, table};

use crate::judge;
use crate::measure::{self, BadOption, Measure, NoOptions, ReplicaRecords, described};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `shear_balance` of the energy of a sheared gas: kinetic energy against shear work and
/// dissipation.
pub struct ShearBalance;

/// Largest relative imbalance of energy in exact dynamics that is rounding: 1e-16 of each of up to
/// 10^12 terms, with random signs.
const ROUNDING: f64 = 1e-10;
/// Name of the work counter that holds the energy imbalance of an engine.
const NUMBER: &str = "shear_energy_imbalance";

/// Returns true if an engine of the plan, exact dynamics, counts the energy balance.
fn has_exact_dynamics(plan: &CasePlan) -> bool {
    plan.engines.iter().any(EnginePlan::is_exact)
}

impl Measure for ShearBalance {
    described!(
        "shear_balance",
        "Energy balance of uniform shear flow: work of the stress, dissipation and change of energy.",
        NoOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_sheared() && has_exact_dynamics(plan)
    }

    fn knows_shear(&self) -> bool {
        true
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let allowed = "a gas in a shear flow, by box.shear_rate; this one is not";
        measure::require(plan.is_sheared(), "", allowed)?;
        let allowed =
            "a case with exact dynamics, which alone closes the balance to rounding: [engine.ed]";
        measure::require(has_exact_dynamics(plan), "", allowed)?;
        self.read_options(plan)
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "shear_balance", "Energy balance -a P_xy V = dissipation + change of energy in uniform shear flow, by replica.";
            key "engine", "", "Engine";
            key "replica", "1", "Replica";
            value "imbalance", "1", "Energy less what the balance expects, over the work of the stress and the dissipation";
        };
        for (engine, finished) in plan.engines.iter().zip(runs.finished) {
            for (replica, one) in finished.iter().enumerate() {
                if let Some(&imbalance) = one.work.numbers.get(NUMBER) {
                    table.add((engine.name, replica, imbalance));
                }
            }
        }
        vec![table]
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let verdict = |(engine, finished): (&EnginePlan, &Vec<measure::CompletedRun>)| {
            let imbalance = |one: &measure::CompletedRun| one.work.numbers.get(NUMBER).copied();
            let all: Option<Vec<f64>> = finished.iter().map(imbalance).collect();
            let worst = all?.into_iter().map(f64::abs).reduce(f64::max)?;
            let closes = worst <= ROUNDING;
            let words = if closes { "closes to" } else { "is off by" };
            let kind = if closes {
                VerdictKind::Note
            } else {
                VerdictKind::Warning
            };
            let sentence = format!(
                "Work of the shear flow, dissipation and change of energy: the balance {words} {worst:.1e} of the turnover; \
                 rounding leaves up to {ROUNDING:.0e}."
            );
            let topic = format!("energy balance, {}", engine_title(engine.name));
            Some(judge::verdict(topic, sentence, kind))
        };
        let all = plan.engines.iter().zip(runs.finished);
        all.filter_map(verdict).collect()
    }
}
