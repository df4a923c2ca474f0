//! Command line as functions, for a program with the options and messages of `stosszahl` and another
//! way to run a case.
//!
//! `main` of such a program calls [`outlive_file_limits`], parses [`Arguments`] or options of its
//! own around [`RunArguments`], and ends with the exit code of [`execute`] or [`ended`].

pub use crate::arguments::{Arguments, CaseArguments, RunArguments, VERSION};
pub use crate::commands::{ended, execute, read, tell};
pub use crate::error::CommandError;
pub use crate::progress::Display;
pub use crate::run::{STOPPED_RUN, run};
pub use crate::terminal::{TimeLimit, listen, note, outlive_file_limits};
