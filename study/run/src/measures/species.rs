//! A gas without positions species by species, or by groups of like size.

use std::any::Any;

use schemars::{JsonSchema, Schema, schema_for};
use serde::Deserialize;
use stosszahl_case::Kind;
use stosszahl_dsmc::homogeneous::Moments;
use stosszahl_results::{Axis, Estimate, Figure, Table};

use super::gas::{self, Record, Sample, against, measured};
use crate::measure::{self, BadOption, Measure, Moment, Probe, Runs};
use crate::plan::{EnginePlan, Plan};
use crate::theory::homogeneous::{self, Curve, GroupCurve, Predicted};

/// Temperature, displacement, fourth cumulant and velocity correlation of each species of a gas without positions.
pub struct Species;

const NAME: &str = "species";

/// The correlation of the velocities with those of the start, in the table of the species.
pub struct VelocityCorrelation;

const CORRELATION: &str = "velocity_correlation";

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Options {}

impl Measure for Species {
    fn name(&self) -> &'static str {
        NAME
    }

    fn about(&self) -> &'static str {
        "Temperature, displacement, fourth cumulant and velocity correlation of each species of a gas without positions."
    }

    fn schema(&self) -> Schema {
        schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Homogeneous && plan.case.sticking.is_none()
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        gas::homogeneous_only(plan)?;
        lasting_only(plan)?;
        measure::options::<Options>(plan, NAME).map(drop)
    }

    fn times(&self, _plan: &Plan) -> Vec<f64> {
        Vec::new()
    }

    fn probe(&self, _plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(NoProbe)
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        vec![table(plan, &rows(plan, &runs.find(0)))]
    }
}

impl Measure for VelocityCorrelation {
    fn name(&self) -> &'static str {
        CORRELATION
    }

    fn about(&self) -> &'static str {
        "Correlation of the velocities with those of the start, as columns of the table of the species."
    }

    fn schema(&self) -> Schema {
        schema_for!(Options)
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        gas::homogeneous_only(plan)?;
        lasting_only(plan)?;
        measure::options::<Options>(plan, CORRELATION).map(drop)
    }

    fn times(&self, _plan: &Plan) -> Vec<f64> {
        Vec::new()
    }

    fn probe(&self, _plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(NoProbe)
    }

    fn tables(&self, _plan: &Plan, _runs: &Runs<'_>) -> Vec<Table> {
        Vec::new()
    }
}

/// Whether the correlation of the velocities with those of the start is measured.
pub(super) fn has_correlation(plan: &Plan) -> bool {
    plan.case.measure.contains_key(CORRELATION) && plan.case.sticking.is_none()
}

/// Refuses a measurement of particles that last, where they stick.
pub(super) fn lasting_only(plan: &Plan) -> Result<(), BadOption> {
    let allowed = "not with [sticking], as clusters do not last";
    measure::require(plan.case.sticking.is_none(), "", allowed)
}

/// Measures nothing: the tables come from the records of other measures.
pub(super) struct NoProbe;

