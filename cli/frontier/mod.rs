//! Speed against error: what `stosszahl frontier` measures around a case, and what it recommends.
//!
//! | module | owns |
//! |---|---|
//! | `setting` | which numerical choices are varied, and in which sequences |
//! | `quantity` | what is measured of a run, and where theory is exact |
//! | `plan` | how a budget is shared out, by counts of work |
//! | `measure` | runs on all cores, each on one thread |
//! | `reference` | the ensemble of exact dynamics, kept on disk |
//! | `front` | bias, noise, cost, and the Pareto front |
//! | `orders` | whether errors fall as theory says |
//! | `recommend` | the cheapest setting for a target, tested on fresh seeds |
//! | `page` | the report |
//!
//! A setting is never measured against itself: the reference is theory where that is exact, and otherwise exact dynamics
//! with seeds of its own. Replicas are not swept, for n of them lower the noise of one by √n and leave its bias.

mod command;
mod front;
mod measure;
mod orders;
mod page;
mod plan;
mod quantity;
mod recommend;
mod reference;
mod setting;

use std::io;
use std::path::PathBuf;

use stosszahl_model::snapshot::SnapshotError;

pub use command::command;
pub use quantity::Kind;
pub use reference::Source;
pub(crate) use setting::resized;

use crate::setup::SetupError;

/// Why a frontier cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrontierError {
    /// An option has no meaning.
    #[error("--{option} {found}: allowed {allowed}")]
    Option {
        /// Which.
        option: &'static str,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The case cannot be swept.
    #[error("{found}; a frontier needs {expected}")]
    Case {
        /// What the case has.
        found: String,
        /// What is needed.
        expected: &'static str,
    },
    /// A system size cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// The kept ensemble is not usable.
    #[error("{0}; remove the file, or name another folder with --cache")]
    Kept(#[source] SnapshotError),
    /// There is no reference.
    #[error("no reference: {reason}")]
    NoReference {
        /// Why.
        reason: String,
    },
    /// A recommendation could not be tested.
    #[error("the recommended setting failed: {reason}")]
    NoTest {
        /// Why.
        reason: String,
    },
    /// There are results already.
    #[error("{} exists and is not empty; use --force to replace its tables, or --out for another folder", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// A folder or file failed.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A table cannot be made.
    #[error("table: {0}")]
    Table(#[from] csv::Error),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] SnapshotError),
}

impl FrontierError {
    /// Whether what was asked for is at fault, and not the system or a run.
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Option { .. }
                | Self::Case { .. }
                | Self::Setup(_)
                | Self::Kept(_)
                | Self::Exists { .. }
        )
    }
}
