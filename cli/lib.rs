//! Root of the library: granular gases, by exact event-driven dynamics and by Monte Carlo.
//!
//! [`prelude`] has the items that a custom program needs. The physics lives in the crates that are
//! re-exported here: [`model`] (parts that all engines share), [`ed`] (exact event-driven disks),
//! [`dsmc`] (Monte Carlo collisions), [`analysis`] (estimators, statistics) and [`theory`] (kinetic
//! theory). [`gas`] builds gases in a few lines, [`case`] reads case files and [`study`] runs them. [`results`] and
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
//!
//! # Features
//!
//! A custom program sets `default-features = false` and names the features that it needs:
//!
//! | feature | adds |
//! |---|---|
//! | none | [`gas`], [`model`], [`ed`], [`dsmc`], [`analysis`], [`theory`] |
//! | `rough` | particles that spin |
//! | `shear` | uniform shear flow of exact disks, in [`ed::simulate`] |
//! | `spheres` | spheres in a box, in [`dsmc::simulate`] |
//! | `aggregation` | particles that stick and break, in [`dsmc::homogeneous`] |
//! | `cases` | [`case`], [`study`], [`results`]; all gases |
//! | `report` | [`report`], [`reproduction`]; `cases` |
//! | `parquet` | `Table::to_parquet` of [`results`], and `--tables parquet` of the program; `cases` |
//! | `cli` (the default) | the program `stosszahl`; `report` |
//!
//! Each of the features `rough`, `shear`, `spheres` and `aggregation` is a quarter to a half of the
//! engines that its crate compiles. A gas that needs an absent feature is refused with its name.
//! `docs/extending.md` has the cost of each feature, and profile lines for a manifest.

#[cfg(feature = "cli")]
mod arguments;
#[cfg(feature = "cli")]
pub mod command_line;
#[cfg(feature = "cli")]
mod commands;
#[cfg(feature = "cli")]
mod error;
#[cfg(feature = "cli")]
mod figure;
#[cfg(feature = "cli")]
mod init;
pub mod prelude;
#[cfg(feature = "cli")]
mod progress;
#[cfg(feature = "cli")]
mod reference;
#[cfg(feature = "cli")]
mod reproduce;
#[cfg(feature = "cli")]
mod run;
#[cfg(feature = "cli")]
mod tables;
#[cfg(feature = "cli")]
mod terminal;

pub use stosszahl_analysis as analysis;
#[cfg(feature = "cases")]
pub use stosszahl_case as case;
pub use stosszahl_dsmc as dsmc;
pub use stosszahl_ed as ed;
pub use stosszahl_gas as gas;
pub use stosszahl_model as model;
#[cfg(feature = "report")]
pub use stosszahl_report as report;
#[cfg(feature = "report")]
pub use stosszahl_reproduce as reproduction;
#[cfg(feature = "cases")]
pub use stosszahl_results as results;
#[cfg(feature = "cases")]
pub use stosszahl_study as study;
pub use stosszahl_theory as theory;

/// Cases and papers that are built into the program.
#[cfg(feature = "cli")]
static BUNDLE: case::CaseBundle = case::CaseBundle({
    static FOLDER: include_dir::Dir<'_> = include_dir::include_dir!("$CARGO_MANIFEST_DIR/cases");
    &FOLDER
});

/// Programs of the documentation page on extending, compiled and run as tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/extending.md")]
struct Extending;
