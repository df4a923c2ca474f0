//! Equation of state of equal hard spheres (D = 3), with the symbols of
//! [`equation_of_state`](super).

use std::f64::consts::PI;

/// Packing fraction of equal spheres at random close packing, about 0.64 (Scott & Kilgour, J. Phys.
/// D 2, 863 (1969)).
pub const RANDOM_CLOSE_PACKING: f64 = 0.64;

/// Pair correlation of equal spheres at contact, (1 - phi/2)/(1 - phi)^3: Carnahan & Starling, J.
/// Chem. Phys. 51, 635 (1969), doi:10.1063/1.1672048. Infinite at packing one and beyond.
///
/// ```
/// // Z = 1 + 4 phi chi against the virial series 1 + 4 phi + 10 phi^2 + 18.365 phi^3 + ...
/// let z = 1.0 + 0.04 * stosszahl_model::equation_of_state::spheres::contact_value(0.01);
/// assert!((z - 1.041_018_65).abs() < 1e-6);
/// ```
pub fn contact_value(packing_fraction: f64) -> f64 {
    if packing_fraction >= 1.0 {
        return f64::INFINITY;
    }
    (1.0 - 0.5 * packing_fraction) / (1.0 - packing_fraction).powi(3)
}

/// Collisions per particle and time of equal spheres, omega = 4 sqrt(pi) n d^2 chi sqrt(T/m), in
/// units of sqrt(T/m)/d, with n d^3 = 6 phi/pi.
pub fn collision_rate(packing_fraction: f64, contact_value: f64) -> f64 {
    24.0 * packing_fraction / PI.sqrt() * contact_value
}

/// Mean free path of equal spheres over the diameter, 1/(sqrt(2) pi n d^3 chi) = 1/(6 sqrt(2) phi
/// chi).
pub fn mean_free_path(packing_fraction: f64, contact_value: f64) -> f64 {
    1.0 / (6.0 * 2.0_f64.sqrt() * packing_fraction * contact_value)
}

/// Structure factor of the elastic fluid of spheres at zero wave number, 1/(d(phi Z)/dphi) with the
/// pressure of Carnahan and Starling: (1 - phi)^4/(1 + 4 phi + 4 phi^2 - 4 phi^3 + phi^4).
///
/// ```
/// // To second order 1 - 8 phi + 34 phi^2.
/// let s = stosszahl_model::equation_of_state::spheres::structure_factor_at_zero(1e-4);
/// assert!((s - (1.0 - 8e-4 + 34e-8)).abs() < 1e-9);
/// ```
pub fn structure_factor_at_zero(packing_fraction: f64) -> f64 {
    let phi = packing_fraction;
    (1.0 - phi).powi(4) / (1.0 + phi * (4.0 + phi * (4.0 + phi * (phi - 4.0))))
}
