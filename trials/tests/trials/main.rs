//! All trials in their short forms, linked into one program so that they run side by side.

mod bench;
mod calibrate;
mod docs;
mod equilibrium;
mod stress;
mod validation;
mod validator;
