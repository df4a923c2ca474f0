//! Moments of each species of a gas without positions at each sample time, with their standard
//! errors.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::homogeneous::SpeciesMoments;
use stosszahl_model::{Grouping, Simulation};
use stosszahl_results::{Figure, FigureAxis, TableEstimate};

use super::mean_over_replicas;
use crate::measure::{self, BadOption, Probe, SampleContext, keeps_record};
use crate::plan::{CasePlan, Predicted};
use crate::theory::homogeneous;

/// Name of the measurement of the velocity correlation.
pub(super) const CORRELATION: &str = "velocity_correlation";

/// Returns true if the case measures the correlation of velocities with initial velocities, and
/// particles do not aggregate.
pub(super) fn has_correlation(plan: &CasePlan) -> bool {
    plan.case.measure.contains_key(CORRELATION) && plan.case.aggregation.is_none()
}

/// Rejects a measurement that requires a gas without positions if the case has a box.
pub(super) fn homogeneous_only(plan: &CasePlan) -> Result<(), BadOption> {
    let allowed = "only in a gas without positions, which is a case without [box]";
    measure::require(!plan.has_box(), "", allowed)
}

/// Returns true if the case measures displacements and has no aggregation, in which particles do
/// not last.
pub fn has_displacement(plan: &CasePlan) -> bool {
    plan.case.measure.contains_key("displacement") && plan.case.aggregation.is_none()
}

/// Moments of all species of a gas without positions at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeciesSample {
    /// Time at which the species were sampled, in the case's unit of time.
    pub time: f64,
    /// Moments of each species, or of each group of particles of similar size.
    pub groups: Vec<SpeciesMoments>,
}

/// Moments of all species in one replica at all sample times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeciesRecord {
    /// Samples of the species' moments, in the order of time.
    pub samples: Vec<SpeciesSample>,
    /// Initial velocities of all particles until the last sample, if the velocity correlation is
    /// measured; otherwise empty.
    start: Vec<[f64; 3]>,
}

/// Accumulator that samples the moments of the species, with displacements and velocity
/// correlations if the case asks for them.
pub(super) struct SpeciesProbe {
    grouping: Grouping,
    displacement: bool,
    correlation: bool,
    until: f64,
    record: SpeciesRecord,
}

impl SpeciesProbe {
    /// Creates the accumulator of species' moments for a case.
    pub(super) fn new(plan: &CasePlan) -> Self {
        Self {
            grouping: plan.grouping(),
            displacement: has_displacement(plan),
            correlation: has_correlation(plan),
            until: plan.case.run.until,
            record: SpeciesRecord::default(),
        }
    }
}

impl Probe for SpeciesProbe {
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
        let groups = moments(simulation, self.grouping, &paths, &self.record.start);
        self.record.samples.push(SpeciesSample {
            time: moment.time,
            groups,
        });
        if moment.time >= self.until {
            self.record.start = Vec::new();
        }
    }

    keeps_record!();
}

