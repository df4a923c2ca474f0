//! Samples of the whole gas at equal intervals, and the time from which the gas is steady; shared
//! by the measures of flows.

use std::ops::Range;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::{self, Freedom, Sighting};
use stosszahl_analysis::steady;
use stosszahl_model::sum::Totals;
use stosszahl_model::{Grouping, Particle, ParticleReduction};

use crate::measure::{self, BadOption, ReplicaRecords, SampleContext};
use crate::plan::CasePlan;

/// Number of samples of a run, if the case does not set it.
const SAMPLES: u64 = 400;

/// Sample of the whole gas at one time. Energies are sums over all particles; all numbers but the
/// time are in engine units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CourseSample {
    /// Time of the sample, in the unit of time of the case.
    pub time: f64,
    /// Number of physical pair collisions so far: each counts the particles per simulator.
    pub collisions: f64,
    /// Potential energy in gravity a: the sum of -m a . r along the axes that end at walls or
    /// openings.
    pub potential: f64,
    /// Sums over the particles of each species.
    pub species: Vec<Share>,
}

/// Sums over the particles of one species, or over all particles, in engine units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Number of particles.
    pub number: f64,
    /// Sum of the masses.
    pub mass: f64,
    /// Sum of the momenta m v.
    pub momentum: [f64; 3],
    /// Kinetic energy of translation, the sum of m v^2/2.
    pub translation: f64,
    /// Kinetic energy of rotation, the sum of I w^2/2.
    pub rotation: f64,
}

impl Share {
    /// Granular temperature m <(v - u)^2>/D with the mean velocity u; 0 without particles.
    pub fn temperature(&self, freedom: Freedom) -> f64 {
        if self.number <= 0.0 {
            return 0.0;
        }
        let square: f64 = self.momentum.iter().map(|p| p * p).sum();
        (2.0 * self.translation - square / self.mass) / (freedom.dimension as f64 * self.number)
    }

    /// Temperature of rotation: I <w^2> over the number of spin components. It is 0 without
    /// particles, and `None` for smooth particles.
    pub fn spin_temperature(&self, freedom: Freedom) -> Option<f64> {
        let each = freedom.rotations as f64 * self.number.max(f64::MIN_POSITIVE);
        (freedom.rotations > 0).then(|| 2.0 * self.rotation / each)
    }
}

impl CourseSample {
    /// Samples the whole gas.
    pub fn sample_gas(looking: &Looking, moment: &SampleContext<'_>) -> Self {
        Self::take_with(looking, moment, None).0
    }

    /// Samples the whole gas, and adds its particles to `fields`, if given, in the same pass.
    pub fn take_with(
        looking: &Looking,
        moment: &SampleContext<'_>,
        fields: Option<fields::FieldSample>,
    ) -> (Self, Option<fields::FieldSample>) {
        let gas = &*moment.simulation;
        let mut look = Look {
            looking: *looking,
            totals: Totals::new(SUMS * looking.grouping.groups() + 1),
            fields,
        };
        gas.reduce_particles(&mut look);
        let values = look.totals.values();
        let (species, potential) = values.split_at(values.len() - 1);
        let share = |sums: &[f64]| Share {
            number: sums[0],
            mass: sums[1],
            momentum: [sums[2], sums[3], sums[4]],
            translation: sums[5],
            rotation: sums[6],
        };
        let sample = Self {
            time: moment.time,
            collisions: gas.work_counters().collisions as f64 * gas.mean_weight(),
            potential: potential[0],
            species: species.chunks(SUMS).map(share).collect(),
        };
        (sample, look.fields)
    }

    /// Sums over the particles of all species.
    pub fn total(&self) -> Share {
        let mut all = Share::default();
        for share in &self.species {
            all.number += share.number;
            all.mass += share.mass;
            for (sum, more) in all.momentum.iter_mut().zip(share.momentum) {
                *sum += more;
            }
            all.translation += share.translation;
            all.rotation += share.rotation;
        }
        all
    }

    /// Total energy: translation, rotation, and potential energy in gravity.
    pub fn energy(&self) -> f64 {
        let all = self.total();
        all.translation + all.rotation + self.potential
    }
}

