//! The structure factor of the density, S(k), of disks in a periodic box.

use nalgebra::Vector2;
use schemars::Schema;
use serde::Deserialize;
use stosszahl_analysis::structure_factor::{
    Assignment, Options as GridOptions, StructureFactor, StructureFactorPlan,
};
use stosszahl_case::Kind;
use stosszahl_model::Particles;
use stosszahl_results::{Axis, Figure, Line, Table};

use super::over;
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, keeps_record};
use crate::plan::{EnginePlan, Plan};

/// The structure factor.
pub struct StructureFactors;

/// How a particle is shared among the points of the grid.
#[derive(Clone, Copy, Debug, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// All of it to the nearest point.
    NearestGridPoint,
    /// Linearly among the four points around it.
    CloudInCell,
}

/// What is measured, and how.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Times. Default: the start and the end of the run.
    pub times: Option<Vec<f64>>,
    /// How a particle is shared among the points of the grid.
    pub assignment: Sharing,
    /// Divide out the shape of the assignment.
    pub correction: bool,
    /// Largest k = L/wavelength.
    pub largest_wave_number: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            times: None,
            assignment: Sharing::CloudInCell,
            correction: true,
            largest_wave_number: 64,
        }
    }
}

/// Times at which structure is measured: those asked for, or the start and the end of the run.
pub(super) fn structure_times(plan: &Plan, times: Option<Vec<f64>>) -> Vec<f64> {
    times.unwrap_or_else(|| vec![0.0, plan.case.run.until])
}

/// Whether the box is periodic and has positions.
pub(super) fn require_periodic(plan: &Plan) -> Result<(), BadOption> {
    let periodic = plan.kind == Kind::Comparison
        || plan.kind == Kind::Flow
            && plan.case.walls.is_periodic()
            && plan.case.obstacle.is_empty();
    measure::require(periodic, "", "a periodic box without walls and obstacles")
}

impl StructureFactors {
    fn options(&self, plan: &Plan) -> Options {
        measure::options(plan, self.name()).unwrap_or_default()
    }

    fn grid(options: &Options, plan: &Plan) -> Result<StructureFactorPlan, BadOption> {
        let grid = GridOptions {
            largest_wave_number: options.largest_wave_number as usize,
            assignment: match options.assignment {
                Sharing::NearestGridPoint => Assignment::NearestGridPoint,
                Sharing::CloudInCell => Assignment::CloudInCell,
            },
            correction: options.correction,
            diameter: mean_diameter(plan),
        };
        let [x, y, _] = plan.lengths;
        StructureFactorPlan::new([x, y], grid).map_err(|error| BadOption {
            key: "largest_wave_number".into(),
            allowed: error.to_string(),
        })
    }
}

/// Mean diameter of the particles: exactly one where lengths are in units of it.
pub(super) fn mean_diameter(plan: &Plan) -> f64 {
    if plan.kind == Kind::Comparison {
        return 1.0;
    }
    let sum: f64 = (plan.species.iter())
        .map(|one| one.count as f64 * 2.0 * one.radius)
        .sum();
    sum / plan.count() as f64
}

/// Positions in the plane.
fn positions(particles: &Particles) -> Vec<Vector2<f64>> {
    particles.all.iter().map(|one| one.position.xy()).collect()
}

/// S(k) by time; none at a time without particles.
type Record = Vec<(f64, Option<StructureFactor>)>;

struct StructureProbe {
    grid: Option<StructureFactorPlan>,
    record: Record,
}

impl Probe for StructureProbe {
    fn sample(&mut self, moment: &mut Moment<'_>) {
        let weight = moment.simulation.weight();
        let positions = positions(moment.particles());
        let measured = self.grid.as_mut();
        let found = measured.and_then(|grid| grid.measure(&positions, weight).ok());
        self.record.push((moment.time, found));
    }

    keeps_record!();
}

impl Measure for StructureFactors {
    fn name(&self) -> &'static str {
        "structure_factor"
    }

    fn about(&self) -> &'static str {
        "Structure factor S(k) of the density, averaged over shells of wave numbers."
    }

    fn schema(&self) -> Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Comparison
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        require_periodic(plan)?;
        measure::require(plan.dimension == 2, "", "disks: gas.dimension = 2")?;
        let options: Options = measure::options(plan, self.name())?;
        let largest = options.largest_wave_number;
        let allowed = format!("a whole number from 1 to 2048; found {largest}");
        measure::require(
            (1..=2048).contains(&largest),
            "largest_wave_number",
            allowed,
        )?;
        measure::require_times(plan, "times", options.times.as_deref().unwrap_or_default())?;
        Self::grid(&options, plan).map(|_| ())
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        structure_times(plan, self.options(plan).times)
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(StructureProbe {
            grid: Self::grid(&self.options(plan), plan).ok(),
            record: Vec::new(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut figure = Figure::curves(
            "Structure factor",
            Axis::logarithmic("k", "k = L/wavelength"),
            Axis::logarithmic("structure_factor", "S(k)"),
        );
        figure.panels.push("time".into());
        figure.lines.push(Line {
            label: "ideal gas".into(),
            y: 1.0,
        });
        let mut table = Table::new(
            "structure_factor",
            "Structure factor by shells of wave numbers.",
        )
        .key("engine", "", "Engine")
        .key("time", "time", "Time since the start")
        .key("k", "1", "Wave number k = L/wavelength, mean of the shell")
        .estimate(
            "structure_factor",
            "1",
            "Structure factor S(k); one for an ideal gas",
        )
        .note("modes", "1", "Wave vectors in the shell")
        .figure(figure);
        for (engine, known) in plan.engines.iter().enumerate() {
            let records = runs.records::<Record>(engine);
            let Some(first) = records.first() else {
                continue;
            };
            for (index, (time, found)) in first.iter().enumerate() {
                let shells = found.iter().flat_map(|found| &found.shells);
                for (number, shell) in shells.enumerate() {
                    let values = records.iter().map(|record| {
                        let found = record[index].1.as_ref()?;
                        found.shells.get(number).map(|shell| shell.value)
                    });
                    table
                        .row()
                        .text(known.name)
                        .number(*time)
                        .number(shell.wave_number)
                        .estimate(over(values))
                        .count(shell.modes as u64);
                }
            }
        }
        vec![table]
    }
}
