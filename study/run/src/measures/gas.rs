//! A gas without positions as a whole, and what its other tables are made of: moments of each group at the sample times.

use nalgebra::Vector3;
use schemars::{JsonSchema, Schema, schema_for};
use serde::{Deserialize, Serialize};
use stosszahl_analysis::statistics;
use stosszahl_case::Kind;
use stosszahl_dsmc::homogeneous::Moments;
use stosszahl_model::Simulation;
use stosszahl_results::{Axis, Estimate, Figure, Table};

use crate::measure::{self, BadOption, Measure, Moment, Needs, Probe, Runs, keeps_record};
use crate::plan::{EnginePlan, Plan};
use crate::theory::homogeneous::{self, Curve, Grouping, Predicted};

/// Particles, collisions, energy and displacement of a gas without positions.
pub struct Gas;

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Options {}

impl Measure for Gas {
    fn name(&self) -> &'static str {
        "gas"
    }

    fn about(&self) -> &'static str {
        "Particles, collisions, energy and mean squared displacement of a gas without positions."
    }

    fn schema(&self) -> Schema {
        schema_for!(Options)
    }

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Homogeneous
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        homogeneous_only(plan)?;
        measure::options::<Options>(plan, self.name()).map(drop)
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        plan.sample_times()
    }

    fn kept_per_particle(&self, plan: &Plan) -> f64 {
        if super::species::has_correlation(plan) {
            size_of::<[f64; 3]>() as f64
        } else {
            0.0
        }
    }

    fn needs(&self, plan: &Plan) -> Needs {
        Needs {
            displacements: has_displacement(plan),
            ..Needs::default()
        }
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(GasProbe {
            grouping: Grouping::of(plan),
            displacement: has_displacement(plan),
            correlation: super::species::has_correlation(plan),
            until: plan.case.run.until,
            record: Record::default(),
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let records: Vec<&Record> = runs.records(0);
        vec![table(&rows(plan, &records)), replicas(&records)]
    }
}

/// Refuses a measurement that only a gas without positions has.
pub(super) fn homogeneous_only(plan: &Plan) -> Result<(), BadOption> {
    let allowed = "only in a gas without positions, which is a case without [box]";
    measure::require(plan.kind == Kind::Homogeneous, "", allowed)
}

/// Whether displacements are measured: `[measure.displacement]`. Clusters have none, as they do not last.
pub fn has_displacement(plan: &Plan) -> bool {
    plan.case.measure.contains_key("displacement") && plan.case.sticking.is_none()
}

/// The gas at one sample time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// When, in the unit of time of the case.
    pub time: f64,
    /// Particles.
    pub particles: usize,
    /// Pair collisions since the start.
    pub collisions: u64,
    /// Kinetic energy, tracers included.
    pub energy: f64,
    /// Moments of each group.
    pub groups: Vec<Moments>,
}

/// The gas at all sample times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// By time.
    pub samples: Vec<Sample>,
    /// Velocities at the start, where their correlation is measured, until the last sample.
    start: Vec<[f64; 3]>,
}

struct GasProbe {
    grouping: Grouping,
    displacement: bool,
    correlation: bool,
    until: f64,
    record: Record,
}

impl Probe for GasProbe {
    fn begin(&mut self, moment: &mut Moment<'_>) {
        if self.displacement {
            moment.simulation.follow_displacements();
        }
        if self.correlation {
            let start = &mut self.record.start;
            let mut keep = |one: &stosszahl_model::Particle| start.push(one.velocity.into());
            moment.simulation.visit(&mut keep);
        }
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        let simulation = &*moment.simulation;
        let paths = self.displacement.then(|| simulation.displacements());
        let paths = paths.flatten().unwrap_or_default();
        let (energy, groups) = moments(simulation, self.grouping, &paths, &self.record.start);
        self.record.samples.push(Sample {
            time: moment.time,
            particles: simulation.count(),
            collisions: simulation.work().collisions,
            energy,
            groups,
        });
        if moment.time >= self.until {
            self.record.start = Vec::new();
        }
    }

    keeps_record!();
}

