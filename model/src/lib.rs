//! Physical model that both engines of stosszahl share: collision law, sizes, box, walls, initial
//! states, random streams and the equation of state.
//!
//! The event-driven and the Monte Carlo engine must agree on everything but the one question under
//! study: *which particles collide, and with which impact parameter*. So this crate holds, once,
//! the collision law ([`collision`]), the sizes ([`sizes`]), the box ([`domain`]), its images
//! ([`images`]) and its walls ([`walls`]). It also holds the initial states ([`initial`]), the
//! thermal bath ([`bath`]), the random streams ([`random`]), the snapshot format ([`snapshot`]), the
//! equation of state ([`equation_of_state`]) and hints about [`memory`].
//!
//! # How choices become types
//!
//! Each choice that changes what is stored per particle, or the arithmetic of each candidate pair,
//! is one small trait ([`Space`], [`Surface`], [`Restitution`], [`Sizes`], [`Field`]); one struct,
//! [`Scene`], bundles them, and engines name the single bound [`ParticleModel`]. Code therefore grows
//! with the sum of the options. Two alternatives lost: a feature flag for the dimension marks every
//! line that touches a vector, and an enum around generic parts is decided again at every
//! collision.
//!
//! # Units
//!
//! Engines are dimensionless. The command line scales a case so that the mean diameter, the mean
//! mass and the initial temperature are one; nothing here relies on it except where a comment says
//! so.

pub mod bath;
mod bytes;
pub mod clusters;
pub mod colliding_pair;
pub mod collision;
pub mod domain;
pub mod equation_of_state;
pub mod exact;
pub mod field;
mod format_short;
pub mod grains;
pub mod gsd;
pub mod images;
pub mod initial;
pub mod interrupt;
pub mod invalid;
pub mod memory;
mod message_units;
pub mod observer;
pub mod particle;
pub mod physics;
pub mod random;
mod recent_contacts;
pub mod restitution;
pub mod samples;
pub mod shear_work;
pub mod simulation;
pub mod sizes;
pub mod snapshot;
pub mod space;
pub mod species;
pub mod state;
pub mod sum;
pub mod surface;
pub mod threads;
pub mod walls;

pub use bath::Bath;
pub use bytes::to_bytes;
pub use clusters::Clusters;
pub use colliding_pair::{CollidingPair, PostCollision};
pub use collision::{Collision, bounce, collide};
pub use domain::Domain;
pub use exact::ExactSum;
pub use field::{Field, Free, Gravity, Sheared};
pub use format_short::format_short;
pub use grains::{ParticleSpec, SizeDistribution};
pub use images::{Image, Images, Shear};
pub use interrupt::Interrupt;
pub use invalid::InvalidValue;
pub use message_units::MessageUnits;
pub use observer::{EachCollision, Observer, Recorder};
pub use particle::Particle;
pub use physics::{ParticleModel, Scene, SpinOf, VectorOf};
pub use recent_contacts::RecentContacts;
pub use restitution::*;
pub use shear_work::ShearWork;
pub use simulation::{
    BoundaryFlux, Budget, Census, Failure, Particles, Simulation, VelocityMoments, WorkCounters,
};
pub use sizes::{Monodisperse, Polydisperse, Sizes};
pub use space::{Plane, Space, Vector, Volume};
pub use species::{Grouping, Species, SpeciesProperties};
pub use state::{ParticleState, State};
pub use sum::{DynReduction, ParticleReduction};
pub use surface::{Rough, Smooth, Surface};
pub use walls::{Face, Rebound, Wall, Walls};
