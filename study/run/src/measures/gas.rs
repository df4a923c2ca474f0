//! A gas without positions as a whole, and what its other tables are made of: moments of each group at the sample times.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::homogeneous::SpeciesMoments;
use stosszahl_model::{Grouping, Simulation};
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};

use super::mean_over_replicas;
use crate::measure::{
    self, BadOption, Measure, Needs, NoOptions, Probe, ReplicaRecords, SampleContext, described,
    keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};
use crate::theory::homogeneous::{self, Predicted, TheoryPoint};

/// Particles, collisions, energy and displacement of a gas without positions.
pub struct HomogeneousGasMeasure;

impl Measure for HomogeneousGasMeasure {
    described!(
        "gas",
        "Particles, collisions, energy and mean squared displacement of a gas without positions.",
        NoOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        !plan.has_box()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        homogeneous_only(plan)?;
        self.read_options(plan)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        plan.sample_times()
    }

    fn kept_per_particle(&self, plan: &CasePlan) -> f64 {
        if has_correlation(plan) {
            size_of::<[f64; 3]>() as f64
        } else {
            0.0
        }
    }

    fn kept_per_look(&self, plan: &CasePlan) -> f64 {
        super::KEPT_PER_SPECIES * (1 + plan.species.len()) as f64
    }

    fn engine_needs(&self, plan: &CasePlan) -> Needs {
        Needs {
            displacements: has_displacement(plan),
            ..Needs::default()
        }
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(GasProbe {
            grouping: plan.grouping(),
            displacement: has_displacement(plan),
            correlation: has_correlation(plan),
            until: plan.case.run.until,
            record: GasRecord::default(),
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let records: Vec<&GasRecord> = runs.records(0);
        vec![table(&rows(plan, &records)), replicas(&records)]
    }
}

/// Name of the measure of the velocity correlation.
pub(super) const CORRELATION: &str = "velocity_correlation";

/// Returns true if the correlation of the velocities with the initial velocities is measured.
pub(super) fn has_correlation(plan: &CasePlan) -> bool {
    plan.case.measure.contains_key(CORRELATION) && plan.case.aggregation.is_none()
}

/// Refuses a measurement that only a gas without positions has.
pub(super) fn homogeneous_only(plan: &CasePlan) -> Result<(), BadOption> {
    let allowed = "only in a gas without positions, which is a case without [box]";
    measure::require(!plan.has_box(), "", allowed)
}

/// Returns true if displacements are measured: the case has `[measure.displacement]`. Particles
/// that stick have no displacement, as they do not last.
pub fn has_displacement(plan: &CasePlan) -> bool {
    plan.case.measure.contains_key("displacement") && plan.case.aggregation.is_none()
}

/// Sample of a gas without positions, at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GasSample {
    /// Time of the sample, in the unit of time of the case.
    pub time: f64,
    /// Number of particles.
    pub particles: usize,
    /// Number of pair collisions since the start.
    pub collisions: u64,
    /// Kinetic energy of all particles, tracers included, in engine units.
    pub energy: f64,
    /// Moments of each species, or of each group of particles of like size.
    pub groups: Vec<SpeciesMoments>,
}

/// Record of one replica: the gas at all sample times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GasRecord {
    /// Samples, in the order of time.
    pub samples: Vec<GasSample>,
    /// Velocities at the start, kept until the last sample if their correlation is measured; else
    /// empty.
    start: Vec<[f64; 3]>,
}

struct GasProbe {
    grouping: Grouping,
    displacement: bool,
    correlation: bool,
    until: f64,
    record: GasRecord,
}

impl Probe for GasProbe {
    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        if self.displacement {
            moment.simulation.track_displacements();
        }
        if self.correlation {
            let start = &mut self.record.start;
            let mut keep = |one: &stosszahl_model::Particle| start.push(one.velocity.into());
            moment.simulation.visit_particles(&mut keep);
        }
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let simulation = &*moment.simulation;
        let paths = self.displacement.then(|| simulation.displacements());
        let paths = paths.flatten().unwrap_or_default();
        let (energy, groups) = moments(simulation, self.grouping, &paths, &self.record.start);
        self.record.samples.push(GasSample {
            time: moment.time,
            particles: simulation.particle_count(),
            collisions: simulation.work_counters().collisions,
            energy,
            groups,
        });
        if moment.time >= self.until {
            self.record.start = Vec::new();
        }
    }

    keeps_record!();
}

