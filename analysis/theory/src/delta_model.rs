//! Steady temperature of the Delta model under molecular chaos, from the energy balance of
//! Maxwellian velocities.

use std::f64::consts::PI;

/// Computes the temperature `T/(m Delta^2)` at which contacts dissipate and add equal energy, for
/// Maxwellian velocities in any dimension at any density. `None` at r = 1, where the gas heats for
/// ever.
///
/// With x = sqrt(T/m)/Delta the balance is `(1 - r^2) x^2 - r sqrt(pi) x - 1 = 0` (R. Brito, D.
/// Risso & R. Soto, *Physical Review E* **87**, 022209 (2013), doi:10.1103/PhysRevE.87.022209). The
/// velocities of the steady state have fewer fast particles than a Maxwellian, which raises T by 1
/// to 3 % for r from 0.95 to 0.7.
///
/// ```
/// use stosszahl_theory::delta_model::maxwellian_temperature;
/// let found = maxwellian_temperature(0.9).expect("a steady state");
/// assert!((found - 80.67).abs() < 5e-3);
/// assert_eq!(maxwellian_temperature(1.0), None);
/// ```
pub fn maxwellian_temperature(coefficient: f64) -> Option<f64> {
    let lost = 1.0 - coefficient * coefficient;
    let half = 0.5 * coefficient * PI.sqrt();
    (lost > 0.0).then(|| ((half + (half * half + lost).sqrt()) / lost).powi(2))
}
