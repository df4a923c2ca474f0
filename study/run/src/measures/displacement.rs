//! Measure `displacement`: mean squared displacement of the particles, against Enskog's theory if
//! it applies.

use serde::Deserialize;
use stosszahl_results::{Figure, FigureAxis, Table, table};
use stosszahl_theory::{Moment, diffusion};

use super::{grid, mean_over_replicas};
use crate::measure::{
    self, BadOption, Measure, Needs, Probe, ReplicaRecords, SampleProbe, described,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `displacement` of the mean squared displacement.
pub struct DisplacementMeasure;

/// Options of `[measure.displacement]`: begin of the measurement.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DisplacementOptions {
    /// Time from which displacements are measured.
    pub from: f64,
}

/// Mean squared displacements \[engine length^2\] by time since the start of the measurement;
/// `None` from an engine that cannot measure them.
type Record = Vec<(f64, Option<f64>)>;

/// Returns the measuring times of displacements, each with the time since the start of the
/// measurement. They form a logarithmic grid, and the last is exactly the end of the run.
fn moments(plan: &CasePlan, from: f64) -> Vec<(f64, f64)> {
    let until = plan.case.run.until;
    // Late starts may leave no room between two times of the grid.
    let mut times: Vec<(f64, f64)> = grid(plan, until - from)
        .map(|elapsed| (from + elapsed, elapsed))
        .filter(|&(time, _)| from < time && time < until)
        .chain([(until, until - from)])
        .collect();
    times.dedup_by_key(|moment| moment.0);
    times
}

/// Computes the theoretical mean squared displacement at given times \[engine length^2\]; `None` if
/// no theory applies.
fn theory(plan: &CasePlan, from: f64, moments: &[(f64, f64)]) -> Vec<Option<f64>> {
    if !plan.has_box() {
        let of_species = by_mixture(plan, moments).filter(|_| from == 0.0);
        return of_species.unwrap_or_else(|| vec![None; moments.len()]);
    }
    let one = |&(_, elapsed): &(f64, f64)| enskog(plan, from, elapsed);
    moments.iter().map(one).collect()
}

/// Computes the mean squared displacement of a gas without positions from the kinetic equations of
/// its species.
fn by_mixture(plan: &CasePlan, moments: &[(f64, f64)]) -> Option<Vec<Option<f64>>> {
    if plan.case.thermostat.is_some() || plan.case.aggregation.is_some() {
        return None;
    }
    let (mixture, start) = (plan.mixture().ok()?, plan.temperatures());
    let times: Vec<f64> = moments
        .iter()
        .map(|moment| plan.engine_time(moment.0))
        .collect();
    let asked = plan
        .case
        .verdict
        .sonine_orders
        .map(|orders| orders as usize);
    let mut orders = (1..=asked.unwrap_or_else(|| mixture.affordable_orders())).rev();
    let found = orders.find_map(|orders| mixture.solve(orders, &start, &times).ok())?;
    let mean = |found: &Moment| {
        let classes = plan.gas.classes.iter().zip(&found.displacements);
        let sum: f64 = classes.map(|(one, square)| one.count as f64 * square).sum();
        Some(sum / plan.count() as f64)
    };
    Some(found.iter().map(mean).collect())
}

/// Computes the mean squared displacement by Enskog's theory of equal disks in first Sonine order,
/// a time `elapsed` after the start of the measurement. A gas in a bath is taken to be in its
/// steady state, whatever the start was.
fn enskog(plan: &CasePlan, from: f64, elapsed: f64) -> Option<f64> {
    if !plan.has_theory() || plan.gas.dimension != 2 {
        return None;
    }
    let decay = diffusion::velocity_decay(
        plan.gas.packing_fraction,
        plan.gas.contact_value,
        plan.gas.restitution,
    );
    let steady = |temperature: f64| {
        let rate = decay * temperature.sqrt();
        diffusion::steady_displacement(temperature, rate, plan.engine_time(elapsed))
    };
    if plan.case.bath().is_some() {
        let (temperature, state) = plan.steady_temperature().zip(plan.bath_state())?;
        let rate = decay * temperature.sqrt() + state.drag;
        let elapsed = plan.engine_time(elapsed);
        return Some(diffusion::steady_displacement(temperature, rate, elapsed));
    }
    let [first, last] = [from, from + elapsed].map(|time| plan.cooling_logarithm(time, false));
    let Some((first, last)) = first.zip(last) else {
        return Some(steady(1.0));
    };
    // T t0^2 is the same at all times of the cooling state, and only the logarithm of its
    // temperature tells how far disks have gone.
    let square = plan.clock.haff_time * plan.clock.haff_time;
    let passed = (last - first).exp_m1();
    Some(square * diffusion::cooling_displacement(plan.gas.restitution, passed))
}

impl DisplacementMeasure {
    fn from(&self, plan: &CasePlan) -> f64 {
        measure::chosen::<DisplacementOptions>(plan, self.name()).from
    }
}

impl Measure for DisplacementMeasure {
    described!(
        "displacement",
        "Mean squared displacement of the particles since a chosen time.",
        DisplacementOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let DisplacementOptions { from } = measure::options(plan, self.name())?;
        let first = grid(plan, plan.case.run.until).next().unwrap_or(0.0);
        let last = plan.case.run.until - first;
        let allowed = format!("a time from 0 to below {last}, so that one sample follows");
        measure::require((0.0..last).contains(&from), "from", allowed)?;
        let closed = plan.case.inflow.is_empty() && plan.case.aggregation.is_none();
        let allowed = "a gas whose particles neither come nor go nor stick";
        measure::require(closed, "", allowed)
    }

    fn engine_needs(&self, _plan: &CasePlan) -> Needs {
        Needs {
            displacements: true,
            ..Needs::default()
        }
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let from = self.from(plan);
        let later = moments(plan, from).into_iter().map(|moment| moment.0);
        std::iter::once(from).chain(later).collect()
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let from = self.from(plan);
        Box::new(SampleProbe::new(Record::new(), move |record, moment| {
            if moment.time == from {
                moment.simulation.track_displacements();
                return;
            }
            let mean = moment.simulation.mean_squared_displacement();
            record.push((moment.time - from, mean));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "mean_squared_displacement", "Mean squared displacement in time.";
            key "engine", "", "Engine";
            key "time", "time", "Time since the start of the run";
            key "lag", "time", "Time since the start of the measurement";
            with_theory "mean_squared_displacement", "length^2", "Mean squared displacement; theory is Enskog's in first Sonine order";
            note "replicas", "1", "Replicas";
        }
        .figure(Figure::curves(
            "Mean squared displacement",
            FigureAxis::logarithmic("lag", "time"),
            FigureAxis::logarithmic("mean_squared_displacement", "mean squared displacement"),
        ));
        let from = self.from(plan);
        let moments = moments(plan, from);
        let theory = theory(plan, from, &moments);
        let unit = plan.scale.length * plan.scale.length;
        for (engine, records) in runs.each::<Record>(plan) {
            for (index, &(time, elapsed)) in moments.iter().enumerate() {
                let squares = records.iter().map(|record| Some(record[index].1? * unit));
                let square =
                    mean_over_replicas(squares).against(theory[index].map(|square| square * unit));
                table.add((engine.name, time, elapsed, square, records.len()));
            }
        }
        vec![table]
    }
}
