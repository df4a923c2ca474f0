//! Gas of 48 disks that cools homogeneously, and theory of it: shear modes cannot grow in its box.

use stosszahl_model::{Constant, kinetic};
use stosszahl_theory::{Component, ContactValues, MaxwellianMixture, TheoryError};

/// Packing fraction of the gas.
pub(super) const PACKING: f64 = 0.25;
/// Coefficient of restitution.
pub(super) const RESTITUTION: f64 = 0.8;
/// Number of disks.
pub(super) const DISKS: usize = 48;
/// Number of elastic collisions of each disk before: RSA is close to equilibrium, and the box is
/// small.
pub(super) const EQUILIBRATE: f64 = 50.0;

/// a2 of the homogeneous cooling state of the Boltzmann equation at this restitution, in six Sonine
/// orders: -0.0262, where the simplest formula has -0.0219.
pub(super) fn cumulant() -> Result<f64, TheoryError> {
    let disk = Component {
        mass: 1.0,
        diameter: 1.0,
        density: 1.0,
    };
    let law = Constant::new(RESTITUTION)?;
    let gas = MaxwellianMixture::new(2, vec![disk], law, ContactValues::Dilute)?;
    // Time of some thirty collisions per particle.
    let found = gas.expand(6, &[1.0], &[100.0])?;
    Ok(found[0].fourth_cumulants[0])
}

/// Haff's time of the gas.
pub(super) fn haff_time() -> f64 {
    kinetic::haff_time(PACKING, RESTITUTION, kinetic::contact_value(PACKING))
}
