//! Transport in a gas of equal disks by Enskog's theory, and what it says about the cooling gas:
//! viscosities and the shear instability.
//!
//! Units: diameter d, mass m and granular temperature T are one, so viscosities come in sqrt(m T)/d
//! (in the plane). The contact value chi is an argument, so that each equation of state can be used.
//!
//! Source of the inelastic coefficients: Garzó & Dufty, Phys. Rev. E 59, 5895 (1999),
//! doi:10.1103/PhysRevE.59.5895, for any dimension by Lutsko, Phys. Rev. E 72, 021306 (2005),
//! doi:10.1103/PhysRevE.72.021306, here for D = 2, first Sonine order. Elastic limit: Gass, J.
//! Chem. Phys. 54, 1898 (1971), doi:10.1063/1.1675116.

use std::f64::consts::{PI, TAU};

use crate::cooling::fourth_cumulant;

/// Shear viscosity of dilute elastic disks in first Sonine order, `eta_0 = sqrt(m T/pi)/(2 d)`, in
/// sqrt(m T)/d.
pub const DILUTE_VISCOSITY: f64 = 0.282_094_791_773_878_14;

/// Ratio of the viscosity of dilute elastic disks in all Sonine orders to that in first order (Gass
/// 1971).
pub const VISCOSITY_ORDERS: f64 = 1.022;

/// Number of space dimensions in all formulas of this module, two.
const D: f64 = 2.0;

/// Computes the cooling rate of the homogeneous gas, `zeta* = ((D + 2)/(4 D)) chi (1 - r^2)(1 + 3
/// a2/16)`, over that at which dilute elastic disks lose shear stress, `n T/eta_0`.
fn reduced_cooling(contact_value: f64, restitution: f64) -> f64 {
    let a2 = fourth_cumulant(2, restitution);
    (D + 2.0) / (4.0 * D)
        * contact_value
        * (1.0 - restitution * restitution)
        * (1.0 + 3.0 * a2 / 16.0)
}

/// Bulk viscosity \[sqrt(m T)/d\], `((1 + r)/(2 D^2)) chi n^2 d^3 2 pi sqrt(m T/pi) (1 - a2/16)`:
/// in the plane `(8/pi) phi^2 chi (1 + r)(1 - a2/16) eta_0`. The dilute gas has none.
pub fn bulk_viscosity(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let a2 = fourth_cumulant(2, restitution);
    let reduced = 8.0 / PI
        * packing_fraction.powi(2)
        * contact_value
        * (1.0 + restitution)
        * (1.0 - a2 / 16.0);
    reduced * DILUTE_VISCOSITY
}

/// Computes the kinetic part of the shear viscosity with its coupling to collisions, over `eta_0`.
/// `decay` is the rate at which shear stress decays besides by collisions, over `n T/eta_0`.
fn kinetic_viscosity(
    packing_fraction: f64,
    contact_value: f64,
    restitution: f64,
    fourth_cumulant: f64,
    decay: f64,
) -> f64 {
    let (phi, chi, r, a2) = (
        packing_fraction,
        contact_value,
        restitution,
        fourth_cumulant,
    );
    let relaxation =
        3.0 / (4.0 * D) * chi * (1.0 - r + 2.0 / 3.0 * D) * (1.0 + r) * (1.0 + 7.0 * a2 / 16.0);
    let streaming = 1.0 - (1.0 + r) * (1.0 - 3.0 * r) * phi * chi / (D + 2.0);
    let kinetic = streaming / (relaxation + decay);
    kinetic * (1.0 + 2.0 / (D + 2.0) * phi * chi * (1.0 + r))
}

/// Shear viscosity of the cooling or elastic gas of disks \[sqrt(m T)/d\], first Sonine order.
///
/// `eta = eta_0 {eta_k* [1 + (2/(D + 2)) phi chi (1 + r)] + (D/(D + 2)) gamma*}` in the plane, with
/// `eta_k* = [1 - (1/(D + 2))(1 + r)(1 - 3 r) phi chi]/(nu* - zeta*/2)`,
/// `nu* = (3/(4 D)) chi (1 - r + 2 D/3)(1 + r)(1 + 7 a2/16)` and the reduced bulk viscosity gamma*.
///
/// ```
/// use stosszahl_model::equation_of_state::henderson;
/// use stosszahl_theory::transport;
/// let eta = transport::shear_viscosity(0.25, henderson(0.25), 1.0) / transport::DILUTE_VISCOSITY;
/// assert!((eta - 1.4825).abs() < 5e-5);
/// ```
pub fn shear_viscosity(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let a2 = fourth_cumulant(2, restitution);
    // Relative to the temperature, which falls, stress decays the less.
    let decay = -reduced_cooling(contact_value, restitution) / 2.0;
    let kinetic = kinetic_viscosity(packing_fraction, contact_value, restitution, a2, decay);
    DILUTE_VISCOSITY * kinetic
        + D / (D + 2.0) * bulk_viscosity(packing_fraction, contact_value, restitution)
}

