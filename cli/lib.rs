//! Facade and command line of stosszahl.
