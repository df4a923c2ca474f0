//! What several tests need.

pub mod bad_cases;

use stosszahl::bench;
pub use stosszahl::bench::Disks;
use stosszahl::model::initial::Arrangement;
use stosszahl::model::{Constant, State};

/// The scene of unit disks with the given restitution.
pub fn disks(restitution: f64) -> Disks {
    bench::unit_disks(Constant::new(restitution).expect("a coefficient"))
}

/// A Maxwellian gas of unit disks at temperature one in a square box.
pub fn gas(
    arrangement: Arrangement,
    count: usize,
    packing_fraction: f64,
    seed: u64,
) -> State<Disks> {
    bench::gas(arrangement, count, packing_fraction, 1.0, seed).expect("a gas")
}

/// Mean of independent values and its standard error.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}
