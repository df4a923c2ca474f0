//! Progress estimate: the fraction of a run's work that is done, measured in computing time.
//!
//! The parts of a replica are its start and its engines, one of which may take a hundred times
//! longer than another. The expected time of a part is its time so far over its fraction done. A
//! part that has not begun is expected to take as long as the same part of other replicas. Before
//! any measurement, the planned times are scaled by those of the measured parts.

use std::time::{Duration, Instant};

use crate::cost::estimate_runtime;
use crate::plan::CasePlan;

/// Receiver of progress reports of a run; libraries print nothing.
pub trait Progress: Sync {
    /// Reports that a sweep point, or the only point, begins: its name or title, and its work.
    fn begin_point(&self, _point: usize, _name: &str, _work: ProgressEstimate) {}

    /// Reports the fraction of a part's work that is done, and its collisions since the last
    /// report. A part is the start or one engine of a replica.
    fn tell_share(&self, _point: usize, _part: usize, _share: f64, _collisions: u64) {}

    /// Reports in words what a slow part of a run spends its time on.
    fn tell_activity(&self, _point: usize, _part: usize, _activity: &str) {}

    /// Reports that a sweep point is finished.
    fn end_point(&self, _point: usize) {}

    /// Reports a note for the user, as text.
    fn show_note(&self, _text: &str) {}
}

/// Ignores all progress messages.
impl Progress for () {}

/// Progress of one point of a sweep, from the fractions of work done by its parts.
#[derive(Clone, Debug)]
pub struct ProgressEstimate {
    /// Estimated times of the start and of each engine for one replica \[s\].
    expected: Vec<f64>,
    parts: Vec<Part>,
    /// Largest fraction of work reported so far, from 0 to 1. Reports never decrease.
    told: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Part {
    share: f64,
    /// Instant of the part's first report, and the fraction of its work done by then. A part
    /// resumed from a checkpoint begins above zero.
    first: Option<(Instant, f64)>,
    /// Fraction of the part's work done since its first report, from 0 to 1.
    did: f64,
    /// Wall time of the part since its first report.
    took: Duration,
}

impl ProgressEstimate {
    /// Creates the progress estimate for a number of replicas. `expected` holds the times of the
    /// start and of each engine for one replica \[s\].
    pub fn new(replicas: usize, expected: &[f64]) -> Self {
        // An estimate of zero still counts as some work.
        let expected: Vec<f64> = expected.iter().map(|cost| cost.max(1e-3)).collect();
        Self {
            parts: vec![Part::default(); replicas * expected.len()],
            expected,
            told: 0.0,
        }
    }

    /// Creates the progress estimate of a case from the planned times of its start and its engines.
    pub fn for_case(plan: &CasePlan) -> Self {
        let pace = estimate_runtime(plan, &[]);
        let engines = pace.engines.iter().map(|[first, _]| *first);
        let parts: Vec<f64> = std::iter::once(pace.start).chain(engines).collect();
        Self::new(plan.case.replicas as usize, &parts)
    }

    /// Records the fraction of its work that part `part` has done at the instant `now`.
    pub fn record_share(&mut self, part: usize, share: f64, now: Instant) {
        let Some(part) = self.parts.get_mut(part) else {
            return;
        };
        part.share = share.clamp(0.0, 1.0);
        let (when, from) = *part.first.get_or_insert((now, part.share));
        if part.share > from {
            part.did = part.share - from;
            part.took = now.duration_since(when);
        }
    }

    /// Sets the progress estimate to 1: all work is done.
    pub fn end(&mut self) {
        self.told = 1.0;
    }

    /// Returns the fraction of all work done, from 0 to 1. It never decreases.
    pub fn done_share(&mut self) -> f64 {
        let kinds = self.expected.len();
        let of_kind = |kind: usize| self.parts.iter().skip(kind).step_by(kinds.max(1));
        // Measured cost of a whole part of each kind [s].
        let measured: Vec<Option<f64>> = (0..kinds)
            .map(|kind| {
                let did: f64 = of_kind(kind).map(|part| part.did).sum();
                let took: f64 = of_kind(kind).map(|part| part.took.as_secs_f64()).sum();
                (did > 0.0 && took > 0.0).then(|| took / did)
            })
            .collect();
        let known = measured.iter().zip(&self.expected);
        let known: Vec<(f64, f64)> = known
            .filter_map(|(cost, guess)| Some(((*cost)?, *guess)))
            .collect();
        let scale = if known.is_empty() {
            1.0
        } else {
            known.iter().map(|one| one.0).sum::<f64>() / known.iter().map(|one| one.1).sum::<f64>()
        };
        let (mut done, mut all) = (0.0, 0.0);
        for (kind, (measured, expected)) in measured.iter().zip(&self.expected).enumerate() {
            let cost = measured.unwrap_or(scale * expected);
            for part in of_kind(kind) {
                done += cost * part.share;
                all += cost;
            }
        }
        if all > 0.0 {
            self.told = self.told.max((done / all).min(1.0));
        }
        self.told
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
    }

    #[test]
    fn the_share_is_that_of_the_time_and_not_of_the_parts() {
        let began = Instant::now();
        let at = |seconds: u64| began + Duration::from_secs(seconds);
        // Two replicas with a fast and a slow part, estimated to be equal.
        let mut gauge = ProgressEstimate::new(2, &[1.0, 1.0]);
        close(gauge.done_share(), 0.0);
        gauge.record_share(0, 0.0, at(0));
        gauge.record_share(0, 1.0, at(10));
        gauge.record_share(1, 0.0, at(10));
        gauge.record_share(1, 0.1, at(100));
        // 10 s of 10 s, and 90 s of 900 s, twice.
        close(gauge.done_share(), 100.0 / 1820.0);
        gauge.record_share(1, 1.0, at(910));
        close(gauge.done_share(), 0.5);
        gauge.record_share(7, 0.5, at(920));
        gauge.end();
        close(gauge.done_share(), 1.0);
    }

    #[test]
    fn what_was_done_before_is_not_counted_as_quick() {
        let began = Instant::now();
        let mut gauge = ProgressEstimate::new(1, &[2.0, 6.0]);
        // The first resumes from a checkpoint at 90 %; the rest of it takes a second.
        gauge.record_share(0, 0.9, began);
        gauge.record_share(0, 1.0, began + Duration::from_secs(1));
        // The first part takes 10 s in all, so the other, three times as costly, takes 30 s.
        close(gauge.done_share(), 0.25);
        // A fraction that falls is not reported.
        gauge.record_share(0, 0.5, began + Duration::from_secs(2));
        close(gauge.done_share(), 0.25);
    }
}
