//! Monte Carlo of homogeneous gases: no positions, no cells, and any number of sizes.
//!
//! The Boltzmann equation without gradients, or Enskog's with constant contact values, is a Poisson
//! process of pair collisions: each unordered pair collides at the rate `k(a, b) g`, with its
//! relative speed g and the [`CollisionKernel`] k of its radii. The engine realises that process exactly for
//! N particles: no time step, no cells, and no error but finite N.
//!
//! * **Pairs** are proposed at a rate that bounds theirs and accepted with the quotient
//!   (acceptance-rejection). [`SelectionMethod`] is the interface. [`Bird`] has one majorant; [`LowRank`]
//!   draws from products of weights of size classes by trees (Bodrova & Osinsky 2024); [`AliasTableSelection`], a
//!   method of this crate and the default, has groups of like speed and size in alias tables.
//! * **Time**: the number of proposals up to a time is Poisson, one draw for many thousands of
//!   them; where trajectories are kept, each has its exact time as one of that number of uniform
//!   ones. See [`HomogeneousEngine`].
//! * **Contacts**: the line of centres is drawn with density |g . e|, and the pair bounces by the
//!   scene's law ([`Bounce`]), leaves no trace on one side ([`Tracers`]), or sticks and breaks
//!   ([`Sticking`]).
//! * **Paths**: [`DisplacementRecord`] and [`Trajectories`] are touched at collisions only.
//!
//! Rejected alternatives:
//!
//! * exponential times with a logarithm for each proposal, as in the published codes;
//! * trees over all particles: 350 bytes each, and eleven levels of memory look-ups for each draw;
//! * bounds that follow every collision down as well as up: moves between groups cost more than the
//!   proposals they save.
//!
//! Memory: 32 bytes for a particle and 5 for its slot.

mod alias;
mod bird;
mod checkpoint;
mod classes;
mod clock;
mod contact;
mod engine;
mod error;
mod gas;
mod kernel;
mod layout;
mod low_rank;
mod measure;
mod motion;
mod paths;
mod selection;
mod simulate;
mod slots;
mod sticking;
mod tree;

pub use bird::Bird;
pub use checkpoint::HomogeneousCheckpoint;
pub use clock::{SelectionCounters, StopReason};
pub use contact::{
    Bounce, CollidingParticles, ContactOutcome, ContactRule, Tracers, line_of_centres,
};
pub use engine::HomogeneousEngine;
pub use error::HomogeneousError;
pub use gas::{GasParticle, HomogeneousGas, SmoothPhysics, TagOf};
pub use kernel::{CollisionKernel, PairCorrelationFactor};
pub use low_rank::LowRank;
pub use measure::{SpeciesMoments, moments, moments_by};
pub use motion::{DisplacementRecord, PathRecord};
pub use paths::{Trajectories, time_averaged};
pub use selection::{CandidatePair, ProposalValidity, SelectionMethod};
pub use simulate::{HomogeneousSettings, PairSelection};
pub use slots::AliasTableSelection;
pub use sticking::{
    AggregationLedger, AggregationRule, EnergyLimit, EnergyLoss, Sticking, TestOrder, Threshold,
    shards, size_distribution,
};

/// Version of the statistics of the homogeneous Monte Carlo engine. It increases with each change
/// that moves means beyond their errors (*Results changed* in the changelog), not with changes of
/// rounding. Costly results in the documentation are refused once it has moved.
pub const STATISTICS_VERSION: u32 = 1;
