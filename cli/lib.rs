//! Granular gases, exact and by Monte Carlo: the root of the library.
//!
//! [`prelude`] has the items that a custom program needs. The physics lives in the crates that are
//! re-exported here: [`model`] (parts that all engines share), [`ed`] (exact event-driven disks),
//! [`dsmc`] (Monte Carlo collisions) and [`analysis`] (estimators, theory, statistics). [`gas`]
//! builds gases in a few lines, [`case`] reads case files and [`study`] runs them. [`results`] and
//! [`report`] hold the output of a run, and [`reproduction`] reproduces papers. The command line
//! stands on them as any program would.
//!
//! ```
//! use stosszahl::prelude::*;
//!
//! let gas = Gas::disks(200).packing_fraction(0.25).restitution(0.9).seed(1).build()?;
//! let mut exact = EventDriven::new(&gas)?;
//! exact.equilibrate(10.0)?;
//! let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?; // the same microstate
//! let mut impact = ImpactParameters::default();
//! exact.advance(10.0, &mut impact)?;
//! chaos.advance(10.0, &mut ())?;
//! assert!(impact.collisions() > 1000 && exact.temperature() < 1.0);
//! # Ok::<(), GasError>(())
//! ```

// For other commands of this workspace, not for custom programs.
#[doc(hidden)]
pub mod arguments;
#[doc(hidden)]
pub mod commands;
mod error;
mod init;
pub mod prelude;
#[doc(hidden)]
pub mod progress;
mod reference;
mod reproduce;
mod run;
mod terminal;

pub use stosszahl_analysis as analysis;
pub use stosszahl_case as case;
pub use stosszahl_dsmc as dsmc;
pub use stosszahl_ed as ed;
pub use stosszahl_gas as gas;
pub use stosszahl_model as model;
pub use stosszahl_report as report;
pub use stosszahl_reproduce as reproduction;
pub use stosszahl_results as results;
pub use stosszahl_study as study;

/// Cases and papers that come with the program.
static BUNDLE: case::Bundle = case::Bundle({
    static FOLDER: include_dir::Dir<'_> = include_dir::include_dir!("$CARGO_MANIFEST_DIR/cases");
    &FOLDER
});

/// Programs in the book, which are compiled and run as tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/extending.md")]
struct Extending;
