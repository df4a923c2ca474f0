//! Monte Carlo of homogeneous gases: no positions, no cells, and any number of sizes.
//!
//! The Boltzmann equation without gradients (or Enskog's, whose contact values are then factors) is
//! a Poisson process of pair collisions: each unordered pair collides at the rate `k(a, b) g`, g
//! its relative speed and k the [`Kernel`] of its radii. The engine realises that process exactly,
//! for N particles: no time step, no cells, and no error but N.
//!
//! * **Pairs** are proposed at a rate that bounds theirs and accepted with the quotient.
//!   [`Selection`] is the interface; [`Bird`] has one majorant, [`LowRank`] draws from products of
//!   weights of size classes by trees (Bodrova & Osinsky 2024), [`Slots`] is our own and the one to
//!   use: groups of like speed and size in alias tables.
//! * **Time**: the number of proposals up to a time is Poisson, one draw for many thousands of
//!   them; where trajectories are kept, each has its exact time as one of that number of uniform
//!   ones. See [`Engine`].
//! * **Contacts**: the line of centres is drawn with density |g . e|, and the pair bounces by the
//!   scene's law ([`Bounce`]), leaves no trace on one side ([`Tracers`]), or sticks and breaks
//!   ([`Sticking`]).
//! * **Paths**: [`Displacement`] and [`Paths`] are touched at collisions only.
//!
//! Rejected alternatives: exponential times with a logarithm for each proposal (as in the published
//! codes); trees over all particles (350 bytes each, and a walk of eleven levels through memory for
//! each draw); bounds that follow every collision down as well as up (the moves between groups cost
//! more than the proposals they save).
//!
//! Memory: 32 bytes for a particle and 5 for its place.

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
mod low_rank;
mod measure;
mod motion;
mod paths;
mod places;
mod selection;
mod simulate;
mod slots;
mod sticking;
mod tree;

pub use bird::Bird;
pub use checkpoint::Checkpoint;
pub use clock::{Stop, Tally};
pub use contact::{Bounce, Contacts, Meeting, Outcome, Tracers, line_of_centres};
pub use engine::Engine;
pub use error::GasError;
pub use gas::{Gas, Grains, Particle, TagOf};
pub use kernel::{Contact, Kernel};
pub use low_rank::LowRank;
pub use measure::{Moments, moments, moments_by};
pub use motion::{Displacement, Motion};
pub use paths::{Paths, time_averaged};
pub use selection::{Candidate, Selection, Standing};
pub use simulate::{Homogeneous, Pick};
pub use slots::Slots;
pub use sticking::{
    Ledger, Limit, Order, Part, Rule, Sticking, Threshold, shards, size_distribution,
};

/// Version of the statistics of this engine: one more with each change that moves means beyond
/// their errors, under *Results changed* in the changelog. Other digits of the same means do not
/// count. Costly results in the documentation are refused once it has moved.
pub const STATISTICS_VERSION: u32 = 1;