/// Kinetic energy and moments of every group, in one pass. Displacements and velocities of the
/// start are empty where they are not measured.
pub(super) fn moments(
    simulation: &dyn Simulation,
    grouping: Grouping,
    displacements: &[Vector3<f64>],
    start: &[[f64; 3]],
) -> (f64, Vec<SpeciesMoments>) {
    // Sums at first, in the fields of their means.
    let mut groups: Vec<SpeciesMoments> = Vec::new();
    let (mut twice, mut index) = (0.0, 0);
    simulation.visit_particles(&mut |particle| {
        let number = grouping.group(particle.species);
        if number >= groups.len() {
            groups.resize(number + 1, SpeciesMoments::default());
        }
        let own = &mut groups[number];
        let square = particle.mass * particle.velocity.norm_squared();
        twice += square;
        own.count += 1;
        own.temperature += square;
        own.fourth_cumulant += square * square;
        if let Some(path) = displacements.get(index) {
            let (square, along) = (path.norm_squared(), path.dot(&particle.velocity));
            own.displacement += square;
            own.displacement_fourth += square * square;
            own.displacement_velocity += along;
            own.displacement_velocity_square += along * along;
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
        own.displacement_velocity /= n;
        own.displacement_velocity_square /= n;
        own.velocity_correlation /= n;
    }
    (0.5 * twice, groups)
}

/// Mean over replicas with the larger of two standard errors: from the spread over replicas, and
/// from `single`, the standard error of one replica by the spread over its particles.
pub(super) fn measured<T>(
    runs: &[T],
    value: impl Fn(&T) -> f64,
    single: Option<f64>,
) -> TableEstimate {
    let found = mean_over_replicas(runs.iter().map(|run| Some(value(run))));
    let within = single.map(|error| error / (runs.len() as f64).sqrt());
    let errors = [found.standard_error, within].into_iter().flatten();
    TableEstimate {
        // The spread over many particles is known better than that of few replicas.
        replicas: found.replicas.filter(|_| within.is_none()),
        standard_error: errors.reduce(f64::max).filter(|error| error.is_finite()),
        ..found
    }
}

/// Returns an estimate with the value of theory added, if there is one.
pub(super) fn against(found: TableEstimate, theory: Option<Predicted>) -> TableEstimate {
    TableEstimate {
        theory: theory.map(|theory| theory.value),
        theory_error: theory.and_then(|theory| theory.error),
        ..found
    }
}

/// Relative standard error of a temperature by the spread over particles:
/// `sqrt(((D + 2)(1 + a2)/D - 1)/N)`. It is at least the error `sqrt(2/(D N))` of Maxwellian
/// velocities, as few particles do not show their own spread.
pub(super) fn temperature_error(plan: &CasePlan, moments: &SpeciesMoments) -> f64 {
    let d = plan.dimension as f64;
    let spread = (d + 2.0) * (1.0 + moments.fourth_cumulant) / d - 1.0;
    (spread.max(2.0 / d) / moments.count.max(1) as f64).sqrt()
}

/// Standard error of a mean squared displacement by the spread over particles, at least that of
/// normally distributed displacements.
pub(super) fn displacement_error(plan: &CasePlan, moments: &SpeciesMoments) -> f64 {
    let (d, mean) = (plan.dimension as f64, moments.displacement);
    let spread = moments.displacement_fourth - mean * mean;
    (spread.max(2.0 / d * mean * mean) / moments.count.max(1) as f64).sqrt()
}

/// Sums `value` with its error over all groups but tracers. Returns the sum and the root of the sum
/// of squared errors.
fn but_tracers(
    plan: &CasePlan,
    sample: &GasSample,
    value: impl Fn(&SpeciesMoments) -> [f64; 2],
) -> [f64; 2] {
    let kept = |number: &usize| plan.species.get(*number).is_none_or(|one| !one.tracer);
    let groups = sample.groups.iter().enumerate();
    let values = groups
        .filter(|(number, _)| kept(number))
        .map(|(_, moments)| value(moments));
    let sum = values.fold([0.0, 0.0], |[sum, square], [value, error]| {
        [sum + value, square + error.powi(2)]
    });
    [sum[0], sum[1].sqrt()]
}

/// Row of the table: the gas at one time, averaged over all replicas.
pub(super) struct GasRow {
    pub time: f64,
    pub particles: TableEstimate,
    pub collisions: TableEstimate,
    pub energy: TableEstimate,
    pub displacement: TableEstimate,
    replicas: usize,
}

/// Samples of each replica at one time and at the start.
pub(super) type ReplicaPairs<'a> = Vec<(&'a GasSample, &'a GasSample)>;

/// Samples of all replicas at one time, each with the sample of its start.
pub(super) fn pairs<'a>(records: &[&'a GasRecord], index: usize) -> ReplicaPairs<'a> {
    let of = |record: &&'a GasRecord| Some((record.samples.get(index)?, record.samples.first()?));
    records.iter().filter_map(of).collect()
}

/// Returns the rows of the table, one for each sample time.
pub(super) fn rows(plan: &CasePlan, records: &[&GasRecord]) -> Vec<GasRow> {
    let curves = homogeneous::curves(plan).ok();
    let times = plan.sample_times().into_iter().enumerate();
    let row = |(index, time)| {
        let curve = curves.and_then(|curves| curves.at.get(index));
        row(plan, time, &pairs(records, index), curve)
    };
    times.map(row).collect()
}

