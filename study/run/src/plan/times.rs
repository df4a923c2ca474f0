//! Sample times of a run and its time blocks: defaults, choices and checks.

use super::data::{CasePlan, PlanError};

/// Largest number of sample times of a run.
const MOST_SAMPLES: f64 = 1e6;
/// Default number of samples per factor of ten in time.
const PER_DECADE: u64 = 12;
/// Default number of samples at equal intervals, for a gas with walls, obstacles or gravity.
const EQUAL_SAMPLES: u64 = 400;

/// Default number of time blocks for averages and their errors, if the number of samples allows it.
const BLOCKS: u64 = 40;
/// Smallest default number of time blocks for averages.
const FEWEST_BLOCKS: u64 = 10;
/// Largest default number of time blocks for averages.
const MOST_BLOCKS: u64 = 160;

/// Returns the number of time blocks with equal numbers of samples whose ratio to 40 is nearest to
/// one; `None` if none from 10 to 160 divides the samples. Fewer than 10 samples are a block each.
fn blocks_of(samples: u64) -> Option<u64> {
    let fewest = FEWEST_BLOCKS.min(samples).max(1);
    let fits = |blocks: &u64| samples.is_multiple_of(*blocks);
    let off = |blocks: u64| (blocks as f64 / BLOCKS as f64).ln().abs();
    (fewest..=MOST_BLOCKS)
        .filter(fits)
        .min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// Returns times in equal factors from the first time on, and last exactly the end. A time that
/// almost coincides with the end is left out.
pub fn logarithmic(first: f64, until: f64, per_decade: u64) -> impl Iterator<Item = f64> {
    (0..)
        .map(move |i| first * 10_f64.powf(f64::from(i) / per_decade as f64))
        .take_while(move |&time| time < until * (1.0 - 1e-9))
        .chain(std::iter::once(until))
}

impl CasePlan {
    /// Returns the number of samples at equal intervals; `None` if samples are in equal factors of
    /// time.
    pub fn equal_samples(&self) -> Option<u64> {
        let run = &self.case.run;
        let is_settling =
            !self.is_uniform() && run.first_sample.is_none() && run.samples_per_decade.is_none();
        run.samples.or(is_settling.then_some(EQUAL_SAMPLES))
    }

    /// Returns the time of the first sample after the start, for samples in equal factors of time.
    pub fn first_sample(&self) -> f64 {
        let run = &self.case.run;
        run.first_sample.unwrap_or(run.until / 1000.0)
    }

    /// Returns the number of samples per factor of ten in time.
    pub fn samples_per_decade(&self) -> u64 {
        self.case.run.samples_per_decade.unwrap_or(PER_DECADE)
    }

    /// Returns the sample times in the unit of time of the case: 0, then at equal intervals or in
    /// equal factors, and last exactly the end of the run.
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

    /// Returns the default number of time blocks for measures of flows.
    pub fn default_blocks(&self) -> u64 {
        self.equal_samples().and_then(blocks_of).unwrap_or(BLOCKS)
    }

    /// Chooses the number of time blocks, and adds a note if it is not 40.
    pub(super) fn choose_blocks(&mut self) -> Result<(), PlanError> {
        let measures = &self.case.measure;
        let is_written = |name: &str| {
            let table = measures.get(name);
            table.is_some_and(|table| table.contains_key("blocks"))
        };
        let asked = ["fields", "boundaries"]
            .iter()
            .any(|name| measures.contains_key(*name));
        let needed = (!self.is_uniform() || asked) && !is_written("fields");
        let (Some(samples), true) = (self.equal_samples(), needed) else {
            return Ok(());
        };
        let Some(blocks) = blocks_of(samples) else {
            let near = samples.div_ceil(BLOCKS) * BLOCKS;
            let allowed = format!(
                "a number of samples that falls into {FEWEST_BLOCKS} to {MOST_BLOCKS} blocks of equal numbers, such as {near}; \
                 measure.fields.blocks chooses any other number of blocks that divides it"
            );
            return Err(PlanError::new("run.samples", "", allowed));
        };
        if blocks != BLOCKS {
            self.notes.choices.push(format!(
                "measure.fields.blocks = {blocks}: the number nearest to {BLOCKS} that divides run.samples = {samples}"
            ));
        }
        Ok(())
    }

    pub(super) fn check_times(&self) -> Result<(), PlanError> {
        let until = self.case.run.until;
        let good = (until * self.clock.time).is_finite();
        PlanError::require(good, "run.until", until, "a finite time above 0")?;
        let (first, each) = (self.first_sample(), self.samples_per_decade());
        let few = (until / first).log10() * each as f64 <= MOST_SAMPLES;
        let allowed = "from 1 to so few that there are at most 1000000 samples";
        PlanError::require(
            few || self.equal_samples().is_some(),
            "run.samples_per_decade",
            each,
            allowed,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks are those found by all divisors of a number of samples, in the plain way.
    #[test]
    fn blocks_divide_the_samples() {
        for samples in 1..=2000_u64 {
            let divisors = (1..=samples).filter(|blocks| samples % blocks == 0);
            let wanted = divisors.filter(|blocks| (10..=160).contains(blocks) || samples < 10);
            let near = |blocks: u64| (blocks as f64 / 40.0).max(40.0 / blocks as f64);
            let plain = wanted.min_by(|&a, &b| near(a).total_cmp(&near(b)));
            assert_eq!(blocks_of(samples), plain, "{samples}");
        }
        let samples = [400, 100, 50, 60, 75, 90, 150, 250, 300, 500, 7, 326];
        let blocks = samples.map(blocks_of);
        let known = [40, 50, 50, 30, 25, 45, 50, 50, 50, 50, 7].map(Some);
        assert_eq!(blocks[..11], known);
        assert_eq!(blocks[11], None);
    }
}
