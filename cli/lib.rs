//! Facade and command line of stosszahl.
pub mod manifest;
pub mod report;
pub mod tables;
