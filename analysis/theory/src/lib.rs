//! Kinetic theory of homogeneous gases and simple flows: curves against which simulations are
//! tested.
//!
//! | module | question |
//! |---|---|
//! | [`cooling`] | how does a uniform gas cool, and its velocity distribution with it? |
//! | [`diffusion`] | how far do its particles get? |
//! | [`transport`] | how viscous is it, and from which size of the box on do waves of shear grow? |
//! | [`mixture`] | how do the species of a mixture cool, and how far do they get? |
//! | [`sonine`] | and if their velocities are not Maxwellian? |
//! | [`cooling_state`] | which temperature ratios does cooling lead to, and what follows in closed form? |
//! | [`cooling_factors`] | by how much do these velocities change the rates of a gas that cools? |
//! | [`contact`] | how does density raise collision rates? |
//! | [`barometric`] | in which equilibrium does a gas settle that falls to the floor of its box? |
//! | [`elastic_disks`] | how does a fluid of elastic disks carry momentum and heat? |
//! | [`rough`] | how do rough particles share and lose their energy? |
//! | [`bath`] | in which steady state do white noise and drag keep a gas? |
//! | [`delta_model`] | at which temperature do contacts heat as much as they dissipate? |
//! | [`three_disks`] | what do three disks add to theory, to first order in density? |
//! | [`uniform_shear`] | which temperature and stress does a dilute gas reach in a shear flow? |
//! | [`integrate`] | an adaptive integrator with control of its error |
//!
//! All of it but [`sonine`] and [`cooling_factors`] takes velocities for Maxwellian (first Sonine
//! order); how far a gas is from that is measured by its fourth cumulant.

pub mod barometric;
pub mod bath;
mod component;
pub mod contact;
pub mod cooling;
pub mod cooling_factors;
pub mod cooling_state;
pub mod delta_model;
pub mod diffusion;
pub mod elastic_disks;
mod error;
pub mod integrate;
pub mod mixture;
pub mod rough;
pub mod sonine;
pub mod three_disks;
pub mod transport;
pub mod uniform_shear;

pub use barometric::{BarometricColumn, Layer};
pub use bath::BathState;
pub use component::Component;
pub use contact::ContactValues;
pub use cooling_factors::CoolingFactors;
pub use cooling_state::CoolingState;
pub use elastic_disks::ElasticDisks;
pub use error::TheoryError;
pub use mixture::{MaxwellianMixture, Moment, SpeciesRates};
pub use rough::{RoughGas, Temperatures};
pub use uniform_shear::UniformShear;

#[cfg(test)]
mod tests;
