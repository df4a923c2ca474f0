//! What `stosszahl validate dsmc` measures: the Monte Carlo schemes against kinetic theory and against exact dynamics,
//! over replicas, with error bars and verdicts.
//!
//! | part | question |
//! |---|---|
//! | `elastic` | are rate, pressure, transport, noise and structure of an elastic gas those of Enskog's theory? |
//! | `cooling` | does a gas too small for shear modes cool as Haff's law says? |
//! | `unstable` | do shear modes of a large one grow as linear theory and exact dynamics say? |
//! | `convergence` | what is left at vanishing simulator weight, cell size and step, and of which order are the errors? |
//!
//! The schemes and their claims are data, [`schemes::METHODS`]. A claim passes if the value is within its tolerance and
//! its standard error at most half of that; it is unresolved if the error is wider. Starts and streams are addressed by
//! fixed seeds, so the table is the same in every run, whatever the number of threads.

mod command;
mod convergence;
mod cooling;
mod elastic;
mod gas;
pub mod schemes;
pub mod table;
mod unstable;
pub mod whole;

use std::ops::Range;

use rayon::prelude::*;

pub use command::{ValidateError, command};
use schemes::Method;
use table::Row;

/// A part of the validation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Elastic gases at four packings.
    Elastic,
    /// Homogeneous cooling.
    Cooling,
    /// Growth of shear modes.
    Unstable,
    /// Weight, cell and step to zero.
    Convergence,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Elastic,
        Self::Cooling,
        Self::Unstable,
        Self::Convergence,
    ];

    /// Measures the schemes; each row is said as soon as it is known.
    ///
    /// # Errors
    /// [`Trouble`] if a gas cannot be made or measured.
    pub fn run(
        self,
        effort: Effort,
        methods: &[Method],
        say: &(dyn Fn(&Row) + Sync),
    ) -> Result<Vec<Row>, Trouble> {
        match self {
            Self::Elastic => elastic::run(effort, methods, say),
            Self::Cooling => cooling::run(effort, methods, say),
            Self::Unstable => unstable::run(effort, methods, say),
            Self::Convergence => convergence::run(effort, methods, say),
        }
    }
}

/// How much work is put in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// A minute instead of an hour: few and small gases, whose errors are too wide for most verdicts.
    pub quick: bool,
}

/// Does something for each of some seeds in parallel; results are in their order.
fn over_seeds<T: Send>(
    seeds: Range<u64>,
    job: impl Fn(u64) -> Result<T, Trouble> + Sync + Send,
) -> Result<Vec<T>, Trouble> {
    seeds.into_par_iter().map(job).collect()
}

/// What keeps a gas from being made or measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// A start could not be made.
    #[error("no start: {0}")]
    Start(#[from] crate::bench::BenchError),
    /// Exact dynamics could not go on.
    #[error(transparent)]
    Exact(#[from] stosszahl_ed::EngineError),
    /// The Monte Carlo engine refused.
    #[error(transparent)]
    MonteCarlo(#[from] stosszahl_dsmc::EngineError),
    /// A measurement refused.
    #[error(transparent)]
    Measure(#[from] stosszahl_analysis::Error),
    /// A gas without positions refused.
    #[error(transparent)]
    Homogeneous(#[from] stosszahl_dsmc::homogeneous::GasError),
    /// Theory of a mixture has no answer.
    #[error(transparent)]
    Theory(#[from] stosszahl_analysis::theory::TheoryError),
    /// A restitution that is none.
    #[error("restitution {0}; allowed is from 0 to 1")]
    Restitution(f64),
    /// Nothing to average.
    #[error("no replicas")]
    NoReplicas,
}
