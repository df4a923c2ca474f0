//! Facade and command line of stosszahl.

pub mod case;
pub mod dispatch;
pub mod manifest;
pub mod progress;
pub mod run;
pub mod setup;
pub mod tables;
