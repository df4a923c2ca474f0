//! The course of the whole gas at equal intervals, and from when on it is steady: what the measures of flows share.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::Freedom;
use stosszahl_analysis::steady;
use stosszahl_model::Particle;

use crate::measure::{self, BadOption, Moment, Runs};
use crate::plan::Plan;

/// Blocks of time, where the case says nothing.
const BLOCKS: u64 = 40;

/// Samples, where the case says nothing.
const SAMPLES: u64 = 400;

/// The whole gas at one time. Energies are sums over all particles; all numbers but the time are in engine units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// When, in the unit of time of the case.
    pub time: f64,
    /// Pair collisions so far, times what each stands for.
    pub collisions: f64,
    /// Energy in the field, sum of -m a . r.
    pub potential: f64,
    /// By species.
    pub species: Vec<Share>,
}

/// What one species has of the gas, or all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Number of particles.
    pub number: f64,
    /// Mass.
    pub mass: f64,
    /// Momentum.
    pub momentum: [f64; 3],
    /// Sum of m v^2/2.
    pub translation: f64,
    /// Sum of I w^2/2.
    pub rotation: f64,
}

impl Share {
    /// m <(v - u)^2>/D with the mean velocity u; 0 without particles.
    pub fn temperature(&self, freedom: Freedom) -> f64 {
        if self.number <= 0.0 {
            return 0.0;
        }
        let square: f64 = self.momentum.iter().map(|p| p * p).sum();
        (2.0 * self.translation - square / self.mass) / (freedom.dimension as f64 * self.number)
    }

    /// I <w^2> for each rotation; 0 without particles, none for smooth ones.
    pub fn spin_temperature(&self, freedom: Freedom) -> Option<f64> {
        let each = freedom.rotations as f64 * self.number.max(f64::MIN_POSITIVE);
        (freedom.rotations > 0).then(|| 2.0 * self.rotation / each)
    }
}

impl Sample {
    /// Looks at all particles, and shows each with the number of its species to another observer too.
    pub fn take(
        plan: &Looking,
        moment: &Moment<'_>,
        mut also: impl FnMut(usize, &Particle),
    ) -> Self {
        let gas = &*moment.simulation;
        let mut sample = Self {
            time: moment.time,
            collisions: gas.work().collisions as f64 * gas.weight(),
            potential: 0.0,
            species: vec![Share::default(); plan.species],
        };
        gas.visit(&mut |particle| {
            let species = particle.species as usize % plan.species;
            let share = &mut sample.species[species];
            let Particle { weight, mass, .. } = *particle;
            share.number += weight;
            share.mass += weight * mass;
            let mut square = 0.0;
            for (sum, &component) in share.momentum.iter_mut().zip(particle.velocity.iter()) {
                *sum += weight * mass * component;
                square += component * component;
            }
            share.translation += 0.5 * weight * mass * square;
            share.rotation += 0.5 * weight * (2.0 * particle.spin_energy);
            sample.potential += weight * (-mass * plan.gravity.dot(&particle.position));
            also(species, particle);
        });
        sample
    }

    /// All species together.
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

    /// Energy of motion and in the field.
    pub fn energy(&self) -> f64 {
        let all = self.total();
        all.translation + all.rotation + self.potential
    }
}

/// What samples need to know of a plan.
#[derive(Clone, Debug)]
pub struct Looking {
    species: usize,
    gravity: nalgebra::Vector3<f64>,
}

impl Looking {
    /// Of a plan.
    pub fn of(plan: &Plan) -> Self {
        Self {
            species: plan.species.len().max(1),
            gravity: plan.grains.gravity.unwrap_or_default(),
        }
    }
}

