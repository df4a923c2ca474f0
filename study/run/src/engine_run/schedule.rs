//! Schedule of an engine run: sample times of all measures, and times of velocity rescaling.

use crate::measure::Measure;
use crate::plan::CasePlan;

/// Scheduled event of an engine run: a time, and the samples and rescaling due at it.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledEvent {
    /// Time of the event, in the unit of time of the case.
    pub time: f64,
    /// True if velocities are rescaled at this time, before any sample.
    pub heating: bool,
    /// Measures that sample at this time, by their index among the measures of the case.
    pub measures: Vec<usize>,
}

/// Returns all scheduled events in order of time. The last is at the end of the run, with or
/// without samples.
pub fn schedule_events(plan: &CasePlan, measures: &[&dyn Measure]) -> Vec<ScheduledEvent> {
    let until = plan.case.run.until;
    let times = measures
        .iter()
        .map(|measure| measure.sample_times(plan))
        .collect();
    let heating = plan.case.rescaling().map_or_else(Vec::new, |interval| {
        let count = (until / interval) as u64;
        (1..=count).map(|i| i as f64 * interval).collect()
    });
    merge_times(times, &heating, until)
}

/// Merges the sample times of measures and the rescaling times, as far as they lie within the run.
fn merge_times(measures: Vec<Vec<f64>>, heating: &[f64], until: f64) -> Vec<ScheduledEvent> {
    let looks = measures.into_iter().enumerate();
    let mut all: Vec<(f64, Option<usize>)> = looks
        .flat_map(|(measure, times)| times.into_iter().map(move |time| (time, Some(measure))))
        .chain(heating.iter().map(|&time| (time, None)))
        .filter(|(time, _)| (0.0..=until).contains(time))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut list: Vec<ScheduledEvent> = Vec::new();
    let empty = |time| ScheduledEvent {
        time,
        heating: false,
        measures: Vec::new(),
    };
    for (time, what) in all {
        if list.last().is_none_or(|last| last.time != time) {
            list.push(empty(time));
        }
        let Some(last) = list.last_mut() else {
            continue;
        };
        match what {
            None => last.heating = true,
            Some(measure) if last.measures.contains(&measure) => {}
            Some(measure) => last.measures.push(measure),
        }
    }
    if list.last().is_none_or(|last| last.time < until) {
        list.push(empty(until));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_united_and_end_with_the_run() {
        let list = merge_times(
            vec![vec![2.0, 0.0, 2.0, 9.0], vec![1.0, 2.0]],
            &[1.0, 2.5],
            3.0,
        );
        let times: Vec<f64> = list.iter().map(|due| due.time).collect();
        assert_eq!(times, [0.0, 1.0, 2.0, 2.5, 3.0]);
        assert_eq!(
            list[1],
            ScheduledEvent {
                time: 1.0,
                heating: true,
                measures: vec![1]
            }
        );
        assert_eq!(list[2].measures, [0, 1]);
        assert_eq!(
            list[4],
            ScheduledEvent {
                time: 3.0,
                heating: false,
                measures: vec![]
            }
        );
    }
}
