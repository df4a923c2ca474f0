//! The pair correlation function g(r) in a periodic box, of disks and of spheres.

use nalgebra::Vector2;
use schemars::Schema;
use serde::Deserialize;
use stosszahl_analysis::pair_correlation::{self, PairCorrelation};
use stosszahl_case::Kind;
use stosszahl_results::{Axis, Figure, Line, Table};

use super::over;
use super::structure_factor::{mean_diameter, require_periodic, structure_times};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs, keeps_record};
use crate::plan::{EnginePlan, Plan};

/// The pair correlation.
pub struct PairCorrelations;

/// Width of the bins, in diameters.
const BIN: f64 = 0.05;

/// What is measured.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Times. Default: the start and the end of the run.
    pub times: Option<Vec<f64>>,
    /// Largest distance, in mean diameters.
    pub range: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            times: None,
            range: 6.0,
        }
    }
}

/// g(r) by time; none at a time without two particles.
type Record = Vec<(f64, Option<PairCorrelation>)>;

struct PairProbe {
    range: f64,
    diameter: f64,
    record: Record,
}

impl Probe for PairProbe {
    fn sample(&mut self, moment: &mut Moment<'_>) {
        let particles = moment.particles();
        let d = self.diameter;
        let [x, y, z] = particles.lengths;
        let sides = &particles.lengths[..particles.dimension];
        let shortest = sides.iter().copied().fold(f64::INFINITY, f64::min);
        let range = (self.range * d).min(0.499_999 * shortest);
        let bins = ((range / (BIN * d)).round() as usize).max(1);
        let found = if particles.dimension == 2 {
            let positions: Vec<Vector2<f64>> =
                particles.all.iter().map(|one| one.position.xy()).collect();
            pair_correlation::measure(&positions, [x, y], d, range, bins)
        } else {
            let positions: Vec<_> = particles.all.iter().map(|one| one.position).collect();
            pair_correlation::measure(&positions, [x, y, z], d, range, bins)
        };
        self.record.push((moment.time, found.ok()));
    }

    keeps_record!();
}

impl PairCorrelations {
    fn options(&self, plan: &Plan) -> Options {
        measure::options(plan, self.name()).unwrap_or_default()
    }
}

impl Measure for PairCorrelations {
    fn name(&self) -> &'static str {
        "pair_correlation"
    }

    fn about(&self) -> &'static str {
        "Pair correlation g(r): neighbours at a distance, over those of an ideal gas."
    }

    fn schema(&self) -> Schema {
        schemars::schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Comparison
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        require_periodic(plan)?;
        let options: Options = measure::options(plan, self.name())?;
        let allowed = format!("a range above 1, in diameters; found {}", options.range);
        let good = options.range > 1.0 && options.range.is_finite();
        measure::require(good, "range", allowed)?;
        measure::require_times(plan, "times", options.times.as_deref().unwrap_or_default())
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        structure_times(plan, self.options(plan).times)
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(PairProbe {
            range: self.options(plan).range,
            diameter: mean_diameter(plan),
            record: Vec::new(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut figure = Figure::curves(
            "Pair correlation",
            Axis::linear("r_over_d", "r/d"),
            Axis::linear("g", "g(r)"),
        );
        figure.panels.push("time".into());
        figure.lines.push(Line {
            label: "ideal gas".into(),
            y: 1.0,
        });
        let mut table = Table::new("pair_correlation", "Pair correlation by distance.")
            .key("engine", "", "Engine")
            .key("time", "time", "Time since the start")
            .key(
                "r_over_d",
                "1",
                "Distance of the centres over the mean diameter",
            )
            .estimate("g", "1", "Pair correlation g(r); one for an ideal gas")
            .figure(figure);
        for (engine, known) in plan.engines.iter().enumerate() {
            let records = runs.records::<Record>(engine);
            let Some(first) = records.first() else {
                continue;
            };
            for (index, (time, found)) in first.iter().enumerate() {
                for (number, bin) in found.iter().flat_map(|found| &found.bins).enumerate() {
                    let values = records.iter().map(|record| {
                        let found = record[index].1.as_ref()?;
                        found.bins.get(number).map(|bin| bin.g)
                    });
                    table
                        .row()
                        .text(known.name)
                        .number(*time)
                        .number(bin.r_over_d)
                        .estimate(over(values));
                }
            }
        }
        vec![table]
    }
}
