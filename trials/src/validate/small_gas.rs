//! Homogeneously cooling gas of 48 disks for validation, and its theory. Shear modes cannot grow in
//! its small box.

use stosszahl_model::{Constant, equation_of_state};
use stosszahl_theory::{Component, ContactValues, MaxwellianMixture, TheoryError, cooling};

/// Packing fraction of the cooling gas.
pub(super) const PACKING: f64 = 0.25;
/// Coefficient of restitution of the cooling gas.
pub(super) const RESTITUTION: f64 = 0.8;
/// Number of disks of the cooling gas.
pub(super) const DISKS: usize = 48;
/// Elastic collisions per disk before cooling. Random sequential addition is close to equilibrium,
/// and the box is small.
pub(super) const EQUILIBRATE: f64 = 50.0;

/// Returns the fourth cumulant a2 of the homogeneous cooling state by the Boltzmann equation, in
/// six Sonine orders: -0.0262. The simplest formula gives -0.0219.
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

/// Returns Haff's time `t_0` of the cooling gas, in units of the diameter over the initial thermal
/// speed.
pub(super) fn haff_time() -> f64 {
    cooling::haff_time(
        PACKING,
        RESTITUTION,
        equation_of_state::contact_value(PACKING),
    )
}