/// Components of velocities and of spins.
pub fn freedom(plan: &Plan) -> Freedom {
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

/// Blocks of time of a measure: as its own table says, or that of `fields`, so that all have the same windows.
pub fn blocks(plan: &Plan, own: Option<u64>) -> usize {
    let fields = plan.case.measure.get("fields");
    let shared = fields.and_then(|table| table.get("blocks")?.as_integer());
    let written = own.or_else(|| shared.and_then(|blocks| u64::try_from(blocks).ok()));
    written.unwrap_or(BLOCKS) as usize
}

/// Number of samples after the start.
pub fn samples(plan: &Plan) -> u64 {
    plan.equal_samples().unwrap_or(SAMPLES)
}

/// Checks a box and a number of blocks.
///
/// # Errors
/// [`BadOption`] without a box, or if samples do not fall into equal blocks.
pub fn check(plan: &Plan, blocks: usize) -> Result<(), BadOption> {
    measure::require(plan.case.domain.is_some(), "", "a case with a box")?;
    let samples = samples(plan);
    let good = (1..=10_000).contains(&blocks) && samples.is_multiple_of(blocks as u64);
    let allowed = format!(
        "a whole number from 1 to 10000 that divides the number of samples, {samples} (run.samples)"
    );
    measure::require(good, "blocks", allowed)
}

/// Time of a sample; the last is the end exactly.
fn sample_time(plan: &Plan, sample: u64) -> f64 {
    plan.case.run.until * (sample as f64 / samples(plan) as f64)
}

/// Times of all samples, from that of the start on.
pub fn times(plan: &Plan) -> Vec<f64> {
    (0..=samples(plan))
        .map(|sample| sample_time(plan, sample))
        .collect()
}

/// Samples in each block.
pub fn per_block(plan: &Plan, blocks: usize) -> usize {
    (samples(plan) as usize / blocks.max(1)).max(1)
}

/// The course of one replica.
pub type Course = Vec<Sample>;

/// From when on all that the gas of one engine has is steady, in the unit of time of the case; `None` if it never is.
fn steady_from(plan: &Plan, runs: &[&Course]) -> Option<f64> {
    let samples = runs.iter().map(|run| run.len()).min()?;
    // The start itself is no average over an interval.
    let series = |of: &dyn Fn(&Sample) -> f64| -> Vec<f64> {
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

/// The same of all engines, where `course` is what records have of it.
pub fn steady<R: 'static>(
    plan: &Plan,
    runs: &Runs<'_>,
    course: fn(&R) -> &Course,
) -> Vec<Option<f64>> {
    let one = |records: Vec<&R>| {
        let courses: Vec<&Course> = records.into_iter().map(course).collect();
        steady_from(plan, &courses)
    };
    runs.each(plan).map(|(_, records)| one(records)).collect()
}

/// Blocks of time that are averaged over.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The blocks.
    pub blocks: Range<usize>,
    /// Start and end, in the unit of time of the case.
    pub times: [f64; 2],
    /// Whether it is the steady state.
    pub steady: bool,
}

impl Window {
    /// Between two times, moved to the ends of blocks.
    pub fn between(plan: &Plan, blocks: usize, [start, end]: [f64; 2], steady: bool) -> Self {
        let length = block_length(plan, blocks);
        let first = ((start / length).round() as usize).min(blocks - 1);
        let last = ((end / length).round() as usize).clamp(first + 1, blocks);
        Self {
            blocks: first..last,
            times: [first as f64 * length, last as f64 * length],
            steady,
        }
    }

    /// The steady state of all engines; without one, the last quarter of the run.
    pub fn last(plan: &Plan, blocks: usize, steady: &[Option<f64>]) -> Self {
        let until = plan.case.run.until;
        let length = block_length(plan, blocks);
        let mut engines = steady.iter();
        let from = engines.try_fold(0.0_f64, |latest, from| Some(latest.max((*from)?)));
        match from {
            // The block in which it becomes steady is left out.
            Some(from) => {
                let start = (from / length).ceil() * length;
                Self::between(plan, blocks, [start, until], true)
            }
            None => Self::between(plan, blocks, [0.75 * until, until], false),
        }
    }
}

/// Length of a block, in the unit of time of the case.
pub fn block_length(plan: &Plan, blocks: usize) -> f64 {
    plan.case.run.until / blocks as f64
}
