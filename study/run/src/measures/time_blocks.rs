//! Division of a flow's run into equal time blocks for averages, and the time from which the flow
//! is steady.

use std::ops::Range;

use stosszahl_analysis::steady;

use super::gas_series::{GasSample, GasSeries, freedom, shortest};
use crate::measure::{self, BadOption, ReplicaRecords};
use crate::plan::CasePlan;

/// Default number of samples of a flow's run.
const SAMPLES: u64 = 400;

/// Returns the number of equal time blocks of a measurement of flows: `own` if it sets one, else
/// that of the measurement `fields`.
pub fn blocks(plan: &CasePlan, own: Option<u64>) -> usize {
    let fields = plan.case.measure.get("fields");
    let shared = fields.and_then(|table| table.get("blocks")?.as_integer());
    let written = own.or_else(|| shared.and_then(|blocks| u64::try_from(blocks).ok()));
    written.unwrap_or_else(|| plan.default_blocks()) as usize
}

/// Returns the number of samples of the run, without the start.
pub fn samples(plan: &CasePlan) -> u64 {
    plan.equal_samples().unwrap_or(SAMPLES)
}

/// Checks that a case has a box, and that the number of time blocks divides the number of samples.
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

/// Returns the time of a numbered sample, in the case's unit of time. The last is exactly the end
/// of the run.
fn sample_time(plan: &CasePlan, sample: u64) -> f64 {
    plan.case.run.until * (sample as f64 / samples(plan) as f64)
}

/// Returns the times of all samples of a flow, start included, in the case's unit of time.
pub fn times(plan: &CasePlan) -> Vec<f64> {
    (0..=samples(plan))
        .map(|sample| sample_time(plan, sample))
        .collect()
}

/// Returns the number of samples in each time block.
pub fn per_block(plan: &CasePlan, blocks: usize) -> usize {
    (samples(plan) as usize / blocks.max(1)).max(1)
}

/// Returns the time from which number of particles, temperature and energies of one engine are
/// steady, in the case's unit of time; `None` if never.
fn steady_from(plan: &CasePlan, runs: &[&GasSeries]) -> Option<f64> {
    let samples = shortest(runs);
    // The start itself is no average over an interval.
    let series = |of: &dyn Fn(&GasSample) -> f64| -> Vec<f64> {
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
    Some(runs.first()?.get(begin)?.time)
}

/// Returns the time from which the flow is steady, for each engine. `series` returns the samples of
/// the gas from a record.
pub fn steady<R: 'static>(
    plan: &CasePlan,
    runs: &ReplicaRecords<'_>,
    series: fn(&R) -> &GasSeries,
) -> Vec<Option<f64>> {
    let one = |records: Vec<&R>| {
        let all_series: Vec<&GasSeries> = records.into_iter().map(series).collect();
        steady_from(plan, &all_series)
    };
    runs.each(plan).map(|(_, records)| one(records)).collect()
}

/// Range of consecutive time blocks of a run, over which flow quantities are averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeBlocks {
    /// Indices of the time blocks, from 0.
    pub blocks: Range<usize>,
    /// Start of the first and end of the last time block, in the case's unit of time.
    pub times: [f64; 2],
    /// True if the flow is steady in these time blocks for all engines.
    pub steady: bool,
}

impl TimeBlocks {
    /// Creates the range of time blocks between two times, rounded to the nearest block ends. Times
    /// are in the case's unit.
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

    /// Creates the range of time blocks in which all engines are steady; the last quarter of the
    /// run if one never is.
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

/// Returns the duration of a time block, in the case's unit of time.
pub fn block_length(plan: &CasePlan, blocks: usize) -> f64 {
    plan.case.run.until / blocks as f64
}