/// Shear viscosity of elastic disks with [`VISCOSITY_ORDERS`] on its kinetic part \[sqrt(m T)/d\]:
/// the reference of elastic simulations of the Enskog equation. The collisional part has no orders
/// to sum.
pub fn elastic_viscosity(packing_fraction: f64, contact_value: f64) -> f64 {
    bath_viscosity(packing_fraction, contact_value, 1.0, 0.0, 0.0)
}

/// Shear viscosity of disks in a bath that keeps their temperature \[sqrt(m T)/d\], first Sonine
/// order with [`VISCOSITY_ORDERS`] on its kinetic part.
///
/// As [`shear_viscosity`], but the temperature is constant and a drag gamma, `drag`
/// \[sqrt(T/m)/d\], damps the velocities, so that stress decays at the rate `nu + 2 gamma` in place
/// of `nu - zeta/2`; gamma = 0 in white noise. Garzó & Montanero, Physica A 313, 336 (2002),
/// doi:10.1016/S0378-4371(02)00994-3 (white noise); Garzó, Chamorro & Vega Reyes, Phys. Rev. E 87,
/// 032201 (2013), doi:10.1103/PhysRevE.87.032201 (with drag).
pub fn bath_viscosity(
    packing_fraction: f64,
    contact_value: f64,
    restitution: f64,
    fourth_cumulant: f64,
    drag: f64,
) -> f64 {
    let (phi, chi, r) = (packing_fraction, contact_value, restitution);
    let decay = if drag > 0.0 {
        2.0 * drag * DILUTE_VISCOSITY / number_density(phi)
    } else {
        0.0
    };
    let kinetic = kinetic_viscosity(phi, chi, r, fourth_cumulant, decay);
    DILUTE_VISCOSITY * VISCOSITY_ORDERS * kinetic + D / (D + 2.0) * bulk_viscosity(phi, chi, r)
}

/// Returns the number density of disks times d^2, `4 phi/pi`.
pub fn number_density(packing_fraction: f64) -> f64 {
    4.0 * packing_fraction / PI
}

/// Rate at which a shear wave of an elastic gas decays, over k^2: the kinematic viscosity
/// `eta/(m n)` \[d sqrt(T/m)\].
pub fn kinematic_viscosity(packing_fraction: f64, contact_value: f64) -> f64 {
    elastic_viscosity(packing_fraction, contact_value) / number_density(packing_fraction)
}

/// Wave number times d below which shear modes of the cooling gas grow against its thermal speed,
/// `k_c^2 = rho zeta/(2 eta)`, that is `(k_c d)^2 = (32 phi^2/pi) zeta*/eta*`. Zero in an elastic
/// gas.
pub fn critical_wave_number(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let viscosity =
        shear_viscosity(packing_fraction, contact_value, restitution) / DILUTE_VISCOSITY;
    let cooling = reduced_cooling(contact_value, restitution);
    (32.0 / PI * packing_fraction.powi(2) * cooling / viscosity).sqrt()
}

/// Side of the smallest square box, over d, in which a shear mode can grow: `2 pi/k_c`. Infinite in
/// an elastic gas.
pub fn critical_length(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    TAU / critical_wave_number(packing_fraction, contact_value, restitution)
}

/// Exponent with which the amplitude of a shear mode of the cooling gas grows over the thermal
/// speed, as a power of `1 + t/t_0`: `1 - (k/k_c)^2`.
pub fn shear_exponent(wave_number: f64, critical: f64) -> f64 {
    1.0 - (wave_number / critical).powi(2)
}

/// Energy of a shear mode over T after `logarithm = ln(1 + t/t_0)` of a cooling that began in
/// thermal equilibrium.
///
/// The scaled amplitude grows at `g = 1 - q`, `q = (k/k_c)^2`, per unit of the logarithm, and
/// viscous noise of the strength of the elastic gas feeds it: `dS/dl = 2 g S + 2 q`, so
/// `S = (exp(2 g l) - q)/(1 - q)`, and `1 + 2 l` at q = 1. (The true noise of the cooling state
/// differs from the elastic one by terms of order 1 - r.)
pub fn thermal_shear_energy(wave_number: f64, critical: f64, logarithm: f64) -> f64 {
    let exponent = shear_exponent(wave_number, critical);
    let growth = 2.0 * exponent * logarithm;
    // (exp(x) - 1)/g is 2 l (1 + x/2 + ...): finite at g = 0.
    let rise = if growth.abs() < 1e-8 {
        2.0 * logarithm
    } else {
        growth.exp_m1() / exponent
    };
    1.0 + rise
}

