//! Measure `boundaries`: particles, momentum (force) and energy (power) that each wall, opening,
//! inflow and obstacle gives to the gas.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::time_average::TimeErrors;
use stosszahl_case::format::{InflowSpec, ObstacleSpec};
use stosszahl_dsmc::BALANCE;
use stosszahl_model::simulation::BoundaryFlux;
use stosszahl_results::{Table, TableEstimate, VerdictText, table};

use super::gas_series::{GasSample, GasSampling, GasSeries};
use super::time_blocks::{self, TimeBlocks};
use super::{PARTS, fewest_parts, mean_over_replicas};
use crate::judge::{self, DifferenceUnit, VerdictRule, interval_of, kind_of, title, with_interval};
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, SampleContext, SampleProbe, described,
};
use crate::plan::{CasePlan, EnginePlan, SpeciesPlan};

/// Measure `boundaries` of particles, momentum and energy that walls, obstacles and inflows give.
pub struct BoundaryMeasure;

/// Options of `[measure.boundaries]`: number of time blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct BoundaryOptions {
    /// Time blocks at whose ends the fluxes of boundaries are recorded. Default: those of
    /// `[measure.fields]`.
    blocks: Option<u64>,
}

/// Boundary fluxes of one replica, for the measure `boundaries`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Record {
    series: GasSeries,
    /// Fluxes of all boundaries since the start, at the end of each time block.
    given: Vec<Vec<BoundaryFlux>>,
}

impl Record {
    /// Returns the flux of one boundary from the start to the end of a block.
    fn flux_until(&self, block: Option<usize>, name: &str) -> BoundaryFlux {
        let given = block.and_then(|block| self.given.get(block));
        let found = given.and_then(|all| all.iter().find(|one| one.name == name));
        found.cloned().unwrap_or_default()
    }
}

fn blocks(plan: &CasePlan) -> usize {
    let options: BoundaryOptions = measure::chosen(plan, BoundaryMeasure.name());
    time_blocks::blocks(plan, options.blocks)
}

impl Measure for BoundaryMeasure {
    described!(
        "boundaries",
        "Particles, force and power that walls, openings, inflows and obstacles give to the gas.",
        BoundaryOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        let case = &plan.case;
        let inside = !case.obstacle.is_empty() || !case.walls.is_periodic();
        case.domain.is_some() && inside
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        self.read_options(plan)?;
        time_blocks::check_blocks(plan, blocks(plan))
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        time_blocks::times(plan).split_off(1)
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let (sampling, per_block) = (
            GasSampling::from_plan(plan),
            time_blocks::per_block(plan, blocks(plan)),
        );
        let look = move |record: &mut Record, moment: &mut SampleContext<'_>| {
            let number = record.series.len();
            record.series.push(GasSample::sample_gas(&sampling, moment));
            if number > 0 && number.is_multiple_of(per_block) {
                record.given.push(moment.simulation.boundary_fluxes());
            }
        };
        Box::new(SampleProbe::from_start(Record::default(), look))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "boundaries", "What a boundary gives to the gas, per time, in the last window";
            key "engine", "", "Engine";
            key "boundary", "", "Name of the face, obstacle or inflow";
            key "window_start", "time", "Start of the window";
            key "window_end", "time", "End of the window";
            estimate "particles_per_time", "1/time", "Contacts per time, or particles per time that came in (out: below zero)";
            estimate "force_x", "energy/length", "Force on the gas along the first axis";
            estimate "force_y", "energy/length", "Force on the gas along the second axis";
            estimate "power", "energy/time", "Power given to the gas";
            note "parts", "1", PARTS;
        };
        for one in One::all_engines(plan, runs) {
            for name in one.names() {
                let [along, across] = [0, 1].map(|axis| one.force(name, axis));
                let contacts = one.rate(name, |given| given.particles);
                let power = one.rate(name, |given| given.energy);
                let found = [contacts, along, across, power.times(plan.scale.energy)];
                let parts = fewest_parts(&found);
                table.add(((one.engine.name, name, one.window.times), found, parts));
            }
        }
        vec![table]
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        plan.engines.len()
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let all = One::all_engines(plan, runs).into_iter();
        all.flat_map(|one| {
            one.drag()
                .into_iter()
                .chain(one.weight_balance(&runs.rule(plan)))
        })
        .collect()
    }
}

/// Boundary fluxes of one engine in one time window, in the units of the case.
struct One<'a> {
    plan: &'a CasePlan,
    engine: &'a EnginePlan,
    records: Vec<&'a Record>,
    window: TimeBlocks,
}

impl<'a> One<'a> {
    /// Creates the boundary fluxes of all engines, in one common time window.
    fn all_engines(plan: &'a CasePlan, runs: &ReplicaRecords<'a>) -> Vec<Self> {
        let steady = time_blocks::steady::<Record>(plan, runs, |record| &record.series);
        let window = TimeBlocks::last(plan, blocks(plan), &steady);
        let one = |(engine, records)| Self {
            plan,
            engine,
            records,
            window: window.clone(),
        };
        runs.each(plan).map(one).collect()
    }