impl Probe for NoProbe {
    fn sample(&mut self, _moment: &mut Moment<'_>) {}

    fn save(&self) -> Result<Vec<u8>, postcard::Error> {
        Ok(Vec::new())
    }

    fn load(&mut self, _bytes: &[u8]) -> Result<(), postcard::Error> {
        Ok(())
    }

    fn record(&self) -> &dyn Any {
        self
    }
}

/// One species at one time, over all replicas.
pub(super) struct Row {
    pub time: f64,
    /// Number of the species, from 0.
    pub species: usize,
    pub temperature: Estimate,
    pub fourth_cumulant: Estimate,
    pub displacement: Estimate,
    pub correlation: Estimate,
}

/// All species at all sample times.
pub(super) fn rows(plan: &Plan, records: &[&Record]) -> Vec<Row> {
    let curves = homogeneous::curves(plan).ok();
    let mut rows = Vec::new();
    for (index, time) in plan.sample_times().into_iter().enumerate() {
        let curve = curves.and_then(|curves| curves.at.get(index));
        let pairs = gas::pairs(records, index);
        rows.extend((0..plan.species.len()).map(|species| row(plan, species, time, &pairs, curve)));
    }
    rows
}

fn row(
    plan: &Plan,
    species: usize,
    time: f64,
    pairs: &gas::Pairs<'_>,
    curve: Option<&Curve>,
) -> Row {
    let none = Moments::default();
    let of = |sample: &Sample| *sample.groups.get(species).unwrap_or(&none);
    let one = pairs.first().map_or(none, |pair| of(pair.0));
    let curve = curve.and_then(|curve| curve.groups.get(species));
    let theory = |value: fn(&GroupCurve) -> Predicted| curve.map(value);
    let temperature = measured(
        pairs,
        |pair| of(pair.0).temperature,
        Some(gas::temperature_error(plan, &one) * one.temperature).filter(|_| one.count > 0),
    );
    let cumulant = measured(pairs, |pair| of(pair.0).fourth_cumulant, None);
    let displacement = gas::has_displacement(plan).then(|| {
        let single = Some(gas::displacement_error(plan, &one)).filter(|_| one.count > 1);
        measured(pairs, |pair| of(pair.0).displacement, single)
    });
    let correlation = has_correlation(plan).then(|| {
        let kept = |pair: &(&Sample, &Sample)| {
            of(pair.0).velocity_correlation / of(pair.1).velocity_correlation
        };
        measured(pairs, kept, None)
    });
    let known = |found: Option<gas::Measured>, theory| {
        found.map_or_else(Estimate::default, |found| against(found, theory))
    };
    Row {
        time,
        species,
        temperature: against(temperature, theory(|group| group.temperature)),
        // In the first order it is zero by assumption, which is no prediction.
        fourth_cumulant: against(
            cumulant,
            theory(|group| group.fourth_cumulant).filter(|theory| theory.error.is_some()),
        ),
        displacement: known(displacement, theory(|group| group.displacement)),
        correlation: known(correlation, theory(|group| group.correlation)),
    }
}

fn table(plan: &Plan, rows: &[Row]) -> Table {
    let about = "Each species, or the particles of like size, at the sample times";
    let mut table = Table::new(NAME, about)
        .key("time", "unit of time", "Time")
        .key("species", "1", "Number of the species, from 1")
        .note("mass", "mass", "Mass of a particle")
        .note("diameter", "length", "Diameter of a particle")
        .note("count", "1", "Particles in each replica")
        .with_theory_error("temperature", "energy", "Temperature T = m <v^2>/D")
        .with_theory_error(
            "fourth_cumulant",
            "1",
            "Fourth cumulant a2 of the velocities, zero for Maxwellian ones; theory is empty in the first order",
        )
        .with_theory_error(
            "displacement_square",
            "length^2",
            "Mean squared displacement",
        )
        .with_theory_error(
            "velocity_correlation",
            "1",
            "Correlation of the velocity with that of the start, <v(0) . v(t)>/<v(0)^2>",
        );
    for row in rows {
        let species = &plan.species[row.species];
        table
            .row()
            .number(row.time)
            .count(row.species as u64 + 1)
            .number(species.mass)
            .number(2.0 * species.radius)
            .count(species.count as u64)
            .estimate(row.temperature)
            .estimate(row.fourth_cumulant)
            .estimate(row.displacement)
            .estimate(row.correlation);
    }
    let several = plan.species.len() > 1;
    let figures = [
        (
            several,
            "Temperatures of the species",
            Axis::logarithmic("temperature", "T"),
            "Temperatures m<v²>/D. Energy is not shared alike in a gas that cools: light particles become the coldest, and in \
             the end all temperatures fall together.",
        ),
        (
            true,
            "Fourth cumulant",
            Axis::linear("fourth_cumulant", "a₂"),
            "Fourth cumulant of the velocities, D<v⁴>/((D + 2)<v²>²) − 1: zero for Maxwellian velocities.",
        ),
        (
            several && gas::has_displacement(plan),
            "Mean squared displacement",
            Axis::logarithmic("displacement_square", "<R²>"),
            "Mean squared displacement since the start: ballistic at first, then ever slower as the gas cools.",
        ),
        (
            has_correlation(plan),
            "Velocity correlation",
            Axis::linear("velocity_correlation", "<v(0)·v(t)>/<v(0)²>"),
            "Correlation of the velocities with those of the start.",
        ),
    ];
    for (shown, title, y, caption) in figures {
        if shown {
            table = table.figure(Figure {
                curves: vec!["species".into()],
                ..gas::against_time(title, y, caption)
            });
        }
    }
    table
}