#[cfg(test)]
mod tests {
    use stosszahl_model::equation_of_state::henderson;

    use super::*;

    /// Published table of `L_c/d`, three digits (four above 1000), with Henderson's contact value.
    #[test]
    fn critical_lengths_are_those_of_the_table() {
        let restitutions = [0.99, 0.95, 0.9, 0.8, 0.7, 0.6];
        for (phi, lengths) in [
            (0.01, [1968.0, 897.0, 649.0, 477.0, 404.0, 363.0]),
            (0.05, [386.0, 176.0, 127.0, 92.7, 78.1, 69.8]),
            (0.1, [190.0, 86.1, 61.9, 45.0, 37.6, 33.4]),
            (0.25, [76.3, 34.3, 24.4, 17.3, 14.2, 12.3]),
            (0.4, [51.8, 23.1, 16.3, 11.4, 9.12, 7.76]),
            (0.5, [45.0, 20.0, 14.1, 9.74, 7.76, 6.56]),
            (0.7, [39.1, 17.4, 12.1, 8.37, 6.64, 5.58]),
        ] {
            for (r, known) in restitutions.into_iter().zip(lengths) {
                let found = critical_length(phi, henderson(phi), r);
                // Half a unit of the third digit is at most 0.5 %.
                assert!(
                    (found / known - 1.0_f64).abs() < 5.01e-3,
                    "phi = {phi}, r = {r}: {found} {known}"
                );
            }
        }
        assert!(critical_length(0.25, henderson(0.25), 1.0).is_infinite());
    }

    /// The elastic limit in closed form, `eta/eta_0 = 1/chi + 2 phi + (1 + 8/pi) phi^2 chi` (Gass),
    /// and its value.
    #[test]
    fn elastic_viscosity_is_that_of_gass() {
        for phi in [1e-6, 0.05, 0.25, 0.5] {
            let chi = henderson(phi);
            let known = 1.0 / chi + 2.0 * phi + (1.0 + 8.0 / PI) * phi * phi * chi;
            let found = shear_viscosity(phi, chi, 1.0) / DILUTE_VISCOSITY;
            assert!(
                (found / known - 1.0).abs() < 1e-14,
                "{phi}: {found} {known}"
            );
            let bulk = bulk_viscosity(phi, chi, 1.0) / DILUTE_VISCOSITY;
            assert!((bulk - 16.0 / PI * phi * phi * chi).abs() < 1e-14);
            let all = elastic_viscosity(phi, chi) / DILUTE_VISCOSITY;
            let orders = VISCOSITY_ORDERS * (found - 0.5 * bulk) + 0.5 * bulk;
            assert!((all / orders - 1.0).abs() < 1e-14);
        }
        assert!((DILUTE_VISCOSITY - 0.5 / PI.sqrt()).abs() < 1e-16);
        let chi = henderson(0.25);
        assert!((shear_viscosity(0.25, chi, 1.0) / DILUTE_VISCOSITY - 1.4825).abs() < 5e-5);
    }

    /// Where drag outruns collisions, stress decays at 2 gamma, and the dilute kinetic viscosity is
    /// n T/(2 gamma), without a trace of the collisions.
    #[test]
    fn strong_drag_sets_the_viscosity() {
        let (phi, drag) = (1e-6, 1.0);
        for r in [1.0, 0.8] {
            let found = bath_viscosity(phi, 1.0, r, 0.0, drag);
            let known = VISCOSITY_ORDERS * number_density(phi) / (2.0 * drag);
            assert!((found / known - 1.0).abs() < 1e-5, "{found} {known}");
        }
        let (phi, chi) = (0.25, henderson(0.25));
        let cooling = shear_viscosity(phi, chi, 0.8);
        let heated = bath_viscosity(phi, chi, 0.8, fourth_cumulant(2, 0.8), 0.0);
        assert!(
            heated < cooling && heated > 0.9 * cooling,
            "{heated} {cooling}"
        );
    }

    /// Against `dS/dl = 2 g S + 2 q`, integrated by the midpoint rule: its error is third order in the
    /// step and below 1e-6 here.
    #[test]
    fn growth_solves_its_equation() {
        for (k, critical) in [(0.1, 0.3), (0.3, 0.3), (0.5, 0.3)] {
            let (q, mut energy, step) = ((k / critical) * (k / critical), 1.0, 1e-4_f64);
            let slope = |energy: f64| 2.0 * (1.0 - q) * energy + 2.0 * q;
            for _ in 0..20_000 {
                let middle = energy + 0.5 * step * slope(energy);
                energy += step * slope(middle);
            }
            let found = thermal_shear_energy(k, critical, 2.0);
            assert!((found / energy - 1.0).abs() < 1e-6, "{k}: {found} {energy}");
        }
    }
}