    /// Estimates the mean rate at which a boundary gives a quantity to the gas, per unit of time of
    /// the case.
    fn rate(&self, name: &str, quantity: impl Fn(&BoundaryFlux) -> f64) -> TableEstimate {
        let TimeBlocks { blocks, times, .. } = &self.window;
        let block = (times[1] - times[0]) / blocks.len() as f64;
        let part = |replica: usize, part: Range<usize>| {
            let [first, end] = [part.start, part.end].map(|block| blocks.start + block);
            let record = self.records[replica];
            let before = record.flux_until(first.checked_sub(1), name);
            let after = record.flux_until(Some(end - 1), name);
            (quantity(&after) - quantity(&before)) / (block * part.len() as f64)
        };
        let replicas = self.records.len();
        let all = (0..replicas).map(|replica| part(replica, 0..blocks.len()));
        let mean = all.sum::<f64>() / replicas as f64;
        let errors = TimeErrors::new([replicas, blocks.len()], &[[mean]], |_, replica, blocks| {
            Some([part(replica, blocks)])
        });
        let error = errors.standard_errors[0][0];
        TableEstimate {
            replicas: Some(errors.parts[0]),
            ..TableEstimate::with_error(mean, Some(error).filter(|error| error.is_finite()))
        }
    }

    /// Estimates a component of the mean force that a boundary exerts on the gas, in the units of
    /// the case.
    fn force(&self, name: &str, axis: usize) -> TableEstimate {
        let scale = self.plan.scale;
        let unit = scale.energy / scale.length / self.plan.clock.time;
        self.rate(name, |given| given.momentum[axis]).times(unit)
    }

    /// Returns the names of all boundaries that gave something to the gas, in the order of first
    /// occurrence.
    fn names(&self) -> Vec<&'a str> {
        let mut names = Vec::new();
        for given in self
            .records
            .iter()
            .filter_map(|record| record.given.last())
            .flatten()
        {
            if !names.contains(&&*given.name) {
                names.push(&*given.name);
            }
        }
        names
    }

    /// Computes the drag of each obstacle in a stream from the left, with its coefficient F/(rho
    /// u^2 h/2), where h is the height of the obstacle across the stream, and returns notes.
    fn drag(&self) -> Vec<VerdictText> {
        let (case, known) = (&self.plan.case, self.names());
        let inflow = case.inflow.iter().find(|one| one.face == "left");
        let one = |(index, obstacle): (usize, &ObstacleSpec)| {
            let (inflow, name) = (inflow?, format!("obstacle {}", index + 1));
            let speed = inflow.velocity.first().copied().unwrap_or(0.0);
            let density = mass_density(self.plan, inflow);
            let scale = 0.5 * density * speed * speed * obstacle_height(obstacle);
            let [drag, lift] = [0, 1].map(|axis| self.force(&name, axis).times(-1.0));
            let sentence = format!(
                "The stream drags it with the force {}; the coefficient of drag is {}, that of lift {} (± half an interval of 95 %).",
                with_interval(&drag, 1.0),
                with_interval(&drag, scale),
                with_interval(&lift, scale)
            );
            let topic = format!("drag of {name}, {}", title(self.engine.name));
            known
                .contains(&&*name)
                .then(|| judge::verdict_note(topic, sentence))
        };
        case.obstacle.iter().enumerate().filter_map(one).collect()
    }

    /// Decides the verdict on the energy and particles that splitting and merging of weighted
    /// simulators added over the whole run.
    fn weight_balance(&self, rule: &VerdictRule) -> Option<VerdictText> {
        let last = self.records.iter().filter_map(|record| record.given.last());
        let given: Vec<_> = last
            .filter_map(|all| all.iter().find(|one| one.name == BALANCE))
            .collect();
        let sum = |of: fn(&BoundaryFlux) -> f64| {
            mean_over_replicas(given.iter().map(|one| Some(of(one))))
        };
        let particles = sum(|one| one.particles);
        let energy = sum(|one| one.energy).times(self.plan.scale.energy);
        // Shares of what the gas had at the start; two numbers share the level.
        let count = self.plan.count() as f64;
        let thermal = 0.5 * self.plan.gas.dimension as f64 * self.plan.gas.temperature;
        let whole = count * thermal * self.plan.scale.energy;
        let half = rule.at_level(0.5 * rule.level);
        let share = |found: &TableEstimate, whole: f64| {
            let interval = interval_of(&found.times(1.0 / whole), half.level);
            (
                DifferenceUnit::Relative.interval(&interval),
                kind_of(interval.decide(&half)),
            )
        };
        particles.value.zip(energy.value)?;
        let [(added, first), (heat, second)] = [share(&particles, count), share(&energy, whole)];
        let kind = judge::together([first, second]);
        let sentence = format!(
            "Over the whole run it added {added} of the particles and {heat} of the energy of the start; the margin is {} and on \
             average it adds nothing.",
            judge::format_margin(rule.margin)
        );
        let topic = format!("splitting and merging, {}", title(self.engine.name));
        Some(judge::verdict(topic, sentence, kind))
    }
}

/// Computes the height of an obstacle across a stream from the left, in the unit of length of the
/// case.
fn obstacle_height(obstacle: &ObstacleSpec) -> f64 {
    if let Some(disk) = obstacle.circle {
        return 2.0 * disk.radius;
    }
    let points = obstacle.polyline.iter().chain(&obstacle.polygon).flatten();
    let heights = points.map(|point| point[1]);
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    heights.fold(f64::NEG_INFINITY, f64::max) - low
}

/// Computes the mass density of an inflow, in the units of the case.
fn mass_density(plan: &CasePlan, inflow: &InflowSpec) -> f64 {
    let (scale, given) = (plan.scale, inflow.number_density.as_ref());
    let volume = plan.gas.volume * scale.length.powi(plan.gas.dimension as i32);
    let one = |(species, kind): (usize, &SpeciesPlan)| {
        let given = given.and_then(|densities| densities.get(species).copied());
        kind.mass * scale.mass * given.unwrap_or(kind.count as f64 / volume)
    };
    plan.gas.species.iter().enumerate().map(one).sum()
}
