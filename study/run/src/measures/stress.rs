//! Measure `stress`: pressure tensor with kinetic and collisional part, pressure and normal stress
//! differences, for the equation of state of a gas.

use std::iter;

use serde::Deserialize;
use stosszahl_analysis::replicas::of_sums;
use stosszahl_analysis::statistics::RunningMoments as Spread;
use stosszahl_analysis::stress::{StressIntegrals, StressRecorder, kinetic_stress};
use stosszahl_model::Observer;
use stosszahl_results::{Table, TableEstimate, table};
use stosszahl_theory::UniformShear;

use super::mean_over_replicas;
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, RunStop, SampleContext, described,
    keeps_record, require,
};
use crate::plan::{CasePlan, EngineKind, EnginePlan};

/// Measure `stress` of the pressure tensor of a gas in a box.
pub struct StressMeasure;

/// Options of `[measure.stress]`: time span of the averages and its blocks.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StressOptions {
    /// Start of the averages, in the unit of time of the case. Default: half of the run for gases
    /// that are heated, 0 for others.
    #[schemars(range(min = 0.0))]
    pub from: Option<f64>,
    /// Number of time blocks from `from` to the end of the run, from 2 to 10000.
    #[schemars(range(min = 2, max = 10_000))]
    pub blocks: u64,
    /// Number of samples of the velocities in each block. Between two samples the kinetic part
    /// follows the collisions.
    #[schemars(range(min = 1, max = 10_000))]
    pub looks: u64,
}

impl Default for StressOptions {
    fn default() -> Self {
        Self {
            from: None,
            blocks: 20,
            looks: 20,
        }
    }
}

impl StressOptions {
    /// Returns the start of the averages, in the unit of time of the case.
    fn start(&self, plan: &CasePlan) -> f64 {
        let heated = plan.case.bath().is_some() || plan.heats_itself() || plan.is_sheared();
        let half = if heated { 0.5 } else { 0.0 };
        self.from.unwrap_or(half * plan.case.run.until)
    }
}

/// Time integrals of the pressure tensor of one engine and replica, by time block; `None` before
/// the start.
type Record = Option<StressRecorder>;

struct StressProbe {
    /// Shear rate of the flow \[1/time\], 0 without one; and true if partners are a contact
    /// distance apart in the flow.
    flow: (f64, bool),
    span: [f64; 2],
    blocks: usize,
    record: Record,
}

impl Probe for StressProbe {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        self.record
            .as_mut()
            .map(|record| record as &mut dyn Observer)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        let kinetic = kinetic_stress(&mut |sum| moment.simulation.reduce_particles(sum));
        let now = moment.simulation.time();
        let recorder = StressRecorder::new(self.span, self.blocks, now, kinetic);
        self.record = Some(recorder.in_flow(self.flow.0, self.flow.1));
    }

    fn on_stop(&mut self, stop: &RunStop) {
        if let (Some(record), Some(before)) = (&mut self.record, stop.kicked_from) {
            record.scale(stop.time, stop.temperature / before);
        }
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let kinetic = kinetic_stress(&mut |sum| moment.simulation.reduce_particles(sum));
        if let Some(record) = &mut self.record {
            record.set_kinetic(moment.simulation.time(), kinetic);
        }
    }

    keeps_record!();
}

/// Quantity of the stress table: a linear form in the elements of the pressure tensor.
struct Quantity {
    name: &'static str,
    of: Element,
}

/// Linear form of the pressure tensor in D dimensions.
type Element = fn(&nalgebra::Matrix3<f64>, usize) -> f64;

