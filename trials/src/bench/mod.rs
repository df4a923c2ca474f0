//! Benchmarks of the engines: collisions per second for a fixed amount of work, on the command
//! line.

mod event_driven;
mod mixture;
mod monte_carlo;

use std::time::Instant;

use cpu_time::ProcessTime;
use serde_json::Value;

use crate::TrialError;

pub use event_driven::BenchEd;
pub use mixture::{BenchMixture, CountRounding, SelectionArgument};
pub use monte_carlo::BenchDsmc;

/// Measured speeds and times of a benchmark, by the names that scripts rely on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Speed(Vec<(&'static str, Value)>);

impl Speed {
    /// Adds a named number or text to the results of a benchmark.
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.0.push((name, value.into()));
        self
    }

    /// Returns the named number of a benchmark's results; NaN without one of this name.
    pub fn number(&self, name: &str) -> f64 {
        let found = self.0.iter().find(|(key, _)| *key == name);
        found
            .and_then(|(_, value)| value.as_f64())
            .unwrap_or(f64::NAN)
    }

    /// Formats the results of a benchmark in their order: as one JSON object, or with a line for
    /// each.
    pub fn text(&self, json: bool) -> String {
        let values = self.0.iter();
        if json {
            let values: Vec<_> = values
                .map(|(name, value)| format!("\"{name}\":{value}"))
                .collect();
            return format!("{{{}}}", values.join(","));
        }
        let line = |(name, value): &(&str, Value)| match value.as_f64() {
            Some(number) if value.is_f64() && !(0.01..1e5).contains(&number) => {
                format!("{name:28} {number:.4e}")
            }
            Some(number) if value.is_f64() => format!("{name:28} {number:.4}"),
            _ => format!("{name:28} {value}"),
        };
        values.map(line).collect::<Vec<_>>().join("\n")
    }
}

/// Benchmark of an engine with its options from the command line.
pub(crate) trait BenchWork {
    /// Creates the start of the benchmark and times its work. Options out of range are an error.
    fn measure_speed(&self) -> Result<Speed, TrialError>;
}

/// Runs a closure and returns its result with its wall and CPU time \[s\].
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (began, cpu) = (Instant::now(), ProcessTime::now());
    let done = work();
    (
        done,
        began.elapsed().as_secs_f64(),
        cpu.elapsed().as_secs_f64(),
    )
}
