//! Measurements on granular gases, their uncertainty, and verdicts.
//!
//! A simulation ends in numbers; this crate says what they mean and how far they can be trusted.
//!
//! | module | question | algorithm | cost |
//! |---|---|---|---|
//! | [`energy`] | how fast does the gas cool, how Maxwellian is it, what is its pressure? | moments, virial | O(N) a sample |
//! | [`flow`] | how do species flow, and what do they have beside that? | sums | O(N) a sample |
//! | [`velocities`] | how are velocities distributed, how fat are the tails? | histograms, cumulants | O(N) a sample |
//! | [`windows`] | which impact parameters, which collision rate? | histograms in windows of time | O(1) a collision |
//! | [`contacts`] | do colliding partners know each other, or share a flow? | local temperature, shuffled partners | O(1) a collision, O(N) a sample |
//! | [`equilibrium`] | is the start forgotten? | direct sums at chosen wave vectors | O(N modes) |
//! | [`compare`] | do two engines differ, when, which way? | tests of equivalence, simultaneous intervals | O(values) |
//! | [`structure_factor`] | at which wavelengths does the density fluctuate? | points assigned to a lattice, fast Fourier transform, average over shells | O(N + M² log M) |
//! | [`pair_correlation`] | how are neighbours arranged around a disk? | cell lists, histogram of distances | O(N) at a fixed range |
//! | [`helfand`] | how does an elastic gas carry momentum and heat, and how fast do its disks spread? | Einstein-Helfand moments | O(1) a collision |
//! | [`stress`] | which momentum do particles carry, and which collisions? | sums, virial of contacts | O(1) a collision, O(N) a sample |
//! | [`modes`] | is the noise right, do shear waves grow or decay? | sums over chosen Fourier modes | O(N modes) |
//! | [`spectra`] | how strongly do density, flow and temperature fluctuate at each wavelength? | the same, by shells | O(N modes) |
//! | [`relaxation`] | at which rate does an amplitude grow or decay? | regression on the time before, jackknife | O(values) |
//! | [`replicas`] | what do few replicas leave open, and how many does it take? | jackknife, Student, Hotelling, power | O(values) |
//! | [`fields`] | where is a flow dense, fast, hot? | sums over cells, batch means | O(N) a sample |
//! | [`steady`] | from when on is it steady? | marginal standard error rule | O(values) |
//! | [`accuracy`] | how far is one run from the truth, and how many does a target take? | means, Student and chi-squared intervals | O(values) |
//! | [`fit`] | which limit, which slope, which order? | weighted least squares | O(values) |
//! | [`statistics`] | is the difference real? | Student, chi-squared and Holm tests | O(values) |
//!
//! Positions are a slice of planar vectors, the periodic box is its two side lengths. Positions may
//! lie anywhere: every measurement takes them modulo the box.
//!
//! Errors are one enum for the crate, [`Error`], whose fields say what was found, where, and what
//! is allowed. Measurements never draw random numbers and sum in a fixed order, so the same input
//! gives the same bytes. Those of a whole gas are sums that several processes can make together
//! ([`stosszahl_model::sum`]).
//!
//! Every fast path has its slow, obvious counterpart. For the structure factor that is public, as
//! [`structure_factor::direct_sum`], because it is also the better choice for a handful of wave
//! vectors: it has neither window nor aliasing. The all-pairs count that checks the cell lists is
//! in the tests.

pub mod accuracy;
pub mod compare;
pub mod contact_value;
pub mod contacts;
pub mod energy;
pub mod equilibrium;
mod error;
pub mod fields;
pub mod fit;
pub mod flow;
pub mod helfand;
pub mod impact;
pub mod modes;
pub mod pair_correlation;
pub mod relaxation;
pub mod replicas;
pub mod spectra;
pub mod statistics;
pub mod steady;
pub mod stress;
pub mod structure_factor;
pub mod time_average;
pub mod velocities;
pub mod windows;

pub use error::Error;
