//! Measure `collision_log`: a table of single collisions, up to a requested number.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Observer};
use stosszahl_results::{Table, TableCell, table};

use super::selection::{Replicas, check_engines, is_named};
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, SampleContext, described, keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `collision_log` that writes collisions one by one.
pub struct CollisionLog;

/// Largest number of logged collisions that may be requested for one engine and replica.
const MOST: u64 = 1_000_000;
/// Memory of a logged collision while tables and report are built \[bytes\].
const ROW: f64 = 600.0;

/// Options of `[measure.collision_log]`: which collisions are kept.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CollisionLogOptions {
    /// Time from which collisions are kept.
    pub from: f64,
    /// Largest number of collisions kept for each engine and replica: the first ones after `from`.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub most: u64,
    /// Engines whose collisions are kept, by name. Default: all.
    pub engines: Option<Vec<String>>,
    /// Replicas whose collisions are kept, by number from 0, or "all". Default: \[0\].
    pub replicas: Replicas,
}

impl Default for CollisionLogOptions {
    fn default() -> Self {
        Self {
            from: 0.0,
            most: 10_000,
            engines: None,
            replicas: Replicas::default(),
        }
    }
}

/// Logged collision: time, partners, positions and velocities, in engine units.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Row {
    time: f64,
    pair: [u32; 2],
    species: [u32; 2],
    impact: f64,
    relative: f64,
    normal: f64,
    restitution: f64,
    weight: f64,
}

impl Row {
    fn from_collision(one: &Collision) -> Self {
        Self {
            time: one.time,
            pair: one.pair,
            species: one.species,
            impact: one.impact_square().sqrt(),
            relative: one.relative_velocity.norm(),
            normal: one.normal_square().sqrt(),
            restitution: one.restitution,
            weight: one.weight,
        }
    }
}

/// Logged collisions of one engine and replica.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Record {
    /// Number of the replica; `None` before the start, and in replicas without a log.
    replica: Option<u64>,
    rows: Vec<Row>,
}

struct LogProbe {
    from: f64,
    most: usize,
    record: Record,
}

impl Observer for LogProbe {
    fn on_collisions(&mut self, batch: &[Collision]) {
        let room = self.most - self.record.rows.len();
        if room > 0 {
            let late = batch.iter().filter(|one| one.time >= self.from);
            self.record
                .rows
                .extend(late.take(room).map(Row::from_collision));
        }
    }
}

impl Probe for LogProbe {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        let goes_on = self.record.replica.is_some() && self.record.rows.len() < self.most;
        goes_on.then_some(self)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        self.record.replica = Some(moment.replica);
    }

    keeps_record!();
}

impl CollisionLog {
    fn options(&self, plan: &CasePlan) -> CollisionLogOptions {
        measure::chosen(plan, self.name())
    }
}

impl Measure for CollisionLog {
    described!(
        "collision_log",
        "Collisions one by one, the first ones from a time on.",
        CollisionLogOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let options: CollisionLogOptions = measure::options(plan, self.name())?;
        let allowed = format!("a number of collisions from 1 to {MOST}");
        measure::require((1..=MOST).contains(&options.most), "most", allowed)?;
        check_engines(plan, options.engines.as_deref())?;
        options.replicas.check_replicas(plan)
    }

    /// Returns the start of the log as a sample time, so that no time step of an engine lies across
    /// it.
    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let from = self.options(plan).from;
        (from > 0.0).then_some(from).into_iter().collect()
    }

    fn kept_bytes(&self, plan: &CasePlan) -> f64 {
        self.options(plan).most as f64 * size_of::<Row>() as f64
    }

    fn figure_bytes(&self, plan: &CasePlan) -> f64 {
        let CollisionLogOptions {
            most,
            engines,
            replicas,
            ..
        } = self.options(plan);
        let engines = (plan.engines.iter()).filter(|one| is_named(engines.as_deref(), one.name));
        let replicas = (0..plan.case.replicas).filter(|&one| replicas.has(one));
        most as f64 * (engines.count() * replicas.count()) as f64 * ROW
    }

    fn looks_at(&self, plan: &CasePlan, replica: u64) -> bool {
        self.options(plan).replicas.has(replica)
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        let options = self.options(plan);
        let is_asked = is_named(options.engines.as_deref(), engine.name);
        Box::new(LogProbe {
            from: plan.engine_time(options.from),
            most: if is_asked { options.most as usize } else { 0 },
            record: Record::default(),
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut table = table! {
            "collision_log", "Collisions one by one, in the order in which the engine made them.";
            key "engine", "", "Engine";
            key "replica", "1", "Number of the replica, from 0";
            key "time", "time", "When it happened";
            note "first", "1", "Index of a partner, from 0, as snapshots have it; empty where the engine does not distinguish equal particles";
            note "second", "1", "The same of the other";
            note "first_species", "1", "Species of the first, from 0";
            note "second_species", "1", "Species of the second";
            value "impact_parameter", "1", "b/d, from 0 (central) to 1 (grazing)";
            value "relative_speed", "speed", "Relative speed before";
            value "normal_speed", "speed", "Its part along the line of centres";
            value "restitution", "1", "Coefficient of restitution that acted";
            note "weight", "1", "Number of physical collisions that it stands for";
        };
        let speed = plan.scale.speed();
        for (engine, records) in runs.each::<Record>(plan) {
            for record in records {
                let replica = record.replica.unwrap_or_default();
                for row in &record.rows {
                    let [first, second] = row.pair.map(index);
                    table.rows.push(vec![
                        TableCell::Text(engine.name.to_owned()),
                        TableCell::Count(replica),
                        TableCell::Number(row.time / plan.clock.time),
                        first,
                        second,
                        TableCell::Count(row.species[0].into()),
                        TableCell::Count(row.species[1].into()),
                        TableCell::Number(row.impact),
                        TableCell::Number(row.relative * speed),
                        TableCell::Number(row.normal * speed),
                        TableCell::Number(row.restitution),
                        TableCell::Number(row.weight),
                    ]);
                }
            }
        }
        vec![table]
    }
}

/// Converts the index of a particle to a table cell; empty for a particle without an index.
fn index(index: u32) -> TableCell {
    match index {
        Collision::ANONYMOUS => TableCell::Empty,
        known => TableCell::Count(known.into()),
    }
}