/// Returns the quantities of the stress table in a dimension, in their order.
fn quantities(dimension: usize) -> Vec<Quantity> {
    let one = |name, of: Element| Quantity { name, of };
    let mut all = vec![
        one("pressure", |tensor, dimension| {
            tensor.trace() / dimension as f64
        }),
        one("xx", |tensor, _| tensor[(0, 0)]),
        one("yy", |tensor, _| tensor[(1, 1)]),
    ];
    if dimension == 3 {
        all.push(one("zz", |tensor, _| tensor[(2, 2)]));
    }
    // The momentum along x that is carried along y.
    all.push(one("xy", |tensor, _| tensor[(1, 0)]));
    all.push(one("normal_stress_difference", |tensor, _| {
        tensor[(0, 0)] - tensor[(1, 1)]
    }));
    all
}

/// Computes the theoretical pressure over n T of a uniform gas: Enskog's for engines whose
/// collisions transfer momentum over a distance, 1 for point particles. `None` for gases without
/// such a theory.
///
/// `p/(n T) = 1 + 2^(D-1) phi chi (1 + r + a/<g_n>)/2` in D dimensions, for Maxwellian velocities
/// with the mean normal approach speed `<g_n> = sqrt(pi T/m)` of colliding pairs and the speed a
/// that contacts add.
fn pressure_theory(plan: &CasePlan, engine: &EnginePlan, temperature: f64) -> Option<f64> {
    let uniform = plan.is_uniform_box() && plan.gas.classes.len() == 1;
    let (coefficient, added_speed) = match (plan.gas.law.constant(), plan.gas.law.delta()) {
        (Some(coefficient), _) => (coefficient, 0.0),
        (None, Some(law)) => (law.coefficient(), 2.0 * law.delta()),
        (None, None) => return None,
    };
    if !uniform || plan.is_sheared() {
        return None;
    }
    if let EngineKind::MonteCarlo(parameters) = &engine.kind {
        match parameters.scheme {
            scheme if scheme.is_cross_cell() => {}
            scheme if scheme.is_dilute() => return Some(1.0),
            // Their displacements are a choice, and with them their pressure.
            _ => return None,
        }
    }
    let approach = (std::f64::consts::PI * temperature / plan.gas.classes[0].mass).sqrt();
    let contact = plan.gas.packing_fraction
        * plan.gas.contact_value
        * f64::from(1 << (plan.gas.dimension - 1));
    Some(1.0 + 0.5 * contact * (1.0 + coefficient + added_speed / approach))
}

/// Largest packing fraction at which theory of shear flow leaves out the collisional stress.
const DILUTE: f64 = 0.01;

/// Returns the theory of uniform shear flow, and the shear rate in engine units. `None` unless the
/// gas is dilute, of one species, smooth and of constant restitution.
fn dilute_flow(plan: &CasePlan, engine: &EnginePlan) -> Option<(UniformShear, f64)> {
    let is_plain =
        plan.gas.classes.len() == 1 && !plan.is_rough() && plan.gas.law.constant().is_some();
    let is_dilute = engine
        .parameters()
        .is_some_and(|one| one.scheme.is_dilute());
    let (flow, rate) = plan.shear_flow()?;
    let has_state = flow.reduced_rate() > 0.0;
    (is_plain && has_state && (is_dilute || plan.gas.packing_fraction <= DILUTE))
        .then_some((flow, rate))
}

/// Computes the theoretical value of a stress quantity over n T in a uniform shear flow.
fn flow_theory(flow: &UniformShear, rate: f64, quantity: &str) -> f64 {
    let [along, across, third] = flow.normal_stresses();
    match quantity {
        "xx" => along,
        "yy" => across,
        "zz" => third,
        "xy" => -flow.shear_stress() * rate.signum(),
        "normal_stress_difference" => along - across,
        _ => 1.0,
    }
}

/// Estimates a stress quantity over n T: its kinetic part, its collisional part, and their sum.
fn estimates(
    records: &[&StressRecorder],
    quantity: &Quantity,
    dimension: usize,
) -> [TableEstimate; 3] {
    let picks: [fn([f64; 2]) -> f64; 3] = [|p| p[0], |p| p[1], |p| p[0] + p[1]];
    picks.map(|pick| {
        estimate_ratio(records, |one| {
            let parts = [one.kinetic, one.collisional];
            let above = pick(parts.map(|tensor| (quantity.of)(&tensor, dimension)));
            [above, one.thermal(dimension)]
        })
    })
}