/// Computes the moments of every species in one pass over the particles. `displacements` and
/// `start` (initial velocities) are empty if not measured.
pub(super) fn moments(
    simulation: &dyn Simulation,
    grouping: Grouping,
    displacements: &[Vector3<f64>],
    start: &[[f64; 3]],
) -> Vec<SpeciesMoments> {
    // Sums at first, in the fields of their means.
    let mut groups: Vec<SpeciesMoments> = Vec::new();
    let mut index = 0;
    simulation.visit_particles(&mut |particle| {
        let number = grouping.group(particle.species);
        if number >= groups.len() {
            groups.resize(number + 1, SpeciesMoments::default());
        }
        let own = &mut groups[number];
        let square = particle.mass * particle.velocity.norm_squared();
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
    groups
}

/// Averages a quantity over replicas, with the larger of two standard errors. One is the spread
/// over replicas; the other follows from `single`, the error of one replica by its particles.
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

/// Adds the theoretical value and its error to an estimate, if theory exists.
pub(super) fn against(found: TableEstimate, theory: Option<Predicted>) -> TableEstimate {
    TableEstimate {
        theory: theory.map(|theory| theory.value),
        theory_error: theory.and_then(|theory| theory.error),
        ..found
    }
}

/// Returns the relative standard error of a temperature in D dimensions from N = `count` particles
/// with fourth cumulant a2: `sqrt(((D + 2)(1 + a2)/D - 1)/N)`. The Maxwellian error `sqrt(2/(D N))`
/// is its lower bound, because few particles underestimate their spread.
pub(super) fn temperature_error(dimension: usize, count: f64, fourth_cumulant: f64) -> f64 {
    let d = dimension as f64;
    let spread = (d + 2.0) * (1.0 + fourth_cumulant) / d - 1.0;
    (spread.max(2.0 / d) / count.max(1.0)).sqrt()
}

/// Returns the standard error of a species' mean squared displacement from the spread over
/// particles, at least that of a normal distribution.
pub(super) fn displacement_error(plan: &CasePlan, moments: &SpeciesMoments) -> f64 {
    let (d, mean) = (plan.gas.dimension as f64, moments.displacement);
    let spread = moments.displacement_fourth - mean * mean;
    (spread.max(2.0 / d * mean * mean) / moments.count.max(1) as f64).sqrt()
}

/// Returns the mean squared displacement of all particles but tracers in one replica, and its
/// standard error from the spread over particles.
fn whole_displacement(plan: &CasePlan, sample: &SpeciesSample) -> [f64; 2] {
    let kept = |number: usize| plan.gas.species.get(number).is_none_or(|one| !one.tracer);
    let (mut count, mut sum, mut square) = (0.0, 0.0, 0.0);
    for (number, moments) in sample.groups.iter().enumerate() {
        if kept(number) {
            let n = moments.count as f64;
            count += n;
            sum += n * moments.displacement;
            square += (n * displacement_error(plan, moments)).powi(2);
        }
    }
    [sum, square.sqrt()].map(|sum| sum / f64::max(count, 1.0))
}

/// Averages the mean squared displacement of all particles but tracers at each sample time, with
/// theory; empty if displacements are not measured.
pub(super) fn whole_displacements(
    plan: &CasePlan,
    records: &[&SpeciesRecord],
) -> Vec<(f64, TableEstimate)> {
    if !has_displacement(plan) {
        return Vec::new();
    }
    let curves = homogeneous::curves(plan).ok();
    let at = |(index, time)| {
        let pairs = pairs(records, index);
        let single = pairs
            .first()
            .map(|pair| whole_displacement(plan, pair.0)[1]);
        let found = measured(&pairs, |pair| whole_displacement(plan, pair.0)[0], single);
        let curve = curves.and_then(|curves| curves.at.get(index));
        (time, against(found, curve.map(|curve| curve.displacement)))
    };
    plan.sample_times()
        .into_iter()
        .enumerate()
        .map(at)
        .collect()
}

/// Pairs of species' moments for each replica: at one time and at the first sample.
pub(super) type ReplicaPairs<'a> = Vec<(&'a SpeciesSample, &'a SpeciesSample)>;

/// Returns the species' moments of all replicas at one sample, each paired with the first sample of
/// its replica.
pub(super) fn pairs<'a>(records: &[&'a SpeciesRecord], index: usize) -> ReplicaPairs<'a> {
    let of =
        |record: &&'a SpeciesRecord| Some((record.samples.get(index)?, record.samples.first()?));
    records.iter().filter_map(of).collect()
}

/// Creates a figure of one curve against logarithmic time.
pub(super) fn against_time(title: &'static str, y: FigureAxis, caption: &'static str) -> Figure {
    Figure::curves(title, FigureAxis::logarithmic("time", "t"), y)
        .by(&[])
        .caption(caption)
}