/// Parameters of a sample of the whole gas: species and gravity.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Looking {
    grouping: Grouping,
    /// Acceleration of gravity along the axes that end at walls or openings, in engine units
    /// ([`CasePlan::gravity`]).
    gravity: Vector3<f64>,
}

impl Looking {
    /// Creates the parameters from a plan.
    pub fn from_plan(plan: &CasePlan) -> Self {
        Self {
            grouping: plan.grouping(),
            gravity: plan.gravity(),
        }
    }
}

/// Number of sums for each species: the numbers of [`Share`].
const SUMS: usize = 7;

/// Reduction over all particles that makes a sample of the gas.
#[derive(Serialize, Deserialize)]
pub struct Look {
    looking: Looking,
    /// Sums of each species in turn; the last sum is the potential energy in gravity.
    totals: Totals,
    fields: Option<fields::FieldSample>,
}

impl ParticleReduction for Look {
    const NAME: &'static str = "course";

    fn add_particle(&mut self, particle: &Particle) {
        let species = self.looking.grouping.group(particle.species);
        let all = self.totals.open();
        let Particle { weight, mass, .. } = *particle;
        let height = self.looking.gravity.dot(&particle.position);
        let last = all.len() - 1;
        all[last] += weight * (-mass * height);
        let sums = &mut all[SUMS * species..][..SUMS];
        sums[0] += weight;
        sums[1] += weight * mass;
        let mut square = 0.0;
        for (sum, &component) in sums[2..5].iter_mut().zip(particle.velocity.iter()) {
            *sum += weight * mass * component;
            square += component * component;
        }
        sums[5] += 0.5 * weight * mass * square;
        sums[6] += 0.5 * weight * (2.0 * particle.spin_energy);
        if let Some(fields) = &mut self.fields {
            let sighting = Sighting {
                position: [particle.position.x, particle.position.y],
                velocity: particle.velocity.into(),
                mass,
                twice_spin_energy: 2.0 * particle.spin_energy,
                weight,
            };
            fields.add(species, &sighting);
        }
    }

    fn close_group(&mut self, group: u32) {
        self.totals.close();
        if let Some(fields) = &mut self.fields {
            fields.close(group);
        }
    }

    fn merge_sum(&mut self, other: Self) {
        self.totals.merge(&other.totals);
        if let (Some(fields), Some(more)) = (&mut self.fields, other.fields) {
            fields.merge(more);
        }
    }
}

/// Returns the number of components of velocities and of spins in a case.
pub fn freedom(plan: &CasePlan) -> Freedom {
    let rotations = match (plan.grains.rough, plan.dimension) {
        (None, _) => 0,
        (Some(_), 2) => 1,
        (Some(_), _) => 3,
    };
    Freedom {
        dimension: plan.dimension,
        rotations,
    }
}

/// Number of equal time blocks of a measure: `own` from its own options, or that of the measure
/// `fields`, so that all measures of flows have the same time windows.
pub fn blocks(plan: &CasePlan, own: Option<u64>) -> usize {
    let fields = plan.case.measure.get("fields");
    let shared = fields.and_then(|table| table.get("blocks")?.as_integer());
    let written = own.or_else(|| shared.and_then(|blocks| u64::try_from(blocks).ok()));
    written.unwrap_or_else(|| plan.default_blocks()) as usize
}

/// Number of samples of the run after the start.
pub fn samples(plan: &CasePlan) -> u64 {
    plan.equal_samples().unwrap_or(SAMPLES)
}

/// Checks that a case has a box, and that a number of time blocks divides the number of samples.
///
/// # Errors
/// [`BadOption`] without a box, or if samples do not fall into equal blocks.
pub fn check_blocks(plan: &CasePlan, blocks: usize) -> Result<(), BadOption> {
    measure::require(plan.case.domain.is_some(), "", "a case with a box")?;
    let samples = samples(plan);
    let good = (1..=10_000).contains(&blocks) && samples.is_multiple_of(blocks as u64);
    let allowed = format!(
        "a whole number from 1 to 10000 that divides the number of samples, {samples} (run.samples)"
    );
    measure::require(good, "blocks", allowed)
}