/// Estimates a ratio of sums over replicas and time blocks. The standard error is the larger of
/// those by replicas and by blocks. Blocks whose denominator is not above zero do not count.
fn estimate_ratio(
    records: &[&StressRecorder],
    of: impl Fn(&StressIntegrals) -> [f64; 2],
) -> TableEstimate {
    let of_record = |record: &&StressRecorder| {
        let blocks = record.blocks().iter();
        blocks.fold(StressIntegrals::default(), |sum, block| sum.plus(block))
    };
    let replicas: Vec<StressIntegrals> = records.iter().map(of_record).collect();
    let blocks: Vec<StressIntegrals> = records
        .iter()
        .flat_map(|record| record.blocks())
        .copied()
        .collect();
    let pseudo = |all: &[StressIntegrals]| {
        let sums = all.iter().map(&of).filter(|sums| sums[1] > 0.0);
        of_sums(&sums.collect::<Vec<_>>(), |[above, below]| above / below)
    };
    let mut found = mean_over_replicas(pseudo(&replicas).into_iter().map(Some));
    let spread: Spread = pseudo(&blocks).into_iter().collect();
    found.standard_error = match (found.standard_error, spread.standard_error()) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    found
}

/// Builds the table of means in a uniform shear flow, over the time span of the averages.
fn sheared_state(plan: &CasePlan, runs: &ReplicaRecords<'_>, rate: f64) -> Table {
    let mut table = table! {
        "sheared_state", "Temperature, viscosity and dissipation of uniform shear flow, over the span of the stress; errors over replicas and blocks of time.";
        key "engine", "", "Engine";
        with_theory "reduced_temperature", "1", "T/(m a^2 d^2), with the mean mass m and the mean diameter d; theory is the kinetic model of dilute gases, high by 2 % at restitution 0.9 and by 10 % at 0.7";
        with_theory "viscosity", "1", "Shear viscosity -P_xy/a over n T/|a|; theory as for the temperature, low by 2 %";
        estimate "dissipation", "1", "Energy that collisions take from a particle in the time 1/|a|, over T; the viscosity over n T/|a| where the state is steady";
        note "replicas", "1", "Replicas";
    };
    let (dimension, count) = (plan.gas.dimension, plan.count() as f64);
    let diameter = 2.0 * plan.mean_radius();
    let squared = (rate * diameter).powi(2) * count;
    for (engine, records) in runs.each::<Record>(plan) {
        let records: Vec<&StressRecorder> =
            records.into_iter().filter_map(Option::as_ref).collect();
        let temperature = estimate_ratio(&records, |one| {
            [one.thermal(dimension), one.duration * squared]
        });
        let viscosity = estimate_ratio(&records, |one| {
            let stress = one.kinetic[(1, 0)] + one.collisional[(1, 0)];
            [-stress * rate.signum(), one.thermal(dimension)]
        });
        let dissipation = estimate_ratio(&records, |one| {
            [one.energy_lost / rate.abs(), one.thermal(dimension)]
        });
        let theory = dilute_flow(plan, engine).map(|(flow, rate)| {
            let temperature = flow.temperature(rate, plan.shear_relaxation());
            [temperature / (rate * diameter).powi(2), flow.shear_stress()]
        });
        table.add((
            engine.name,
            temperature.against(theory.map(|one| one[0])),
            viscosity.against(theory.map(|one| one[1])),
            dissipation,
            records.len(),
        ));
    }
    table
}

impl Measure for StressMeasure {
    described!(
        "stress",
        "Pressure tensor over n T: kinetic and collisional part, pressure, normal stress difference.",
        StressOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_sheared()
    }

