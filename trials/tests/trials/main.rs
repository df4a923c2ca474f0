//! All trials in their short forms. One program for all tests, so that it is linked once and its tests run side by side.

mod bench;
mod calibrate;
mod docs;
mod equilibrium;
mod stress;
#[path = "../support/mod.rs"]
mod support;
mod validation;
mod validator;
