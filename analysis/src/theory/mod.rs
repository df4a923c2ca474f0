//! What kinetic theory says of homogeneous gases: curves that simulations are measured against.
//!
//! | module | question |
//! |---|---|
//! | [`mixture`] | how do the species of a mixture cool, and how far do they get? |
//! | [`sonine`] | and if their velocities are not Maxwellian? |
//! | [`cooling_state`] | which temperature ratios does cooling lead to, and what follows in closed form? |
//! | [`contact`] | how does density raise collision rates? |
//! | [`barometric`] | what becomes of a gas that falls to the floor of its box? |
//! | [`elastic_disks`] | how does a fluid of elastic disks carry momentum and heat? |
//! | [`rough`] | how do grains that turn each other share and lose their energy? |
//! | [`integrate`] | an adaptive integrator with control of its error |
//!
//! All of it but [`sonine`] takes velocities for Maxwellian (first Sonine order); how far a gas is from that is measured by its
//! fourth cumulant.

use stosszahl_model::Invalid;

pub mod barometric;
pub mod contact;
pub mod cooling_state;
pub mod elastic_disks;
pub mod integrate;
pub mod mixture;
pub mod rough;
pub mod sonine;

pub use barometric::{Column, Layer};
pub use contact::Contact;
pub use cooling_state::CoolingState;
pub use elastic_disks::ElasticDisks;
pub use mixture::{Component, Mixture, Moment, Rates};
pub use rough::{RoughGas, Temperatures};

/// Why a curve cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TheoryError {
    /// A number out of range.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The integration cannot go on.
    #[error(
        "the integration stopped at {at} with steps of {step}: the solution is not smooth there"
    )]
    Integration {
        /// Where.
        at: f64,
        /// Last step tried.
        step: f64,
    },
}

#[cfg(test)]
mod tests;
