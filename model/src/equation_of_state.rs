//! Equation of state of hard disks (D = 2) and spheres (D = 3): contact value, pressure, rate of
//! collisions and mean free path of a uniform gas.
//!
//! Symbols: d diameter, m mass, n number density, phi packing fraction, r coefficient of
//! restitution, chi pair correlation at contact, T = m<v^2>/D granular temperature (an energy),
//! omega collisions per particle and time (one pair collision counts once for each partner).

use std::f64::consts::PI;

pub mod spheres;

/// Packing fraction of equal disks at close packing, pi/(2 sqrt 3).
pub const CLOSE_PACKING: f64 = 0.906_899_682_117_089_3;

/// Packing fraction of equal disks at random close packing, as used by Luding, Müller & McNamara
/// (1998).
pub const RANDOM_CLOSE_PACKING: f64 = 0.82;

/// Packing fraction at which the disordered fluid of equal hard disks begins to order, about 0.70
/// (Bernard & Krauth, Phys. Rev. Lett. 107, 155704 (2011), doi:10.1103/PhysRevLett.107.155704).
pub const FREEZING: f64 = 0.70;

/// Pair correlation of equal disks at contact, for packing fractions from 0 to close packing.
///
/// Luding, Phys. Rev. E 63, 042201 (2001), doi:10.1103/PhysRevE.63.042201: the fluid branch g4 =
/// (1 - 7 phi/16)/(1 - phi)^2 - (phi^3/16)/(8 (1 - phi)^4), which improves Henderson's first term,
/// joined at phi = 0.701 to the free-volume branch of the crystal. Within 0.1 % of simulations in
/// the fluid, about 1 % beyond. Infinite from close packing on.
///
/// ```
/// let chi = stosszahl_model::equation_of_state::contact_value(0.25);
/// assert!((chi - 1.58295).abs() < 1e-5);
/// ```
pub fn contact_value(packing_fraction: f64) -> f64 {
    let phi = packing_fraction;
    if phi >= CLOSE_PACKING {
        return f64::INFINITY;
    }
    let fluid = |phi: f64| henderson(phi) - phi.powi(3) / (128.0 * (1.0 - phi).powi(4));
    // The switch is below 1e-18 there, and the dense branch is singular at zero packing.
    if phi < 0.2 {
        return fluid(phi);
    }
    let gap = CLOSE_PACKING - phi;
    let dense = 2.0 * CLOSE_PACKING * (1.0 - 0.04 * gap + 3.25 * gap.powi(3)) / gap - 1.0;
    let share = 1.0 / (1.0 + ((0.701 - phi) / 0.0111).exp());
    let pressure = 2.0 * phi * fluid(phi);
    (pressure + share * (dense - pressure)) / (2.0 * phi)
}

/// Henderson's contact value of equal disks, (1 - 7 phi/16)/(1 - phi)^2 (Mol. Phys. 30, 971 (1975),
/// doi:10.1080/00268977500102511): the one that Luding, Müller & McNamara (1998) use for `t_0`.
pub fn henderson(packing_fraction: f64) -> f64 {
    (1.0 - 7.0 / 16.0 * packing_fraction) / (1.0 - packing_fraction).powi(2)
}

/// Factor by which the free volume of Luding, Müller & McNamara (1998) raises the collision rate,
/// 1/(1 - phi/0.82); infinite from random close packing on.
pub fn free_volume_factor(packing_fraction: f64) -> f64 {
    if packing_fraction >= RANDOM_CLOSE_PACKING {
        f64::INFINITY
    } else {
        1.0 / (1.0 - packing_fraction / RANDOM_CLOSE_PACKING)
    }
}

/// Contact value of a pair of species in a mixture, from the contact value chi of equal disks at
/// the same packing: `1/(1 - phi) + (chi - 1/(1 - phi)) 2 d_i d_j M_1/((d_i + d_j) M_2)` with the
/// moments M of the diameter. Santos, Yuste & López de Haro, Mol. Phys. 96, 1 (1999); with
/// Henderson's chi this is Jenkins & Mancini 1987.
pub fn mixture_contact_value(
    equal: f64,
    packing_fraction: f64,
    diameters: [f64; 2],
    moment_ratio: f64,
) -> f64 {
    let point = 1.0 / (1.0 - packing_fraction);
    let [i, j] = diameters;
    point + (equal - point) * 2.0 * i * j * moment_ratio / (i + j)
}

/// Computes the compressibility factor of a gas of inelastic disks, p/(nT) = 1 + (1 + r) phi chi.
pub fn compressibility_factor(packing_fraction: f64, restitution: f64) -> f64 {
    1.0 + (1.0 + restitution) * packing_fraction * contact_value(packing_fraction)
}

/// Structure factor of the elastic fluid of disks at zero wave number, S(0) = 1/(d(phi Z)/d phi).
///
/// The derivative is a central difference of width 1e-5, good to 1e-8.
pub fn structure_factor_at_zero(packing_fraction: f64) -> f64 {
    let pressure = |phi: f64| phi * compressibility_factor(phi, 1.0);
    let step = 1e-5_f64.min(packing_fraction / 2.0);
    2.0 * step / (pressure(packing_fraction + step) - pressure(packing_fraction - step))
}

/// Collisions per particle and time of equal disks,
/// omega = 2 sqrt(pi) n d chi sqrt(T/m)(1 - a2/16), in units of sqrt(T/m)/d:
/// the factor that multiplies sqrt(T/m)/d, with n d^2 = 4 phi/pi.
pub fn collision_rate(packing_fraction: f64, contact_value: f64, fourth_cumulant: f64) -> f64 {
    8.0 * packing_fraction / PI.sqrt() * contact_value * (1.0 - fourth_cumulant / 16.0)
}

/// Mean free path of equal disks over the diameter, pi/(8 sqrt(2) phi chi).
pub fn mean_free_path(packing_fraction: f64, contact_value: f64) -> f64 {
    PI / (8.0 * 2.0_f64.sqrt() * packing_fraction * contact_value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten-term virial series of hard disks (as quoted with the bar of the equation of state); the
    /// fluid branch claims 0.1 %.
    #[test]
    fn contact_value_matches_the_virial_series_and_the_dense_branch() {
        for (phi, z, tolerance) in [
            (0.1, 1.236_144, 1e-4),
            (0.25, 1.791_574, 3e-4),
            (0.5, 4.107, 1e-3),
        ] {
            let found = compressibility_factor(phi, 1.0);
            assert!((found / z - 1.0).abs() < tolerance, "phi = {phi}: {found}");
        }
        // Values of the published global equation of state.
        for (phi, z) in [(0.72, 10.31), (0.75, 11.68), (0.80, 16.96)] {
            let found = compressibility_factor(phi, 1.0);
            assert!((found - z).abs() < 0.02, "phi = {phi}: {found}");
        }
        assert!(contact_value(CLOSE_PACKING).is_infinite());
        assert!((contact_value(0.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn rates_and_compressibility_go_together() {
        assert!((structure_factor_at_zero(0.25) - 0.3318).abs() < 3e-4);
        // omega = 4 (Z - 1)/sqrt(pi) with d = m = T = 1.
        let chi = contact_value(0.25);
        let omega = collision_rate(0.25, chi, 0.0);
        assert!(
            (omega - 4.0 * (compressibility_factor(0.25, 1.0) - 1.0) / PI.sqrt()).abs() < 1e-14
        );
    }

    #[test]
    fn mixture_reduces_to_equal_disks() {
        assert!((mixture_contact_value(1.58, 0.25, [2.0, 2.0], 0.5) - 1.58).abs() < 1e-15);
    }
}
