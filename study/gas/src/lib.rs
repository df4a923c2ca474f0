//! Builder of granular gases and their engines in a few lines, for custom programs.
//!
//! [`Gas`] is built from a description: number of disks, density, dissipation. [`EventDriven`] runs
//! it exactly, [`MonteCarlo`] by Monte Carlo, from one and the same microstate if wished. Both are
//! a [`Simulation`]: they advance to a time and feed observers with collisions. Units: the first
//! diameter, the first mass and the temperature of the start are one unless set otherwise; the time
//! is then in d sqrt(m/T).
//!
//! ```
//! use stosszahl_gas::{EventDriven, Gas, MonteCarlo, Scheme};
//! use stosszahl_model::Simulation;
//!
//! let gas = Gas::disks(500).packing_fraction(0.25).restitution(0.9).seed(1).build()?;
//! let mut exact = EventDriven::new(&gas)?;
//! exact.equilibrate(10.0)?;
//! let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?; // the same microstate
//! exact.advance(5.0, &mut ())?;
//! chaos.advance(5.0, &mut ())?;
//! assert!((exact.temperature() / chaos.temperature() - 1.0).abs() < 0.2);
//! # Ok::<(), stosszahl_gas::GasError>(())
//! ```
//!
//! The crate `stosszahl-study` reads case files, measures and judges, and drives the same engines.

mod builder;
mod engines;
mod memory;
mod reach;

pub use builder::{Gas, GasBuilder};
pub use engines::{EventDriven, MonteCarlo};
pub use stosszahl_dsmc::{Scheme, SchemeSettings};
use stosszahl_model::format_short;
pub use stosszahl_model::walls::{Face, Rebound, Wall};
pub use stosszahl_model::{Law, Rough, Simulation};

/// Error with which a gas cannot be built, or an engine cannot run it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GasError {
    /// A parameter of the gas is out of range.
    #[error(transparent)]
    Invalid(#[from] stosszahl_model::InvalidValue),
    /// Particles cannot be placed without overlap.
    #[error(transparent)]
    Placement(#[from] stosszahl_model::initial::PlacementError),
    /// The faces of the box are an invalid combination.
    #[error(transparent)]
    Walls(#[from] stosszahl_model::walls::WallError),
    /// Exact dynamics cannot start from the gas.
    #[error(transparent)]
    EventDriven(#[from] stosszahl_ed::EventDrivenError),
    /// Monte Carlo in cells cannot start from the gas.
    #[error(transparent)]
    MonteCarlo(#[from] stosszahl_dsmc::DsmcError),
    /// Monte Carlo of a gas without positions cannot start.
    #[error(transparent)]
    Homogeneous(#[from] stosszahl_dsmc::homogeneous::HomogeneousError),
    /// An engine cannot start or continue, as in inelastic collapse.
    #[error(transparent)]
    Failure(#[from] stosszahl_model::Failure),
    /// The gas needs more memory than is available.
    #[error("{particles} particles need {needed:.2} GiB of memory; {free:.2} GiB are free")]
    Memory {
        /// Number of particles of the gas.
        particles: usize,
        /// Memory that the gas needs \[GiB\].
        needed: f64,
        /// Memory that is available \[GiB\].
        free: f64,
    },
    /// The gas cannot be advanced to the requested time.
    #[error("advance to time {} from time {}; allowed: {allowed}", format_short(*until), format_short(*now))]
    Time {
        /// Current time of the gas \[time\].
        now: f64,
        /// Requested time \[time\].
        until: f64,
        /// Description of the allowed times.
        allowed: String,
    },
    /// The gas cannot start from the given particles.
    #[error("the start has {found}; allowed: {allowed}")]
    Start {
        /// Invalid property of the given particles.
        found: String,
        /// Description of the allowed values.
        allowed: &'static str,
    },
    /// The gas or its engine cannot have the requested property.
    #[error("{what}; {instead}")]
    Unfit {
        /// Requested property, in words.
        what: &'static str,
        /// Advice on what to do instead.
        instead: &'static str,
    },
}

#[cfg(test)]
mod tests;
