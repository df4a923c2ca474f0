//! When a run looks, and whether that has a meaning.

use stosszahl_case::Kind;

use super::data::{Plan, PlanError};

/// Most samples of a run.
const MOST_SAMPLES: f64 = 1e6;
/// Samples in each factor of ten, and in a flow.
const PER_DECADE: u64 = 12;
const SAMPLES_OF_FLOW: u64 = 400;

/// A grid in equal factors from the first time on, and last the end exactly; a point that all but coincides with the end is
/// left out.
pub fn logarithmic(first: f64, until: f64, per_decade: u64) -> impl Iterator<Item = f64> {
    (0..)
        .map(move |i| first * 10_f64.powf(f64::from(i) / per_decade as f64))
        .take_while(move |&time| time < until * (1.0 - 1e-9))
        .chain(std::iter::once(until))
}

impl Plan {
    /// Number of samples at equal intervals, where they are.
    pub fn equal_samples(&self) -> Option<u64> {
        let run = &self.case.run;
        let flow = self.kind == Kind::Flow
            && run.first_sample.is_none()
            && run.samples_per_decade.is_none();
        run.samples.or(flow.then_some(SAMPLES_OF_FLOW))
    }

    /// First sample after the start, with samples in equal factors of time.
    pub fn first_sample(&self) -> f64 {
        let run = &self.case.run;
        run.first_sample.unwrap_or(run.until / 1000.0)
    }

    /// Samples in each factor of ten of time.
    pub fn samples_per_decade(&self) -> u64 {
        self.case.run.samples_per_decade.unwrap_or(PER_DECADE)
    }

    /// Times of the samples, in the unit of time of the case: 0, then at equal intervals or in equal factors, and last the end
    /// of the run exactly.
    pub fn sample_times(&self) -> Vec<f64> {
        let until = self.case.run.until;
        if let Some(samples) = self.equal_samples() {
            return (0..=samples)
                .map(|sample| until * (sample as f64 / samples as f64))
                .collect();
        }
        let grid = logarithmic(self.first_sample(), until, self.samples_per_decade());
        std::iter::once(0.0).chain(grid).collect()
    }

    pub(super) fn check_times(&self) -> Result<(), PlanError> {
        let until = self.case.run.until;
        let good = (until * self.time).is_finite();
        PlanError::unless(good, "run.until", until, "a finite time above 0")?;
        let (first, each) = (self.first_sample(), self.samples_per_decade());
        let few = (until / first).log10() * each as f64 <= MOST_SAMPLES;
        let allowed = "from 1 to so few that there are at most 1000000 samples";
        PlanError::unless(
            few || self.equal_samples().is_some(),
            "run.samples_per_decade",
            each,
            allowed,
        )
    }
}
