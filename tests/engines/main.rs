//! Tests of both engines. One program for all tests, so that each instance of an engine is compiled
//! once.

mod checkpoints;
#[path = "../support/damage.rs"]
mod damage;
mod displacement;
#[path = "../support/draws.rs"]
mod draws;
mod event_driven;
mod monte_carlo;
mod properties;
mod support;
