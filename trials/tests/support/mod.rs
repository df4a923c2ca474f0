//! Gases of unit disks for several tests.

use stosszahl_model::State;
use stosszahl_trials::gas;
pub use stosszahl_trials::gas::EqualDisks;

/// Creates the scene of unit disks with a restitution.
pub fn disks(restitution: f64) -> EqualDisks {
    gas::disks(restitution).expect("a coefficient")
}

/// Creates a disordered Maxwellian gas of unit disks at temperature one in a square box.
pub fn disordered(count: usize, packing_fraction: f64, seed: u64) -> State<EqualDisks> {
    gas::disordered(count, packing_fraction, seed).expect("a gas")
}
