//! The event-driven engine. One program for all tests, so that each instance of the engine is
//! compiled once.

mod gravity;
mod legs;
mod obstacles;
mod plain;
mod properties;
mod rough;
mod shear;
mod strips;
mod support;
mod walls;
mod wide;