/// Time of a sample by its number, in the unit of time of the case; the last is exactly the end of
/// the run.
fn sample_time(plan: &CasePlan, sample: u64) -> f64 {
    plan.case.run.until * (sample as f64 / samples(plan) as f64)
}

/// Times of all samples, the start included, in the unit of time of the case.
pub fn times(plan: &CasePlan) -> Vec<f64> {
    (0..=samples(plan))
        .map(|sample| sample_time(plan, sample))
        .collect()
}

/// Number of samples in each time block.
pub fn per_block(plan: &CasePlan, blocks: usize) -> usize {
    (samples(plan) as usize / blocks.max(1)).max(1)
}

/// Samples of one replica over the run.
pub type ReplicaCourse = Vec<CourseSample>;

/// Time from which on all quantities of the gas of one engine are steady, in the unit of time of
/// the case; `None` if they never are.
fn steady_from(plan: &CasePlan, runs: &[&ReplicaCourse]) -> Option<f64> {
    let samples = runs.iter().map(|run| run.len()).min()?;
    // The start itself is no average over an interval.
    let series = |of: &dyn Fn(&CourseSample) -> f64| -> Vec<f64> {
        (1..samples)
            .map(|index| runs.iter().map(|run| of(&run[index])).sum())
            .collect()
    };
    let freedom = freedom(plan);
    let signals = [
        series(&|sample| sample.total().number),
        series(&|sample| sample.total().temperature(freedom)),
        series(&|sample| sample.total().translation),
        series(&|sample| sample.total().rotation),
        series(&|sample| sample.potential),
    ];
    let mut begin = 0;
    for signal in signals {
        let largest = signal
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        let low = signal.iter().copied().fold(f64::INFINITY, f64::min);
        let high = signal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // What does not change but by rounding is steady.
        if high - low > 1e-9 * largest {
            begin = begin.max(steady::beginning(&signal)?);
        }
    }
    Some(sample_time(plan, begin as u64))
}

/// Returns the beginning of the steady state of each engine; `course` picks the samples of a
/// record.
pub fn steady<R: 'static>(
    plan: &CasePlan,
    runs: &ReplicaRecords<'_>,
    course: fn(&R) -> &ReplicaCourse,
) -> Vec<Option<f64>> {
    let one = |records: Vec<&R>| {
        let courses: Vec<&ReplicaCourse> = records.into_iter().map(course).collect();
        steady_from(plan, &courses)
    };
    runs.each(plan).map(|(_, records)| one(records)).collect()
}

/// Consecutive time blocks that are averaged over.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRange {
    /// Indices of the blocks.
    pub blocks: Range<usize>,
    /// Start of the first and end of the last block, in the unit of time of the case.
    pub times: [f64; 2],
    /// True if all engines are steady in these blocks.
    pub steady: bool,
}

impl BlockRange {
    /// Creates the range between two times, in the unit of time of the case, moved to the nearest
    /// ends of blocks.
    pub fn between_times(
        plan: &CasePlan,
        blocks: usize,
        [start, end]: [f64; 2],
        steady: bool,
    ) -> Self {
        let length = block_length(plan, blocks);
        let first = ((start / length).round() as usize).min(blocks - 1);
        let last = ((end / length).round() as usize).clamp(first + 1, blocks);
        Self {
            blocks: first..last,
            times: [first as f64 * length, last as f64 * length],
            steady,
        }
    }

    /// Creates the range in which all engines are steady; if one never is, the last quarter of the
    /// run.
    pub fn last(plan: &CasePlan, blocks: usize, steady: &[Option<f64>]) -> Self {
        let until = plan.case.run.until;
        let length = block_length(plan, blocks);
        let mut engines = steady.iter();
        let from = engines.try_fold(0.0_f64, |latest, from| Some(latest.max((*from)?)));
        match from {
            // The block in which it becomes steady is left out.
            Some(from) => {
                let start = (from / length).ceil() * length;
                Self::between_times(plan, blocks, [start, until], true)
            }
            None => Self::between_times(plan, blocks, [0.75 * until, until], false),
        }
    }
}

/// Length of a block, in the unit of time of the case.
pub fn block_length(plan: &CasePlan, blocks: usize) -> f64 {
    plan.case.run.until / blocks as f64
}