    fn knows_shear(&self) -> bool {
        true
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        require(
            plan.has_box(),
            "",
            "a gas in a box; this one has no positions",
        )?;
        super::require_kept(plan)?;
        let options: StressOptions = measure::options(plan, self.name())?;
        let (from, until) = (options.start(plan), plan.case.run.until);
        let allowed = format!("at least 0 and below run.until, {until}");
        require((0.0..until).contains(&from), "from", allowed)?;
        require(
            (2..=10_000).contains(&options.blocks),
            "blocks",
            "2 to 10000",
        )?;
        require((1..=10_000).contains(&options.looks), "looks", "1 to 10000")
    }

    /// Returns the sample times: start and end of the averages, and the middles of equal intervals
    /// between them.
    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let options: StressOptions = measure::chosen(plan, self.name());
        let (from, until) = (options.start(plan), plan.case.run.until);
        let looks = options.blocks * options.looks;
        let step = (until - from) / looks as f64;
        let middle = |look: u64| from + step * (look as f64 + 0.5);
        let mut times: Vec<f64> = (0..looks).map(middle).collect();
        times.push(from);
        times.push(until);
        times.retain(|&time| time > 0.0);
        times
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        let apart = match &engine.kind {
            EngineKind::MonteCarlo(parameters) => parameters.scheme.properties().feels_flow,
            _ => true,
        };
        let options: StressOptions = measure::chosen(plan, self.name());
        let span = [options.start(plan), plan.case.run.until];
        Box::new(StressProbe {
            flow: (plan.gas.particles.shear_rate.unwrap_or_default(), apart),
            span: span.map(|time| plan.engine_time(time)),
            blocks: options.blocks as usize,
            record: None,
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "stress", "Pressure tensor over n T, with n T from the same looks; errors over replicas and blocks of time.";
            key "engine", "", "Engine";
            key "quantity", "", "pressure: mean of the diagonal; xx, yy, zz: normal stresses; xy: momentum along x that is carried along y; normal_stress_difference: xx less yy";
            note "window_start", "time", "Start of the averages";
            note "window_end", "time", "End of the averages";
            estimate "kinetic", "1", "Momentum that particles carry";
            estimate "collisional", "1", "Momentum that collisions carry over the distance of their partners";
            with_theory "total", "1", "Both; theory is Enskog's pressure of the uniform gas, and in a dilute shear flow the kinetic model of Brey, Ruiz-Montero & Moreno, right to 3 %";
            note "replicas", "1", "Replicas";
        };
        let options: StressOptions = measure::chosen(plan, self.name());
        let span = (options.start(plan), plan.case.run.until);
        for (engine, records) in runs.each::<Record>(plan) {
            let records: Vec<&StressRecorder> =
                records.into_iter().filter_map(Option::as_ref).collect();
            let temperature = plan.steady_temperature().unwrap_or(1.0) * plan.gas.temperature;
            let theory = pressure_theory(plan, engine, temperature);
            for quantity in quantities(plan.gas.dimension) {
                let [kinetic, collisional, total] =
                    estimates(&records, &quantity, plan.gas.dimension);
                let at_rest = match quantity.name {
                    "pressure" | "xx" | "yy" | "zz" => theory,
                    _ => theory.map(|_| 0.0),
                };
                let sheared = dilute_flow(plan, engine);
                let sheared = sheared.map(|(flow, rate)| flow_theory(&flow, rate, quantity.name));
                let theory = sheared.or(at_rest);
                table.add((
                    engine.name,
                    quantity.name,
                    span.0,
                    span.1,
                    [kinetic, collisional],
                    total.against(theory),
                    records.len(),
                ));
            }
        }
        let flow = plan
            .gas
            .particles
            .shear_rate
            .map(|rate| sheared_state(plan, runs, rate));
        iter::once(table).chain(flow).collect()
    }
}
