//! `stosszahl validate`: everything that this program claims about accuracy, as one table of claims.
//!
//! A part is left out only by name or when the time is up, and both are said. Rows are told as they come and the table is
//! written after each part, so that a run that is stopped leaves what it had. The end is `pass` only if every claim of every
//! part passed.

mod command;
pub mod exact;
mod literature;
mod spheres;
pub mod subject;
mod suites;

pub use command::command;

use super::schemes::METHODS;
use super::table::Row;
use super::{Effort, Part, Trouble};
use subject::{ContactPoint, Exact, Work, claims};

/// A part of the whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Chapter {
    /// Printed numbers.
    Literature,
    /// Conservation, reversal, equation of state and structure of exact dynamics.
    Exact,
    /// Both engines against kinetic theory: an elastic gas and a cooling one.
    Engines,
    /// Gases without positions: cooling in two and three dimensions, a published mixture.
    Homogeneous,
    /// The default Monte Carlo scheme in all that it claims of cooling; without --quick also its elastic gas.
    MonteCarlo,
    /// The hard cases of all engines.
    Stress,
}

impl Chapter {
    /// All of them, the quickest first.
    pub const ALL: [Self; 6] = [
        Self::Literature,
        Self::Exact,
        Self::Engines,
        Self::Homogeneous,
        Self::Stress,
        Self::MonteCarlo,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Literature => "literature",
            Self::Exact => "exact",
            Self::Engines => "engines",
            Self::Homogeneous => "homogeneous",
            Self::MonteCarlo => "monte-carlo",
            Self::Stress => "stress",
        }
    }

    /// Whether it is so much work that every claim is resolved.
    pub fn resolves(self) -> bool {
        self != Self::MonteCarlo
    }

    /// Measures what the part claims; each row is told as soon as it is known.
    ///
    /// # Errors
    /// [`Trouble`] if a gas cannot be made or measured.
    pub fn run(self, quick: bool, say: &(dyn Fn(&Row) + Sync)) -> Result<Vec<Row>, Trouble> {
        let mut rows = Vec::new();
        let mut add = |more: Vec<Row>| {
            more.iter().for_each(say);
            rows.extend(more);
        };
        match self {
            Self::Literature => add(literature::all()),
            Self::Exact => {
                add(exact::mechanics(quick)?);
                add(exact::state(quick)?);
                add(exact::structure(quick)?);
            }
            Self::Engines => {
                let (few, many) = if quick { (1, 1) } else { (4, 4) };
                // So many seeds that every error is below half of its tolerance.
                let exact = Work {
                    elastic: (1000, 40 * few),
                    cooling: (400, 1000 * few),
                };
                add(claims(&Exact, exact)?);
                let simulated = Work {
                    elastic: (1000, 8 * many),
                    cooling: (400, 32 * many),
                };
                add(claims(&ContactPoint { copies: None }, simulated)?);
            }
            Self::Homogeneous => {
                add(spheres::haff(quick)?);
                add(spheres::published_mixture()?);
            }
            Self::MonteCarlo => {
                let default: Vec<_> = METHODS.iter().filter(|m| m.default).copied().collect();
                // Rows are told by the parts themselves.
                let effort = Effort { quick };
                rows.extend(Part::Cooling.run(effort, &default, say)?);
                if !quick {
                    rows.extend(Part::Elastic.run(effort, &default, say)?);
                    rows.extend(Part::Unstable.run(effort, &default, say)?);
                }
            }
            Self::Stress => rows.extend(suites::all(&|row| say(row))),
        }
        Ok(rows)
    }
}