/// Kinetic energy and moments of every group, in one pass. Displacements and velocities of the start are empty where they
/// are not measured.
pub(super) fn moments(
    simulation: &dyn Simulation,
    grouping: Grouping,
    displacements: &[Vector3<f64>],
    start: &[[f64; 3]],
) -> (f64, Vec<Moments>) {
    // Sums at first, in the fields of their means.
    let mut groups: Vec<Moments> = Vec::new();
    let (mut twice, mut index) = (0.0, 0);
    simulation.visit(&mut |particle| {
        let number = grouping.group(particle.species);
        if number >= groups.len() {
            groups.resize(number + 1, Moments::default());
        }
        let own = &mut groups[number];
        let square = particle.mass * particle.velocity.norm_squared();
        twice += square;
        own.count += 1;
        own.temperature += square;
        own.fourth_cumulant += square * square;
        if let Some(path) = displacements.get(index) {
            let square = path.norm_squared();
            own.displacement += square;
            own.displacement_fourth += square * square;
        }
        if let Some(&before) = start.get(index) {
            own.velocity_correlation += Vector3::from(before).dot(&particle.velocity);
        }
        index += 1;
    });
    let d = simulation.dimension() as f64;
    for own in &mut groups {
        let n = own.count.max(1) as f64;
        let mean = own.temperature / n;
        own.fourth_cumulant = if mean > 0.0 {
            d * (own.fourth_cumulant / n) / ((d + 2.0) * mean * mean) - 1.0
        } else {
            0.0
        };
        own.temperature = mean / d;
        own.displacement /= n;
        own.displacement_fourth /= n;
        own.velocity_correlation /= n;
    }
    (0.5 * twice, groups)
}

/// A value with its standard error.
pub(super) type Measured = (f64, Option<f64>);

/// Mean over replicas, and the larger of the two errors that are known: the spread over replicas and, by `single`, that
/// over the particles of one.
pub(super) fn measured<T>(runs: &[T], value: impl Fn(&T) -> f64, single: Option<f64>) -> Measured {
    let values: Vec<f64> = runs.iter().map(value).filter(|x| x.is_finite()).collect();
    let spread = statistics::Estimate::over_replicas(&values);
    let within = single.map(|error| error / (runs.len() as f64).sqrt());
    let error = match (spread.and_then(|spread| spread.standard_error), within) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    (
        spread.map_or(f64::NAN, |spread| spread.value),
        error.filter(|error| error.is_finite()),
    )
}

/// An estimate with its theory, where there is one.
pub(super) fn against(found: Measured, theory: Option<Predicted>) -> Estimate {
    Estimate {
        value: Some(found.0),
        standard_error: found.1,
        theory: theory.map(|theory| theory.value),
        theory_error: theory.and_then(|theory| theory.error),
    }
}

/// Relative standard error of a temperature by the spread over particles: `sqrt(((D + 2)(1 + a2)/D - 1)/N)`, at least that
/// of Maxwellian velocities, `sqrt(2/(D N))`, as few particles do not know their own spread.
pub(super) fn temperature_error(plan: &Plan, moments: &Moments) -> f64 {
    let d = plan.dimension as f64;
    let spread = (d + 2.0) * (1.0 + moments.fourth_cumulant) / d - 1.0;
    (spread.max(2.0 / d) / moments.count.max(1) as f64).sqrt()
}

/// Standard error of a mean squared displacement by the spread over particles, at least that of normally distributed
/// displacements.
pub(super) fn displacement_error(plan: &Plan, moments: &Moments) -> f64 {
    let (d, mean) = (plan.dimension as f64, moments.displacement);
    let spread = moments.displacement_fourth - mean * mean;
    (spread.max(2.0 / d * mean * mean) / moments.count.max(1) as f64).sqrt()
}

/// Moments of all groups but tracers.
fn but_tracers<'a>(plan: &'a Plan, sample: &'a Sample) -> impl Iterator<Item = &'a Moments> {
    let groups = sample.groups.iter().enumerate();
    groups
        .filter(|(number, _)| plan.species.get(*number).is_none_or(|one| !one.tracer))
        .map(|(_, moments)| moments)
}

fn has_tracer(plan: &Plan) -> bool {
    plan.species.iter().any(|one| one.tracer)
}

/// Kinetic energy of all particles but tracers.
fn energy_of(plan: &Plan, sample: &Sample) -> f64 {
    if !has_tracer(plan) {
        return sample.energy;
    }
    let twice: f64 = but_tracers(plan, sample)
        .map(|moments| moments.count as f64 * moments.temperature)
        .sum();
    0.5 * plan.dimension as f64 * twice
}

/// A gas at one time, over all replicas.
pub(super) struct Row {
    pub time: f64,
    pub particles: Estimate,
    pub collisions: Estimate,
    pub energy: Estimate,
    pub displacement: Estimate,
    replicas: usize,
}

/// Each replica at one time, and at the start.
pub(super) type Pairs<'a> = Vec<(&'a Sample, &'a Sample)>;

/// The samples of all replicas at one time, with those of the start.
pub(super) fn pairs<'a>(records: &[&'a Record], index: usize) -> Pairs<'a> {
    let of = |record: &&'a Record| Some((record.samples.get(index)?, record.samples.first()?));
    records.iter().filter_map(of).collect()
}

/// The gas at all sample times.
pub(super) fn rows(plan: &Plan, records: &[&Record]) -> Vec<Row> {
    let curves = homogeneous::curves(plan).ok();
    let times = plan.sample_times().into_iter().enumerate();
    times
        .map(|(index, time)| {
            let curve = curves.and_then(|curves| curves.at.get(index));
            row(plan, time, &pairs(records, index), curve)
        })
        .collect()
}

