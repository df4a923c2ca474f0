//! `boundaries`: particles, force and power that each wall, opening, inflow and obstacle gives to the gas.

use std::any::Any;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stosszahl_case::format::{Inflow, Obstacle};
use stosszahl_dsmc::BALANCE;
use stosszahl_model::simulation::BoundaryFlux;
use stosszahl_results::{Table, Verdict, VerdictKind, engine_title as title};

use super::course::{self, Course, Looking, Sample, Window, in_units, over};
use super::words::{self, with_error};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs};
use crate::plan::{EnginePlan, Plan};

/// What comes from outside.
pub struct Boundaries;

/// Options of `[measure.boundaries]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Options {
    /// Blocks of time at whose ends it is summed up. Default: those of `[measure.fields]`.
    blocks: Option<u64>,
}

/// What a run leaves.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Record {
    course: Course,
    /// What boundaries gave until the end of each block.
    given: Vec<Vec<BoundaryFlux>>,
}

impl Record {
    /// What one boundary gave until the end of a block.
    fn until(&self, block: Option<usize>, name: &str) -> BoundaryFlux {
        let given = block.and_then(|block| self.given.get(block));
        let found = given.and_then(|all| all.iter().find(|one| one.name == name));
        found.cloned().unwrap_or_default()
    }
}

fn blocks(plan: &Plan) -> usize {
    let options = measure::options::<Options>(plan, Boundaries.name());
    course::blocks(plan, options.unwrap_or_default().blocks)
}

impl Measure for Boundaries {
    fn name(&self) -> &'static str {
        "boundaries"
    }

    fn about(&self) -> &'static str {
        "Particles, force and power that walls, openings, inflows and obstacles give to the gas."
    }

    fn schema(&self) -> schemars::Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        let case = &plan.case;
        let inside = !case.obstacle.is_empty() || !case.walls.is_periodic();
        case.domain.is_some() && inside
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        measure::options::<Options>(plan, self.name())?;
        course::check(plan, blocks(plan))
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        course::times(plan).split_off(1)
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(Watch {
            looking: Looking::of(plan),
            per_block: course::per_block(plan, blocks(plan)),
            record: Record::default(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut table = empty();
        let window = window(plan, runs);
        for (index, engine) in plan.engines.iter().enumerate() {
            fill(&mut table, plan, engine, &runs.records(index), &window);
        }
        vec![table]
    }

    fn verdicts(&self, plan: &Plan, runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        let window = window(plan, runs);
        let mut list = Vec::new();
        for (index, engine) in plan.engines.iter().enumerate() {
            let records = runs.records::<Record>(index);
            list.extend(drag(plan, engine, &records, &window));
            list.extend(balance(plan, engine, &records));
        }
        list
    }
}

struct Watch {
    looking: Looking,
    per_block: usize,
    record: Record,
}

impl Probe for Watch {
    fn begin(&mut self, moment: &mut Moment<'_>) {
        let sample = Sample::take(&self.looking, moment, |_, _| {});
        self.record.course.push(sample);
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        let number = self.record.course.len();
        self.begin(moment);
        if number.is_multiple_of(self.per_block) {
            self.record.given.push(moment.simulation.boundaries());
        }
    }

    fn save(&self) -> Result<Vec<u8>, postcard::Error> {
        measure::save(&self.record)
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), postcard::Error> {
        measure::load(&mut self.record, bytes)
    }

    fn record(&self) -> &dyn Any {
        &self.record
    }
}

/// The window of all engines.
fn window(plan: &Plan, runs: &Runs<'_>) -> Window {
    let steady: Vec<_> = (0..plan.engines.len())
        .map(|engine| {
            let records = runs.records::<Record>(engine);
            let courses: Vec<&Course> = records.iter().map(|record| &record.course).collect();
            course::steady_from(plan, &courses)
        })
        .collect();
    Window::last(plan, blocks(plan), &steady)
}

fn empty() -> Table {
    Table::new(
        "boundaries",
        "What a boundary gives to the gas, per time, in the last window",
    )
    .key("engine", "", "Engine")
    .key("boundary", "", "Name of the face, obstacle or inflow")
    .key("window_start", "time", "Start of the window")
    .key("window_end", "time", "End of the window")
    .estimate(
        "grains_per_time",
        "1/time",
        "Contacts per time, or particles per time that came in (out: below zero)",
    )
    .estimate(
        "force_x",
        "energy/length",
        "Force on the gas along the first axis",
    )
    .estimate(
        "force_y",
        "energy/length",
        "Force on the gas along the second axis",
    )
    .estimate("power", "energy/time", "Power given to the gas")
}

/// What a boundary gives per time, in the units of the case.
struct Rates<'a> {
    plan: &'a Plan,
    records: &'a [&'a Record],
    window: &'a Window,
}

