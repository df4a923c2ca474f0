//! Speed: benchmarks whose work is defined.

mod event_driven;
mod mixture;
mod monte_carlo;

use std::time::Instant;

use cpu_time::ProcessTime;
use serde_json::Value;

use crate::Trouble;

pub use event_driven::{BenchEd, BenchStart};
pub use mixture::{BenchMixture, Counts, Pick};
pub use monte_carlo::BenchDsmc;

/// What was measured.
#[derive(Clone, Debug)]
pub struct Speed {
    /// In words.
    pub words: String,
    /// Numbers by the names that scripts rely on.
    pub values: Vec<(&'static str, Value)>,
}

impl Speed {
    /// One of the numbers; NaN if there is none of this name.
    pub fn number(&self, name: &str) -> f64 {
        let found = self.values.iter().find(|(key, _)| *key == name);
        found
            .and_then(|(_, value)| value.as_f64())
            .unwrap_or(f64::NAN)
    }

    /// As JSON, in the order in which the numbers are listed, or in words.
    pub fn text(&self, json: bool) -> String {
        if !json {
            return self.words.clone();
        }
        let value = |(name, value): &(&str, Value)| format!("\"{name}\":{value}");
        let values: Vec<_> = self.values.iter().map(value).collect();
        format!("{{{}}}", values.join(","))
    }
}

/// A piece of work for an engine, as asked for on the command line.
pub trait Work {
    /// Makes the start and times the work.
    ///
    /// # Errors
    /// [`Trouble`] if a number is out of range, or the engine cannot go on.
    fn measure(&self) -> Result<Speed, Trouble>;

    /// Whether JSON is asked for.
    fn json(&self) -> bool;
}

/// Does something; its wall and CPU seconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (began, cpu) = (Instant::now(), ProcessTime::now());
    let done = work();
    (
        done,
        began.elapsed().as_secs_f64(),
        cpu.elapsed().as_secs_f64(),
    )
}