fn row(
    plan: &CasePlan,
    time: f64,
    pairs: &ReplicaPairs<'_>,
    curve: Option<&TheoryPoint>,
) -> GasRow {
    let number =
        |(now, start): &(&GasSample, &GasSample)| now.particles as f64 / start.particles as f64;
    let all = plan.count() as f64;
    let traced = plan.species.iter().any(|one| one.tracer);
    let collisions = (!traced).then(|| {
        let found = measured(pairs, |pair| 2.0 * pair.0.collisions as f64 / all, None);
        against(found, curve.map(|curve| curve.collisions))
    });
    // Energies of species add up, and so do their variances.
    let energies = |sample: &GasSample| {
        but_tracers(plan, sample, |moments| {
            let energy = moments.count as f64 * moments.temperature;
            [energy, energy * temperature_error(plan, moments)]
        })
    };
    let energy = |sample: &GasSample| {
        let all = || 0.5 * plan.dimension as f64 * energies(sample)[0];
        if traced { all() } else { sample.energy }
    };
    let ratio = |pair: &(&GasSample, &GasSample)| energy(pair.0) / energy(pair.1);
    let first = pairs.first().filter(|_| plan.case.aggregation.is_none());
    let single = first.and_then(|pair| {
        let [sum, error] = energies(pair.0);
        (sum > 0.0).then(|| error / sum * ratio(pair))
    });
    let displacement = has_displacement(plan).then(|| {
        let mean = |sample: &GasSample| {
            let [count, _] = but_tracers(plan, sample, |moments| [moments.count as f64, 0.0]);
            let sums = but_tracers(plan, sample, |moments| {
                let n = moments.count as f64;
                [
                    n * moments.displacement,
                    n * displacement_error(plan, moments),
                ]
            });
            sums.map(|sum| sum / f64::max(count, 1.0))
        };
        let single = pairs.first().map(|pair| mean(pair.0)[1]);
        let found = measured(pairs, |pair| mean(pair.0)[0], single);
        against(found, curve.map(|curve| curve.displacement))
    });
    GasRow {
        time,
        particles: measured(pairs, number, None),
        collisions: collisions.unwrap_or_default(),
        energy: against(
            measured(pairs, ratio, single),
            curve.map(|curve| curve.energy_ratio),
        ),
        displacement: displacement.unwrap_or_default(),
        replicas: pairs.len(),
    }
}

fn table(rows: &[GasRow]) -> Table {
    let mut table = table! {
        "gas", "The gas as a whole at the sample times";
        key "time", "unit of time", "Time";
        estimate "particles_ratio", "1", "Particles over those of the start";
        with_theory_error "collisions_per_particle", "1",
            "Collisions of a particle since the start, on average over the particles of the start; empty with tracers";
        with_theory_error "energy_ratio", "1", "Kinetic energy over that of the start, without tracers";
        with_theory_error "mean_squared_displacement", "length^2", "Mean squared displacement of all particles but tracers";
        note "replicas", "1", "Replicas that the averages run over";
    };
    for row in rows {
        let found = [row.particles, row.collisions, row.energy, row.displacement];
        table.add((row.time, found, row.replicas));
    }
    let displaced = rows.iter().any(|row| row.displacement.value.is_some());
    for (shown, title, y, caption) in [
        (
            true,
            "Energy",
            FigureAxis::logarithmic("energy_ratio", "E/E(0)"),
            "Kinetic energy over that of the start.",
        ),
        (
            true,
            "Collisions",
            FigureAxis::linear("collisions_per_particle", "collisions per particle"),
            "Collisions that a particle of the start took part in, on average. In a gas that cools by Haff's law they grow \
             as the logarithm of time.",
        ),
        (
            displaced,
            "Mean squared displacement of all particles",
            FigureAxis::logarithmic("mean_squared_displacement", "<R²>"),
            "Mean squared displacement since the start: ballistic at first, then ever slower as the gas cools.",
        ),
    ] {
        table
            .figures
            .extend(shown.then(|| against_time(title, y, caption)));
    }
    table
}

/// Creates a figure of a single curve against the logarithm of time.
pub(super) fn against_time(title: &'static str, y: FigureAxis, caption: &'static str) -> Figure {
    Figure::curves(title, FigureAxis::logarithmic("time", "t"), y)
        .by(&[])
        .caption(caption)
}

fn replicas(records: &[&GasRecord]) -> Table {
    let mut table = table! {
        "replicas", "Samples of single replicas";
        key "replica", "1", "Number of the replica, from zero";
        key "time", "unit of time", "Time";
        value "particles", "1", "Particles";
        value "collisions", "1", "Pair collisions since the start";
        value "energy", "energy", "Kinetic energy, (1/2) sum m v^2";
    };
    for (replica, record) in records.iter().enumerate() {
        for one in &record.samples {
            table.add((replica, one.time, one.particles, one.collisions, one.energy));
        }
    }
    table
}
