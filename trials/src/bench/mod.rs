//! Speed: benchmarks whose work is defined.

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

/// Measured numbers, by the names that scripts rely on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Speed(Vec<(&'static str, Value)>);

impl Speed {
    /// Adds a number, or a word.
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.0.push((name, value.into()));
        self
    }

    /// Returns one of the numbers; NaN if there is none of this name.
    pub fn number(&self, name: &str) -> f64 {
        let found = self.0.iter().find(|(key, _)| *key == name);
        found
            .and_then(|(_, value)| value.as_f64())
            .unwrap_or(f64::NAN)
    }

    /// Formats the numbers in the order in which they are listed: one JSON object, or a line for
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

/// Piece of work for an engine, as requested on the command line.
pub(crate) trait BenchWork {
    /// Makes the start and times the work; refuses numbers out of range.
    fn measure_speed(&self) -> Result<Speed, TrialError>;
}

/// Runs some work; returns its result, and its wall and CPU seconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (began, cpu) = (Instant::now(), ProcessTime::now());
    let done = work();
    (
        done,
        began.elapsed().as_secs_f64(),
        cpu.elapsed().as_secs_f64(),
    )
}
