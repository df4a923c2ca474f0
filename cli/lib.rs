//! Facade and command line of stosszahl.

pub mod case;