fn row(plan: &Plan, time: f64, pairs: &Pairs<'_>, curve: Option<&Curve>) -> Row {
    let particles = measured(
        pairs,
        |(now, start)| now.particles as f64 / start.particles as f64,
        None,
    );
    let colliding = plan.count() as f64;
    let collisions = (!has_tracer(plan)).then(|| {
        let each = |pair: &(&Sample, &Sample)| 2.0 * pair.0.collisions as f64 / colliding;
        measured(pairs, each, None)
    });
    // Energies of species add up, and so do their variances.
    let single = |sample: &Sample| {
        let (mut sum, mut square) = (0.0, 0.0);
        for moments in but_tracers(plan, sample) {
            let energy = moments.count as f64 * moments.temperature;
            sum += energy;
            square += (energy * temperature_error(plan, moments)).powi(2);
        }
        (sum > 0.0).then(|| square.sqrt() / sum)
    };
    let ratio = |pair: &(&Sample, &Sample)| energy_of(plan, pair.0) / energy_of(plan, pair.1);
    let relative = pairs
        .first()
        .filter(|_| plan.case.sticking.is_none())
        .and_then(|pair| Some(single(pair.0)? * ratio(pair)));
    let displacement = has_displacement(plan).then(|| {
        let mean = |sample: &Sample| {
            let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
            for moments in but_tracers(plan, sample) {
                let n = moments.count as f64;
                count += n;
                sum += n * moments.displacement;
                square += (n * displacement_error(plan, moments)).powi(2);
            }
            (
                sum / f64::max(count, 1.0),
                square.sqrt() / f64::max(count, 1.0),
            )
        };
        let single = pairs.first().map(|pair| mean(pair.0).1);
        measured(pairs, |pair| mean(pair.0).0, single)
    });
    let known = |found: Option<Measured>, theory: fn(&Curve) -> Predicted| {
        found.map_or_else(Estimate::default, |found| against(found, curve.map(theory)))
    };
    Row {
        time,
        particles: against(particles, None),
        collisions: known(collisions, |curve| curve.collisions),
        energy: known(Some(measured(pairs, ratio, relative)), |curve| {
            curve.energy_ratio
        }),
        displacement: known(displacement, |curve| curve.displacement),
        replicas: pairs.len(),
    }
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new("gas", "The gas as a whole at the sample times")
        .key("time", "unit of time", "Time")
        .estimate("particles_ratio", "1", "Particles over those of the start")
        .with_theory_error(
            "collisions_per_particle",
            "1",
            "Collisions of a particle since the start, on average over the particles of the start; empty with tracers",
        )
        .with_theory_error(
            "energy_ratio",
            "1",
            "Kinetic energy over that of the start, without tracers",
        )
        .with_theory_error(
            "displacement_square",
            "length^2",
            "Mean squared displacement of all particles but tracers",
        )
        .note("replicas", "1", "Replicas that the averages run over");
    for row in rows {
        table
            .row()
            .number(row.time)
            .estimate(row.particles)
            .estimate(row.collisions)
            .estimate(row.energy)
            .estimate(row.displacement)
            .count(row.replicas as u64);
    }
    let energy = Axis::logarithmic("energy_ratio", "E/E(0)");
    let collisions = Axis::linear("collisions_per_particle", "collisions per particle");
    table = table
        .figure(against_time(
            "Energy",
            energy,
            "Kinetic energy over that of the start.",
        ))
        .figure(against_time(
            "Collisions",
            collisions,
            "Collisions that a particle of the start took part in, on average. In a gas that cools by Haff's law they grow \
             as the logarithm of time.",
        ));
    if rows.iter().any(|row| row.displacement.value.is_some()) {
        table = table.figure(against_time(
            "Mean squared displacement of all particles",
            Axis::logarithmic("displacement_square", "<R²>"),
            "Mean squared displacement since the start: ballistic at first, then ever slower as the gas cools.",
        ));
    }
    table
}

/// A figure of a single curve against the logarithm of time.
pub(super) fn against_time(title: &'static str, y: Axis, caption: &'static str) -> Figure {
    Figure {
        curves: Vec::new(),
        caption: caption.into(),
        ..Figure::curves(title, Axis::logarithmic("time", "t"), y)
    }
}

fn replicas(records: &[&Record]) -> Table {
    let mut table = Table::new("replicas", "Samples of single replicas")
        .key("replica", "1", "Number of the replica, from zero")
        .key("time", "unit of time", "Time")
        .value("particles", "1", "Particles")
        .value("collisions", "1", "Pair collisions since the start")
        .value("energy", "energy", "Kinetic energy, (1/2) sum m v^2");
    for (replica, record) in records.iter().enumerate() {
        for sample in &record.samples {
            table
                .row()
                .count(replica as u64)
                .number(sample.time)
                .count(sample.particles as u64)
                .count(sample.collisions)
                .number(sample.energy);
        }
    }
    table
}