impl Rates<'_> {
    /// Mean and error of a quantity per time of the case.
    fn of(&self, name: &str, quantity: impl Fn(&BoundaryFlux) -> f64) -> (f64, Option<f64>) {
        let [start, end] = self.window.times;
        over(self.records.iter().map(|record| {
            let before = record.until(self.window.blocks.start.checked_sub(1), name);
            let after = record.until(Some(self.window.blocks.end - 1), name);
            (quantity(&after) - quantity(&before)) / (end - start)
        }))
    }

    /// A component of the force.
    fn force(&self, name: &str, axis: usize) -> (f64, Option<f64>) {
        let scale = self.plan.scale;
        let unit = scale.energy / scale.length / self.plan.time;
        let (value, error) = self.of(name, |given| given.momentum[axis]);
        (value * unit, error.map(|error| error * unit))
    }
}

/// Names of all boundaries, in the order in which they first gave something.
fn names(records: &[&Record]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for given in records
        .iter()
        .filter_map(|record| record.given.last())
        .flatten()
    {
        if !names.contains(&given.name) {
            names.push(given.name.clone());
        }
    }
    names
}

fn fill(table: &mut Table, plan: &Plan, engine: &EnginePlan, records: &[&Record], window: &Window) {
    let rates = Rates {
        plan,
        records,
        window,
    };
    for name in names(records) {
        let row = table.row().text(engine.name).text(name.as_str());
        row.number(window.times[0])
            .number(window.times[1])
            .estimate(in_units(rates.of(&name, |given| given.particles), 1.0))
            .estimate(in_units(rates.force(&name, 0), 1.0))
            .estimate(in_units(rates.force(&name, 1), 1.0))
            .estimate(in_units(
                rates.of(&name, |given| given.energy),
                plan.scale.energy,
            ));
    }
}

/// The height that an obstacle has across a stream from the left.
fn height(obstacle: &Obstacle) -> f64 {
    if let Some(disc) = obstacle.disc {
        return 2.0 * disc.radius;
    }
    let points = obstacle.polyline.iter().chain(&obstacle.polygon).flatten();
    let heights = points.map(|point| point[1]);
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    heights.fold(f64::NEG_INFINITY, f64::max) - low
}

/// Mass per volume of an inflow, in the units of the case.
fn mass_density(plan: &Plan, inflow: &Inflow) -> f64 {
    let (scale, given) = (plan.scale, inflow.number_density.as_ref());
    let volume = plan.volume * scale.length.powi(plan.dimension as i32);
    let kinds = plan.species.iter().enumerate();
    kinds
        .map(|(species, kind)| {
            let uniform = kind.count as f64 / volume;
            let density = given.and_then(|densities| densities.get(species).copied());
            kind.mass * scale.mass * density.unwrap_or(uniform)
        })
        .sum()
}

/// The drag of each obstacle in a stream from the left, and its coefficient F/(rho u^2 h/2) with the height h that it has
/// across the stream.
fn drag(plan: &Plan, engine: &EnginePlan, records: &[&Record], window: &Window) -> Vec<Verdict> {
    let Some(inflow) = plan.case.inflow.iter().find(|one| one.face == "left") else {
        return Vec::new();
    };
    let speed = inflow.velocity.first().copied().unwrap_or(0.0);
    let rates = Rates {
        plan,
        records,
        window,
    };
    let known = names(records);
    let one = |(index, obstacle): (usize, &Obstacle)| {
        let name = format!("obstacle {}", index + 1);
        let [(x, x_error), (y, y_error)] = [0, 1].map(|axis| rates.force(&name, axis));
        if !known.contains(&name) {
            return None;
        }
        let scale = 0.5 * mass_density(plan, inflow) * speed * speed * height(obstacle);
        let share = |force: f64, error: Option<f64>| {
            with_error(-force / scale, error.map(|error| error / scale))
        };
        Some(Verdict {
            topic: format!("drag of {name}, {}", title(engine.name)),
            sentence: format!(
                "The stream drags it with the force {}; the coefficient of drag is {}, that of lift {}.",
                with_error(-x, x_error),
                share(x, x_error),
                share(y, y_error)
            ),
            kind: VerdictKind::Note,
        })
    };
    let obstacles = plan.case.obstacle.iter().enumerate();
    obstacles.filter_map(one).collect()
}

/// What splitting and merging of simulators added over the whole run.
fn balance(plan: &Plan, engine: &EnginePlan, records: &[&Record]) -> Option<Verdict> {
    let given: Vec<BoundaryFlux> = (records.iter())
        .filter_map(|record| record.given.last()?.iter().find(|one| one.name == BALANCE))
        .cloned()
        .collect();
    if given.is_empty() {
        return None;
    }
    let particles = over(given.iter().map(|one| one.particles));
    let unit = plan.scale.energy;
    let energy = over(given.iter().map(|one| one.energy * unit));
    let fair = |(value, error): (f64, Option<f64>)| match error {
        None => VerdictKind::Note,
        Some(error) if value.abs() <= words::ERRORS * error => VerdictKind::Agree,
        Some(_) => VerdictKind::Differ,
    };
    Some(Verdict {
        topic: format!("splitting and merging, {}", title(engine.name)),
        sentence: format!(
            "Over the whole run it added {} particles and the energy {}; on average it adds nothing (margin {} standard errors).",
            with_error(particles.0, particles.1),
            with_error(energy.0, energy.1),
            words::ERRORS
        ),
        kind: words::worst([fair(particles), fair(energy)]),
    })
}
